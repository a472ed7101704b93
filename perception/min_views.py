"""How many views make a face."""

FEWEST_VIEWS = 3
"""A face is found where so many views agree on it: two alone may agree by chance."""
