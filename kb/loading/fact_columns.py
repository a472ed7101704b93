"""Facts to the text that fact_columns.pl reads: the values of each argument together."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from facetlog.kb.engine.terms import Atom, Struct, Term, integer_text, term_text
from facetlog.kb.loading.encode import Fact, argument_text

__all__ = [
    "FACTS_PER_CHUNK",
    "SEPARATOR",
    "Floats",
    "chunks_of_columns",
    "column_text",
    "columns_text",
    "floats_text",
    "rows_text",
]

Floats: TypeAlias = NDArray[np.float64]

# Facts are handed over in texts of this many: long enough that the crossing costs nothing.
FACTS_PER_CHUNK = 5000

SEPARATOR = "\x1f"  # separator/1 of fact_columns.pl

FLOAT_BYTE = 14  # float_byte/1 of float_bytes.pl
FLOAT = np.dtype([("byte", "u1"), ("value", "<f8")])


def chunks_of_columns(scene: str, facts: Iterable[Fact]) -> Iterator[tuple[str, int]]:
    """The requests that add the facts, each with how many it adds; errors as for columns_text."""
    source = iter(facts)
    while chunk := tuple(islice(source, FACTS_PER_CHUNK)):
        yield columns_text(scene, chunk), len(chunk)


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
            layout, text = column_text(column, name, alike)
            layouts.append(Struct("-", (Atom(layout), len(text))))
            columns.append(text)
        heads.append(Struct("kind", (Atom(name), len(alike), tuple(layouts))))
    head = term_text(Struct("facts", (Atom(scene), tuple(heads))))
    return "".join((head, "\n", *columns))


def column_text(
    values: Sequence[str | int | float] | Floats, name: str, rows: Iterable[Fact]
) -> tuple[str, str]:
    """The layout and the text of the values of one argument of the facts `name`."""
    if isinstance(values, np.ndarray):
        text = floats_text(values)
        if text:
            return "f", text
        values = values.tolist()
    types = set(map(type, values))
    if types == {str}:
        text = SEPARATOR.join(values)  # type: ignore[arg-type]
        if text.count(SEPARATOR) == len(values) - 1:
            return "a", text
    if types and all(issubclass(kind, float) for kind in types):
        text = floats_text(values)
        if text:
            return "f", text
    if types == {int}:
        return "t", f"[{','.join(map(integer_text, values))}]"
    facts = ((name, *row) for row in rows)
    return "t", f"[{','.join(map(argument_text, values, facts))}]"


def floats_text(values: Sequence[str | int | float] | Floats) -> str:
    """Floats as float_bytes.pl has them; empty if one of them is not finite."""
    numbers = np.empty(len(values), FLOAT)
    numbers["byte"] = FLOAT_BYTE
    numbers["value"] = values
    if not np.isfinite(numbers["value"]).all():
        return ""
    return numbers.tobytes().decode("latin-1")
