"""The views among which an exploring robot chose one, as collect.jsonl has them."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from facetlog.perception.types import FloatArray
from facetlog.robot.collecting.next_stop import CHOSEN

__all__ = ["CandidateView", "candidate_views"]

# Of the ball that stands for the best of some candidates, and for one that promised nothing, m.
LARGEST, SMALLEST = 0.05, 0.008


@dataclass(frozen=True, eq=False, slots=True)
class CandidateView:
    """A view from a `place` (3,) that could be taken: the probability `mass` of verdicts that it
    may turn, `seconds` until it is there. `radius` is that of the ball that stands for it (m): its
    area is as what it promised a second.
    """

    place: FloatArray
    mass: float
    seconds: float
    is_chosen: bool
    radius: float

    @property
    def words(self) -> str:
        """For example 'may turn 0.31 verdicts, in 9 s'."""
        return f"may turn {self.mass:.2f} verdicts, in {self.seconds:.0f} s"


def candidate_views(lines: Sequence[Mapping[str, object]], name: str) -> tuple[CandidateView, ...]:
    """Those among which the view of a name was chosen; none of one of a tour, or of the first."""
    rows: object = next(
        (
            line.get("candidates")
            for line in reversed(lines)
            if line.get("result") == CHOSEN and line.get("image") == name
        ),
        None,
    )
    if not isinstance(rows, list) or not rows:
        return ()
    table = np.array(rows, dtype=np.float64).reshape(-1, 6)
    rates = table[:, 3] / np.maximum(table[:, 4], 1e-9)
    most = float(rates.max())
    return tuple(
        CandidateView(
            row[:3],
            float(row[3]),
            float(row[4]),
            bool(row[5]),
            max(LARGEST * math.sqrt(rate / most) if most > 0 else 0.0, SMALLEST),
        )
        for row, rate in zip(table, rates, strict=True)
    )
