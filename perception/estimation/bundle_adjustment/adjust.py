"""Bundle adjustment: the most likely poses and points together, and honest covariances.

How far the poses may be off, and how far pixels beyond their own covariance, is what makes the
residuals most likely (error_sizes.py); so poses and points are fitted and sizes estimated in turn.
The prior of the poses holds the gauge: what no picture tells, as the place of the whole in the
world, stays with the mean of the poses given.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular

from facetlog.perception.estimation.bundle_adjustment.error_sizes import (
    EXACT,
    LEAST_PX,
    Sizes,
    likely_sizes,
)
from facetlog.perception.estimation.bundle_adjustment.normal_equations import (
    Linear,
    Problem,
    Reduced,
    State,
    Tracks,
    linear,
    reduced,
)
from facetlog.perception.estimation.bundle_adjustment.pose_prior import PosePrior, pose_prior
from facetlog.perception.types import FloatArray, Pose, PoseErrors, View

__all__ = ["Adjusted", "adjust"]

MAX_STEPS = 30
CONVERGED = 0.1
"""Sum of squares: a step that lowers it by less ends the iteration, for the next one would lower it
by a fraction of that."""
ROUNDS = 5
"""At most, of unknowns fitted and sizes estimated in turn: from far off both are wrong at first."""


@dataclass(frozen=True, eq=False, slots=True)
class Adjusted:
    """Poses (V), points (n, 3) and their covariances (n, 3, 3) with the poses' own in them.

    `sizes` are those of the pixels' noise beyond their covariances and of the poses' own error;
    `residual` (V,) is the root mean square of each view's residuals in px, NaN where it shows no
    point. `twists` (V, 6) have brought the views there. The rest, of it what pixels and prior know
    of all twists (6 V, 6 V each), is for `errors_at`.
    """

    poses: tuple[Pose, ...]
    points: FloatArray
    covs: FloatArray
    sizes: Sizes
    residual: FloatArray
    twists: FloatArray
    problem: Problem
    of_pixels: FloatArray
    of_prior: FloatArray

    def errors_at(
        self, tracks: Tracks, points: FloatArray, factor: float = 1.0
    ) -> tuple[FloatArray, FloatArray]:
        """Those of points (m, 3) estimated from tracks at the adjusted poses: own and shared.

        Errors of points i and j have the covariance δij own_i + shared_iᵀ shared_j, with `own`
        (m, 3, 3) of the pixels and `shared` (m, 6 V, 3) of the poses, where the pixels' variances
        are `factor` times what they are given as. Every track must be used in two views.
        """
        views = zip(self.problem.views, self.poses, strict=True)
        placed = tuple(replace(view, pose=pose) for view, pose in views)
        here = replace(self.problem, tracks=tracks, views=placed)
        at = linear(here, State(np.zeros((len(placed), 6)), points))
        both = self.of_pixels / factor + self.of_prior
        return _errors(reduced(tracks, at, self.sizes.extra_px), both, factor)


def adjust(
    tracks: Tracks,
    views: Sequence[View],
    points: FloatArray,
    errors: PoseErrors | None = None,
    extra_px: float = 1.0,
    near: Adjusted | None = None,
    least_px: float = LEAST_PX,
) -> Adjusted:
    """The most likely poses and points of the tracks, from the views' poses and `points` (n, 3).

    `errors` are those that are stated of the poses; beyond them poses err independently by a size
    that the residuals tell. `extra_px` is the noise that pixels seem to have at the views' poses;
    `near` was found from much the same tracks; `least_px` is the least noise that they have beyond
    their own. Every point must be used in two views.
    """
    about = points.mean(axis=0) if near is None else near.problem.about
    centres = np.array([v.pose.centre for v in views])
    distance = float(np.median(np.linalg.norm(centres - about, axis=1)))
    problem = Problem(tracks, tuple(views), about, np.repeat([1.0, distance], 3))
    prior = pose_prior([v.pose for v in views], errors, about, distance)
    weighted = prior.weighted(tracks.weight)
    if near is None:
        # What the residuals show may be the pixels' or the poses': both may take it at first.
        focal = float(np.median([v.camera.fx for v in views]))
        sizes = Sizes(max(extra_px, LEAST_PX), max(extra_px / focal, EXACT))
        state = _fitted(problem, weighted, State(np.zeros((len(views), 6)), points), sizes)
        sizes = likely_sizes(problem, prior, state, least_px)
    else:
        state = State(near.twists, points)
        sizes = replace(near.sizes, extra_px=max(near.sizes.extra_px, least_px))
    for _ in range(ROUNDS):
        state = _fitted(problem, weighted, state, sizes)
        before, sizes = sizes, likely_sizes(problem, prior, state, least_px, sizes)
        if sizes == before:
            break
    return _result(problem, weighted, state, sizes)


@dataclass(frozen=True, eq=False, slots=True)
class _Normal:
    # The pixels' equations and the prior's together.
    pixels: Reduced
    cost: float
    matrix: FloatArray
    gradient: FloatArray


def _normal(
    problem: Problem,
    at: Linear,
    twists: FloatArray,
    prior: PosePrior,
    belief: FloatArray,
    px: float,
) -> _Normal:
    pixels = reduced(problem.tracks, at, px)
    off = (twists - prior.mean).ravel()
    push = belief @ off
    cost = pixels.cost + float(off @ push)
    return _Normal(pixels, cost, pixels.matrix + belief, pixels.gradient - push)


def _fitted(problem: Problem, prior: PosePrior, state: State, sizes: Sizes) -> State:
    """Gauss-Newton, damped where a step does not help (Levenberg-Marquardt)."""
    belief, _ = prior.precision(sizes.pose_sd)

    def normal(there: State, at: Linear) -> _Normal:
        return _normal(problem, at, there.twists, prior, belief, sizes.extra_px)

    here = normal(state, linear(problem, state))
    damping = 0.0
    for _ in range(MAX_STEPS):
        trial = _step(here, state, damping)
        at = linear(problem, trial)
        there = normal(trial, at) if at.in_front else None
        if there is None or there.cost > here.cost + CONVERGED:
            damping = max(10 * damping, 1e-3)
            continue
        gained = here.cost - there.cost
        state, here, damping = trial, there, damping / 10 if damping > 1e-6 else 0.0
        if gained < CONVERGED:
            break
    return state


def _step(normal: _Normal, state: State, damping: float) -> State:
    lhs = normal.matrix + damping * np.diag(np.diagonal(normal.matrix))
    twist = cho_solve(cho_factor(lhs, lower=True, check_finite=False), normal.gradient)
    pixels = normal.pixels
    white = (pixels.pull.ravel() - pixels.coupling.T @ twist).reshape(-1, 3) / (1.0 + damping)
    points = state.points + np.einsum("nba,nb->na", pixels.of_points, white)
    return State(state.twists + twist.reshape(-1, 6), points)


def _result(problem: Problem, prior: PosePrior, state: State, sizes: Sizes) -> Adjusted:
    at = linear(problem, state)
    pixels = reduced(problem.tracks, at, sizes.extra_px)
    belief, _ = prior.precision(sizes.pose_sd)
    seen = problem.tracks.used.sum(axis=0)
    square = np.where(seen > 0, (at.residual**2).sum(axis=(0, 2)) / 2, np.nan)
    own, shared = _errors(pixels, pixels.matrix + belief)
    return Adjusted(
        problem.poses(state.twists),
        state.points,
        own + shared.transpose(0, 2, 1) @ shared,
        sizes,
        np.sqrt(square / np.maximum(seen, 1)),
        state.twists,
        problem,
        pixels.matrix,
        belief,
    )


def _errors(
    pixels: Reduced, of_views: FloatArray, factor: float = 1.0
) -> tuple[FloatArray, FloatArray]:
    # F⁻ᵀ (f I + Bᵀ S⁻¹ B) F⁻¹ with B the whitened coupling of a point with all views.
    root = np.linalg.cholesky(of_views)
    half = solve_triangular(root, pixels.coupling, lower=True, check_finite=False)
    shared = half.reshape(len(root), -1, 3).transpose(1, 0, 2) @ pixels.of_points
    return factor * pixels.of_points.transpose(0, 2, 1) @ pixels.of_points, shared
