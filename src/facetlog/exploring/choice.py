"""Which view is taken next: the one that promises most for each second it takes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from facetlog.exploring.needs import LEAST_TURNED, Needs
from facetlog.exploring.promise import Promise, Promises
from facetlog.perception.types import Camera, FloatArray
from facetlog.robot.collecting.ring_views import STEP, Candidate, bearing

__all__ = ["Choice", "beginning", "choose"]

# Rates of promises are compared to so many digits: of views as good the first is taken.
DIGITS = 9
# Of what is open so much is named in a line.
NAMED = 3
# A place counts as the next on a ring when it is off by this share of a step: odometry's error.
NEARLY = 0.75


@dataclass(frozen=True, eq=False, slots=True)
class Choice:
    """The view that was chosen, what it promises, what was undecided, and what each of the
    candidates `among` which it was chosen promised.
    """

    candidate: Candidate
    promise: Promise
    needs: Needs
    among: tuple[tuple[Candidate, float], ...]

    @property
    def undecided(self) -> str:
        """What may turn, in words, first what most likely does."""
        return undecided(self.needs)

    @property
    def why(self) -> str:
        """Why this view, in words."""
        return (
            f"{self.promise.reason}: may turn {self.promise.mass:.2f} of {self.needs.mass:.2f} "
            f"verdicts, {self.candidate.way:.1f} m and {math.degrees(self.candidate.turns):.0f}° "
            f"of turns away ({self.candidate.seconds:.0f} s)"
        )


def undecided(needs: Needs) -> str:
    """What may turn, in words, first what most likely does."""
    ranked = sorted(needs.open, key=lambda each: -round(each.mass, DIGITS))
    named = [f"{e.model} ({e.mass:.0%})" if e.model else "what is there" for e in ranked]
    more = f" and {len(named) - NAMED} more" if len(named) > NAMED else ""
    return (", ".join(named[:NAMED]) + more) or "nothing"


def choose(
    candidates: Sequence[Candidate],
    needs: Needs,
    camera: Camera,
    places: Sequence[FloatArray],
    pose_cov: FloatArray | None = None,
    *,
    least: float = LEAST_TURNED,
) -> Choice | None:
    """The view with the largest promise per second after views from `places`; of equal ones the
    first. None if none may turn `least` of a verdict.

    `pose_cov` (6, 6) is that of the last view's pose: the next one's is hardly better.
    """
    promises = Promises(needs, camera, places)
    found = [(each, promises.of(each.pose, pose_cov)) for each in candidates]
    among = tuple((each, promise.mass) for each, promise in found)
    best: tuple[float, Choice] | None = None
    for candidate, promise in found:
        if promise.mass < least:
            continue
        rate = promise.mass / candidate.seconds
        if best is None or rate > best[0] * (1 + 10.0**-DIGITS):
            best = rate, Choice(candidate, promise, needs, among)
    return None if best is None else best[1]


def beginning(
    candidates: Sequence[Candidate], target: FloatArray, places: Sequence[FloatArray]
) -> Candidate | None:
    """The nearest in time of those that lie a step on a ring from every earlier view: the first
    views are neighbours, whose pictures have faces in common.
    """
    angles = [bearing(target, place) for place in places]
    free = [
        each
        for each in candidates
        if all(
            abs(math.remainder(bearing(target, each.pose.centre) - angle, math.tau)) > NEARLY * STEP
            for angle in angles
        )
    ]
    return min(free, key=lambda each: round(each.seconds, DIGITS), default=None)
