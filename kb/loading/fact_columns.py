"""Facts to the text that fact_columns.pl reads: the values of each argument together."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from facetlog.kb.engine.terms import Atom, Struct, Term, format_integer, format_prolog_term
from facetlog.kb.loading.encode import Fact, format_argument

__all__ = [
    "FACTS_PER_CHUNK",
    "SEPARATOR",
    "Floats",
    "build_facts_request",
    "encode_column",
    "encode_floats",
]

Floats: TypeAlias = NDArray[np.float64]

# Facts are handed over in texts of this many: long enough that the crossing costs nothing.
FACTS_PER_CHUNK = 5000

SEPARATOR = "\x1f"  # separator/1 of fact_columns.pl

FLOAT_BYTE = 14  # float_byte/1 of float_bytes.pl
FLOAT = np.dtype([("byte", "u1"), ("value", "<f8")])


def build_facts_request(scene: str, facts: Sequence[Fact]) -> str:
    """Return the text that adds the facts to the module `scene`; those of a kind stay in order.

    Raise TypeError for what is no fact, and ValueError for a number that is not finite.
    """
    kinds: dict[tuple[object, int], list[Fact]] = defaultdict(list)
    for fact in facts:
        kinds[fact[0], len(fact)].append(fact)
    heads: list[Term] = []
    texts: list[str] = []
    for (name, _), alike in kinds.items():
        if not isinstance(name, str):
            raise TypeError(f"a fact begins with the name of its functor, not {name!r}")
        layouts: list[Term] = []
        rows = [fact[1:] for fact in alike]
        for values in zip(*rows, strict=True):
            layout, text = encode_column(values, name, rows)
            layouts.append(Struct("-", (Atom(layout), len(text))))
            texts.append(text)
        heads.append(Struct("kind", (Atom(name), len(alike), tuple(layouts))))
    head = format_prolog_term(Struct("facts", (Atom(scene), tuple(heads))))
    return "".join((head, "\n", *texts))


def encode_column(
    values: Sequence[str | int | float] | Floats, name: str, rows: Iterable[Fact]
) -> tuple[str, str]:
    """Return the layout and the text of the values of one argument of the facts `name`."""
    if isinstance(values, np.ndarray):
        text = encode_floats(values)
        if text:
            return "f", text
        values = values.tolist()
    types = set(map(type, values))
    if types == {str}:
        text = SEPARATOR.join(values)  # type: ignore[arg-type]
        if text.count(SEPARATOR) == len(values) - 1:
            return "a", text
    if types and all(issubclass(kind, float) for kind in types):
        text = encode_floats(values)
        if text:
            return "f", text
    if types == {int}:
        return "t", f"[{','.join(map(format_integer, values))}]"
    facts = ((name, *row) for row in rows)
    return "t", f"[{','.join(map(format_argument, values, facts))}]"


def encode_floats(values: Sequence[str | int | float] | Floats) -> str:
    """Return floats as float_bytes.pl has them; empty if one of them is not finite."""
    numbers = np.empty(len(values), FLOAT)
    numbers["byte"] = FLOAT_BYTE
    numbers["value"] = values
    if not np.isfinite(numbers["value"]).all():
        return ""
    return numbers.tobytes().decode("latin-1")
