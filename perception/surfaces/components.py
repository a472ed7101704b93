"""Groups of what is connected."""

from collections.abc import Iterable


def components(count: int, pairs: Iterable[tuple[int, int]]) -> tuple[int, ...]:
    """Return the connected group of each of `count` nodes, numbered by first member.

    >>> components(4, [(3, 1)])
    (0, 1, 2, 1)
    """
    parent = list(range(count))

    def root(node: int) -> int:
        while parent[node] != node:
            parent[node] = node = parent[parent[node]]
        return node

    for one, two in pairs:
        first, second = root(one), root(two)
        parent[max(first, second)] = min(first, second)
    names: dict[int, int] = {}
    return tuple(names.setdefault(root(node), len(names)) for node in range(count))
