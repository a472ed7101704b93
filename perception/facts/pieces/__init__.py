"""Facts about the pieces of things and about their openings."""
