"""The query shell: goals and commands from a terminal, a pipe or the command line."""
