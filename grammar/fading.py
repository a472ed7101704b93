"""Over which width a limit fades: what the language does by default, and what a model says of it.

Degrees fall about a limit, from 1 to 0 over a share of it to either side, and are a half in the
limit itself, which alone decides what holds. `fading` behind a comparison is another thing: its
edge falls beyond the limit, and what holds is decided in the middle of that slope.
"""

from collections.abc import Iterator, Mapping

from facetlog.grammar import syntax as s
from facetlog.grammar.constants import Constant, constant
from facetlog.grammar.resolve import Owned
from facetlog.grammar.scope import Scope
from facetlog.grammar.traversal import walk
from facetlog.grammar.units import Dimension
from facetlog.grammar.vocabulary import Gives

FADING = "fading"
"""The name of the constant that says over which share of them the limits of a model fade."""

SHARE = 0.10
"""Of a limit to either side, where a model does not say (the language's definition)."""

ABOUT = 0.10
"""`about x` is x ± 10 %, fading over 10 % more (the language's definition)."""

_UNITS = {Dimension.LENGTH: " m", Dimension.AREA: " m2", Dimension.ANGLE: " deg"}


def get_default_share(lets: Mapping[str, Owned[s.Let]]) -> float:
    """Return the share of its limits over which a model with these constants fades to either
    side."""
    let = lets.get(FADING)
    value = None if let is None else constant(let.node.value, lets)
    return SHARE if value is None else value.value


def get_soft_share(node: s.Comparison, scope: Scope) -> float:
    """Return the share over which a comparison fades about its limits; 0 of one that says how, or
    that counts.
    """
    exact = node.comparator is s.Comparator.EQUAL and node.second is None
    if node.sharp or node.fading is not None or node.comparator is s.Comparator.ABOUT or exact:
        return 0.0
    if any(is_count(side, scope) for side in (node.measure, node.limit)):
        return 0.0
    return get_default_share(scope.lets)


def is_count(node: s.Expression, scope: Scope) -> bool:
    """Return whether a number of elements is in a measure: there is nothing between two and
    three.
    """
    for inner in walk(node):
        if isinstance(inner, s.Call):
            word = scope.words.get(inner.name.text)
            if inner.name.text == "count" or (word is not None and word.gives is Gives.COUNT):
                return True
    return False


def describe_fading(node: s.Comparison, scope: Scope) -> str:
    """Describe the range over which a comparison fades, in numbers where limits are constant."""
    share = get_soft_share(node, scope)
    if node.fading is None and node.comparator is not s.Comparator.ABOUT and not share:
        return "does not fade"
    slopes = tuple(_iter_slopes(node, scope, share))
    if slopes:
        return "fades " + " and ".join(f"from {low} to {high}" for low, high in slopes)
    if share:
        of = _format_constant(Constant(share, Dimension.NUMBER, percent=True))
        return f"fades over {of} of its limit to either side"
    return "fades beyond its limit"


def _iter_slopes(node: s.Comparison, scope: Scope, share: float) -> Iterator[tuple[str, str]]:
    """Iterate over the ends of each slope, the lower one first; none where a limit is measured."""
    limit = constant(node.limit, scope.lets)
    second = constant(node.second, scope.lets) if node.second is not None else None
    beyond = constant(node.fading, scope.lets) if node.fading is not None else None
    if limit is None or (node.second is not None and second is None):
        return
    low, high = _find_edges(node.comparator, limit, second)
    if share:
        scale = (high - low) / 2 if low is not None and high is not None else abs(limit.value)
        inwards = outwards = share * abs(scale)
    elif node.comparator is s.Comparator.ABOUT:
        inwards, outwards = 0.0, ABOUT * abs(limit.value)
    elif beyond is not None:
        of = abs(limit.value) if beyond.percent else 1.0
        inwards, outwards = 0.0, beyond.value * of
    else:
        return
    if low is not None:
        yield _format_constant(limit, low - outwards), _format_constant(limit, low + inwards)
    if high is not None:
        yield _format_constant(limit, high - inwards), _format_constant(limit, high + outwards)


def _find_edges(
    comparator: s.Comparator, limit: Constant, second: Constant | None
) -> tuple[float | None, float | None]:
    match comparator:
        case s.Comparator.AT_LEAST:
            return limit.value, None
        case s.Comparator.AT_MOST:
            return None, limit.value
        case s.Comparator.BETWEEN if second is not None:
            return limit.value, second.value
        case s.Comparator.ABOUT:
            width = ABOUT * abs(limit.value)
        case _:
            width = 0.0 if second is None else second.value
            if second is not None and second.percent:
                width *= abs(limit.value)
    return limit.value - width, limit.value + width


def _format_constant(like: Constant, value: float | None = None) -> str:
    number = like.value if value is None else value
    if like.percent:
        return f"{100 * number:.4g} %"
    return f"{number:.4g}{_UNITS.get(like.dimension, '')}"
