"""Why a condition holds or not: a tree down to the measured facts, as data and as text."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from facetlog.kb.amounts import amount, measured, sd_count, with_unit

__all__ = ["MARKS", "Comparison", "Note", "Proof", "Shortfall", "Side", "State", "Within"]


class State(StrEnum):
    """What is known of a condition or a model."""

    HOLDS = "holds"
    FAILS = "fails"
    UNKNOWN = "unknown"


class Side(StrEnum):
    """On which side of its region a value lies."""

    BELOW = "below"
    ABOVE = "above"


MARKS = {State.HOLDS: "+", State.FAILS: "-", State.UNKNOWN: "?"}

_OPEN = f"{MARKS[State.UNKNOWN]} not known"

# Of a list of steps that all hold, this many are written out: the rest says the same again.
HOLDING_SHOWN = 6


@dataclass(frozen=True, slots=True)
class Within:
    """The region that a value was tested against: near, between, at_least or at_most.

    Its edges are sharp, or fall off to nothing over the width `fading`.
    """

    sort: str
    limits: tuple[float, ...]
    fading: float = 0.0

    def text(self, unit: str) -> str:
        """For example 'at most 0.046 m'; degrees, which need no unit to be understood, bare."""
        limits = tuple(map(amount, self.limits))
        match self.sort, limits:
            case "near", (target, tolerance):
                region = f"{target} ± {tolerance}"
            case "between", (low, high):
                region = f"{low} to {high}"
            case _:
                region = f"{self.sort.replace('_', ' ')} {', '.join(limits)}"
        if self.fading > 0:
            region = f"{region} fading over {amount(self.fading)}"
        return region if unit == "°" else with_unit(region, unit)


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

    def text(self, unit: str) -> str:
        """For example '3.8° short, 3.4 sd'."""
        word = "short" if self.side is Side.BELOW else "over"
        sds = "" if self.sds is None else f", {sd_count(self.sds)} sd"
        return f"{with_unit(measured(self.amount, self.sd), unit)} {word}{sds}"

    def to_json(self) -> dict[str, Any]:
        """The shortfall as plain data."""
        return {"amount": self.amount, "sd": self.sd, "sds": self.sds, "side": self.side.value}


@dataclass(frozen=True, slots=True)
class Comparison:
    """A measured value and the region that it was tested against; kind is deg, length, ..."""

    measure: str
    value: float
    sd: float
    kind: str
    within: Within
    shortfall: Shortfall | None = None

    def unit(self, length_unit: str | None) -> str:
        """The unit as it is written behind a number; empty for pure numbers."""
        match self.kind, length_unit:
            case "deg", _:
                return "°"
            case "length", str(unit):
                return unit
            case "area", str(unit):
                return f"{unit}²"
            case _:
                return ""

    def text(self, length_unit: str | None) -> str:
        """For example 'angle(f1, f2) = 90.3° ± 0.4°'."""
        unit = self.unit(length_unit)
        value = measured(self.value, self.sd)
        if self.sd <= 0:
            return f"{self.measure} = {with_unit(value, unit)}"
        spread = with_unit(f"{self.sd:.2g}", unit)
        # A degree sign belongs to each number, a unit that is a word to both.
        return f"{self.measure} = {with_unit(value, '°' if unit == '°' else '')} ± {spread}"

    def sentence(self, state: State, length_unit: str | None) -> str:
        """The value, the region, and by how much it misses."""
        unit = self.unit(length_unit)
        text = self.text(length_unit)
        region = self.within.text(unit)
        if self.shortfall is not None:
            miss = self.shortfall.text(unit)
            so_far = " so far, but there may be more" if state is State.UNKNOWN else ""
            return f"{text}, needs {region}: {miss}{so_far}"
        if state is State.UNKNOWN:
            return f"{text}, too uncertain to say whether it is {region}"
        within = "" if self.within.sort.startswith("at_") else "within "
        return f"{text}, {within}{region}"


@dataclass(frozen=True, slots=True)
class Note:
    """What else a step rests on: a relation, what is missing, what became of the children.

    `words` says it as a reader does; it is empty for steps that only join others.
    """

    name: str
    about: str = ""
    words: str = ""
    cause: str = ""


@dataclass(frozen=True, slots=True)
class Proof:
    """One tested condition; `low` and `high` bound the probability that it truly holds."""

    state: State
    low: float
    high: float
    test: str
    detail: Comparison | Note
    children: tuple["Proof", ...] = ()

    def comparisons(self) -> Iterator[Comparison]:
        """All measured values that the proof rests on, in order."""
        if isinstance(self.detail, Comparison):
            yield self.detail
        for child in self.children:
            yield from child.comparisons()

    def shortfalls(self) -> Iterator[Comparison]:
        """The comparisons that miss and by that make this fail or stay open, in order."""
        if self.state is State.HOLDS or self._is("not"):
            return
        if isinstance(self.detail, Comparison) and self.detail.shortfall is not None:
            yield self.detail
        for child in self._wanting():
            yield from child.shortfalls()

    def _wanting(self) -> tuple["Proof", ...]:
        """The children that should have held: of groups that are counted, the next best."""
        if self._is("implies"):
            return self.children[1:]
        if self._is("counted"):
            return tuple(c for c in self.children if c.state is not State.HOLDS)[:1]
        return self.children

    def because(self, length_unit: str | None = None) -> str:
        """The first reason for the state, in words."""
        if self._is("not") and self.children:
            reason = self.children[0].because(length_unit)
            return f"{reason}, which should not be" if self.state is State.FAILS else reason
        if self._is("implies"):
            then = "" if self._is_void() else f"then {self.children[1].because(length_unit)}"
            return f"{self._where(length_unit)}{then}"
        if self._is("counted"):
            return self.sentence(length_unit)
        same = [child for child in self.children if child.state is self.state]
        if not same:
            return self.sentence(length_unit)
        # Of alternatives that all fail, the one that lacks least is worth saying.
        first = min(same, key=Proof._lacking) if self._is("any") else same[0]
        return first.because(length_unit)

    def _lacking(self) -> tuple[bool, int, int]:
        """Whether no value misses, how many of the joined tests fail, and, negated, how many hold.

        An alternative for another kind of thing, as what is known from all sides, misses nothing
        that could be measured better: it says less than one that a value misses.
        """
        unmeasured = next(self.shortfalls(), None) is None
        if not self._is("all"):
            return unmeasured, 1, 0
        states = [child.state for child in self.children]
        return unmeasured, states.count(State.FAILS), -states.count(State.HOLDS)

    def sentence(self, length_unit: str | None = None) -> str:
        """This step alone, in words."""
        if isinstance(self.detail, Comparison):
            return self.detail.sentence(self.state, length_unit)
        if self._is("any") and not self.children:
            return "there is nothing to choose from"
        words = self.detail.words or _JOINED.get(self.detail.name, self.test)
        cause = f", because {self.detail.cause}" if self.detail.cause else ""
        return f"{words}{cause}"

    def lines(self, length_unit: str | None = None, depth: int = 0) -> Iterator[str]:
        """The tree as text, one line a step; steps that only join others are left out.

        Of alternatives that hold, those that do not are left out as well: they are no reason. Nor
        are more than a few of many steps that hold written out, nor anything twice.
        """
        indent = "  " * depth
        if self._is("not") and not self.children[0].children:
            yield f"{indent}{MARKS[self.state]} {self.because(length_unit)}"
            return
        if self._is("implies"):
            yield from self._implied_lines(length_unit, depth)
            return
        joins = self._joins()
        if not joins:
            yield f"{indent}{MARKS[self.state]} {self.sentence(length_unit)}"
        inner = depth if joins else depth + 1
        shown: set[str] = set()
        open_ones: set[str] = set()
        holding = 0
        for child in self._shown_children():
            holding += child.state is State.HOLDS
            if child.state is State.HOLDS and holding > HOLDING_SHOWN:
                continue
            text = tuple(child.lines(length_unit, inner))
            if "\n".join(text) not in shown:
                shown.add("\n".join(text))
                # What leaves several alternatives open is told of the first.
                for line in text:
                    if line not in open_ones:
                        yield line
                open_ones.update(line for line in text if line.lstrip().startswith(_OPEN))
        if holding > HOLDING_SHOWN:
            yield f"{'  ' * inner}+ and {holding - HOLDING_SHOWN} more that hold"

    def _implied_lines(self, length_unit: str | None, depth: int) -> Iterator[str]:
        then = self.children[1]
        head = f"{'  ' * depth}{MARKS[self.state]} {self._where(length_unit)}"
        if self._is_void():
            yield head
        elif not then.children:
            yield f"{head}then {then.sentence(length_unit)}"
        else:
            yield f"{head}then:"
            yield from then.lines(length_unit, depth + 1)

    def _is_void(self) -> bool:
        """Whether what a second test depends on is not so."""
        return self.children[0].state is State.FAILS

    def _where(self, length_unit: str | None) -> str:
        where = f"where {self.children[0].because(length_unit)}, "
        return f"{where}nothing is asked" if self._is_void() else where

    def _is(self, *names: str) -> bool:
        return isinstance(self.detail, Note) and self.detail.name in names

    def _joins(self) -> bool:
        if self._is("any"):
            return self.state is State.HOLDS or len(self.children) == 1
        if self._is("expect"):
            return self.children[0].state is State.HOLDS
        return self._is("short", "if_known", "all")

    def _shown_children(self) -> tuple["Proof", ...]:
        if self._is("any"):
            if self.state is State.HOLDS:
                return tuple(c for c in self.children if c.state is State.HOLDS)
            return tuple(c for child in self.children for c in child._alternatives())
        if self._is("counted"):
            # Those that hold are too many, or enough; else the best of the others are what lacks.
            others = tuple(c for c in self.children if c.state is not State.HOLDS)
            wanting = others[:HOLDING_SHOWN] if self.state is State.UNKNOWN else ()
            return tuple(c for c in self.children if c.state is State.HOLDS) + wanting
        return self.children

    def _alternatives(self) -> tuple["Proof", ...]:
        """An alternative that itself lists alternatives, taken apart."""
        if self.state is State.HOLDS or not self.children:
            return (self,)
        if self._is("short"):
            return self.children[0]._alternatives()
        if self._is("any"):
            return tuple(c for child in self.children for c in child._alternatives())
        return (self,)

    def to_json(self) -> dict[str, Any]:
        """The tree as plain data."""
        data: dict[str, Any] = {
            "test": self.test,
            "state": self.state.value,
            "degree": [self.low, self.high],
        }
        match self.detail:
            case Comparison() as c:
                data["measure"] = c.measure
                data["value"], data["sd"], data["kind"] = c.value, c.sd, c.kind
                data["within"] = {"sort": c.within.sort, "limits": list(c.within.limits)}
                if c.within.fading > 0:
                    data["within"]["fading"] = c.within.fading
                if c.shortfall is not None:
                    data["shortfall"] = c.shortfall.to_json()
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
    "not_asked": "not asked, for it is not known:",
    "expect": "expected, but not required:",
}
