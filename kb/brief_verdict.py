"""Brief verdicts: what a batch keeps of each, and what it took."""

from dataclasses import dataclass, field

from facetlog.kb.confidence import Confidence
from facetlog.kb.explaining.proof import State

__all__ = ["STACKS", "BriefVerdict", "Conditions", "Cost"]

STACKS = "the limit of memory (Prolog's stacks)"
"""How bridge.pl begins what it says when a stack cannot grow."""


@dataclass(frozen=True, slots=True)
class Cost:
    """Cost of judging one thing by one model: assignments proposed, inferences of Prolog, seconds
    of processor time."""

    candidates: int = 0
    inferences: int = 0
    seconds: float = 0.0

    def __add__(self, other: "Cost") -> "Cost":
        return Cost(
            self.candidates + other.candidates,
            self.inferences + other.inferences,
            self.seconds + other.seconds,
        )


@dataclass(frozen=True, slots=True)
class Conditions:
    """How many conditions a model has, and the labels of those that the interpreter judges, in
    whole or in part, since they could not be specialised."""

    count: int
    interpreted: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class BriefVerdict:
    """Verdict of one model on one thing, as `Verdict` has it.

    `parts` are (role, names), none where nothing was seen for the role; `sizes` are
    (name, value, standard deviation).
    """

    model: str
    thing: str
    state: State
    degree: float
    degree_at_most: float
    confidence: Confidence
    parts: tuple[tuple[str, tuple[str, ...]], ...]
    sizes: tuple[tuple[str, float, float], ...]
    specialises: tuple[str, ...] = ()
    rather_than: tuple[str, ...] = field(default=(), compare=False)
    own: bool = field(default=False, compare=False)
    cost: Cost = field(default=Cost(), compare=False)
    limit: str = ""
    """Which limit the model reached on a thing with too many faces; then its verdict is unknown."""
