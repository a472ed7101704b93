"""Margins of a verdict: the least change of one measured value that would turn it."""

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from facetlog.kb.explaining.amounts import (
    PERCENT,
    amount,
    choose_unit_for,
    format_sd_count,
    format_with_unit,
)
from facetlog.kb.explaining.measure_words import measure_words
from facetlog.kb.explaining.proof import Comparison, Nearness, Note, Proof, State, nearness

if TYPE_CHECKING:
    from facetlog.kb.explaining.verdict import Condition, Verdict

__all__ = ["Margin", "margin", "state_with", "turned"]

# Just beyond an edge, relative to the numbers there: far above a float's rounding, far below what
# any picture shows.
BEYOND = 1e-9

# Too few of what is counted may be all that was seen: kb/prolog/meaning/compare.pl, so_far/1.
_SO_FAR = re.compile(r"^(count of |count\(|faces_at\()")
# How a proof names counted groups: kb/prolog/explaining/prove.pl.
_COUNTED = re.compile(r"^(at_least_of|at_least_in|at_most_of)\((\d+)\b")


@dataclass(frozen=True, slots=True)
class Margin:
    """The change of one measured value, all others as they are, that makes the verdict `becomes`.

    `change` is signed, in the measure's unit; `sd` is the deviation of that value, or of its
    difference from a measured limit where that is known; `unit` is empty for pure numbers, `kind`
    is deg, length, ratio, ...
    """

    label: str
    measure: str
    value: float
    change: float
    sd: float
    unit: str
    becomes: State
    kind: str = ""

    @property
    def sds(self) -> float | None:
        """The size of the change in standard deviations; None where the deviation is 0."""
        return abs(self.change) / self.sd if self.sd > 0 else None

    @property
    def nearness(self) -> Nearness:
        """Sort key of changes from the least, of measures of all kinds (proof.py)."""
        return nearness(self.change, self.value, self.sd, self.kind)

    def text(self) -> str:
        """Return for example 'unknown if tilt(f1) were 3.2° more (5.1 sd)'."""
        unit = PERCENT if self.kind == "ratio" else choose_unit_for(self.unit, self.change)
        size = format_with_unit(amount(abs(unit.of(self.change))), unit.name)
        more = "more" if self.change > 0 else "less"
        sds = "" if self.sds is None else f" ({format_sd_count(self.sds)} sd)"
        return f"{self.becomes} if {measure_words(self.measure)} were {size} {more}{sds}"

    def to_json(self) -> dict[str, Any]:
        """Return the margin as plain data."""
        return {
            "label": self.label,
            "measure": self.measure,
            "value": self.value,
            "change": self.change,
            "unit": self.unit,
            "sd": self.sd,
            "sds": self.sds,
            "becomes": self.becomes.value,
        }


def margin(verdict: "Verdict") -> Margin | None:
    """Return the least change that turns the verdict on these parts; None if no single one does.

    Least as `nearness` has it. Limits that were measured themselves stay where they are.
    """
    return min(turned(verdict), key=lambda found: found.nearness, default=None)


def turned(verdict: "Verdict") -> Iterator[Margin]:
    """Yield for each measured value the least changes that turn the verdict, one for each new
    state."""
    before = _joined(c.proof.state for c in verdict.conditions)
    reading = _Reading({})
    for measure, found in _group_comparisons(verdict.conditions).items():
        asked = [c for c in verdict.conditions if measure in reading.of(c.proof)]
        others = _joined(
            c.proof.state for c in verdict.conditions if measure not in reading.of(c.proof)
        )
        nearest: dict[State, Margin] = {}
        for comparison, change, probe in _iter_edge_changes(found):
            states = [reading.state(c.proof, measure, probe) for c in asked]
            after = _joined((others, *states))
            if after is before or (after in nearest and abs(change) >= abs(nearest[after].change)):
                continue
            # The line that the change turns says more than the line that the edge belongs to.
            label = next(
                c.label for c, s in zip(asked, states, strict=True) if s is not c.proof.state
            )
            shortfall = comparison.shortfall
            nearest[after] = Margin(
                label,
                measure,
                comparison.value,
                change,
                comparison.sd if shortfall is None else shortfall.sd,
                comparison.unit(verdict.length_unit),
                after,
                comparison.kind,
            )
        yield from nearest.values()


def _group_comparisons(conditions: "Iterable[Condition]") -> dict[str, list[Comparison]]:
    """Return the different comparisons of all lines by what they measure."""
    found: dict[str, dict[Comparison, None]] = {}
    for condition in conditions:
        for comparison in condition.proof.comparisons():
            found.setdefault(comparison.measure, {})[comparison] = None
    return {measure: list(some) for measure, some in found.items()}


def _iter_edge_changes(found: Sequence[Comparison]) -> Iterator[tuple[Comparison, float, float]]:
    """Yield changes of a value up to an edge of a region, and the values there and just beyond."""
    for comparison in found:
        value = comparison.value
        for edge in filter(math.isfinite, comparison.within.edges):
            if comparison.kind == "count":
                for whole in range(max(0, math.floor(edge) - 1), math.ceil(edge) + 2):
                    yield comparison, whole - value, whole
            else:
                step = BEYOND * max(abs(edge), abs(value), BEYOND)
                for probe in (edge - step, edge, edge + step):
                    yield comparison, edge - value, probe


def _joined(states: Iterable[State]) -> State:
    """Return the joint state of lines that must all hold."""
    found = set(states)
    if State.FAILS in found:
        return State.FAILS
    return State.UNKNOWN if State.UNKNOWN in found else State.HOLDS


_OPPOSITE: Mapping[State, State] = {
    State.HOLDS: State.FAILS,
    State.FAILS: State.HOLDS,
    State.UNKNOWN: State.UNKNOWN,
}


def _join_alternatives(states: Iterable[State]) -> State:
    return _OPPOSITE[_joined(_OPPOSITE[state] for state in states)]


def state_with(proof: Proof, measure: str, value: float) -> State:
    """Return the state of a proof if the measure had this value, and all others the values they
    have."""
    return _Reading({}).state(proof, measure, value)


@dataclass(frozen=True, slots=True)
class _Reading:
    """Which measures each step of a proof rests on, by the step's identity, worked out once."""

    known: dict[int, frozenset[str]]

    def of(self, proof: Proof) -> frozenset[str]:
        """Return the measures that a step rests on."""
        found = self.known.get(id(proof))
        if found is None:
            found = frozenset().union(*map(self.of, proof.children))
            if isinstance(proof.detail, Comparison):
                found |= {proof.detail.measure}
            self.known[id(proof)] = found
        return found

    def state(self, proof: Proof, measure: str, value: float) -> State:
        """Return the state of a step if the measure had another value: three-valued logic, as it
        was."""
        if measure not in self.of(proof):
            return proof.state
        if isinstance(proof.detail, Comparison):
            return _compare_value(proof, proof.detail, value)
        states = [self.state(child, measure, value) for child in proof.children]
        return _combine_states(proof, proof.detail, states)


def _combine_states(proof: Proof, step: Note, states: list[State]) -> State:
    match step.name, states:
        case "all" | "short", _:
            return _joined(states)
        case "any", _:
            return _join_alternatives(states)
        case "not", [state]:
            return _OPPOSITE[state]
        case "if_known" | "not_applied", [state]:
            return State.HOLDS if state is State.UNKNOWN else state
        case "implies", [where, then]:
            return _join_alternatives((_OPPOSITE[where], then))
        case "expect", _:
            return State.HOLDS
        case "counted", _:
            return _counted(proof, states)
        case _:
            return proof.state


def _counted(proof: Proof, states: list[State]) -> State:
    match = _COUNTED.match(proof.test)
    if match is None:
        return proof.state
    bound, wanted = match[1], int(match[2])
    holding = states.count(State.HOLDS)
    if bound != "at_most_of":
        if holding >= wanted:
            return State.HOLDS
        # Refuted only if nothing more can be there; else more of it may be than was seen.
        open_ = states.count(State.UNKNOWN)
        refuted = proof.state is State.FAILS and holding + open_ < wanted
        return State.FAILS if refuted else State.UNKNOWN
    if holding > wanted:
        return State.FAILS
    return State.UNKNOWN if holding + states.count(State.UNKNOWN) > wanted else State.HOLDS


def _compare_value(proof: Proof, comparison: Comparison, value: float) -> State:
    low, high = comparison.within.edges
    inside = low <= value <= high
    if proof.state is State.UNKNOWN and comparison.shortfall is None and inside:
        return State.UNKNOWN  # too uncertain to say, there as here
    if inside:
        return State.HOLDS
    return State.UNKNOWN if value < low and _SO_FAR.match(comparison.measure) else State.FAILS
