"""How far poses and pixels are off beyond what is stated of them, as the residuals tell it.

Both sizes are the most likely ones, with twists and points integrated out about the best of them
(Laplace's approximation; variance components, empirical Bayes). Exact poses thus stay as they are.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from facetlog.perception.estimation.bundle_adjustment.normal_equations import (
    Problem,
    Reduced,
    State,
    Tracks,
    linear,
    reduced,
)
from facetlog.perception.estimation.bundle_adjustment.pose_prior import PosePrior
from facetlog.perception.types import FloatArray

__all__ = ["EXACT", "LEAST_PX", "Sizes", "likely_sizes"]

MOST_VIEWS = 24
"""That tell the sizes: their number cubed is what each size tried costs."""
WORTH = 0.1
"""Of deviance, for which a size is changed."""
EXACT = np.radians(1e-3)
"""The size of the poses' error that no picture shows, radians: a hundredth of a pixel."""
POSE_SDS = (EXACT, np.radians(0.03), np.radians(0.3), np.radians(2.0))
LEAST_PX = 0.01
"""Of extra noise: no picture shows less."""
EXTRA_PX = (LEAST_PX, 0.1, 0.5, 2.0)
"""Sizes of the poses' error (radians) and of the extra noise (px) that are tried first."""
FACTORS = (2.0, 1.2)
"""By which the best of them is then made larger or smaller, as long as that is better: a size
known to a fifth is as good as known."""


@dataclass(frozen=True, slots=True)
class Sizes:
    """Standard deviations: the pixels' beyond their own (px), the poses' own error (radians)."""

    extra_px: float
    pose_sd: float


def likely_sizes(
    problem: Problem,
    prior: PosePrior,
    state: State,
    least_px: float = LEAST_PX,
    near: Sizes | None = None,
) -> Sizes:
    """The most likely sizes at a state; where some are known to be near, from these on."""
    problem, prior, state = _some(problem, prior, state)
    at = linear(problem, state)
    of_pixels: dict[float, Reduced] = {}
    of_poses: dict[float, tuple[FloatArray, float]] = {}
    known: dict[Sizes, float] = {}

    def deviance(tried: Sizes) -> float:
        if tried.extra_px not in of_pixels:
            of_pixels[tried.extra_px] = reduced(problem.tracks, at, tried.extra_px)
        if tried.pose_sd not in of_poses:
            of_poses[tried.pose_sd] = prior.precision(tried.pose_sd)
        if tried not in known:
            pixels, (belief, log_det) = of_pixels[tried.extra_px], of_poses[tried.pose_sd]
            known[tried] = _deviance(pixels, state.twists - prior.mean, belief, log_det)
        return known[tried]

    # All pairs: both explain the same residuals, and one at a time would not get across.
    first = [Sizes(max(px, least_px), sd) for px in EXTRA_PX for sd in POSE_SDS]
    best = near or min(first, key=deviance)
    for factor in FACTORS:
        while True:
            px, sd = best.extra_px, best.pose_sd
            tried = [Sizes(max(px * f, least_px), sd) for f in (1 / factor, factor)]
            tried += [Sizes(px, max(sd * f, EXACT)) for f in (1 / factor, factor)]
            better = min(tried, key=deviance)
            if deviance(better) >= deviance(best) - WORTH:
                break
            best = better
    return best


def _deviance(pixels: Reduced, off: FloatArray, belief: FloatArray, log_det: float) -> float:
    """-2 log of the likelihood of the sizes, all else integrated out about the state.

    `off` (V, 6) is how far the twists are from the prior's mean.
    """
    push = belief @ off.ravel()
    value = pixels.cost + float(off.ravel() @ push)
    value += pixels.log_noise + log_det
    value -= float((pixels.pull**2).sum())
    value -= 2 * float(np.log(np.diagonal(pixels.of_points, axis1=1, axis2=2)).sum())
    factor = np.linalg.cholesky(pixels.matrix + belief)
    pull = solve_triangular(factor, pixels.gradient - push, lower=True, check_finite=False)
    value -= float((pull**2).sum())
    return value + 2 * float(np.log(np.diagonal(factor)).sum())


def _some(problem: Problem, prior: PosePrior, state: State) -> tuple[Problem, PosePrior, State]:
    # No more than MOST_VIEWS of the views, all of weight 1: sizes are those of single views.
    count = len(problem.views)
    chosen = np.unique(np.linspace(0, count - 1, min(count, MOST_VIEWS)).round().astype(np.intp))
    used = problem.tracks.used[:, chosen]
    rows = used.sum(axis=1) >= 2
    uv, cov = problem.tracks.uv[rows][:, chosen], problem.tracks.cov[rows][:, chosen]
    tracks = Tracks(uv, cov, used[rows], np.ones(len(chosen)))
    views = tuple(problem.views[k] for k in chosen.tolist())
    part = Problem(tracks, views, problem.about, problem.unit)
    return part, prior.some(chosen), State(state.twists[chosen], state.points[rows])
