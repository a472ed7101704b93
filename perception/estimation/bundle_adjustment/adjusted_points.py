"""Bundle adjustment: the most likely poses, lenses and points together, with honest covariances.

The standard deviations of pose and lens errors, and of pixel noise beyond its stated covariance,
are those that make the residuals most likely (normal_equations.py); unknowns and these sizes are
estimated in turn. The prior of the poses fixes the gauge: what no picture determines, as the place
of the whole scene in the world, stays with the mean of the given poses.

Inliers cannot be chosen before the poses are right, nor poses be estimated from wrong matches. So
all observations of a point take part at first, with a robust weight; then the inliers are chosen
anew at the adjusted poses, and only these are used.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, solve_triangular

from facetlog.perception.estimation.bundle_adjustment.lens_unknowns import (
    LENS_UNKNOWNS,
    group_lenses,
)
from facetlog.perception.estimation.bundle_adjustment.normal_equations import (
    EXACT,
    LEAST_PX,
    LENS_SD,
    Linear,
    Problem,
    Reduced,
    Sizes,
    State,
    Tracks,
    estimate_sizes,
    linear,
    reduced,
)
from facetlog.perception.estimation.bundle_adjustment.pose_prior import Prior, build_prior
from facetlog.perception.estimation.point_filter import estimate_points
from facetlog.perception.estimation.pose_noise import (
    estimate_pose_noise_px,
    estimate_shared_error_factor,
    view_groups,
)
from facetlog.perception.types import FloatArray, LensError, Pose, PoseErrors, View

MAX_STEPS = 30
CONVERGED = 0.1
"""Convergence: a step that lowers the sum of squares by less ends the iteration, for the next one
would lower it by a fraction of that."""
SHORTEST_STEP = 1e-3
"""The shortest step of the line search, as a share of the full one: along its direction the sum
falls at first."""
ROUNDS = 5
"""Rounds of fitting and size estimation, at most: from far off both are wrong at first."""
LEAST_POINTS = 4
"""Fewer points do not constrain six unknowns a view and three a point."""
CHOICES = 2
"""Choices of inliers, each at better poses."""


@dataclass(frozen=True, eq=False, slots=True)
class Adjusted:
    """Poses (V), points (n, 3) and their covariances (n, 3, 3) with the poses' own in them.

    `lens` (C, 2) are the unknowns of the cameras (lens_unknowns.py). `sizes` are the standard
    deviations of pixel noise beyond its covariances and of pose and lens errors. `twists` (V, 6)
    move the views from their given poses. The rest is for `compute_errors_at`, of it the
    information of pixels and of the prior on all twists and lenses (m, m each, m = 6 V + 2 C).
    """

    poses: tuple[Pose, ...]
    points: FloatArray
    covs: FloatArray
    sizes: Sizes
    twists: FloatArray
    lens: FloatArray
    problem: Problem
    of_pixels: FloatArray
    of_prior: FloatArray

    @property
    def views(self) -> tuple[View, ...]:
        """The views with the poses and the focal lengths found."""
        focal = 1.0 + self.problem.lenses.of_views(self.lens)[:, 0]
        placed = zip(self.problem.views, self.poses, focal.tolist(), strict=True)
        return tuple(replace(v, pose=p, camera=v.camera.zoomed(f)) for v, p, f in placed)

    def undistorted(self, tracks: Tracks) -> Tracks:
        """Return the tracks undistorted: as pinholes would show them."""
        return replace(tracks, uv=self.problem.lenses.undistorted(self.lens, tracks.uv))

    @property
    def lens_errors(self) -> tuple[LensError, ...]:
        """The estimated error of each view's lens; none where lenses are as stated."""
        if self.sizes.lens_sd == EXACT or not self.lens.size:
            return ()
        variances = np.diagonal(np.linalg.inv(self.of_pixels + self.of_prior))
        sds = np.sqrt(variances[-self.lens.size :]).reshape(self.lens.shape)
        return self.problem.lenses.errors(self.lens, sds)

    def compute_errors_at(
        self, tracks: Tracks, points: FloatArray, factor: float = 1.0
    ) -> tuple[FloatArray, FloatArray]:
        """Return errors of points (m, 3) estimated from tracks at the adjusted poses: own and
        shared.

        Errors of points i and j have the covariance δij own_i + shared_iᵀ shared_j, with `own`
        (m, 3, 3) of the pixels and `shared` (m, 6 V + 2 C, 3) of poses and lenses, where the
        pixels' variances are `factor` times the given ones. Every track must be used in two views.
        """
        views = zip(self.problem.views, self.poses, strict=True)
        placed = tuple(replace(view, pose=pose) for view, pose in views)
        here = replace(self.problem, tracks=tracks, views=placed)
        at = linear(here, State(np.zeros((len(placed), 6)), points, self.lens))
        both = self.of_pixels / factor + self.of_prior
        return _errors(reduced(here, at, self.sizes.extra_px), both, factor)


def adjust(
    tracks: Tracks,
    views: Sequence[View],
    points: FloatArray,
    errors: PoseErrors | None = None,
    extra_px: float = 1.0,
    near: Adjusted | None = None,
    least_px: float = LEAST_PX,
    lens_is_off: bool = False,
) -> Adjusted:
    """Return the most likely poses and points of the tracks, from the views' poses and `points` (n,
    3).

    `errors` are the stated pose errors; beyond them poses have independent errors of a size that is
    estimated from the residuals. `extra_px` is the apparent pixel noise at the views' poses; `near`
    is a result for nearly the same tracks, to start from; `least_px` is a lower bound of the noise
    beyond the pixels' own. `lens_is_off` states that the intrinsics are not calibrated; else that
    is estimated from the residuals too. Every point must be used in two views.
    """
    about = points.mean(axis=0) if near is None else near.problem.about
    centres = np.array([v.pose.centre for v in views])
    distance = float(np.median(np.linalg.norm(centres - about, axis=1)))
    lenses = group_lenses(views)
    problem = Problem(tracks, tuple(views), lenses, about, np.repeat([1.0, distance], 3))
    unknowns = LENS_UNKNOWNS * lenses.count
    prior = build_prior([v.pose for v in views], errors, about, distance, unknowns)
    lens_sds = (LENS_SD,) if lens_is_off else (EXACT, LENS_SD)
    weighted = prior.weighted(tracks.weight)
    given = State(np.zeros((len(views), 6)), points, np.zeros((lenses.count, LENS_UNKNOWNS)))
    if near is None:
        # Residuals may come from the pixels or the poses: at first each may explain them all.
        focal = float(np.median([v.camera.fx for v in views]))
        sizes = Sizes(max(extra_px, LEAST_PX), max(extra_px / focal, EXACT), lens_sds[0])
        state = given
    else:
        sizes = replace(near.sizes, extra_px=max(near.sizes.extra_px, least_px))
        state = State(near.twists, points, near.lens)
    for _ in range(ROUNDS):
        state = _fitted(problem, weighted, state, sizes)
        before, sizes = sizes, estimate_sizes(problem, prior, state, least_px, sizes, lens_sds)
        if sizes == before:
            break
        if sizes.lens_sd > before.lens_sd:
            # Poses that made up for the lens lie far up a narrow valley; with the noise that pixels
            # seem to have at first it is wide.
            rough = replace(sizes, extra_px=max(extra_px, sizes.extra_px))
            state = _fitted(problem, weighted, given, rough)
    return _result(problem, weighted, state, sizes)


@dataclass(frozen=True, eq=False, slots=True)
class _Normal:
    # The pixels' equations and the prior's together.
    pixels: Reduced
    cost: float
    matrix: FloatArray
    gradient: FloatArray


def _fitted(problem: Problem, prior: Prior, state: State, sizes: Sizes) -> State:
    """Fit the state by Gauss-Newton, with shorter steps where a whole one does not help."""
    belief, _ = prior.precision(sizes.pose_sd, sizes.lens_sd)

    def normal(there: State, at: Linear) -> _Normal:
        pixels = reduced(problem, at, sizes.extra_px)
        off = prior.off(there.twists, there.lens)
        push = belief @ off
        cost = pixels.cost + float(off @ push)
        return _Normal(pixels, cost, pixels.matrix + belief, pixels.gradient - push)

    here = normal(state, linear(problem, state))
    for _ in range(MAX_STEPS):
        step, length, gained = _step(here, state), 1.0, 0.0
        while length > SHORTEST_STEP:
            trial = _moved(state, step, length)
            at = linear(problem, trial)
            if at.in_front:
                there = normal(trial, at)
                if there.cost < here.cost:
                    gained = here.cost - there.cost
                    state, here = trial, there
                    break
            length /= 2
        if gained < CONVERGED:
            break
    return state


def _step(normal: _Normal, state: State) -> State:
    # By how much all unknowns change.
    factor = cho_factor(normal.matrix, lower=True, check_finite=False)
    step = cho_solve(factor, normal.gradient)
    pixels = normal.pixels
    white = (pixels.pull.ravel() - pixels.coupling.T @ step).reshape(-1, 3)
    points = np.einsum("nba,nb->na", pixels.of_points, white)
    twists, lens = np.split(step, [state.twists.size])
    return State(twists.reshape(state.twists.shape), points, lens.reshape(state.lens.shape))


def _moved(state: State, step: State, length: float) -> State:
    return State(
        state.twists + length * step.twists,
        state.points + length * step.points,
        state.lens + length * step.lens,
    )


def _result(problem: Problem, prior: Prior, state: State, sizes: Sizes) -> Adjusted:
    at = linear(problem, state)
    pixels = reduced(problem, at, sizes.extra_px)
    belief, _ = prior.precision(sizes.pose_sd, sizes.lens_sd)
    own, shared = _errors(pixels, pixels.matrix + belief)
    return Adjusted(
        problem.poses(state.twists),
        state.points,
        own + shared.transpose(0, 2, 1) @ shared,
        sizes,
        state.twists,
        state.lens,
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


def remove_common_motion(points: FloatArray, own: FloatArray, shared: FloatArray) -> FloatArray:
    """Return covariances (n, 3, 3) of points (n, 3) after the best rigid alignment of all with the
    truth.

    Before it the errors of points i and j have the covariance δij own_i + shared_iᵀ shared_j, with
    `own` (n, 3, 3) and `shared` (n, m, 3). The alignment weights points by their precision.
    """
    covs: FloatArray = own + shared.transpose(0, 2, 1) @ shared
    if not len(points):
        return covs
    weight = 1.0 / np.trace(covs, axis1=1, axis2=2)
    arm = points - weight @ points / weight.sum()
    arm = arm / max(float(np.abs(arm).max()), np.finfo(np.float64).tiny)
    # A shift, and a rotation vector, which moves a point by rotation × arm.
    x, y, z = arm.T
    by_motion = np.zeros((len(points), 3, 6))
    by_motion[:, :, :3] = np.eye(3)
    by_motion[:, 0, 4], by_motion[:, 0, 5] = z, -y
    by_motion[:, 1, 3], by_motion[:, 1, 5] = -z, x
    by_motion[:, 2, 3], by_motion[:, 2, 4] = y, -x
    weighted = by_motion * weight[:, None, None]
    # One or two points leave some rotations undetermined: these are set to zero.
    solve = np.linalg.pinv(np.einsum("nia,nib->ab", weighted, by_motion), hermitian=True)
    motion = weighted @ solve  # (n, 3, 6): the best motion is its sum over the errors
    of_shared = np.einsum("nmi,nia->ma", shared, motion)
    with_motion = own @ motion + shared.transpose(0, 2, 1) @ of_shared
    of_motion = np.einsum("nia,nib->ab", motion, with_motion)
    cross = with_motion @ by_motion.transpose(0, 2, 1)
    return np.asarray(
        covs
        - cross
        - cross.transpose(0, 2, 1)
        + by_motion @ of_motion @ by_motion.transpose(0, 2, 1)
    )


@dataclass(frozen=True, eq=False, slots=True)
class AdjustedPoints:
    """Views adjusted in pose and focal length; points (n, 3), covs (n, 3, 3), used (n, V), ok (n,).

    As of `estimate_points`, pose errors included, and `shape_covs` (n, 3, 3) without the common
    motion of all points; `extra_px` is the pixel noise beyond the pixels' own
    covariances, `factor` by how much all these variances are too small because neighbouring views
    share errors. `adjusted` is None where there were too few points to adjust poses.
    """

    views: tuple[View, ...]
    points: FloatArray
    covs: FloatArray
    shape_covs: FloatArray
    used: NDArray[np.bool_]
    ok: NDArray[np.bool_]
    extra_px: float
    factor: float = 1.0
    adjusted: Adjusted | None = None


def adjusted_points(
    tracks: Tracks,
    views: Sequence[View],
    errors: PoseErrors | None = None,
    lens_is_off: bool = False,
) -> AdjustedPoints:
    """Return the points of tracks whose `used` says what was seen; not adjusted where these are too
    few.

    `errors` are the stated errors of the views' poses; `lens_is_off` as of `adjust`. Residuals
    weighted by the corners' own covariances are too small where the most certain corners are
    overconfident; so the pixel noise is at least that of the unweighted residuals (pose_noise.py).
    """
    extra_px = _measure_pose_noise_px(tracks, views)
    found = _estimate_all(tracks, views, extra_px)
    used = tracks.used & found.ok[:, None] & _in_front(found)
    done: Adjusted | None = None
    least_px = LEAST_PX
    for choice in range(1 + CHOICES):
        chosen = np.flatnonzero(found.ok & (used.sum(axis=1) >= 2))
        if len(chosen) < LEAST_POINTS:
            break
        of_chosen = replace(tracks, used=used).rows(chosen)
        start = found.points[chosen]
        done = adjust(of_chosen, views, start, errors, extra_px, done, least_px, lens_is_off)
        straight = done.undistorted(tracks)
        found = _estimate_all(straight, done.views, done.sizes.extra_px)
        before, used = used, found.used
        if choice and (used == before).all():
            break
        least_px = max(_measure_pose_noise_px(straight, done.views), LEAST_PX)
    straight = tracks if done is None else done.undistorted(tracks)
    projections = np.array([v.projection for v in found.views])
    groups = view_groups(np.array([v.pose.centre for v in found.views]))
    noise = tracks.noise(found.extra_px)
    factor = estimate_shared_error_factor(
        straight.uv, noise, found.used, projections, found.covs, groups
    )
    return _inflate_covariances(tracks, replace(found, factor=factor, adjusted=done))


def estimate_points_at(tracks: Tracks, at: AdjustedPoints) -> AdjustedPoints:
    """Return the points of tracks at the adjusted poses, with the errors of these in their
    covariances.
    """
    straight = tracks if at.adjusted is None else at.adjusted.undistorted(tracks)
    found = _estimate_all(straight, at.views, at.extra_px)
    return _inflate_covariances(tracks, replace(found, factor=at.factor, adjusted=at.adjusted))


def _inflate_covariances(tracks: Tracks, found: AdjustedPoints) -> AdjustedPoints:
    # The points with covariances that include pose errors and errors that views share.
    covs, ok = found.factor * found.covs, found.ok
    shape_covs = covs.copy()
    if found.adjusted is not None:
        of_ok, points = replace(tracks, used=found.used).rows(ok), found.points[ok]
        own, shared = found.adjusted.compute_errors_at(of_ok, points, found.factor)
        covs[ok] = own + shared.transpose(0, 2, 1) @ shared
        shape_covs[ok] = remove_common_motion(points, own, shared)
    return replace(found, covs=covs, shape_covs=shape_covs)


def _measure_pose_noise_px(tracks: Tracks, views: Sequence[View]) -> float:
    projections = np.array([v.projection for v in views])
    return estimate_pose_noise_px(tracks.uv, tracks.cov, tracks.used, projections)


def _estimate_all(tracks: Tracks, views: Sequence[View], extra_px: float) -> AdjustedPoints:
    projections = np.array([v.projection for v in views])
    cov = tracks.noise(extra_px)
    points, covs, used, ok = estimate_points(tracks.uv, cov, tracks.used, projections)
    return AdjustedPoints(tuple(views), points, covs, covs, used, ok, extra_px)


def _in_front(found: AdjustedPoints) -> NDArray[np.bool_]:
    third = np.array([v.projection[2] for v in found.views])
    depth = np.nan_to_num(found.points) @ third[:, :3].T + third[:, 3]
    return np.asarray(depth > 0)
