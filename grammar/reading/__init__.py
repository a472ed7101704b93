"""Model text into its syntax tree: tokens, statements, the parser, and what it says of faults."""
