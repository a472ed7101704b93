"""Comparisons that never hold: of the range of what is measured, or with a width of nothing."""

import math
from collections.abc import Iterator

from facetlog.grammar import syntax as s
from facetlog.grammar.faults import Fault, Severity
from facetlog.grammar.fixing.fix import Edit, Fix, swap
from facetlog.grammar.lint.claims import Bound, Claims, Place, Region, in_short
from facetlog.grammar.lint.linear import Linear
from facetlog.grammar.source import Span
from facetlog.grammar.vocabulary import Gives


def find_impossible(claims: Claims, reported: set[Place]) -> Iterator[Fault]:
    """Find comparisons of the model itself that never hold, each reported once.

    `reported` gets the places of those that have a fault.
    """
    seen: dict[int, bool] = {}
    for region in claims.regions:
        if region.own and id(region.node) not in seen:
            # Definitions are used more than once.
            fault = _find_bad_width(claims, region) or _find_never(claims, region)
            seen[id(region.node)] = fault is not None
            if fault is not None:
                yield fault
        if seen.get(id(region.node)):
            reported.add(region.place)


def _find_bad_width(claims: Claims, region: Region) -> Fault | None:
    node, source = region.node, region.source
    widths = (("tolerance", region.tolerance, node.second), ("fading", region.fading, node.fading))
    for what, width, shown in widths:
        if width is None or shown is None or not width.is_constant:
            continue
        if width.constant < 0:
            message, hint = f"a {what} cannot be negative", "write it without the sign"
            fixes = _drop_sign(source.text, shown)
            return Fault("negative-width", message, source, shown.span, hint, fixes=fixes)
        if what == "tolerance" and width.constant == 0 and not _is_count(claims, region.measure):
            message = "with a tolerance of 0 only an exact value will do"
            hint = "no measure is exact: give it some room"
            return Fault("zero-tolerance", message, source, shown.span, hint, Severity.WARNING)
    return None


def _drop_sign(text: str, node: s.Expression) -> tuple[Fix, ...]:
    if not isinstance(node, s.Negative) or not isinstance(node.operand, s.Quantity):
        return ()
    number = node.operand.span.start
    before = text[:number].rstrip()
    if not before.endswith("-"):
        return ()  # brackets stand there
    return (Fix("leave the sign out", (Edit(Span(len(before) - 1, number), ""),), True),)


def _is_count(claims: Claims, measure: Linear) -> bool:
    words = claims.scope.words
    names = [str(atom[0]) for atom in measure.terms]
    return all(n == "count" or (n in words and words[n].gives is Gives.COUNT) for n in names)


def _find_never(claims: Claims, region: Region) -> Fault | None:
    node, source = region.node, region.source
    low, high = region.low_bound, region.high_bound
    if low and high and _is_impossible(claims, low.half.plus(high.half)):
        first, second = in_short(source, node.limit), in_short(source, node.second or node.limit)
        message = f"this never holds: `{first}` is more than `{second}`"
        fixes: tuple[Fix, ...] = ()
        if node.comparator is s.Comparator.BETWEEN and node.second is not None:
            ends = (region.low, region.high)
            sure = all(end is not None and end.is_constant for end in ends)
            fixes = (swap(source.text, node.limit.span, node.second.span, sure=sure),)
        return Fault("never-holds", message, source, node.span, "change them round", fixes=fixes)
    for bound in region.bounds:
        if _is_impossible(claims, bound.half):
            why = _describe_range(claims, region, bound)
            message = f"this never holds{why and ': ' + why}"
            return Fault("never-holds", message, source, node.span)
    return None


def _is_impossible(claims: Claims, rest: Linear) -> bool:
    """Whether what should not be negative is."""
    high = rest.interval(claims.ranges)[1]
    # Else nothing but measures that are never zero, taken off.
    return high < 0 or (
        high == 0
        and rest.constant == 0
        and any(c < 0 and a in claims.positive for a, c in rest.terms.items())
    )


def _describe_range(claims: Claims, region: Region, bound: Bound) -> str:
    """Return the range of what is measured, if that is the reason."""
    if len(bound.full.terms) != 1 or bound.half.interval(claims.ranges)[1] >= 0:
        return ""
    ((atom, factor),) = bound.full.terms.items()
    if region.measure.terms.get(atom) != abs(factor):
        return ""
    name = f"`{in_short(region.source, region.node.measure)}`"
    if atom[0] == "count":
        name = f"the number of `{str(atom[1])[1:]}`"
    low, high = claims.ranges[atom]
    end, side = (high, "most") if bound is region.low_bound else (low, "least")
    word = claims.scope.words.get(str(atom[0]))
    shown = f"{end:g}"
    if word is not None and word.gives is Gives.ANGLE:
        shown = f"{end:g} deg"
    elif word is not None and word.gives is Gives.RATIO:
        shown = f"{100 * end:g} %"
    return f"{name} is at {side} {shown}" if math.isfinite(end) else ""
