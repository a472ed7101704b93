"""The facts of one scene for facts_on_demand.pl: columns that are decoded when they are asked for.

Most facts of a scene are of pairs of faces, and of many kinds no rule asks on most scenes. What is
known of each two faces goes over as a matrix, the other kinds as columns (fact_columns.py).
"""

from collections.abc import Mapping, Sequence
from itertools import chain
from math import isqrt

from facetlog.kb.encode import Fact, argument_text
from facetlog.kb.fact_columns import SEPARATOR, column_text, floats_text

__all__ = ["facts_text"]

FEWEST = 3  # names in a matrix: of fewer the columns are as good


def facts_text(scene: str, rows: Mapping[tuple[str, int], Sequence[Fact]]) -> str:
    """The facts of the module `scene` by functor and number of arguments, each without its functor.

    Raises TypeError for what is no fact, and ValueError for a number that is not finite.
    """
    names: tuple[str, ...] = ()
    matrices: list[str] = []
    kinds: list[str] = []
    texts: list[str] = []
    later: list[str] = []
    for (name, arity), alike in rows.items():
        columns = tuple(zip(*alike, strict=True))
        found = _of_each_two(columns)
        matrix = _matrix(columns[2:], len(found)) if found and names in ((), found) else ""
        if matrix:
            names = found
            matrices.append(f"{argument_text(name, ())}-{arity}")
            texts.append(matrix)
            continue
        layouts: list[str] = []
        for column in columns:
            layout, text = column_text(column, name, alike)
            layouts.append(f"{layout}-{len(text)}")
            later.append(text)
        kinds.append(f"kind({argument_text(name, ())},{len(alike)},[{','.join(layouts)}])")
    joined = SEPARATOR.join(names)
    about = f"matrices({len(names)},{len(joined)},[{','.join(matrices)}])"
    head = f"facts({argument_text(scene, ())},{about},[{','.join(kinds)}])\n"
    return "".join((head, joined, *texts, *later))


def _of_each_two(columns: Sequence[Sequence[str | int | float]]) -> tuple[str, ...]:
    """The names of which each two, in either order, have one row of floats, in order of the names.

    None if the columns are anything else.
    """
    if len(columns) < 3:
        return ()
    firsts, seconds = columns[0], columns[1]
    count = (1 + isqrt(1 + 4 * len(firsts))) // 2
    if count < FEWEST or count * (count - 1) != len(firsts):
        return ()
    found = firsts[:: count - 1]
    names = tuple(name for name in found if isinstance(name, str) and SEPARATOR not in name)
    if len(set(names)) != count:
        return ()
    wanted = (names[:i] + names[i + 1 :] for i in range(count))
    if tuple(seconds) != tuple(chain.from_iterable(wanted)):
        return ()
    if tuple(firsts) != tuple(chain.from_iterable([name] * (count - 1) for name in names)):
        return ()
    floats = all(
        issubclass(kind, float) for column in columns[2:] for kind in set(map(type, column))
    )
    return names if floats else ()


def _matrix(columns: Sequence[Sequence[str | int | float]], count: int) -> str:
    """One matrix for each column, row by row; 0 stands for what a name has with itself.

    Empty if a value is not finite.
    """
    values: list[str | int | float] = []
    for column in columns:
        for row in range(count):
            # count - 1 values, then the place between two rows in which the diagonal comes next.
            values.append(0.0)
            values.extend(column[row * count : (row + 1) * count])
    return floats_text(values)
