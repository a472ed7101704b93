"""Why a condition holds or not, as data: a tree down to the measured facts.

As text it is in trace.py, the one step of it that a reader needs in reasons.py.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from facetlog.kb.explaining.amounts import (
    PERCENT,
    Unit,
    amount,
    beside,
    choose_unit_for,
    deviation,
    format_sd_count,
    format_with_unit,
    measured,
    tell_apart,
)
from facetlog.kb.explaining.measure_words import describe_limit, describe_ratio, measure_words

__all__ = [
    "MARKS",
    "Comparison",
    "Nearness",
    "Note",
    "Proof",
    "Shortfall",
    "Side",
    "State",
    "Within",
    "nearness",
]


Nearness = tuple[bool, float]
"""Sorts changes from the least; what an error of measurement explains comes before all else."""


class State(StrEnum):
    """State of a condition or a model."""

    HOLDS = "holds"
    FAILS = "fails"
    UNKNOWN = "unknown"


class Side(StrEnum):
    """On which side of its region a value lies."""

    BELOW = "below"
    ABOVE = "above"


_SHAPES = frozenset({"board", "bar", "block"})

MARKS = {State.HOLDS: "+", State.FAILS: "-", State.UNKNOWN: "?"}


@dataclass(frozen=True, slots=True)
class Within:
    """The region that a value was tested against: near, between, at_least or at_most.

    Its edges are sharp, or fall off to nothing over the width `fading` beyond them. Over the width
    `soft`, half of it to either side of them, degrees alone fall.
    """

    sort: str
    limits: tuple[float, ...]
    fading: float = 0.0
    soft: float = 0.0

    @property
    def edges(self) -> tuple[float, float]:
        """The least and the greatest value inside, the middle of the slope where they fade."""
        match self.sort, self.limits:
            case "near", (target, tolerance):
                low, high = target - tolerance, target + tolerance
            case "between", (low, high):
                pass
            case "at_least", (low,):
                high = math.inf
            case "at_most", (high,):
                low = -math.inf
            case _:
                return -math.inf, math.inf
        # Wider by half the slope: there the membership is 1/2, on which the state turns.
        half = self.fading / 2
        return low - half, high + half

    def text(self, unit: Unit, value: float) -> str:
        """Return for example 'at most 46 mm'; degrees, which need no unit to be understood, bare.

        `value` is what is compared with it, written beside it.
        """
        limits = tuple(amount(unit.of(limit)) for limit in self.limits)
        if self.sort != "near":
            own = unit.of(value)
            limits = tuple(tell_apart(amount(own), own, unit.of(limit))[1] for limit in self.limits)
        match self.sort, limits:
            case "near", (target, tolerance):
                region = f"{target} ± {tolerance}"
            case "between", (low, high):
                region = f"{low} to {high}"
            case _:
                region = f"{self.sort.replace('_', ' ')} {', '.join(limits)}"
        if self.fading > 0:
            region = f"{region} fading over {amount(unit.of(self.fading))}"
        return region if unit.is_degree else format_with_unit(region, unit.name)


@dataclass(frozen=True, slots=True)
class Shortfall:
    """By how much a value misses its region, in its unit; `sd` is the deviation of that difference.

    A measured limit's deviation is in it too, to first order. 0 where none was measured.
    """

    amount: float
    sd: float
    side: Side

    @property
    def sds(self) -> float | None:
        """The shortfall in standard deviations; None where the deviation is 0."""
        return self.amount / self.sd if self.sd > 0 else None

    def text(self, unit: Unit) -> str:
        """Return for example '3.8° short'."""
        word = "short" if self.side is Side.BELOW else "over"
        own = unit.of(self.amount)
        missing = amount(float(measured(own, self.sd / unit.size)))
        if float(missing) == 0:  # it is less than its deviation, and no less true
            missing = amount(float(f"{self.amount / unit.size:.1g}"))
        return f"{format_with_unit(missing, unit.name)} {word}"

    def to_json(self) -> dict[str, Any]:
        """Return the shortfall as plain data."""
        return {"amount": self.amount, "sd": self.sd, "sds": self.sds, "side": self.side.value}


@dataclass(frozen=True, slots=True)
class Comparison:
    """A measured value and the region that it was tested against; kind is deg, length, ...

    `limits` are those of the region as the rules have them where they were measured themselves
    ('0.75*width(f1)'), else empty; there are none where no limit was. `unseen` are the values if
    the space that nobody saw is free, and if it is full; the value is the one that is nearer to
    failing.
    """

    measure: str
    value: float
    sd: float
    kind: str
    within: Within
    shortfall: Shortfall | None = None
    limits: tuple[str, ...] = ()
    unseen: tuple[float, float] | None = None

    def unit(self, length_unit: str | None) -> str:
        """Return the unit of the value as it is kept; empty for pure numbers."""
        match self.kind, length_unit:
            case "deg", _:
                return "°"
            case "length", str(unit):
                return unit
            case "area", str(unit):
                return f"{unit}²"
            case _:
                return ""

    def choose_unit_of_value(self, length_unit: str | None) -> Unit:
        """Return the unit in which value, deviation, limits and what is missing are all written."""
        if self.kind == "ratio":
            return PERCENT
        missing = () if self.shortfall is None else (self.shortfall.amount,)
        limits = (*self.within.limits, self.within.fading)
        return choose_unit_for(self.unit(length_unit), self.value, self.sd, *limits, *missing)

    def text(self, length_unit: str | None, *, with_sd: bool = True) -> str:
        """Return for example 'angle(f1, f2) = 90.3° ± 0.4°'."""
        unit, measure, end = self.choose_unit_of_value(length_unit), measure_words(self.measure), ""
        if self.kind == "ratio":
            measure, end = describe_ratio(self.measure)
        value, sd = unit.of(self.value), self.sd / unit.size
        number, spread = measured(value, sd), deviation(value, sd)
        if not spread:
            number = beside(value, *map(unit.of, self.within.limits))
        limits = self.within.limits
        if self.within.sort == "near":
            target, tolerance = limits
            limits = target - tolerance, target + tolerance
        for limit in limits:
            number, _ = tell_apart(number, value, unit.of(limit))
        if not spread or not with_sd:
            return f"{measure} = {format_with_unit(number, unit.name)}{end}"
        # A degree sign belongs to each number, a unit that is a word to both.
        number = format_with_unit(number, unit.name if unit.is_degree else "")
        return f"{measure} = {number} ± {format_with_unit(spread, unit.name)}{end}"

    @property
    def nearness(self) -> Nearness:
        """How near the value is to the nearest edge of its region; 0 where it has none."""
        changes = [edge - self.value for edge in self.within.edges if math.isfinite(edge)]
        change = min(changes, key=abs, default=0.0)
        sd = self.sd if self.shortfall is None else self.shortfall.sd
        return nearness(change, self.value, sd, self.kind)

    def _describe_missed_limit(self) -> str:
        """Return the limit that the value misses, if it was measured itself; else an empty text."""
        if self.shortfall is None or self.within.sort == "near" or not self.limits:
            return ""
        return describe_limit(self.limits[0 if self.shortfall.side is Side.BELOW else -1])

    def sentence(self, state: State, length_unit: str | None) -> str:
        """Return the value, the region, and by how much it misses."""
        return self.sentences(state, length_unit)[0]

    def sentences(
        self, state: State, length_unit: str | None, *, is_wanted: bool = True
    ) -> tuple[str, ...]:
        """Return the sentence in forms from the longest to the shortest: details go first.

        Of a value that holds the region, then the deviation; of one that misses the deviations,
        then by how much. What should not be and is not `is_wanted` to miss nothing.
        """
        unit = self.choose_unit_of_value(length_unit)
        text, bare = self.text(length_unit), self.text(length_unit, with_sd=False)
        region = self.within.text(unit, self.value)
        if state is State.UNKNOWN and self.unseen is not None:
            return self._open_sentences(unit, region)
        if not is_wanted and state is State.FAILS:
            return f"{text}, not {region}", f"{bare}, not {region}", bare
        if self.shortfall is not None:
            sds = (
                "" if self.shortfall.sds is None else f", {format_sd_count(self.shortfall.sds)} sd"
            )
            miss = self.shortfall.text(unit)
            so_far = " so far, but there may be more" if state is State.UNKNOWN else ""
            needs, limit = f"needs {region}", self._describe_missed_limit()
            lack = f"{needs} ({limit}): {miss}"
            whole = (
                f"{text}, {lack}{sds}{so_far}",
                f"{text}, {lack}{so_far}",
                f"{bare}, {lack}",
            )
            return (
                *(whole if limit else ()),
                f"{text}, {needs}: {miss}{sds}{so_far}",
                f"{bare}, {needs}: {miss}{sds}{so_far}",
                f"{bare}, {needs}: {miss}{so_far}",
                f"{bare}, {needs}{so_far}",
                f"{measure_words(self.measure)} is {miss}{so_far}",
                f"{miss}{so_far}",
            )
        if state is State.UNKNOWN:
            uncertain = "too uncertain to say whether it is"
            return f"{text}, {uncertain} {region}", f"{bare}, {uncertain} {region}", text
        within = "" if self.within.sort.startswith("at_") else "within "
        return f"{text}, {within}{region}", text, bare

    def _open_sentences(self, unit: Unit, region: str) -> tuple[str, ...]:
        # Which of both is so hangs on space that nobody saw.
        free, full = (amount(unit.of(value)) for value in self.unseen or ())
        measure = measure_words(self.measure)
        least, most = (format_with_unit(each, unit.name) for each in (free, full))
        ends = f"{measure} = {least} or {most}"
        return (
            f"{ends}, as what was not seen is free or full, needs {region}",
            f"{ends} (unseen space free or full), {region}",
            f"{ends}, as what was not seen is free or full",
            f"{measure} hangs on space that was not seen",
        )

    def to_json(self) -> dict[str, Any]:
        """Return value, region and what is missing as plain data."""
        within = {"sort": self.within.sort, "limits": list(self.within.limits)}
        widths = {"fading": self.within.fading, "soft": self.within.soft}
        slopes = {name: width for name, width in widths.items() if width > 0}
        missing = {} if self.shortfall is None else {"shortfall": self.shortfall.to_json()}
        return {
            "measure": self.measure,
            "value": self.value,
            "sd": self.sd,
            "kind": self.kind,
            "within": {**within, **slopes},
            **missing,
            **({} if self.unseen is None else {"unseen": list(self.unseen)}),
        }


@dataclass(frozen=True, slots=True)
class Note:
    """Other ground of a step: a relation, what is missing, what became of the children.

    `words` says it as a reader does; it is empty for steps that only join others. `counted` are of
    groups that are counted how many hold, and how many are wanted at least or at most.
    """

    name: str
    about: str = ""
    words: str = ""
    cause: str = ""
    counted: tuple[int, int] | None = None


@dataclass(frozen=True, slots=True)
class Proof:
    """One tested condition; `low` and `high` bound the probability that it truly holds."""

    state: State
    low: float
    high: float
    test: str
    detail: Comparison | Note
    children: tuple["Proof", ...] = ()

    @property
    def name(self) -> str:
        """How it was decided, as kb/prolog/explaining/prove.pl names it; empty of comparisons."""
        return self.detail.name if isinstance(self.detail, Note) else ""

    @property
    def comparison(self) -> Comparison | None:
        """The measured value that decides this step, if one does: also that of a shape."""
        if isinstance(self.detail, Comparison):
            return self.detail
        if not self.shape:
            return None
        shares = tuple(self.comparisons())
        if self.state is State.HOLDS:
            return min(shares, key=lambda c: abs(c.value - c.within.limits[0]), default=None)
        is_by_thickness = len(shares) == 1 or self.shape == "board"
        return shares[0 if is_by_thickness else -1]

    @property
    def other_shape(self) -> str:
        """The shape of a piece that is not of the one that is wanted; empty of other steps."""
        return self.detail.about if isinstance(self.detail, Note) and self.name == "short" else ""

    @property
    def shape(self) -> str:
        """The shape of a piece where a step tells or denies that it is of one, as far as known."""
        word = self.test.partition("(")[0]
        if self.name == "short" and self.state is State.HOLDS and word in _SHAPES:
            return word
        return self.other_shape

    def comparisons(self) -> Iterator[Comparison]:
        """Return all measured values that the proof rests on, in order."""
        if isinstance(self.detail, Comparison):
            yield self.detail
        for child in self.children:
            yield from child.comparisons()

    def shortfalls(self) -> Iterator[Comparison]:
        """Return the comparisons that miss and by that make this fail or stay open, in order."""
        if self.state is State.HOLDS or self.name == "not":
            return
        if isinstance(self.detail, Comparison) and self.detail.shortfall is not None:
            yield self.detail
        for child in self._list_wanting_steps():
            yield from child.shortfalls()

    def _list_wanting_steps(self) -> tuple["Proof", ...]:
        """Return the children that should have held: of groups that are counted, the next best."""
        if self.name == "implies":
            return self.children[1:]
        if self.name == "counted":
            return tuple(c for c in self.children if c.state is not State.HOLDS)[:1]
        return self.children

    @property
    def is_void(self) -> bool:
        """Whether what a second test depends on is not so."""
        return self.name == "implies" and self.children[0].state is State.FAILS

    def lacking(self) -> tuple[bool, int, int]:
        """Return whether no value misses, how many of the joined tests fail, and, negated, how many
        hold.

        An alternative for another kind of thing, as what is known from all sides, misses nothing
        that could be measured better: it says less than one that a value misses.
        """
        unmeasured = next(self.shortfalls(), None) is None
        if any(child.other_shape for child in self.children):
            unmeasured = True
        if self.name != "all":
            return unmeasured, 1, 0
        states = [child.state for child in self.children]
        return unmeasured, states.count(State.FAILS), -states.count(State.HOLDS)

    def sentence(self, length_unit: str | None = None) -> str:
        """Return this step in words."""
        return self.sentences(length_unit)[0]

    def sentences(
        self, length_unit: str | None = None, *, is_wanted: bool = True
    ) -> tuple[str, ...]:
        """Return the sentence in forms from the longest to the shortest, as for a comparison."""
        if isinstance(self.detail, Comparison):
            return self.detail.sentences(self.state, length_unit, is_wanted=is_wanted)
        if self.name in {"all", "any"} and not self.children and self.state is State.UNKNOWN:
            return (
                "nothing was found, and a part that it belongs to was not seen",
                "nothing was found",
            )
        if self.name == "any" and not self.children:
            return "nothing was found that could be it", "there is none"
        if self.shape:
            return self._shape_sentences()
        words = self.detail.words or _JOINED.get(self.detail.name, self.test)
        if self.name == "counted":
            # What comes next or decides, and whether there may be more, stand behind.
            return words, words.partition(";")[0], words.partition(", but")[0]
        return (f"{words}, because {self.detail.cause}", words) if self.detail.cause else (words,)

    def _shape_sentences(self) -> tuple[str, ...]:
        """Return which shape a piece is of, by how much, and the limit."""
        wanted, _, piece = self.test.rstrip(")").partition("(")
        is_other = f"no {wanted}: it is a {self.other_shape}"
        said = f"{piece} is {is_other if self.other_shape else f'a {self.shape}'}"
        if self.comparison is None:
            return (said,)
        share = self.comparison.text(None, with_sd=False).replace(f"({piece})", "")
        limit = amount(PERCENT.of(self.comparison.within.limits[0]))
        return f"{said} ({share.replace(' =', '')}, limit {limit} %)", said

    def to_json(self) -> dict[str, Any]:
        """Return the tree as plain data."""
        data: dict[str, Any] = {
            "test": self.test,
            "state": self.state.value,
            "degree": [self.low, self.high],
        }
        match self.detail:
            case Comparison() as comparison:
                data |= comparison.to_json()
            case Note(name, about, _, cause):
                data["note"] = f"{name}({about})" if about else name
                if cause:
                    data["cause"] = cause
        if self.children:
            data["because"] = [child.to_json() for child in self.children]
        return data


_JOINED = {
    "any": "one of these at least:",
    "not": "all this together should not be so:",
    "not_applied": "not required, for it is not known:",
    "expect": "expected, but not required:",
}


# ---- how small a change is beside others: one order for values of all kinds and units

NOISE_SDS = 3.0
"""Standard deviations within which a difference may be an error of measurement."""

# Angles have no size to be compared with: 0 is no less than 90.
RIGHT_ANGLE = 90.0

# To so many digits changes are compared: of those that differ by rounding alone the first is least,
# on every processor.
DIGITS = 9


def nearness(change: float, value: float, sd: float, kind: str) -> Nearness:
    """Return how small a change of a value of this kind (deg, length, ...) and standard deviation
    is.

    A change of at most three standard deviations may be an error of measurement: such are compared
    by their number of deviations, for they are the likelier the fewer these are. Beyond that no
    error explains it, the thing itself would have to be another: how well it was measured says
    nothing then, and a change is compared as a share of the value, before or after it, whichever is
    larger, and that of an angle as a share of a right angle.

    >>> near, far = nearness(0.02, 0.5, 0.01, "length"), nearness(0.02, 0.5, 0.001, "length")
    >>> near, far, near < far
    ((False, 2.0), (True, 0.0384615385), True)
    """
    size = abs(change)
    if sd > 0 and size <= NOISE_SDS * sd:
        return False, _round_digits(size / sd)
    if kind == "deg":
        return True, _round_digits(size / RIGHT_ANGLE)
    scale = max(abs(value), abs(value + change))
    return True, _round_digits(size / scale) if scale > 0 else 0.0


def _round_digits(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
