"""Limits of one question."""

from dataclasses import dataclass

from facetlog.kb.engine.terms import Struct

__all__ = ["Limits"]


@dataclass(frozen=True, slots=True)
class Limits:
    """Bounds of one question; a question that reaches one ends with an EngineError.

    `seconds` is the processor time that Prolog may work for all its answers, and a fifth of the
    time by the clock; `inferences` (some 10 to 20 million a second) and `stack_mb` bound each
    chunk of them.
    """

    seconds: float = 30.0
    inferences: int = 300_000_000
    stack_mb: int = 256

    def __post_init__(self) -> None:
        for name in ("seconds", "inferences", "stack_mb"):
            if not getattr(self, name) > 0:
                raise ValueError(f"the limit {name} must be above 0")

    @property
    def bounds(self) -> Struct:
        """bounds(Inferences, StackBytes), which Prolog keeps; the caller keeps the time."""
        return Struct("bounds", (int(self.inferences), int(self.stack_mb) << 20))
