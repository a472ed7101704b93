"""The normal equations of poses and points, with the points eliminated (Schur complement).

The unknowns are a twist a view (rotation and shift about one point, pose_chain.py; shifts in units
of the cameras' distance), two numbers a camera (lens_unknowns.py) and three a point. The reduced
system has six rows a view and two a camera, however many points there are (Triggs et al. 2000,
section 6). Residuals far beyond the noise have a Cauchy weight, so that outliers have no influence.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from facetlog.perception.estimation.bundle_adjustment.lens_unknowns import (
    LENS_UNKNOWNS,
    Lenses,
)
from facetlog.perception.estimation.bundle_adjustment.pose_prior import build_block_diagonal
from facetlog.perception.estimation.pose_refinement.pose_chain import moved
from facetlog.perception.types import FloatArray, Pose, View

ROBUST_SD = 5.0
"""Standard deviations of a residual at which its weight is a half: beyond noise, not in it."""
RIDGE = 1e-12
"""Share of a matrix's trace that is added to its diagonal, so that its Cholesky factor exists in
spite of rounding."""


@dataclass(frozen=True, eq=False, slots=True)
class Tracks:
    """Pixels (n, V, 2), covariances (n, V, 2, 2), which are used (n, V); a view's `weight` (V,).

    Nearly identical views share the errors of their poses and pixels: the variance of each, which
    is estimated view by view, is multiplied by 1 / weight.
    """

    uv: FloatArray
    cov: FloatArray
    used: NDArray[np.bool_]
    weight: FloatArray

    def rows(self, chosen: NDArray[np.bool_] | NDArray[np.intp]) -> "Tracks":
        """Return the chosen tracks."""
        return Tracks(self.uv[chosen], self.cov[chosen], self.used[chosen], self.weight)

    def noise(self, extra_px: float) -> FloatArray:
        """Return covariances (n, V, 2, 2) with a noise of `extra_px` beyond the pixels' own."""
        return self.cov + (extra_px**2 / self.weight)[None, :, None, None] * np.eye(2)


@dataclass(frozen=True, eq=False, slots=True)
class State:
    """Twists (V, 6), points (n, 3) and the cameras' unknowns (C, 2)."""

    twists: FloatArray
    points: FloatArray
    lens: FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class Problem:
    """Tracks and the views that twists move: about a point (3,), in units (6,)."""

    tracks: Tracks
    views: tuple[View, ...]
    lenses: Lenses
    about: FloatArray
    unit: FloatArray

    def poses(self, twists: FloatArray) -> tuple[Pose, ...]:
        """Return the views' poses where the twists (V, 6) put them."""
        placed = zip(self.views, twists * self.unit, strict=True)
        return tuple(moved(view.pose, twist, self.about) for view, twist in placed)

    def projections(self, twists: FloatArray) -> FloatArray:
        """Return the projections (V, 3, 4) of all views moved by twists (V, 6)."""
        scaled = twists * self.unit
        turns = Rotation.from_rotvec(scaled[:, :3]).as_matrix()
        centres = np.array([v.pose.centre for v in self.views]) - self.about
        centres = (turns @ centres[..., None])[..., 0] + self.about + scaled[:, 3:]
        rotations = turns @ np.array([v.pose.rotation for v in self.views])
        to_camera = rotations.transpose(0, 2, 1)
        shifts = -(to_camera @ centres[..., None])
        matrices = np.array([v.camera.matrix for v in self.views])
        return np.asarray(matrices @ np.concatenate([to_camera, shifts], axis=2))


@dataclass(frozen=True, eq=False, slots=True)
class Linear:
    """Residuals (n, V, 2) in px and the pixels' derivatives by the unknowns at a state.

    `by_twist` (n, V, 2, 6), `by_lens` (n, V, 2, 2), `by_point` (n, V, 2, 3); zero where a track is
    not used. `in_front` says that each point lies before the cameras that show it.
    """

    residual: FloatArray
    by_twist: FloatArray
    by_lens: FloatArray
    by_point: FloatArray
    in_front: bool


def linear(problem: Problem, state: State) -> Linear:
    """Return the problem linearised at a state."""
    projections = problem.projections(state.twists)
    used = problem.tracks.used
    h = (state.points @ projections[:, :, :3].transpose(0, 2, 1)).transpose(1, 0, 2)
    h = h + projections[:, :, 3]
    in_front = bool((h[..., 2][used] > 0).all())
    depth = np.where(used, h[..., 2], 1.0)
    uv = np.where(used[..., None], h[..., :2] / depth[..., None], 0.0)
    by_point = projections[None, :, :2, :3] - uv[..., None] * projections[None, :, 2:, :3]
    by_point = by_point * np.where(used, 1.0 / depth, 0.0)[..., None, None]
    uv, by_pixel, by_lens = problem.lenses.seen(state.lens, uv)
    by_point = by_pixel @ by_point
    by_lens = np.where(used[..., None, None], by_lens, 0.0)
    # A camera's twist moves the world the other way (line_alignment.py).
    arm = (state.points - problem.about)[:, None, None, :]
    by_twist = np.concatenate([_cross(by_point, arm), -by_point], axis=-1) * problem.unit
    residual = np.where(used[..., None], problem.tracks.uv - uv, 0.0)
    return Linear(residual, by_twist, by_lens, by_point, in_front)


@dataclass(frozen=True, eq=False, slots=True)
class Reduced:
    """The pixels' normal equations of twists and lenses, with the points eliminated.

    `matrix` (m, m) and `gradient` (m,), m = 6 V + 2 C, are the reduced system; `cost` the robust
    sum of squares and `log_noise` the log determinant of the noise. Points are whitened:
    `of_points` (n, 3, 3) is the inverse of the factor of their information, `coupling` (m, 3 n)
    their cross terms with the other unknowns, `pull` (n, 3) their gradient.
    """

    cost: float
    log_noise: float
    matrix: FloatArray
    gradient: FloatArray
    coupling: FloatArray
    of_points: FloatArray
    pull: FloatArray


def reduced(problem: Problem, at: Linear, extra_px: float) -> Reduced:
    """Return the normal equations where the pixels have a noise of `extra_px` beyond their own."""
    tracks, lenses = problem.tracks, problem.lenses
    noise = tracks.noise(extra_px)
    a = np.sqrt(noise[..., 0, 0])
    b = noise[..., 0, 1] / a
    c = np.sqrt(noise[..., 1, 1] - b**2)
    # In units of the noise, rows (…, 2, 12): derivatives by point, twist and lens, and residual.
    parts = [at.by_point, at.by_twist, at.by_lens, at.residual[..., None]]
    rows = np.concatenate(parts, axis=-1)
    rows[..., 0, :] /= a[..., None]
    rows[..., 1, :] -= b[..., None] * rows[..., 0, :]
    rows[..., 1, :] /= c[..., None]
    square = (rows[..., -1] ** 2).sum(axis=-1)
    share = 1.0 + square / ROBUST_SD**2
    cost = ROBUST_SD**2 * float(np.log(share)[tracks.used].sum())
    log_noise = 2 * float(np.log(a * c)[tracks.used].sum())
    rows /= np.sqrt(share)[..., None, None]
    by_point, by_view, residual = rows[..., :3], rows[..., 3:-1], rows[..., -1]

    count, views = tracks.used.shape
    of_point = by_point.reshape(count, 2 * views, 3)
    information = of_point.transpose(0, 2, 1) @ of_point
    ridge = RIDGE * np.trace(information, axis1=1, axis2=2) + np.finfo(np.float64).tiny
    factor = np.linalg.inv(np.linalg.cholesky(information + ridge[:, None, None] * np.eye(3)))
    of_point = of_point @ factor.transpose(0, 2, 1)
    pull = (of_point.transpose(0, 2, 1) @ residual.reshape(count, -1, 1))[..., 0]
    white = of_point.reshape(count, views, 2, 3).transpose(1, 0, 2, 3)
    across = by_view.transpose(1, 0, 2, 3)
    both = across[:, :, 0, :, None] * white[:, :, 0, None]
    both += across[:, :, 1, :, None] * white[:, :, 1, None]
    coupling = _gather_rows(lenses, both.transpose(0, 2, 1, 3).reshape(views, -1, 3 * count))
    columns = across.reshape(views, 2 * count, -1)
    of_views = columns.transpose(0, 2, 1) @ columns
    gradient = columns.transpose(0, 2, 1) @ residual.transpose(1, 0, 2).reshape(views, -1, 1)
    return Reduced(
        cost,
        log_noise,
        _whole(lenses, of_views) - coupling @ coupling.T,
        _gather_rows(lenses, gradient)[:, 0] - coupling @ pull.ravel(),
        coupling,
        factor,
        pull,
    )


def _gather_rows(lenses: Lenses, rows: FloatArray) -> FloatArray:
    # Of each view's rows (V, 8, k) those of its twist, and below them those of the cameras, which
    # are sums over their views: (6 V + 2 C, k).
    of_lenses = lenses.of_cameras(rows[:, -LENS_UNKNOWNS:])
    k = rows.shape[-1]
    return np.vstack([rows[:, :-LENS_UNKNOWNS].reshape(-1, k), of_lenses.reshape(-1, k)])


def _whole(lenses: Lenses, blocks: FloatArray) -> FloatArray:
    # Of each view's block (V, 8, 8) the matrix of all unknowns (6 V + 2 C, 6 V + 2 C).
    views, size = len(blocks), blocks.shape[1] - LENS_UNKNOWNS
    between = np.einsum("vc,vtl->vtcl", lenses.member, blocks[:, :size, size:])
    between = between.reshape(views * size, -1)
    of_cameras = build_block_diagonal(lenses.of_cameras(blocks[:, size:, size:]))
    of_views = build_block_diagonal(blocks[:, :size, :size])
    return np.block([[of_views, between], [between.T, of_cameras]])


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    # np.cross takes ten times as long.
    (x, y, z), (u, v, w) = np.moveaxis(a, -1, 0), np.moveaxis(b, -1, 0)
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=-1)
