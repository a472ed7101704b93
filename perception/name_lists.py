"""Many names in one line: the first, and how many more there are."""

from collections.abc import Sequence

NAMED = 3


def named(names: Sequence[str]) -> str:
    """Return the first names and how many more there are.

    >>> named(["a.png", "b.png", "c.png", "d.png", "e.png"])
    'a.png, b.png, c.png and 2 more'
    """
    more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
    return ", ".join(names[:NAMED]) + more
