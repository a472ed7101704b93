"""The rectangle round a thing's plan, as its pose on the floor, with the covariance.

Its direction is the one, or square to it, that most of the thing's level sides have, by their
length: things are built square. Each side counts as surely as its ends are known. On each of its
sides the outermost point decides: the one that surely reaches farthest, for of many points that are
poorly known the outermost is so by its noise. The covariance is that of all these points,
propagated to first order.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from facetlog.perception.types import FloatArray, frozen

HALF_TURN, QUARTER_TURN = math.pi, math.pi / 2
# For numerical derivatives, in shares of the plan's extent: the cube root of a double's precision.
STEP = 6e-6
# Directions that differ by less than so many standard deviations may be one, and lengths too.
ALIKE_SDS = 3.0
# A tenth of a degree: sides that are known better than that are as good as one another.
LEAST_SD = math.radians(0.1)

Rows = NDArray[np.intp]


@dataclass(frozen=True, eq=False, slots=True)
class PlanBox:
    """A rectangle on the floor: `values` (5,) are x, y of its middle, the heading of its longer
    side in (-π/2, π/2], length and width; metres and radians. `cov` (5, 5) is of these.
    """

    values: FloatArray
    cov: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", frozen(self.values, 5))
        object.__setattr__(self, "cov", frozen(self.cov, 5, 5))

    @property
    def turns_alike(self) -> float:
        """The least turn, radians, after which the rectangle looks the same: half a turn, or a
        quarter where length and width cannot be told apart.
        """
        difference = np.array([0.0, 0.0, 0.0, 1.0, -1.0])
        sd = math.sqrt(max(float(difference @ self.cov @ difference), 0.0))
        alike = float(difference @ self.values) <= ALIKE_SDS * sd
        return QUARTER_TURN if alike else HALF_TURN


def plan_box(points: FloatArray, covs: FloatArray, sides: Rows) -> PlanBox | None:
    """Return the rectangle round points (n, 2) of the floor with covariances (n, 2, 2), which are
    independent; `sides` (m, 2) are the ends of the thing's level sides. None round one place.

    Without sides its direction is that of the two points that are farthest apart.
    """
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    if not apart.size or apart.max() == 0.0:
        return None
    if not len(sides):
        sides = np.array([np.unravel_index(int(np.argmax(apart)), apart.shape)], dtype=np.intp)
    sides, weights = _dominant(points, covs, sides)
    reference = _heading(points, sides, weights, _angle(points, sides)[0])
    outermost = [
        _outermost(points, covs, axis)
        for axis in (_unit(reference), _unit(reference + QUARTER_TURN))
    ]
    rows, of = np.unique([*sides.ravel(), *np.ravel(outermost)], return_inverse=True)
    own = of[: sides.size].reshape(-1, 2)
    (low_a, high_a), (low_b, high_b) = of[sides.size :].reshape(2, 2).tolist()
    first = _rectangle(points[rows], own, weights, reference, (low_a, high_a, low_b, high_b))
    swapped = bool(first[4] > first[3])

    def rectangle(flat: FloatArray) -> FloatArray:
        at = flat.reshape(-1, 2)
        found = _rectangle(at, own, weights, reference, (low_a, high_a, low_b, high_b))
        return _put_longer_first(found) if swapped else found

    flat = points[rows].ravel()
    values = rectangle(flat)
    jacobian = _derivatives(rectangle, flat, STEP * float(apart.max()))
    cov = jacobian @ block_diag(*covs[rows]) @ jacobian.T
    values[2] = _wrap_to_half_turn(float(values[2]))
    return PlanBox(values, (cov + cov.T) / 2)


def _dominant(points: FloatArray, covs: FloatArray, sides: Rows) -> tuple[Rows, FloatArray]:
    """Return the sides that have the direction of the most of them, or are square to it, the
    longest first, and how much each counts.
    """
    steps = points[sides[:, 1]] - points[sides[:, 0]]
    lengths = np.linalg.norm(steps, axis=1)
    sides, steps, lengths = sides[lengths > 0], steps[lengths > 0], lengths[lengths > 0]
    across = np.column_stack([-steps[:, 1], steps[:, 0]]) / lengths[:, None]
    spread = np.einsum("ni,nij,nj->n", across, covs[sides].sum(axis=1), across)
    variances = spread / lengths**2 + LEAST_SD**2
    angles = np.arctan2(steps[:, 1], steps[:, 0])
    between = np.abs(_wrap_to_quarter(angles[:, None] - angles[None]))
    alike = between <= ALIKE_SDS * np.sqrt(variances[:, None] + variances[None])
    # A side that is hardly known agrees with all: it is as much evidence as its angle is known.
    evidence = (alike * (lengths / np.sqrt(variances))[None]).sum(axis=1)
    surest = evidence * (variances <= np.median(variances))
    chosen = np.flatnonzero(alike[int(np.argmax(np.round(surest, 9)))])
    chosen = chosen[np.argsort(-lengths[chosen], kind="stable")]
    return sides[chosen], 1.0 / variances[chosen]


def _wrap_to_quarter(angles: FloatArray) -> FloatArray:
    """Return angles to the nearest multiple of a quarter turn, in [-π/4, π/4]."""
    turned: FloatArray = angles - QUARTER_TURN * np.round(angles / QUARTER_TURN)
    return turned


def _angle(points: FloatArray, sides: Rows) -> FloatArray:
    steps = points[sides[:, 1]] - points[sides[:, 0]]
    angles: FloatArray = np.arctan2(steps[:, 1], steps[:, 0])
    return angles


def _heading(points: FloatArray, sides: Rows, weights: FloatArray, reference: float) -> float:
    """Return the weighted mean of the sides' directions, near a reference that is one of them."""
    off = _wrap_to_quarter(_angle(points, sides) - reference)
    return reference + float(off @ weights / weights.sum())


def _unit(angle: float) -> FloatArray:
    return np.array([math.cos(angle), math.sin(angle)])


def _outermost(points: FloatArray, covs: FloatArray, axis: FloatArray) -> tuple[int, int]:
    """Return the points (indices) that surely reach farthest, against an axis (2,) and along it."""
    along = points @ axis
    sds = np.sqrt(np.maximum(np.einsum("i,nij,j->n", axis, covs, axis), 0.0))
    return int(np.argmin(along + ALIKE_SDS * sds)), int(np.argmax(along - ALIKE_SDS * sds))


def _rectangle(
    points: FloatArray,
    sides: Rows,
    weights: FloatArray,
    reference: float,
    outermost: tuple[int, int, int, int],
) -> FloatArray:
    """Return x, y, heading, length, width; `outermost` are points along the direction, both ways,
    and across it. Neither side is known to be the longer one.
    """
    heading = _heading(points, sides, weights, reference)
    along, across = _unit(heading), _unit(heading + QUARTER_TURN)
    low_a, high_a, low_b, high_b = (
        float(points[index] @ axis)
        for index, axis in zip(outermost, (along, along, across, across), strict=True)
    )
    middle = (low_a + high_a) / 2 * along + (low_b + high_b) / 2 * across
    return np.array([*middle, heading, high_a - low_a, high_b - low_b])


def _put_longer_first(box: FloatArray) -> FloatArray:
    x, y, heading, length, width = box.tolist()
    return np.array([x, y, heading + QUARTER_TURN, width, length])


def _wrap_to_half_turn(heading: float) -> float:
    turned = math.remainder(heading, HALF_TURN)
    return HALF_TURN / 2 if turned == -HALF_TURN / 2 else turned


def _derivatives(of: Callable[[FloatArray], FloatArray], at: FloatArray, step: float) -> FloatArray:
    """Return the Jacobian (5, k) at a point (k,), by central differences."""
    moves = step * np.eye(len(at))
    return np.stack([(of(at + m) - of(at - m)) / (2 * step) for m in moves], axis=1)
