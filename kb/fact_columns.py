"""Facts to the text that fact_columns.pl reads: the values of each argument together."""

import math
import struct
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from itertools import repeat

from facetlog.kb.encode import Fact, argument_text
from facetlog.kb.terms import Atom, Struct, Term, term_text

__all__ = ["columns_text", "rows_text"]

SEPARATOR = "\x1f"  # separator/1 of fact_columns.pl

FLOAT_BYTE = 14  # float_byte/1 of float_bytes.pl


def columns_text(scene: str, facts: Iterable[Fact]) -> str:
    """The request that adds the facts to the module `scene`; those of a kind stay in order.

    Raises TypeError for what is no fact, and ValueError for a number that is not finite.
    """
    kinds: dict[tuple[object, int], list[Fact]] = defaultdict(list)
    for fact in facts:
        kinds[fact[0], len(fact)].append(fact)
    rows: dict[tuple[str, int], list[Fact]] = {}
    for (name, length), alike in kinds.items():
        if not isinstance(name, str):
            raise TypeError(f"a fact begins with the name of its functor, not {name!r}")
        rows[name, length - 1] = [fact[1:] for fact in alike]
    return rows_text(scene, rows)


def rows_text(scene: str, rows: Mapping[tuple[str, int], Sequence[Fact]]) -> str:
    """The same of facts by functor and number of arguments, each without its functor."""
    heads: list[Term] = []
    columns: list[str] = []
    for (name, _), alike in rows.items():
        values = zip(*alike, strict=True)
        layouts: list[Term] = []
        for column in values:
            layout, text = _column(column, name, alike)
            layouts.append(Struct("-", (Atom(layout), len(text))))
            columns.append(text)
        heads.append(Struct("kind", (Atom(name), len(alike), tuple(layouts))))
    head = term_text(Struct("facts", (Atom(scene), tuple(heads))))
    return "".join((head, "\n", *columns))


def _column(
    values: Sequence[str | int | float], name: str, rows: Sequence[Fact]
) -> tuple[str, str]:
    """The layout and the text of the values of one argument."""
    types = set(map(type, values))
    if types == {str}:
        text = SEPARATOR.join(values)  # type: ignore[arg-type]
        if text.count(SEPARATOR) == len(values) - 1:
            return "a", text
    if types == {float} and all(map(math.isfinite, values)):  # type: ignore[arg-type]
        return "f", _floats(values)  # type: ignore[arg-type]
    facts = ((name, *row) for row in rows)
    return "t", f"[{','.join(map(argument_text, values, facts))}]"


def _floats(values: Sequence[float]) -> str:
    pairs = [x for pair in zip(repeat(FLOAT_BYTE), values) for x in pair]
    return struct.pack("<" + "Bd" * len(values), *pairs).decode("latin-1")
