"""The space of each thing: where it is full, where it is free, and where nobody looked."""
