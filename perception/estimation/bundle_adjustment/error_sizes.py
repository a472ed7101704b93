"""Standard deviations of pose, lens and pixel errors beyond the stated ones, from the residuals.

Variance components by empirical Bayes: the sizes that maximise the marginal likelihood, with all
unknowns integrated out by Laplace's approximation. Exact poses thus stay as they are. A lens is
either as stated or has a usual error, whichever is more likely.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

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
from facetlog.perception.estimation.bundle_adjustment.pose_prior import Prior
from facetlog.perception.types import FloatArray

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
