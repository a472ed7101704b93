"""Counts with their nouns, as text has them."""

__all__ = ["many"]


def many(count: int, one: str, several: str = "") -> str:
    """Return the count with its noun; the plural has an s unless it is given.

    >>> many(1, "face"), many(0, "face"), many(2, "vertex", "vertices")
    ('1 face', '0 faces', '2 vertices')
    """
    return f"{count} {one if count == 1 else several or f'{one}s'}"
