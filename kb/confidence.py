"""A confidence: how often a verdict is right, how well that is known, and where from."""

from dataclasses import dataclass
from typing import Any

__all__ = ["DEGREES_ASKED", "Confidence"]

DEGREES_ASKED = "degrees were asked for"

WIDE = 0.2
"""Width of an interval that is given in place of one figure: that is known no better than by 10 %
to either side."""

SOURCES_NAMED = 4  # on one line, beside the counts


@dataclass(frozen=True, slots=True)
class Confidence:
    """How often a thing is what the model describes where it gives such a verdict.

    `low` and `high` bound the share with a probability of nine tenths. Of `cases` labelled things
    on which the model gave such a verdict, `true` were what it describes; `sources` are the
    collections that they are from. Without a `value` there is the `reason`.
    """

    value: float | None = None
    low: float | None = None
    high: float | None = None
    cases: int = 0
    true: int = 0
    sources: tuple[str, ...] = ()
    reason: str = ""

    @property
    def is_wide(self) -> bool:
        """Whether it is known so badly that only its bounds should be named."""
        return self.low is not None and self.high is not None and self.high - self.low > WIDE

    def format(self, degree: float) -> str:
        """Return the share, or the bounds of one that few cases say; without one the degree.

        >>> Confidence(0.931, 0.87, 0.96).format(1.0), Confidence(0.8, 0.6, 0.95).format(1.0)
        ('93%', 'few cases: 60–95%')
        >>> Confidence().format(0.98)
        'degree 98%'
        """
        if self.value is None:
            return f"degree {degree:.0%}"
        if self.low is None or self.high is None or not self.is_wide:
            return f"{self.value:.0%}"
        return f"few cases: {100 * self.low:.0f}–{self.high:.0%}"

    @property
    def origin(self) -> str:
        """Where the figure comes from, or why there is none.

        >>> Confidence(0.93, 0.87, 0.96, 32, 31, ("ikea", "ycb")).origin
        'true of 31 of 32 labelled cases (ikea, ycb)'
        """
        if self.value is None:
            return self.reason
        if not self.cases:
            return "no labelled case of its own; by those of other models"
        named = list(self.sources[:SOURCES_NAMED])
        more = len(self.sources) - len(named)
        which = ", ".join([*named, *([f"{more} more"] if more else [])])
        return f"true of {self.true} of {self.cases} labelled cases ({which})"

    def to_json(self) -> dict[str, Any]:
        """Return the share with its bounds, and where it comes from, as columns of results."""
        return {
            "confidence": self.value,
            "confidence_low": self.low,
            "confidence_high": self.high,
            "confidence_origin": self.origin,
        }
