"""What an analysis keeps between its passes, and from one text to the next."""
