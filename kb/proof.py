"""Why a condition holds or not: a tree down to the measured facts, as data and as text."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

__all__ = ["Comparison", "Note", "Proof", "State", "Within", "amount"]


class State(StrEnum):
    """What is known of a condition or a model."""

    HOLDS = "holds"
    FAILS = "fails"
    UNKNOWN = "unknown"


MARKS = {State.HOLDS: "+", State.FAILS: "-", State.UNKNOWN: "?"}


def amount(value: float) -> str:
    """The number as a reader wants it: four digits, no exponent in everyday sizes.

    >>> amount(90.0), amount(0.25401), amount(12345.6)
    ('90', '0.254', '12346')
    """
    return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.4g}"


@dataclass(frozen=True, slots=True)
class Within:
    """The region that a value was tested against: near, between, at_least or at_most."""

    sort: str
    limits: tuple[float, ...]

    def __str__(self) -> str:
        limits = tuple(map(amount, self.limits))
        match self.sort, limits:
            case "near", (target, tolerance):
                return f"{target} ± {tolerance}"
            case "between", (low, high):
                return f"{low} to {high}"
            case _:
                return f"{self.sort.replace('_', ' ')} {', '.join(limits)}"


@dataclass(frozen=True, slots=True)
class Comparison:
    """A measured value and the region that it was tested against; kind is deg, length, ..."""

    measure: str
    value: float
    sd: float
    kind: str
    within: Within

    def text(self, length_unit: str | None) -> str:
        """For example 'angle(f1, f2) = 90.3 ± 0.4 deg'."""
        unit = {"deg": "deg", "length": length_unit, "area": length_unit and f"{length_unit}²"}
        spread = f" ± {self.sd:.2g}" if self.sd > 0 else ""
        return f"{self.measure} = {amount(self.value)}{spread} {unit.get(self.kind) or ''}".rstrip()

    def verb(self, state: State) -> str:
        """How the value lies to the region."""
        match state:
            case State.HOLDS:
                return "within"
            case State.FAILS:
                return "not"
            case State.UNKNOWN:
                return "so far, wanted" if self.kind == "count" else "too uncertain for"


@dataclass(frozen=True, slots=True)
class Note:
    """What else a step rests on: a relation, what is missing, what became of the children."""

    name: str
    about: str = ""


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

    def deciding(self) -> "Proof":
        """The first leaf that made this fail or stay open; for one that holds, itself."""
        negated = isinstance(self.detail, Note) and self.detail.name == "not"
        for child in self.children:
            if negated or child.state is self.state:
                return child.deciding()
        return self

    def sentence(self, length_unit: str | None = None) -> str:
        """This step alone, in words."""
        match self.detail:
            case Comparison() as c:
                verb = (
                    ""
                    if c.within.sort.startswith("at_") and self.state is State.HOLDS
                    else (c.verb(self.state) + " ")
                )
                return f"{c.text(length_unit)}, {verb}{c.within}"
            case Note("missing", measure):
                return f"{measure} is not known"
            case Note("fact", truth):
                return {"true": self.test, "false": f"not {self.test}"}.get(
                    truth, f"{self.test} is not known"
                )
            case Note("not_asked"):
                return f"{self.test}: not asked, as it is not known"
            case _:
                return self.test

    def lines(self, length_unit: str | None = None, depth: int = 0) -> Iterator[str]:
        """The tree as text, one line a step; steps that only join others are left out.

        Of alternatives that hold, those that do not are left out as well: they are no reason.
        """
        joins = isinstance(self.detail, Note) and self.detail.name in ("all", "any", "short")
        if not joins:
            yield f"{'  ' * depth}{MARKS[self.state]} {self.sentence(length_unit)}"
        children = self.children
        if joins and self.detail == Note("any") and self.state is State.HOLDS:
            children = tuple(c for c in children if c.state is State.HOLDS)
        for child in children:
            yield from child.lines(length_unit, depth if joins else depth + 1)

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
            case Note(name, about):
                data["note"] = f"{name}({about})" if about else name
        if self.children:
            data["because"] = [child.to_json() for child in self.children]
        return data
