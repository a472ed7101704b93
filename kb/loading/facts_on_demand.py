"""The facts of one scene for facts_on_demand.pl: columns that are decoded when they are asked for.

Most facts of a scene are of pairs of faces, and of many kinds no rule asks on most scenes. What is
known of each two faces goes over as a matrix, the other kinds as columns (fact_columns.py).
"""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import chain
from math import isqrt
from typing import TypeAlias

import numpy as np

from facetlog.kb.loading.encode import format_argument
from facetlog.kb.loading.fact_columns import SEPARATOR, Floats, encode_column, encode_floats

__all__ = ["Columns", "encode_facts"]

Columns: TypeAlias = Sequence[Sequence[str | int | float] | Floats]
"""The values of each argument of facts of one kind; floats may be an array."""

FEWEST = 3  # names in a matrix: of fewer the columns are as good


def encode_facts(scene: str, facts: Mapping[tuple[str, int], Columns]) -> str:
    """Return the facts of the module `scene` by functor and number of arguments, column by column.

    Raise TypeError for what is no fact, and ValueError for a number that is not finite.
    """
    names: tuple[str, ...] = ()
    matrices: list[str] = []
    kinds: list[str] = []
    texts: list[str] = []
    later: list[str] = []
    for (name, arity), columns in facts.items():
        found = _find_pair_names(columns)
        matrix = (
            _build_matrix_text(columns[2:], len(found)) if found and names in ((), found) else ""
        )
        if matrix:
            names = found
            matrices.append(f"{format_argument(name, ())}-{arity}")
            texts.append(matrix)
            continue
        layouts: list[str] = []
        for column in columns:
            layout, text = encode_column(column, name, zip(*columns, strict=True))
            layouts.append(f"{layout}-{len(text)}")
            later.append(text)
        count = len(columns[0]) if columns else 0
        kinds.append(f"kind({format_argument(name, ())},{count},[{','.join(layouts)}])")
    joined = SEPARATOR.join(names)
    about = f"matrices({len(names)},{len(joined)},[{','.join(matrices)}])"
    head = f"facts({format_argument(scene, ())},{about},[{','.join(kinds)}])\n"
    return "".join((head, joined, *texts, *later))


def _find_pair_names(columns: Columns) -> tuple[str, ...]:
    """Return the names of which each two, in either order, have one row of floats, in order of the
    names.

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
    if (tuple(firsts), tuple(seconds)) != _list_name_pairs(names):
        return ()
    floats = all(isinstance(c, np.ndarray) or set(map(type, c)) == {float} for c in columns[2:])
    return names if floats else ()


@lru_cache(maxsize=64)
def _list_name_pairs(names: tuple[str, ...]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the first and the second names of all pairs."""
    others = (names[:i] + names[i + 1 :] for i in range(len(names)))
    firsts = chain.from_iterable([name] * (len(names) - 1) for name in names)
    return tuple(firsts), tuple(chain.from_iterable(others))


def _build_matrix_text(columns: Columns, count: int) -> str:
    """Return one matrix for each column, row by row; 0 stands for what a name has with itself.

    Empty if a value is not finite.
    """
    # After the first place of each row but the last, count - 1 others and the next one's first.
    values = np.zeros((len(columns), count * count))
    for matrix, column in zip(values, columns, strict=True):
        matrix[:-1].reshape(count - 1, count + 1)[:, 1:] = np.reshape(column, (count - 1, count))
    return encode_floats(values.ravel())
