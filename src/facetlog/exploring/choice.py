"""Which view is taken next: the one that promises most for each second it takes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import ndtr, ndtri

from facetlog.exploring.open_questions import LEAST_TURNED, Lack, Needs, SeenThing
from facetlog.exploring.sides import GRAZING, Sides, units
from facetlog.kb.explaining.unseen import NEAR_DEG
from facetlog.perception.estimation.point_recursion import update_by_view
from facetlog.perception.estimation.pose_noise import compute_pixel_covs
from facetlog.perception.min_views import FEWEST_VIEWS
from facetlog.perception.types import Camera, FloatArray, Pose, View
from facetlog.robot.collecting.ring_views import STEP, Candidate, bearing

# Rates of promises are compared to so many digits: of views as good the first is taken.
DIGITS = 9
# Of what is open so much is named in a line.
NAMED = 3
# A place counts as the next on a ring when it is off by this share of a step: odometry's error.
NEARLY = 0.75

# How well a corner is found in a picture, px: half a pixel, as two edges that are right to a third.
CORNER_SD_PX = 0.5


@dataclass(frozen=True, slots=True)
class Promise:
    """Expected gain of a view: the probability `mass` of verdicts that it may turn, and of what
    lacks the shares (0..1) of the thing that counts most: missing sides, unseen space, corners'
    spread.
    """

    mass: float
    sides: float = 0.0
    space: float = 0.0
    corners: float = 0.0

    @property
    def reason(self) -> str:
        """The new information of the view in words."""
        parts = [
            f"{share:.0%} of {what}"
            for share, what in (
                (self.sides, "the sides that lack views"),
                (self.space, "the space that nobody looked into"),
            )
            if share >= LEAST_SAID
        ]
        if self.corners >= LEAST_SAID:
            parts.append(f"corners surer by {self.corners:.0%}")
        return ", ".join(parts) or "nothing new"


# Shares are said in whole per cents.
LEAST_SAID = 0.005


class Promises:
    """Expected gains of views where `needs` are left after views from `places`, in order."""

    def __init__(self, needs: Needs, camera: Camera, places: Sequence[FloatArray]) -> None:
        self._camera = camera
        self._of_thing = {
            thing.name: _Seen(thing, np.array(places).reshape(-1, 3)) for thing in needs.things
        }
        self._open = needs.open

    def of(self, pose: Pose, pose_cov: FloatArray | None = None) -> Promise:
        """Return what a view from a pose promises; `pose_cov` (6, 6) is how sure the pose
        would be.
        """
        shares: dict[str, tuple[float, float, float]] = {}
        masses: dict[str, float] = {}
        for each in self._open:
            seen = self._of_thing[each.thing]
            if each.thing not in shares:
                surer = seen.surer(self._camera, pose, pose_cov)
                shares[each.thing] = (*seen.shown(pose.centre), surer)
            sides, space, corners = shares[each.thing]
            share = {Lack.SIDES: sides, Lack.SPACE: space, Lack.CORNERS: corners}
            of_lack = [share[lack] for lack in each.lack]
            # It fails by any condition and holds by all: which it comes to is not known.
            unseen = (min(of_lack) + max(of_lack)) / 2
            gained = each.unseen * unseen + each.assumed * sides
            gained += _crossing(each.measured, corners)
            masses[each.thing] = masses.get(each.thing, 0.0) + gained
        if not masses:
            return Promise(0.0)
        most = max(masses, key=lambda thing: round(masses[thing], 9))
        return Promise(sum(masses.values()), *shares[most])


def _crossing(doubt: float, shrunk: float) -> float:
    """Return the chance that an estimate crosses a limit, beyond which the truth lies with the
    probability `doubt` (at most 1/2), when its standard deviation shrinks by a share.

    >>> [round(_crossing(0.25, shrunk), 3) for shrunk in (0.0, 0.03, 0.3, 1.0)]
    [0.0, 0.003, 0.172, 0.25]
    """
    if doubt <= 0.0 or shrunk <= 0.0:
        return 0.0
    # Φ(-z / sqrt(1 - r²)), with doubt = Φ(-z) and r = 1 - shrunk
    return float(ndtr(ndtri(doubt) / math.sqrt(1.0 - (1.0 - shrunk) ** 2)))


class _Seen:
    """A thing after views that were taken from `places` (v, 3), and what another would add."""

    def __init__(self, thing: SeenThing, places: FloatArray) -> None:
        self._thing, self._places = thing, places
        self._sides = Sides(thing.middle, thing.normals, places)

    def new(self, place: FloatArray) -> float:
        """Return how new a look from a place is beside those before, 0..1."""
        towards = units(place - self._thing.middle)
        return float(_new(towards[None, None], self._sides.towards[None])[0])

    def shown(self, place: FloatArray) -> tuple[float, float]:
        """Return the shares of missing sides and of unseen space that a view from there
        would show.
        """
        sides = self.new(place) * self._sides.shown_from(place)
        space = 0.0
        unseen = self._thing.space
        if unseen is not None:
            shown = unseen.shown_from(place)
            # What as many looks as a face needs laid open, and none could measure, stays unseen.
            shown &= self._seen_towards.any(axis=2).sum(axis=1) < FEWEST_VIEWS
            at = unseen.points[shown]
            weights = _new(units(place - at)[:, None], self._seen_towards[shown])
            space = float(weights.sum()) / len(unseen.points)
        return sides, space

    def surer(self, camera: Camera, pose: Pose, pose_cov: FloatArray | None) -> float:
        """Return the share by which the sds of visible corners would shrink, averaged over all.

        From beside an earlier place a corner is off in the same way as before: that counts less.
        """
        thing = self._thing
        if not len(thing.corners):
            return 0.0
        to_place = units(pose.centre - thing.corners)
        before = (np.einsum("nmi,ni->nm", thing.facing, to_place) > GRAZING).any(axis=1)
        image = np.zeros((camera.height, camera.width), np.uint8)
        view = View("", image, camera, pose, pose_cov=pose_cov)
        h = np.column_stack([thing.corners, np.ones(len(thing.corners))]) @ view.projection.T
        uv = h[:, :2] / np.where(h[:, 2] > 0, h[:, 2], np.nan)[:, None]
        inside = ((uv > 0) & (uv < [camera.width - 1, camera.height - 1])).all(axis=1)
        rows = np.flatnonzero(before & inside)
        if not len(rows):
            return 0.0
        points, covs = thing.corners[rows], thing.covs[rows]
        noise = CORNER_SD_PX**2 * np.eye(2) + compute_pixel_covs(view, points)
        _, after, _ = update_by_view(view.projection, points, covs, uv[rows], noise)
        # The geometric mean of three sds is the sixth root of the determinant.
        ratio = np.linalg.det(after) / np.linalg.det(covs)
        shrunk = float((1.0 - np.clip(ratio, 0.0, 1.0) ** (1 / 6)).sum()) / len(thing.corners)
        return self.new(pose.centre) * shrunk

    @cached_property
    def _seen_towards(self) -> FloatArray:
        """Directions (n, v, 3) from unseen points to the places that they lay open to before; rows
        of zeros for others. What was measured from none of these is not from beside them.
        """
        unseen = self._thing.space
        if unseen is None:
            return np.zeros((0, 0, 3))
        found = np.zeros((len(unseen.points), len(self._places), 3))
        for i, place in enumerate(self._places):
            shown = unseen.shown_from(place)
            found[shown, i] = units(place - unseen.points[shown])
        return found


_NEAR = math.cos(math.radians(NEAR_DEG))


def _new(towards: FloatArray, before: FloatArray) -> FloatArray:
    """Return how new looks (n, 1, 3) are beside earlier ones (n, v, 3), 0 from the same direction,
    1 from 45 degrees on: by the chord, which parallax grows with.
    """
    if not before.shape[1]:
        first: FloatArray = np.ones(len(towards))
        return first
    nearest = np.where(
        before.any(axis=2),
        np.einsum("nvi,nvi->nv", np.broadcast_to(towards, before.shape), before),
        -1.0,
    ).max(axis=1)
    chord: FloatArray = np.sqrt(np.maximum(1.0 - nearest, 0.0) / (1.0 - _NEAR))
    new: FloatArray = np.where(chord < SAME, 0.0, np.minimum(chord, 1.0))
    return new


# Of one direction twice the rounding of cosines leaves a chord of this size.
SAME = 1e-6


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
        """Undecided verdicts in words, the most likely to turn first."""
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
    """Return the undecided verdicts in words, the most likely to turn first."""
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
    """Return the view with the largest promise per second after views from `places`; of equal ones
    the first. None if none may turn `least` of a verdict.

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
    """Return the nearest in time of those that lie a step on a ring from every earlier view: the
    first views are neighbours, whose pictures have faces in common.
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
