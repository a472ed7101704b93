"""What holds of every solid, in words."""

from collections.abc import Hashable, Iterable

from facetlog.grammar.lint.bound_graph import Edge, is_one
from facetlog.grammar.lint.claims import Claim
from facetlog.grammar.units import Dimension
from facetlog.grammar.vocabulary import VOCABULARY

__all__ = ["kind_meant", "of_every_solid"]

_KINDS = ("board", "bar", "block")
_UNITS = {Dimension.LENGTH: " m", Dimension.AREA: " m²", Dimension.ANGLE: "°"}


def of_every_solid(edges: Iterable[Edge]) -> str:
    """That and what of it, in words.

    >>> of_every_solid([Edge(("height", "$this"), ("height", "$top"), 1.0, True)])
    'what holds of every solid: height(top) is at most height(this)'
    """
    said = [words for words in map(_words, edges) if words]
    return "what holds of every solid" + (f": {' and '.join(said)}" if said else "")


def kind_meant(claims: Iterable[Claim]) -> str:
    """What a board, a bar or a block is, if one of the claims is that something is one."""
    kinds = [c.said[0] for c in claims if isinstance(c.said, tuple) and c.said[0] in _KINDS]
    return "; ".join(f"a {kind}: {VOCABULARY[kind].meaning}" for kind in dict.fromkeys(kinds))


def _words(edge: Edge) -> str:
    """An edge in words; nothing where it names what has no name in the text."""
    greater, lesser = (_measure(each) for each in (edge.greater, edge.lesser))
    if is_one(edge.greater) and lesser:
        return f"{lesser} is at most {_number(1.0 / edge.factor, edge.greater)}"
    if is_one(edge.lesser) and greater:
        return f"{greater} is at least {_number(edge.factor, edge.lesser)}"
    if not (greater and lesser):
        return ""
    times = "" if edge.factor == 1.0 else f"{100.0 / edge.factor:.3g} % of "
    return f"{lesser} is at most {times}{greater}"


def _measure(atom: Hashable) -> str:
    match atom:
        case (str() as word, str() as of):
            return f"{word}({of.lstrip('$')})"
        case (str() as word, tuple() | frozenset() as of) if all(isinstance(x, str) for x in of):
            return f"{word}({', '.join(sorted(x.lstrip('$') for x in of))})"
    return ""


def _number(value: float, one: Hashable) -> str:
    unit = _UNITS.get(one[1], "") if isinstance(one, tuple) else ""
    return f"{value:.4g}{unit}"
