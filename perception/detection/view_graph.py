"""The view graph: the point that views look at, how far they differ, which pairs give depth."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.stable_order import TIE, choose_farthest_points, largest
from facetlog.perception.types import FloatArray, View

# Two views count as two only as far as the picture of the object moved between them, px: with less
# motion any candidate looks consistent.
DISTINCT_PX = 6.0
# At this multiple they count as fully distinct: three such views count as three, not as a billionth
# less.
APART = 4.0
# Best angle between the rays of a pair: below it depth is poor, above it appearance changes.
PAIR_ANGLE = np.radians(15.0)
PARTNERS = 4
# Views whose segments are matched; more views add support, hardly new segments.
KEY_VIEWS = 16
# Steps towards the point with the least sum of distances from the axes; it need not be exact.
WEISZFELD_STEPS = 20
# No camera of the same tour is farther away than this multiple of the usual distance.
FAR = 10.0


@dataclass(frozen=True, eq=False, slots=True)
class ViewGraph:
    """The common focus of views, their weights, and the pairs to match.

    `focus` (3,) is the point nearest to all optical axes, `distance` the median distance of the
    cameras from it; `weight` (V,) is how much a view counts beside those almost like it;
    `pairs` lists (i, j), i < j, the views between which segments are matched.
    """

    focus: FloatArray
    distance: float
    weight: FloatArray
    pairs: tuple[tuple[int, int], ...]


def measure_view_motion(views: Sequence[View]) -> FloatArray:
    """Return the motion (V, V), px, between each two views of the picture of what they look at."""
    return _looks(views).motion()


def view_graph(views: Sequence[View]) -> ViewGraph:
    """Return the views' common focus, their weights and the pairs to match."""
    looks = _looks(views)
    motion = looks.motion()
    alike = np.where(motion < APART * DISTINCT_PX, np.exp(-((motion / DISTINCT_PX) ** 2)), 0.0)
    weight = 1.0 / alike.sum(axis=1)
    # Each next key view is the one whose picture differs most from those of all chosen.
    key = sorted(choose_farthest_points(motion, KEY_VIEWS))
    return ViewGraph(looks.focus, looks.distance, weight, _pairs(_angles(looks.directions), key))


@dataclass(frozen=True, eq=False, slots=True)
class _Looks:
    # Where views look: `directions` (V, 3) are unit vectors to the focus, of a camera that stands
    # there along its axis; `facing` (V,) says which views have it before them.
    views: Sequence[View]
    focus: FloatArray
    distance: float
    directions: FloatArray
    facing: NDArray[np.bool_]

    def motion(self) -> FloatArray:
        projections = np.array([v.projection for v in self.views])
        facing = self.facing
        motion = np.zeros((len(facing), len(facing)))
        # What a view that does not face the focus looks at is taken to be as far along its axis. To
        # views that do not have that before them it has no more in common than opposite corners.
        unlike = max(float(np.hypot(v.camera.width, v.camera.height)) for v in self.views)
        motion[np.ix_(facing, facing)] = _measure_picture_motion(
            projections[facing], self.focus, 0.1 * self.distance
        )
        for i in np.flatnonzero(~facing).tolist():
            distance = self.distance or 1.0
            own = self.views[i].pose.centre + distance * self.views[i].pose.rotation[:, 2]
            depth = projections[:, 2, :3] @ own + projections[:, 2, 3]
            sees = depth > TIE * distance
            between = np.full(len(facing), unlike)
            moved = _measure_picture_motion(projections[sees], own, 0.1 * distance)
            between[sees] = np.minimum(moved[np.flatnonzero(sees) == i].ravel(), unlike)
            motion[i] = np.maximum(motion[i], between)
            motion[:, i] = motion[i]
        return motion


def _looks(views: Sequence[View]) -> _Looks:
    centres = np.array([v.pose.centre for v in views])
    axes = np.array([v.pose.rotation[:, 2] for v in views])
    focus = _focus(centres, axes)
    rays = focus - centres
    range_ = np.linalg.norm(rays, axis=1)
    distance = float(np.median(range_))
    along = np.einsum("ni,ni->n", rays, axes)
    rounding = TIE * float(np.abs(centres).max())
    apart = range_ > rounding
    directions = axes.copy()
    directions[apart] = rays[apart] / range_[apart, None]
    facing = apart & (along > TIE * range_)
    return _Looks(views, focus, distance if distance > rounding else 0.0, directions, facing)


def _focus(centres: FloatArray, axes: FloatArray) -> FloatArray:
    # A gross pose error would bias the point: views that look elsewhere are left out.
    looking = _find_common_views(centres, axes)
    centres, axes = centres[looking], axes[looking]
    spread = float(np.linalg.norm(centres - centres.mean(axis=0), axis=1).max())
    prior = centres.mean(axis=0) + 3.0 * spread * axes.mean(axis=0)
    focus = _solve_nearest_point(centres, axes, np.ones(len(centres)), prior)
    depth = np.einsum("ni,ni->n", focus - centres, axes)
    return focus if np.median(depth) > 0.3 * spread else prior


def _solve_nearest_point(
    centres: FloatArray, axes: FloatArray, weight: FloatArray, prior: FloatArray
) -> FloatArray:
    # Least squares: sum (I - d dᵀ)(x - c) = 0. Nearly parallel axes leave the depth open; a weak
    # pull to a point before the cameras, some baselines away, decides it then.
    across = weight[:, None, None] * (np.eye(3) - axes[:, :, None] * axes[:, None, :])
    pull = 1e-3 * weight.sum()
    lhs = across.sum(axis=0) + pull * np.eye(3)
    rhs = np.einsum("nij,nj->i", across, centres) + pull * prior
    return np.asarray(np.linalg.solve(lhs, rhs))


def _find_common_views(centres: FloatArray, axes: FloatArray) -> NDArray[np.bool_]:
    # Sum of distances in place of that of squares (Weiszfeld): robust against a minority.
    middle = np.median(centres, axis=0)
    away = np.linalg.norm(centres - middle, axis=1)
    spread = float(np.median(away)) or float(away.max())  # most of a film may be of one place
    if not spread:
        return np.ones(len(centres), np.bool_)
    focus = prior = middle + 3.0 * spread * np.median(axes, axis=0)
    for _ in range(WEISZFELD_STEPS):
        relative = focus - centres
        along = np.einsum("ni,ni->n", relative, axes)
        miss = np.linalg.norm(relative - along[:, None] * axes, axis=1)
        weight = 1.0 / np.maximum(miss, 1e-3 * spread)
        focus = _solve_nearest_point(centres, axes, weight, prior)
    range_ = np.linalg.norm(focus - centres, axis=1)
    looking: NDArray[np.bool_] = np.logical_and(
        miss <= max(float(np.median(range_)), 2.0 * float(np.median(miss))),
        range_ <= FAR * np.median(range_),
    )
    # A camera that only turns looks at no point: its axes meet where it stands.
    apart = np.ptp(centres[looking], axis=0).max(initial=0.0) > TIE * np.abs(centres).max()
    most = 2 * looking.sum() > len(looking) and apart
    return looking if most else np.ones(len(looking), np.bool_)


def _measure_picture_motion(
    projections: FloatArray, focus: FloatArray, radius: float
) -> FloatArray:
    # Rms shift in px, between views, of points spread evenly over a sphere round the focus. With
    # uv + J · r for a point r away: |uv_i - uv_j|² + radius² / 3 · |J_i - J_j|², in any frame.
    h = projections[:, :, :3] @ focus + projections[:, :, 3]
    uv = h[:, :2] / h[:, 2:]
    jacobian = projections[:, :2, :3] - uv[..., None] * projections[:, 2:, :3]
    jacobian /= h[:, 2, None, None]
    shift = ((uv[:, None] - uv[None]) ** 2).sum(axis=-1)
    spread = ((jacobian[:, None] - jacobian[None]) ** 2).sum(axis=(-2, -1))
    motion: FloatArray = np.sqrt(shift + radius**2 / 3 * spread)
    return motion


def _angles(directions: FloatArray) -> FloatArray:
    # Between unit vectors (V, 3); the arc cosine would lose half of the digits of small angles.
    difference = np.linalg.norm(directions[:, None] - directions[None], axis=-1)
    total = np.linalg.norm(directions[:, None] + directions[None], axis=-1)
    angles: FloatArray = 2.0 * np.arctan2(difference, total)
    return angles


def _pairs(angle: FloatArray, key: list[int]) -> tuple[tuple[int, int], ...]:
    # Each key view with those key views that see the focus under about the best angle; of two as
    # good the one farther from the partners that the view has, so that they stand on both sides.
    pairs: set[tuple[int, int]] = set()
    for i in key:
        others = [j for j in key if j != i]
        partners: list[int] = []
        while others and len(partners) < PARTNERS:
            cost = np.abs(np.log(np.maximum(angle[i, others], 1e-6) / PAIR_ANGLE))
            apart = angle[np.ix_(others, partners)].min(axis=1, initial=np.pi)
            partners.append(others.pop(largest(-cost, apart)))
        pairs.update((min(i, j), max(i, j)) for j in partners)
    return tuple(sorted(pairs))
