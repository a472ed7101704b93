"""Margins of a model's conditions on a solid: fitting makes them large.

A verdict's proofs become margins as in the robust semantics of signal temporal logic: of what must
all hold the least counts, of alternatives the greatest, and `not` turns the sign. A measured value
has its distance to the nearer end of its limits, as a share of half their width, or of the limit
where there is one alone: 1 in the middle, 0 at the limit, negative beyond. Between positive limits
it is distances of logarithms that count, since sizes compare by factors.
"""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from facetlog.kb.explaining.proof import Comparison, Note, Proof, State
from facetlog.kb.explaining.verdict import Verdict
from facetlog.perception.scene import Scene

FAR = 0.5
"""The most that a margin counts where solids are compared: in the middle half of its limits all is
well. What is true or false alone is so far from its limit."""
OPEN = -0.5 * FAR

Margins = Mapping[tuple[str, str], float]
"""The margin of each demand by the label of its condition, and which of its demands it is."""

# Names of a scene's faces, pieces and openings, which follow their order in it.
_NAMES = re.compile(r"\b[fpo]\d+\b")

EXPECTED, PART = "expected", "part"
"""Instead of a label, of what is expected alone, and of parts that were not found."""


@dataclass(frozen=True, slots=True)
class Judged:
    """A solid with what a model says of it, and by how much."""

    sizes: Mapping[str, float]
    scene: Scene
    verdict: Verdict
    margins: Margins

    @property
    def holds(self) -> bool:
        """Whether the model says that it is one."""
        return self.verdict.state is State.HOLDS

    @property
    def missed(self) -> tuple[str, ...]:
        """The labels of what is to hold and does not: parts that are missing, conditions."""
        parts = (label for kind, label in self.margins if kind == PART)
        unmet = (c.label for c in self.verdict.conditions if c.proof.state is not State.HOLDS)
        return (*parts, *unmet)

    @property
    def fails_alone(self) -> str:
        """The label of the one condition that fails while all others hold; empty if not so."""
        failed = self.verdict.list_conditions_in_state(State.FAILS)
        return failed[0].label if len(failed) == len(self.missed) == 1 else ""

    @property
    def rank(self) -> tuple[float, ...]:
        """Greater is better: what is unmet, the degree in tenths, the least margin, all together.

        Of demands that are expected alone it counts how many are not met.
        """
        unmet = sum(c.proof.state is not State.HOLDS for c in self.verdict.conditions)
        missed = sum(margin <= 0.0 for margin in self.margins.values())
        enough = [min(FAR, margin) for margin in self.margins.values()]
        least = min(enough, default=0.0)
        total = math.fsum(enough) / max(1, len(enough))
        degree = math.floor(10.0 * self.verdict.degree) / 10.0
        return (-float(unmet), float(self.holds), -float(missed), degree, least, total)


def compute_margins(verdict: Verdict) -> Margins:
    """Return the margins of all demands of a verdict; of parts that were not found as well.

    Where all conditions are decided, the parts that were not found are optional.
    """
    found: dict[tuple[str, str], float] = {}
    is_open = bool(verdict.list_conditions_in_state(State.UNKNOWN))
    for part in verdict.parts:
        if is_open and not part.faces and not part.is_group:
            found[PART, part.role] = -FAR
    for condition in verdict.conditions:
        proof, label = condition.proof, condition.label
        if proof.name == "expect":
            proof, label = proof.children[0], EXPECTED
        for path, margin in _demands(proof, condition.label):
            found[label, path] = margin
    return MappingProxyType(found)


def _demands(proof: Proof, path: str) -> Iterator[tuple[str, float]]:
    """Yield what must all hold, each apart; of a value with two limits each of both."""
    if proof.name in {"all", "short", "if_known"} and proof.children:
        for nth, child in enumerate(_in_order(proof.children)):
            yield from _demands(child, f"{path}.{nth}")
    elif proof.name == "implies" and proof.children[0].state is State.HOLDS:
        # What each bench is to be is met by better benches, not by what is no bench.
        yield from _demands(proof.children[1], path)
    elif isinstance(proof.detail, Comparison) and proof.state is not State.UNKNOWN:
        for side, margin in _sides(proof.detail):
            yield f"{path} {side}", margin
    else:
        yield path, compute_margin(proof)


def _in_order(children: Sequence[Proof]) -> list[Proof]:
    """Return steps that say the same of several faces or pieces, by what was measured of them.

    Which of them is named first changes with the sizes; the least of their values hardly does.
    """
    first: dict[str, int] = {}
    for nth, child in enumerate(children):
        first.setdefault(_NAMES.sub("_", child.test), nth)
    return sorted(children, key=lambda c: (first[_NAMES.sub("_", c.test)], _measured(c)))


def _measured(proof: Proof) -> float:
    if proof.name == "implies":
        return _measured(proof.children[1])
    return proof.detail.value if isinstance(proof.detail, Comparison) else compute_margin(proof)


def compute_margin(proof: Proof) -> float:
    """Return the margin of a step: greater than 0 if it holds."""
    match proof.name:
        case "counted":
            return _counted(proof)
        case "all" | "short" | "if_known" if proof.children:
            return min(map(compute_margin, proof.children))
        case "any" if proof.children:
            return max(map(compute_margin, proof.children))
        case "implies":
            where, then = proof.children
            return compute_margin(then) if where.state is State.HOLDS else -compute_margin(where)
        case "not":
            return -compute_margin(proof.children[0])
        case _ if isinstance(proof.detail, Comparison) and proof.state is not State.UNKNOWN:
            return min(margin for _, margin in _sides(proof.detail))
        case _:
            return _flat(proof.state)


def iter_counts(proof: Proof) -> Iterator[int]:
    """Yield how many are wanted, at least or at most, wherever a proof counts."""
    if isinstance(proof.detail, Note) and proof.detail.counted is not None:
        yield proof.detail.counted[1]
    for child in proof.children:
        yield from iter_counts(child)


def _flat(state: State) -> float:
    return {State.HOLDS: FAR, State.FAILS: -FAR, State.UNKNOWN: OPEN}[state]


def _counted(proof: Proof) -> float:
    """Return the margin of a count: if it fails, by how many are too few or too many."""
    counted = proof.detail.counted if isinstance(proof.detail, Note) else None
    if proof.state is not State.FAILS or counted is None:
        return _flat(proof.state)
    holding, wanted = counted
    return -FAR * min(1.0, (1 + abs(wanted - holding)) / (1 + wanted))


def _sides(found: Comparison) -> Iterator[tuple[str, float]]:
    low, high = found.within.edges
    if low == high:  # a number of pieces
        yield "even", FAR if found.value == low else -abs(found.value - low)
        return
    value = found.value
    if found.within.sort == "between" and low > 0.0 and math.isfinite(high):
        low, high = math.log(low), math.log(high)
        value = math.log(value) if value > 0.0 else low - (high - low)
    if math.isfinite(low) and math.isfinite(high):
        scale = (high - low) / 2.0
    else:
        scale = abs(low if math.isfinite(low) else high)
    scale = scale or abs(value) or 1.0
    if math.isfinite(low):
        yield "low", (value - low) / scale
    if math.isfinite(high):
        yield "high", (high - value) / scale
    if not (math.isfinite(low) or math.isfinite(high)):
        yield "free", FAR
