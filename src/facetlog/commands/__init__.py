"""The commands of the command line that ask the knowledge base, and what all commands share."""
