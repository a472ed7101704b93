"""Tolerances that always or never hold, and those that pictures are too coarse for."""

import math
from collections.abc import Iterator

from facetlog.grammar import syntax as s
from facetlog.grammar.faults import Fault, Severity
from facetlog.grammar.fixing.fix import Edit, Fix, swap
from facetlog.grammar.lint.claims import Bound, Claims, Place, Region, in_short
from facetlog.grammar.lint.linear import Linear
from facetlog.grammar.source import Span
from facetlog.grammar.units import Dimension
from facetlog.grammar.vocabulary import Gives, Word

__all__ = ["region_faults"]

TYPICAL_ANGLE_SD = 0.02
"""Degrees: what the deviation of an angle between two faces is at best. Half of all errors were
below 0.014 degrees in the demo's rendered pictures (accuracy_demo in docs/benchmarks.md), which is
0.67 sd. Real pictures are worse: a region that is too narrow for these is so for all."""

HALF = 0.6745
"""Standard deviations either side of the middle that hold half of a normal distribution."""


def region_faults(claims: Claims, seen: dict[int, bool], reported: set[Place]) -> Iterator[Fault]:
    """What is odd about each comparison that the model itself makes, one fault for each at most.

    `seen` are the comparisons (ids) that were looked at, and whether they have a fault:
    definitions are used more than once. `reported` gets the places of the latter. Both grow.
    """
    for region in claims.regions:
        if region.own and id(region.node) not in seen:
            faults = list(_Look(claims, region).faults())
            seen[id(region.node)] = bool(faults)
            yield from faults
        if seen.get(id(region.node)):
            reported.add(region.place)


class _Look:
    def __init__(self, claims: Claims, region: Region) -> None:
        self.claims = claims
        self.region = region
        self.node = region.node

    def fault(
        self,
        code: str,
        message: str,
        node: s.Node,
        hint: str,
        fixes: tuple[Fix, ...] = (),
        *,
        sure: bool,
    ) -> Fault:
        severity = Severity.ERROR if sure else Severity.WARNING
        return Fault(code, message, self.region.source, node.span, hint, severity, fixes)

    def faults(self) -> Iterator[Fault]:
        region = self.region
        if all(bound.full.is_constant for bound in region.bounds) and region.measure.is_constant:
            yield self.fault(
                "nothing-measured", "numbers are compared here, and nothing is measured",
                self.node, "name a measure: `length(top)`", sure=False,
            )  # fmt: skip
            return
        found = self._width() or self._never() or self._always() or self._too_narrow()
        if found is not None:
            yield found

    # ------------------------------------------------- tolerance and fading

    def _width(self) -> Fault | None:
        node, region = self.node, self.region
        if node.second is not None and region.tolerance is not None:
            found = self._negative("tolerance", region.tolerance, node.second)
            if found is not None:
                return found
            if _is_zero(region.tolerance) and not self._counts():
                return self.fault(
                    "zero-tolerance", "with a tolerance of 0 only an exact value will do",
                    node.second, "no measure is exact: give it some room", sure=False,
                )  # fmt: skip
        if node.fading is not None and region.fading is not None:
            found = self._negative("fading", region.fading, node.fading)
            if found is not None:
                return found
            if _is_zero(region.fading):
                return self.fault(
                    "zero-fading", "a fading of 0 changes nothing", node.fading,
                    "leave it out", self._without_fading(node.fading), sure=False,
                )  # fmt: skip
        return None

    def _negative(self, what: str, width: Linear, node: s.Expression) -> Fault | None:
        if not width.is_constant or width.constant >= 0:
            return None
        message = f"a {what} cannot be negative"
        hint = "write it without the sign"
        return self.fault("negative-width", message, node, hint, self._unsigned(node), sure=True)

    def _unsigned(self, node: s.Expression) -> tuple[Fix, ...]:
        if not isinstance(node, s.Negative) or not isinstance(node.operand, s.Quantity):
            return ()
        number = node.operand.span.start
        before = self.region.source.text[:number].rstrip()
        if not before.endswith("-"):
            return ()  # brackets stand there
        sign = Span(len(before) - 1, number)
        return (Fix("leave the sign out", (Edit(sign, ""),), True),)

    def _without_fading(self, fading: s.Expression) -> tuple[Fix, ...]:
        before = self.node.second or self.node.limit
        word = self.region.source.text[before.span.end : fading.span.start]
        if word.strip() != "fading":
            return ()  # brackets stand there
        edit = Edit(Span(before.span.end, fading.span.end), "")
        return (Fix("leave the fading out", (edit,), True),)

    def _counts(self) -> bool:
        words = self.claims.scope.words
        names = [str(atom[0]) for atom in self.region.measure.terms]
        return all(n == "count" or (n in words and words[n].gives is Gives.COUNT) for n in names)

    # --------------------------------------------------------- never, always

    def _never(self) -> Fault | None:
        low, high = self.region.low_bound, self.region.high_bound
        if low is not None and high is not None and self._impossible(low.half.plus(high.half)):
            first, second = self._ends()
            message = f"this never holds: {first} is more than {second}"
            hint, fixes = "change them round", self._ends_swapped()
            return self.fault("never-holds", message, self.node, hint, fixes, sure=True)
        for bound in self.region.bounds:
            if self._impossible(bound.half):
                why = self._why(bound)
                message = f"this never holds{why and ': ' + why}"
                return self.fault("never-holds", message, self.node, "", sure=True)
        return None

    def _ends(self) -> tuple[str, str]:
        limit, second = self.node.limit, self.node.second or self.node.limit
        return tuple(f"`{in_short(self.region.source, n)}`" for n in (limit, second))  # type: ignore[return-value]

    def _ends_swapped(self) -> tuple[Fix, ...]:
        node, region = self.node, self.region
        if node.comparator is not s.Comparator.BETWEEN or node.second is None:
            return ()
        constant = all(end is not None and end.is_constant for end in (region.low, region.high))
        return (swap(region.source.text, node.limit.span, node.second.span, sure=constant),)

    def _impossible(self, rest: Linear) -> bool:
        """Whether what should not be negative is."""
        high = rest.interval(self.claims.ranges)[1]
        if high < 0:
            return True
        # Nothing but measures that are never zero, taken off.
        positive = self.claims.positive
        return high == 0 and rest.constant == 0 and any(
            c < 0 and a in positive for a, c in rest.terms.items()
        )  # fmt: skip

    def _always(self) -> Fault | None:
        bounds = self.region.bounds
        ranges = self.claims.ranges
        lowest = [bound.full.interval(ranges)[0] for bound in bounds]
        if all(low >= 0 for low in lowest):
            why = " and ".join(dict.fromkeys(filter(None, map(self._why, bounds))))
            message = f"this always holds{why and ': ' + why}"
            return self.fault(
                "always-holds", message, self.node, "it decides nothing: leave it out", sure=False
            )
        if len(self.region.measure.terms) == 1:
            (atom,) = self.region.measure.terms
            ends = (self.region.low, self.region.high)
            if any(end is not None and atom in end.terms for end in ends):
                name = in_short(self.region.source, self.node.measure)
                return self.fault(
                    "same-measure", f"`{name}` is compared with itself", self.node,
                    "compare it with another measure", sure=False,
                )  # fmt: skip
        return None

    def _why(self, bound: Bound) -> str:
        """The range of what is measured, if that says it all."""
        if len(bound.full.terms) != 1 or bound.full.absolute:
            return ""
        ((atom, factor),) = bound.full.terms.items()
        if atom not in self.region.measure.terms or self.region.measure.terms[atom] != abs(factor):
            return ""
        low, high = self.claims.ranges[atom]
        word = self.claims.scope.words.get(str(atom[0]))
        name = in_short(self.region.source, self.node.measure)
        name = f"the number of `{str(atom[1])[1:]}`" if atom[0] == "count" else f"`{name}`"
        # The end of the range that is nearer to this end of the region decides.
        below = bound is self.region.low_bound
        never = bound.half.interval(self.claims.ranges)[1] < 0
        end, side = (high, "most") if below == never else (low, "least")
        return f"{name} is at {side} {_shown(end, word)}" if math.isfinite(end) else ""

    # ------------------------------------------------------------ too narrow

    def _too_narrow(self) -> Fault | None:
        """An angle's region that is narrower than what pictures leave of it."""
        low, high, region = self.region.low, self.region.high, self.region
        if low is None or high is None or region.measure.dimension is not Dimension.ANGLE:
            return None
        if not (low.is_constant and high.is_constant) or list(region.measure.terms.values()) != [1]:
            return None
        fading = region.fading.constant if region.fading is not None else 0.0
        width = high.constant - low.constant + fading
        least = 2 * HALF * TYPICAL_ANGLE_SD
        if width >= least:
            return None
        message = (
            f"this can hardly hold: the region is {width:.2g} deg wide, and measured angles are "
            f"off by {TYPICAL_ANGLE_SD} deg and more"
        )
        return self.fault("too-narrow", message, self.node, "give it a degree or more", sure=False)


def _is_zero(width: Linear) -> bool:
    return width.is_constant and width.constant == 0


def _shown(value: float, word: Word | None) -> str:
    if word is not None and word.gives is Gives.ANGLE:
        return f"{value:g} deg"
    if word is not None and word.gives is Gives.RATIO:
        return f"{100 * value:g} %"
    return f"{value:g}"
