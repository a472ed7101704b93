"""Poses from odometry, corrected by the straight edges in the pictures.

The first views, between which odometry has hardly drifted, are aligned from coarse pictures to fine
ones, since in a small picture a wrong pose is off by few pixels. Each further view is then
registered to the 3-D segments found so far, and all are fitted together (line_alignment.py), with
odometry as the prior. What only odometry determines, as the place of the whole in the world, stays
as it is.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import SUPPORTED
from facetlog.perception.detection.line_front_end.segments_3d.line_support import (
    coverage,
    project_points,
)
from facetlog.perception.detection.line_front_end.segments_3d.pose_consistency import (
    measure_share_explained,
)
from facetlog.perception.detection.view_graph import view_graph
from facetlog.perception.detection.working_size import (
    enlarge_to_working_size,
    measure_working_noises,
)
from facetlog.perception.estimation.pose_refinement.line_alignment import (
    DriftingViews,
    align_one,
    fitted,
    lines_of,
    prepare_drifting_views,
    smaller,
)
from facetlog.perception.estimation.pose_refinement.pose_chain import pose_chain
from facetlog.perception.reading.read_views import ViewSet
from facetlog.perception.types import FloatArray, PoseErrorKind, View

DRAWN = 400
# Samples spread a little wider than the prior: covariances are estimates too.
SPREAD = 1.5
IMPROVED = 6
# Width searched, px, and share of a segment that must lie on edges, in successive steps.
STEPS = ((8.0, 0.3), (5.0, 0.3), (3.0, 0.5), (2.0, 0.5), (2.0, 0.5))
# A segment counts from this share on; by its length in the picture, up to half the usual picture:
# the floor's boards are longer than anything that stands on it.
SHOWN = 0.5
LONGEST = 0.5
# So many pixels of shown segments count as much as one unit of the prior's squared Mahalanobis
# distance.
PX_A_UNIT = 2.0


def registered(
    drifting: DriftingViews, k: int, twists: FloatArray, segments: FloatArray
) -> FloatArray:
    """Return the twist (6,) of view k that shows segments (n, 2, 3) best, within its prior."""
    before, step = drifting.chain.expected(k, twists)
    rng = np.random.default_rng(k)
    drawn = rng.multivariate_normal(before, SPREAD * step, DRAWN, method="eigh")
    drawn = np.vstack([before, drawn])
    shown = np.array([_measure_shown_px(drifting, k, twist, segments) for twist in drawn])
    best, most = before, -np.inf
    belief = np.linalg.inv(step)
    for index in np.argsort(-shown, kind="stable")[:IMPROVED]:
        twist = _improve_twist(drifting, k, drawn[index], (before, step), segments)
        off = twist - before
        score = _measure_shown_px(drifting, k, twist, segments) - PX_A_UNIT * float(
            off @ belief @ off
        )
        if score > most:
            best, most = twist, score
    return best


def _improve_twist(
    drifting: DriftingViews,
    k: int,
    twist: FloatArray,
    expected: tuple[FloatArray, FloatArray],
    segments: FloatArray,
) -> FloatArray:
    for search_px, least in STEPS:
        shown = _coverage(drifting, k, twist, segments) > least
        if not shown.any():
            break
        twist = align_one(drifting, k, twist, expected, segments[shown], search_px)
    return twist


def _coverage(
    drifting: DriftingViews, k: int, twist: FloatArray, segments: FloatArray
) -> FloatArray:
    view = drifting.at([k], twist[None])
    return np.nan_to_num(coverage(segments, view, [drifting.maps[k]])[:, 0])


def _measure_shown_px(
    drifting: DriftingViews, k: int, twist: FloatArray, segments: FloatArray
) -> float:
    (view,) = drifting.at([k], twist[None])
    share = _coverage(drifting, k, twist, segments)
    uv, _ = project_points(view.projection, segments)
    along = uv[:, 1] - uv[:, 0]
    length = np.minimum(np.hypot(along[:, 0], along[:, 1]), LONGEST * view.camera.width)
    return float((np.where(share > SHOWN, share, 0.0) ** 2 * length).sum())


# Views that are aligned first: a 3-D segment needs three, and one of them may show little.
FIRST = 6
# Pictures are shrunk to these shares at first.
COARSE_TO_FINE = (1 / 3, 1 / 2, 1.0)
# Width searched across projected segments, px, in successive fits.
FIRST_SEARCH_PX = (4.0, 3.0, 2.0, 2.0, 2.0)
SEARCH_PX = (4.0, 3.0, 2.0)
# All views are fitted anew when their number has grown by this factor: each time costs as much as
# all views together.
GROWTH = 1.1
ROUNDS = 4
"""Rounds of new segments and a fit, once all views are there; fewer once no view gains by it."""
DOUBTFUL = 0.05
"""A view whose explained share is this far below the median of all may be off by one edge, and is
registered again in each round, with more segments known."""
GAIN = 0.02
"""Least gain of its explained share for which a view is moved."""


@dataclass(frozen=True, eq=False, slots=True)
class RefinedViews:
    """The views at their new poses; the largest correction (world units, radians).

    `explained` and `explained_before` are the shares (by length) of the pictures' straight segments
    that lie on 3-D segments, at the new poses and at the given ones. Where the new ones explain no
    more, the views are returned as given.
    """

    views: tuple[View, ...]
    shift: float
    turn: float
    explained: float
    explained_before: float


def refine_views(
    views: Sequence[View],
    covariances: FloatArray,
    progress: Callable[[str, int, int], None] | None = None,
) -> RefinedViews:
    """Return the views with their poses corrected; in the order in which they were taken.

    `covariances` (V, 6, 6): of each camera's place (world units) and of a rotation vector
    (radians), both in the world frame, as they accumulate in odometry. `progress` is called with
    ("poses", done, all).
    """
    working, factors = enlarge_to_working_size(views)
    graph = view_graph(working)
    chain = pose_chain([v.pose for v in views], covariances, graph.focus, graph.distance)
    full = prepare_drifting_views(working, chain, noises=measure_working_noises(views, factors))
    given = np.zeros((len(views), 6))
    before = lines_of(full, given).explained
    twists, segments = _fit_first_twists(working, full)
    count = len(twists)
    for k in range(len(twists), len(views)):
        if progress is not None:
            progress("poses", k, len(views))
        found = registered(full, k, twists, segments)
        twists = np.vstack([twists, found])
        if len(twists) >= GROWTH * count:
            twists, segments = fitted(full, twists, SEARCH_PX)
            count = len(twists)
    for _ in range(ROUNDS):
        twists, _ = fitted(full, twists, SEARCH_PX)
        again = _register_again(full, twists)
        if again is twists:
            break
        twists = again
    else:
        twists, _ = fitted(full, twists, SEARCH_PX)
    after = lines_of(full, twists).explained
    if after <= before:
        return RefinedViews(tuple(views), 0.0, 0.0, before, before)
    poses = [full.pose(k, twist) for k, twist in enumerate(twists)]
    went = [np.linalg.norm(p.centre - v.pose.centre) for p, v in zip(poses, views, strict=True)]
    turned = [
        Rotation.from_matrix(p.rotation @ v.pose.rotation.T).magnitude()
        for p, v in zip(poses, views, strict=True)
    ]
    return RefinedViews(
        tuple(replace(view, pose=pose) for view, pose in zip(views, poses, strict=True)),
        float(max(went)),
        float(max(turned)),
        after,
        before,
    )


def correct_poses(
    view_set: ViewSet, progress: Callable[[str, int, int], None] | None = None
) -> ViewSet:
    """Return the set with its poses corrected, and a line about that among its problems.

    Only poses from odometry are corrected: independent errors are left to bundle adjustment.
    ValueError if the covariances of the poses are not stated.
    """
    if view_set.pose_errors is None:
        raise ValueError(f"{view_set.name}: the covariances of the poses are not known")
    if view_set.pose_errors.kind is PoseErrorKind.INDEPENDENT:
        return view_set
    found = refine_views(view_set.views, view_set.pose_errors.covariances, progress)
    if found.explained <= found.explained_before:
        return view_set
    length = f"{found.shift * 100:.2g} cm" if view_set.metric else f"{found.shift:.2g} units"
    line = (
        f"poses were off by up to {length} and {np.degrees(found.turn):.2g} degrees and were "
        f"corrected: {found.explained:.0%} of the straight edges agree, before it was "
        f"{found.explained_before:.0%} (--keep-poses takes them as they are)"
    )
    return replace(view_set, views=found.views, problems=(*view_set.problems, line))


def _fit_first_twists(views: Sequence[View], full: DriftingViews) -> tuple[FloatArray, FloatArray]:
    """Fit twists (FIRST, 6) of the first views and segments, from coarse pictures to fine ones."""
    first = full.first(min(FIRST, len(views)))
    twists, segments = np.zeros((len(first.views), 6)), np.zeros((0, 2, 3))
    for share in COARSE_TO_FINE:
        level = first
        if share < 1:
            level = smaller(first, share)
        twists, segments = fitted(level, twists, FIRST_SEARCH_PX)
    return twists, segments


def _register_again(drifting: DriftingViews, twists: FloatArray) -> FloatArray:
    """Return the twists with those of suspect views registered again; unchanged where none gains by
    it.
    """
    lines = lines_of(drifting, twists)
    shares = np.array(
        [measure_shown_share(drifting, k, t, lines.segments) for k, t in enumerate(twists)]
    )
    better = twists
    for k in range(1, len(twists)):
        if shares[k] >= np.median(shares) - DOUBTFUL:
            continue
        found = registered(drifting, k, better, lines.segments)
        if measure_shown_share(drifting, k, found, lines.segments) > shares[k] + GAIN:
            better = better.copy()
            better[k] = found
    return better


def measure_shown_share(
    drifting: DriftingViews, k: int, twist: FloatArray, segments: FloatArray
) -> float:
    """Return share of the straight segments of view k that the 3-D segments (n, 2, 3) explain."""
    view = drifting.at([k], twist[None])
    use = np.nan_to_num(coverage(segments, view, [drifting.maps[k]])) > SUPPORTED
    return measure_share_explained(segments, use, view, [drifting.segments[k]])
