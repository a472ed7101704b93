"""One page of a run: the thing to turn, the pictures, the verdicts and their reasons."""
