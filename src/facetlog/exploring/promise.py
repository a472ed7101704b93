"""What a view promises: the probability mass of verdicts that it may turn. No picture is needed.

A verdict that is open for what was not seen may turn by as much of that as would show. One that is
unsure for what was measured turns if the new estimate crosses its limit, of which the chance is
known before the picture: a mean that is z deviations from its limit, and whose deviation the
picture shrinks by the factor r, moves by N(0, 1 - r²) of these deviations (preposterior analysis,
Raiffa and Schlaifer 1961).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import ndtr, ndtri

from facetlog.exploring.needs import Needs, SeenThing
from facetlog.kb.explaining.unseen import GRAZING_DEG, NEAR_DEG
from facetlog.perception.estimation.point_recursion import updated_by_view
from facetlog.perception.estimation.pose_noise import pixel_covs
from facetlog.perception.fewest_views import FEWEST_VIEWS
from facetlog.perception.types import Camera, FloatArray, Pose, View

__all__ = ["Promise", "Promises"]

# A thing may have a face on each of so many sides in plan, and one upwards: two neighbours are 30
# degrees apart, less than what one look sees of sides.
SIDES = 12
# How well a corner is found in a picture, px: half a pixel, as two edges that are right to a third.
CORNER_SD_PX = 0.5


@dataclass(frozen=True, slots=True)
class Promise:
    """What a view may do: the probability `mass` of verdicts that it may turn, and of what lacks
    the shares (0..1) of the thing that counts most: missing sides, unseen space, corners' spread.
    """

    mass: float
    sides: float = 0.0
    space: float = 0.0
    corners: float = 0.0

    @property
    def reason(self) -> str:
        """What of it would show, in words."""
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
    """What views promise where `needs` are left after views from `places`, in their order."""

    def __init__(self, needs: Needs, camera: Camera, places: Sequence[FloatArray]) -> None:
        self._camera = camera
        self._of_thing = {
            thing.name: _Lack(thing, np.array(places).reshape(-1, 3)) for thing in needs.things
        }
        self._open = needs.open

    def of(self, pose: Pose, pose_cov: FloatArray | None = None) -> Promise:
        """What a view from a pose promises; `pose_cov` (6, 6) is how sure the pose would be."""
        shares: dict[str, tuple[float, float, float]] = {}
        masses: dict[str, float] = {}
        for each in self._open:
            lack = self._of_thing[each.thing]
            if each.thing not in shares:
                surer = lack.surer(self._camera, pose, pose_cov)
                shares[each.thing] = (*lack.shown(pose.centre), surer)
            sides, space, corners = shares[each.thing]
            # Which of the two would settle a condition is not known.
            unseen = (sides + space) / 2 if lack.has_space else sides
            gained = each.unseen * unseen + _crossing(each.measured, corners)
            masses[each.thing] = masses.get(each.thing, 0.0) + gained
        if not masses:
            return Promise(0.0)
        most = max(masses, key=lambda thing: round(masses[thing], 9))
        return Promise(sum(masses.values()), *shares[most])


def _crossing(doubt: float, shrunk: float) -> float:
    """The chance that an estimate crosses a limit, beyond which the truth lies with the probability
    `doubt` (at most 1/2), when its standard deviation shrinks by a share.

    >>> [round(_crossing(0.25, shrunk), 3) for shrunk in (0.0, 0.03, 0.3, 1.0)]
    [0.0, 0.003, 0.172, 0.25]
    """
    if doubt <= 0.0 or shrunk <= 0.0:
        return 0.0
    # Φ(-z / sqrt(1 - r²)), with doubt = Φ(-z) and r = 1 - shrunk
    return float(ndtr(ndtri(doubt) / math.sqrt(1.0 - (1.0 - shrunk) ** 2)))


class _Lack:
    """What of a thing lacks views that were taken from `places` (v, 3)."""

    def __init__(self, thing: SeenThing, places: FloatArray) -> None:
        self._thing, self._places = thing, places
        steps = places - thing.middle
        self._towards = steps / np.maximum(np.linalg.norm(steps, axis=1), 1e-12)[:, None]

    @property
    def has_space(self) -> bool:
        return self._thing.space is not None

    def new(self, place: FloatArray) -> float:
        """How new a look from a place is beside those before, 0..1."""
        towards = _units(place - self._thing.middle)
        return float(_new(towards[None, None], self._towards[None])[0])

    def shown(self, place: FloatArray) -> tuple[float, float]:
        """The shares of missing sides and of unseen space that a view from there would show."""
        towards, new = _units(place - self._thing.middle), self.new(place)
        lacking = self._lacking
        before = (self._sides @ towards > _GRAZING) & (lacking > 0)
        total = float(lacking.sum())
        sides = new * float(before.sum()) / FEWEST_VIEWS / total if total else 0.0
        space = 0.0
        unseen = self._thing.space
        if unseen is not None:
            shown = unseen.shown_from(place)
            at = unseen.points[shown]
            weights = _new(_units(place - at)[:, None], self._seen_towards[shown])
            space = float(weights.sum()) / len(unseen.points)
        return sides, space

    def surer(self, camera: Camera, pose: Pose, pose_cov: FloatArray | None) -> float:
        """By what share the sds of the corners that show would shrink, on average of all.

        From beside an earlier place a corner is off in the same way as before: that counts less.
        """
        thing = self._thing
        if not len(thing.corners):
            return 0.0
        to_place = _units(pose.centre - thing.corners)
        before = (np.einsum("nmi,ni->nm", thing.facing, to_place) > _GRAZING).any(axis=1)
        image = np.zeros((camera.height, camera.width), np.uint8)
        view = View("", image, camera, pose, pose_cov=pose_cov)
        h = np.column_stack([thing.corners, np.ones(len(thing.corners))]) @ view.projection.T
        uv = h[:, :2] / np.where(h[:, 2] > 0, h[:, 2], np.nan)[:, None]
        inside = ((uv > 0) & (uv < [camera.width - 1, camera.height - 1])).all(axis=1)
        rows = np.flatnonzero(before & inside)
        if not len(rows):
            return 0.0
        points, covs = thing.corners[rows], thing.covs[rows]
        noise = CORNER_SD_PX**2 * np.eye(2) + pixel_covs(view, points)
        _, after, _ = updated_by_view(view.projection, points, covs, uv[rows], noise)
        # The geometric mean of three sds is the sixth root of the determinant.
        ratio = np.linalg.det(after) / np.linalg.det(covs)
        shrunk = float((1.0 - np.clip(ratio, 0.0, 1.0) ** (1 / 6)).sum()) / len(thing.corners)
        return self.new(pose.centre) * shrunk

    @cached_property
    def _sides(self) -> FloatArray:
        """Directions (s, 3) that faces of the thing may face: the first view's bearing is one."""
        first = self._towards[0] if len(self._towards) else np.array([1.0, 0.0, 0.0])
        angles = math.atan2(first[1], first[0]) + math.tau / SIDES * np.arange(SIDES)
        level = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(SIDES)])
        return np.concatenate([level, [[0.0, 0.0, 1.0]], self._thing.normals])

    @cached_property
    def _lacking(self) -> FloatArray:
        """How much of the views that a face needs each side lacks (s,), 0..1."""
        looks = (self._sides @ self._towards.T > _GRAZING).sum(axis=1)
        lacking: FloatArray = np.maximum(FEWEST_VIEWS - looks, 0) / FEWEST_VIEWS
        return lacking

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
            found[shown, i] = _units(place - unseen.points[shown])
        return found


_GRAZING = math.cos(math.radians(GRAZING_DEG))
_NEAR = math.cos(math.radians(NEAR_DEG))


def _units(steps: FloatArray) -> FloatArray:
    units: FloatArray = steps / np.maximum(np.linalg.norm(steps, axis=-1, keepdims=True), 1e-12)
    return units


def _new(towards: FloatArray, before: FloatArray) -> FloatArray:
    """How new looks (n, 1, 3) are beside earlier ones (n, v, 3), 0 from the same direction, 1 from
    45 degrees on: by the chord, which parallax grows with.
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
