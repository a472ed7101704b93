"""Poses and 3-D segments fitted together to the edges in the pictures, odometry as the prior.

Gauss-Newton: the unknowns are a twist of six numbers a view (pose_chain.py) and four a segment
(both ends across it). The residuals are the distances in pixels from samples of the projected
segments to the nearest strong edge; the prior is the chain of odometry's steps.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.coarse_pictures import coarse_pictures
from facetlog.perception.detection.edge_maps import EdgeMap, edge_map
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import find_shown_lines
from facetlog.perception.detection.line_front_end.segments_3d.line_refine import (
    READINGS_A_VIEW,
    build_across_basis,
    compute_ends_jacobian,
    compute_point_jacobian,
    read_edges,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_support import segment_samples
from facetlog.perception.detection.line_front_end.segments_3d.pose_consistency import (
    measure_share_explained,
)
from facetlog.perception.detection.picture_noise import Noise, measure_working_noise
from facetlog.perception.detection.segments import detect_segments
from facetlog.perception.estimation.pose_refinement.pose_chain import TwistPrior, moved
from facetlog.perception.types import FloatArray, Pose, View

SAMPLES = 16
# The robust (Cauchy) scale is this share of the width searched, one pixel at least: at first the
# right edge is some pixels away, near the end an edge one pixel away is a different one.
ROBUST_SHARE = 1 / 3


@dataclass(frozen=True, eq=False, slots=True)
class DriftingViews:
    """Views at the poses from odometry, their edges, and the prior of the errors of these poses."""

    views: tuple[View, ...]
    maps: tuple[EdgeMap, ...]
    segments: tuple[FloatArray, ...]
    """Straight segments (n, 4) of each picture."""
    chain: TwistPrior

    def at(self, chosen: Sequence[int], twists: FloatArray) -> tuple[View, ...]:
        """Return the chosen views moved by these twists, one for each of them."""
        placed = zip(chosen, twists, strict=True)
        return tuple(replace(self.views[k], pose=self.pose(k, twist)) for k, twist in placed)

    def pose(self, k: int, twist: FloatArray) -> Pose:
        """Return the pose of view k with this twist (6,)."""
        return moved(self.views[k].pose, twist, self.chain.about)

    def first(self, count: int) -> "DriftingViews":
        """Return the first so many of them."""
        return DriftingViews(
            self.views[:count], self.maps[:count], self.segments[:count], self.chain
        )


def align(
    drifting: DriftingViews,
    twists: FloatArray,
    segments: FloatArray,
    use: NDArray[np.bool_],
    search_px: float,
) -> tuple[FloatArray, FloatArray]:
    """Take one step for the views and segments (n, 2, 3) together: twists (V, 6) and segments.

    `use` (n, V) says which segment is searched in which view.
    """
    views, lines = len(drifting.views), len(segments)
    basis = build_across_basis(segments)
    points = segment_samples(segments, SAMPLES)
    own = 6 * views
    h, g = np.zeros((own + 4 * lines,) * 2), np.zeros(own + 4 * lines)
    drifting.chain.add_prior(twists, h, g)
    for k, view in enumerate(drifting.at(range(views), twists)):
        chosen = np.nonzero(use[:, k])[0]
        if not len(chosen):
            continue
        by_view, by_point, error, weight = _readings(
            view, drifting.maps[k], points[chosen], drifting.chain.about, search_px
        )
        by_ends = compute_ends_jacobian(by_point, basis[chosen])
        at = slice(6 * k, 6 * k + 6)
        h[at, at] += np.einsum("nm,nma,nmb->ab", weight, by_view, by_view)
        g[at] += np.einsum("nm,nma,nm->a", weight, by_view, error)
        both = np.einsum("nm,nma,nmb->nab", weight, by_view, by_ends)
        ends = np.einsum("nm,nma,nmb->nab", weight, by_ends, by_ends)
        pull = np.einsum("nm,nma,nm->na", weight, by_ends, error)
        for i, line in enumerate(chosen):
            of = slice(own + 4 * line, own + 4 * line + 4)
            h[of, of] += ends[i]
            h[at, of] += both[i]
            h[of, at] += both[i].T
            g[of] += pull[i]
    # A touch of damping: a segment read in too few places does not move where it is not known.
    ends_of = np.arange(own, len(g))
    if lines:
        h[ends_of, ends_of] += 1e-6 * h[ends_of, ends_of].mean() + 1e-300
    step = np.linalg.solve(h, g)
    shift = step[own:].reshape(lines, 2, 2)
    return twists + step[:own].reshape(views, 6), segments + np.einsum("nka,nea->nek", basis, shift)


def align_one(
    drifting: DriftingViews,
    k: int,
    twist: FloatArray,
    expected: tuple[FloatArray, FloatArray],
    segments: FloatArray,
    search_px: float,
) -> FloatArray:
    """Take one step for the twist (6,) of view k alone, to segments (n, 2, 3) that stay.

    `expected` are the mean and covariance of its prior.
    """
    (view,) = drifting.at([k], twist[None])
    points = segment_samples(segments, SAMPLES)
    by_view, _, error, weight = _readings(
        view, drifting.maps[k], points, drifting.chain.about, search_px
    )
    mean, cov = expected
    belief = np.linalg.inv(cov)
    h = belief + np.einsum("nm,nma,nmb->ab", weight, by_view, by_view)
    g = belief @ (mean - twist) + np.einsum("nm,nma,nm->a", weight, by_view, error)
    return np.asarray(twist + np.linalg.solve(h, g))


def _readings(
    view: View, edges: EdgeMap, points: FloatArray, about: FloatArray, search_px: float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return Jacobians by the view's twist (n, m, 6) and the point (n, m, 3); errors, weights (n,
    m).
    """
    read = read_edges(view, edges, points, search_px)
    by_point = compute_point_jacobian(view, points, read)
    # The camera's twist moves the world the other way: dX = -(turn x r + shift), r from `about`.
    by_view = np.concatenate([np.cross(by_point, points - about), -by_point], axis=-1)
    found = np.isfinite(read.offset)
    error = np.where(found, read.offset, 0.0)
    scale = max(1.0, ROBUST_SHARE * search_px)
    # The samples of a segment in a view share its error there.
    weight = found / (1.0 + (error / scale) ** 2) * (READINGS_A_VIEW / SAMPLES)
    return by_view, by_point, error, weight


class Lines(NamedTuple):
    """3-D segments (n, 2, 3), which view shows which (n, V), and the share that they explain."""

    segments: FloatArray
    use: NDArray[np.bool_]
    explained: float


def prepare_drifting_views(
    views: Sequence[View],
    chain: TwistPrior,
    reach_px: float | None = None,
    noises: Sequence[Noise] | None = None,
) -> DriftingViews:
    """Return the views with their edges and segments; `reach_px`, `noises` as of `edge_map`."""
    maps, segments = [], []
    for view, noise in zip(
        views, noises or (measure_working_noise(v.image) for v in views), strict=True
    ):
        coarser = coarse_pictures(view.image, noise)
        maps.append(edge_map(view.image, reach_px, noise, coarser))
        segments.append(detect_segments(view.image, noise, coarser))
    return DriftingViews(tuple(views), tuple(maps), tuple(segments), chain)


def smaller(drifting: DriftingViews, share: float, reach_px: float | None = None) -> DriftingViews:
    """Return the views with pictures shrunk to this share of their sides."""
    views = []
    for view in drifting.views:
        height, width = (round(share * side) for side in view.image.shape)
        image = cv2.resize(view.image, (width, height), interpolation=cv2.INTER_AREA)
        camera = view.camera.resized(width, height)
        views.append(View(view.name, np.asarray(image, dtype=np.uint8), camera, view.pose))
    return prepare_drifting_views(views, drifting.chain, reach_px)


def fitted(
    drifting: DriftingViews, twists: FloatArray, searches_px: Sequence[float]
) -> tuple[FloatArray, FloatArray]:
    """Return twists and segments after a joint fit of all views that have a twist."""
    here = drifting.first(len(twists))
    lines = lines_of(here, twists)
    segments = lines.segments
    for search_px in searches_px:
        twists, segments = align(here, twists, segments, lines.use, search_px)
    return twists, segments


def lines_of(drifting: DriftingViews, twists: FloatArray) -> Lines:
    """Return the 3-D segments of the views at these twists (V, 6)."""
    views = drifting.at(range(len(drifting.views)), twists)
    cloud, use = find_shown_lines(views, drifting.maps, drifting.segments)
    share = measure_share_explained(cloud.segments, use, views, drifting.segments)
    return Lines(cloud.segments, use, share)
