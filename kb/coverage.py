"""Which lines of models ever decided a verdict, over examples and labelled scenes."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from facetlog.kb.explaining.proof import Note, Proof, State
from facetlog.kb.explaining.verdict import Condition, Verdict

__all__ = ["LineCoverage", "ModelCoverage", "coverage"]


@dataclass(frozen=True, slots=True)
class LineCoverage:
    """In how many verdicts a line held, failed or was unknown, and in how many it alone decided.

    A line alone decides that a verdict fails if no other line does, and that it is unknown if no
    other line is open: were it to hold, the verdict would turn. Of an `expected` line it is counted
    what was expected: it forbids nothing, and never decides.
    """

    label: str
    expected: bool
    held: int
    failed: int
    unknown: int
    decided: int

    @property
    def is_idle(self) -> bool:
        """Whether it could have decided a verdict, and never did."""
        return self.decided == 0 and not self.expected

    def to_json(self) -> dict[str, Any]:
        """Return the counts as plain data."""
        return asdict(self)


@dataclass(frozen=True, slots=True)
class ModelCoverage:
    """The lines of a model, and how many verdicts of it were looked at, by state."""

    model: str
    held: int
    failed: int
    unknown: int
    lines: tuple[LineCoverage, ...]

    @property
    def verdicts(self) -> int:
        """How many verdicts there were."""
        return self.held + self.failed + self.unknown

    @property
    def idle(self) -> tuple[str, ...]:
        """The lines that never decided anything, though they may."""
        return tuple(line.label for line in self.lines if line.is_idle)

    def to_json(self) -> dict[str, Any]:
        """Return the counts as plain data."""
        return {
            "model": self.model,
            "verdicts": {"holds": self.held, "fails": self.failed, "unknown": self.unknown},
            "lines": [line.to_json() for line in self.lines],
            "never_decided": list(self.idle),
        }


def coverage(
    verdicts: Iterable[Verdict], lines: Mapping[str, Mapping[str, bool]]
) -> tuple[ModelCoverage, ...]:
    """Return the coverage of each model of `lines`, which gives its labels, and whether only
    expected.

    Lines come in the order of the verdicts, among them counts of parts, which are not given.
    """
    of_model: dict[str, list[Verdict]] = {model: [] for model in lines}
    for verdict in verdicts:
        of_model.setdefault(verdict.model, []).append(verdict)
    return tuple(
        _compute_model_coverage(model, found, lines.get(model, {}))
        for model, found in of_model.items()
    )


def _compute_model_coverage(
    model: str, verdicts: Sequence[Verdict], given: Mapping[str, bool]
) -> ModelCoverage:
    labels: dict[str, bool] = {}
    for verdict in verdicts:
        for condition in verdict.conditions:
            expected = _find_expectation(condition.proof) is not None
            labels.setdefault(condition.label, given.get(condition.label, expected))
    labels |= {label: expected for label, expected in given.items() if label not in labels}
    held, failed, unknown = _count_states(verdict.state for verdict in verdicts)
    lines = tuple(_compute_line_coverage(label, labels[label], verdicts) for label in labels)
    return ModelCoverage(model, held, failed, unknown, lines)


def _compute_line_coverage(label: str, expected: bool, verdicts: Iterable[Verdict]) -> LineCoverage:
    states: list[State] = []
    decided = 0
    for verdict in verdicts:
        # A rule in Prolog may have several conditions of one label.
        own = [c for c in verdict.conditions if c.label == label]
        states.extend(map(_get_line_state, own))
        decided += _decides_alone(own, verdict)
    return LineCoverage(label, expected, *_count_states(states), decided)


def _decides_alone(own: Sequence[Condition], verdict: Verdict) -> bool:
    """Return whether these alone keep the verdict from holding, or from being open."""
    if verdict.state is State.HOLDS:
        return False
    deciding = verdict.list_conditions_in_state(verdict.state)
    return bool(deciding) and all(c in own for c in deciding)


def _get_line_state(condition: Condition) -> State:
    """Return the state of a line, or of what it expects."""
    expected = _find_expectation(condition.proof)
    return condition.proof.state if expected is None else expected.state


def _find_expectation(proof: Proof) -> Proof | None:
    """Return the expectation of a line; None for lines that must hold."""
    if isinstance(proof.detail, Note) and proof.detail.name == "expect":
        return proof.children[0]
    return None


def _count_states(states: Iterable[State]) -> tuple[int, int, int]:
    """Return how many hold, fail and are unknown."""
    found = list(states)
    return found.count(State.HOLDS), found.count(State.FAILS), found.count(State.UNKNOWN)
