"""The normal equations of poses and points, and the error sizes that explain the residuals.

The unknowns are a twist a view (rotation and shift about one point, pose_chain.py; shifts in units
of the cameras' distance), two numbers a camera (lens_unknowns.py) and three a point, which are
eliminated (Schur complement). The reduced system has six rows a view and two a camera, however many
points there are (Triggs et al. 2000, section 6). Residuals far beyond the noise have a Cauchy
weight, so that outliers have no influence.

Error sizes are standard deviations of pose, lens and pixel errors beyond the stated ones. They are
variance components by empirical Bayes: the sizes that maximise the marginal likelihood, with all
unknowns integrated out by Laplace's approximation. Exact poses thus stay as they are. A lens is
either as stated or has a usual error, whichever is more likely.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from facetlog.perception.estimation.bundle_adjustment.lens_unknowns import (
    LENS_UNKNOWNS,
    Lenses,
)
from facetlog.perception.estimation.bundle_adjustment.pose_prior import Prior, build_block_diagonal
from facetlog.perception.estimation.pose_refinement.pose_chain import moved
from facetlog.perception.estimation.rotations import convert_to_matrices
from facetlog.perception.types import FloatArray, Pose, View

ROBUST_SD = 5.0
"""Standard deviations of a residual at which its weight is a half: beyond noise, not in it."""
RIDGE = 1e-12
"""Share of a matrix's trace that is added to its diagonal, so that its Cholesky factor exists in
spite of rounding."""
MOST_VIEWS = 24
"""Views from which the sizes are estimated: each trial costs their number cubed."""
WORTH = 0.1
"""Least gain of deviance for which a size is changed."""
EXACT = np.radians(1e-3)
"""A pose error below what pictures can show, radians: a hundredth of a pixel."""
POSE_SDS = (EXACT, np.radians(0.03), np.radians(0.3), np.radians(2.0))
LENS_SD = 0.05
"""Prior standard deviation of focal lengths, as a share, and of radial factors, where they are off:
the accuracy of makers' data and of pictures' headers. Pictures that determine them do so far
better."""
LENS_PRICE = 2 * float(np.log(1000.0))
"""Gain of deviance for a lens error: fewer than one in a thousand right lenses may seem wrong by
chance."""
LEAST_PX = 0.01
"""Least extra noise, px: no picture shows less."""
EXTRA_PX = (LEAST_PX, 0.1, 0.5, 2.0)
"""Sizes of the poses' error (radians) and of the extra noise (px) that are tried first."""
FACTORS = (2.0, 1.2)
"""Factors by which the best of them is then changed as long as that improves it: a size known to a
fifth is good enough."""


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
        turns = convert_to_matrices(scaled[:, :3])
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


@dataclass(frozen=True, slots=True)
class Sizes:
    """Standard deviations: pixel noise beyond the pixels' own (px), pose errors (radians), lens
    errors (shares)."""

    extra_px: float
    pose_sd: float
    lens_sd: float = EXACT


def estimate_sizes(
    problem: Problem,
    prior: Prior,
    state: State,
    least_px: float = LEAST_PX,
    near: Sizes | None = None,
    lens_sds: Sequence[float] = (EXACT, LENS_SD),
) -> Sizes:
    """Return the most likely sizes at a state, searched from `near` where it is given.

    That of lenses is one of `lens_sds`, of which the first needs no evidence.
    """
    problem, prior, state = _some(problem, prior, state)
    at, off = linear(problem, state), prior.off(state.twists, state.lens)
    of_pixels: dict[float, Reduced] = {}
    of_prior: dict[tuple[float, float], tuple[FloatArray, float]] = {}
    known: dict[Sizes, float] = {}

    def deviance(tried: Sizes) -> float:
        if tried.extra_px not in of_pixels:
            of_pixels[tried.extra_px] = reduced(problem, at, tried.extra_px)
        beyond = tried.pose_sd, tried.lens_sd
        if beyond not in of_prior:
            of_prior[beyond] = prior.precision(*beyond)
        if tried not in known:
            pixels, (belief, log_det) = of_pixels[tried.extra_px], of_prior[beyond]
            price = 0.0 if tried.lens_sd == lens_sds[0] else LENS_PRICE
            known[tried] = price + _compute_deviance(pixels, off, belief, log_det)
        return known[tried]

    def improved(best: Sizes) -> Sizes:
        for factor in FACTORS:
            while True:
                px, sd = best.extra_px, best.pose_sd
                steps = (1 / factor, factor)
                tried = [replace(best, extra_px=max(px * f, least_px)) for f in steps]
                tried += [replace(best, pose_sd=max(sd * f, EXACT)) for f in steps]
                better = min(tried, key=deviance)
                if deviance(better) >= deviance(best) - WORTH:
                    break
                best = better
        return best

    # Pixels and poses jointly: both explain the same residuals, and a search over one at a time
    # would get stuck. A lens as stated is tried first: without evidence it is taken.
    found = []
    for lens_sd in lens_sds:
        first = [Sizes(max(px, least_px), sd, lens_sd) for px in EXTRA_PX for sd in POSE_SDS]
        if near is not None:
            first.append(replace(near, lens_sd=lens_sd))
        found.append(improved(min(first, key=deviance)))
    return min(found, key=deviance)


def _compute_deviance(
    pixels: Reduced, off: FloatArray, belief: FloatArray, log_det: float
) -> float:
    """Return -2 log of the marginal likelihood of the sizes, all else integrated out about the
    state.

    `off` (m,) is how far the unknowns but the points are from the prior's mean.
    """
    push = belief @ off
    value = pixels.cost + float(off @ push)
    value += pixels.log_noise + log_det
    value -= float((pixels.pull**2).sum())
    value -= 2 * float(np.log(np.diagonal(pixels.of_points, axis1=1, axis2=2)).sum())
    factor = np.linalg.cholesky(pixels.matrix + belief)
    pull = solve_triangular(factor, pixels.gradient - push, lower=True, check_finite=False)
    value -= float((pull**2).sum())
    return value + 2 * float(np.log(np.diagonal(factor)).sum())


def _some(problem: Problem, prior: Prior, state: State) -> tuple[Problem, Prior, State]:
    # No more than MOST_VIEWS of the views, all of weight 1: sizes are those of single views.
    count = len(problem.views)
    chosen = np.unique(np.linspace(0, count - 1, min(count, MOST_VIEWS)).round().astype(np.intp))
    used = problem.tracks.used[:, chosen]
    rows = used.sum(axis=1) >= 2
    uv, cov = problem.tracks.uv[rows][:, chosen], problem.tracks.cov[rows][:, chosen]
    tracks = Tracks(uv, cov, used[rows], np.ones(len(chosen)))
    views = tuple(problem.views[k] for k in chosen.tolist())
    lenses = problem.lenses.some(chosen.tolist())
    part = Problem(tracks, views, lenses, problem.about, problem.unit)
    there = State(state.twists[chosen], state.points[rows], state.lens)
    return part, prior.some(chosen), there
