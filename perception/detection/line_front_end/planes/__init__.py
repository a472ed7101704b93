"""Planes through 3-D segments, and the ground among them."""
