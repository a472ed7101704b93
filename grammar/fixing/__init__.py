"""What puts faults right: edits of a text, and a file with all that is sure of them made."""
