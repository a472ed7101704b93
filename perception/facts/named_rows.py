"""Facts as rows of arguments: names of what the rows are about, and columns into rows.

Faces are named f1 …, edges e1 …, vertices v1 …, views view1 …, things t1 …, in the scene's order.
"""

from collections.abc import Iterable, Sequence
from typing import TypeAlias

from facetlog.perception.facts.fact_schema import Value

__all__ = ["FactRows", "both_ways", "named", "names", "rows_of"]

FactRows: TypeAlias = dict[str, list[tuple[Value, ...]]]
"""Arguments of facts by functor."""


def names(letter: str, count: int) -> list[str]:
    """Names of all that there are of a kind.

    >>> names("f", 2)
    ['f1', 'f2']
    """
    return [f"{letter}{i}" for i in range(1, count + 1)]


def named(letter: str, indices: Iterable[int]) -> list[str]:
    """Names of some, which count from 0.

    >>> named("e", [4, 0])
    ['e5', 'e1']
    """
    return [f"{letter}{i + 1}" for i in indices]


def rows_of(first: Iterable[str], *columns: Iterable[Value]) -> Iterable[tuple[Value, ...]]:
    """A row for each name."""
    return zip(first, *columns, strict=True)


def both_ways(
    rows: list[tuple[Value, ...]],
    one: Sequence[str],
    two: Sequence[str],
    *columns: Iterable[Value],
) -> None:
    """Adds a row for each pair of names, and after it that for the two in the other order."""
    for first, second, *rest in zip(one, two, *columns, strict=True):
        rows.append((first, second, *rest))
        rows.append((second, first, *rest))
