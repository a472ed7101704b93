"""Texture points of a scene: features matched between pairs of views, linked and triangulated."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from facetlog.perception.detection.edge_maps import EdgeMap
from facetlog.perception.detection.line_front_end.points_3d.texture_features import (
    APART_PX,
    TextureFeatures,
    common_direction,
    texture_features,
)
from facetlog.perception.detection.view_graph import ViewGraph
from facetlog.perception.estimation.point_consensus import agreeing_views
from facetlog.perception.estimation.point_views import Cameras, Sightings
from facetlog.perception.types import FloatArray, View

# Standard deviation of a corner's place, px: texture looks different from elsewhere, and its corner
# moves by a share of the window.
CORNER_SD_PX = 0.7
# A match lies this near to the epipolar line, in standard deviations of both corners.
LINE_SDS = 3.0
# Patches are alike from this correlation on: of two that have nothing in common, each of some
# twenty independent samples, it is 1 / √20 on average, and once in 300 as much as this.
MIN_CORRELATION = 0.6
# Ratio test: the second best match on the line must be this much farther off (Lowe 2004).
RATIO = 0.85
# Two views of a point prove nothing: the rays of a chance match on epipolar lines always meet.
MIN_TRACK = 3


def feature_tracks(
    features: Mapping[int, TextureFeatures],
    views: Sequence[View],
    pairs: Sequence[tuple[int, int]],
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return pixels (n, V, 2) of n candidate points, and which views show them (n, V).

    `features` are those of the views (by their number) that the `pairs` name. Of a chain with two
    features of one view neither counts: they are not the same point.
    """
    numbers = sorted(features)
    counts = [len(features[k].uv) for k in numbers]
    first = dict(zip(numbers, np.cumsum([0, *counts[:-1]]).tolist(), strict=True))
    links = [np.zeros((0, 2), dtype=np.intp)]
    for i, j in pairs:
        found = matched_features(features[i], features[j], views[i], views[j])
        links.append(found + np.array([first[i], first[j]]))
    a, b = np.concatenate(links).T
    total = sum(counts)
    graph = coo_array((np.ones(len(a), dtype=np.bool_), (a, b)), shape=(total, total))
    chains, label = connected_components(graph, directed=False)
    owner = np.repeat(np.array(numbers, dtype=np.intp), counts)
    often = np.zeros((chains, len(views)), dtype=np.intp)
    np.add.at(often, (label, owner), 1)
    kept = np.nonzero((often == 1).sum(axis=1) >= MIN_TRACK)[0]
    uv = np.zeros((chains, len(views), 2))
    if total:
        uv[label, owner] = np.concatenate([features[k].uv for k in numbers])
    return uv[kept], often[kept] == 1


def matched_features(
    one: TextureFeatures, other: TextureFeatures, view: View, other_view: View
) -> NDArray[np.intp]:
    """Return pairs (m, 2) of features of two views that are each other's best match on epipolar
    lines.
    """
    if not len(one.uv) or not len(other.uv):
        return np.zeros((0, 2), dtype=np.intp)
    lines = np.column_stack([one.uv, np.ones(len(one.uv))]) @ _epipolar(view, other_view).T
    lines /= np.maximum(np.hypot(lines[:, 0], lines[:, 1]), 1e-300)[:, None]
    off = lines.astype(np.float32) @ np.vstack([other.uv.T, np.ones(len(other.uv))]).astype(
        np.float32
    )
    near = np.abs(off) < LINE_SDS * np.sqrt(2) * CORNER_SD_PX
    likeness = np.where(near, one.patches @ other.patches.T, np.float32(-1.0))
    rows = np.arange(len(one.uv))
    best = likeness.argmax(axis=1)
    alike = likeness[rows, best]
    mutual = likeness.argmax(axis=0)[best] == rows
    likely = np.nonzero(mutual & (alike > MIN_CORRELATION))[0]
    rest, places = likeness[likely], other.uv.astype(np.float32)
    there = places[best[likely]]
    apart = np.abs(there[:, :1] - places[:, 0]) > APART_PX
    apart |= np.abs(there[:, 1:] - places[:, 1]) > APART_PX
    second = np.where(apart, rest, np.float32(-1.0)).max(axis=1)
    # Of unit vectors |a - b|² = 2 - 2 a·b.
    clear = 1.0 - alike[likely] < RATIO**2 * (1.0 - second)
    return np.stack([likely[clear], best[likely[clear]]], axis=1)


def _epipolar(view: View, other: View) -> FloatArray:
    # F (3, 3): a pixel of the first view has the line F (u, v, 1) in the other one.
    onto = other.projection[:, :3] @ np.linalg.inv(view.projection[:, :3])
    x, y, z = other.projection @ np.append(view.pose.centre, 1.0)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]) @ onto


@dataclass(frozen=True, eq=False, slots=True)
class TexturePoints:
    """Points (n, 3) of the scene, their covariances (n, 3, 3), and which view sees which (n, V)."""

    points: FloatArray
    covs: FloatArray
    seen: NDArray[np.bool_]

    @classmethod
    def none(cls, views: int) -> Self:
        """Return no points in so many views."""
        return cls(np.zeros((0, 3)), np.zeros((0, 3, 3)), np.zeros((0, views), dtype=np.bool_))

    def take(self, rows: NDArray[np.intp] | NDArray[np.bool_]) -> Self:
        """Return some of the points."""
        return type(self)(self.points[rows], self.covs[rows], self.seen[rows])


def texture_points(
    views: Sequence[View],
    maps: Sequence[EdgeMap],
    graph: ViewGraph,
    pixel: float,
) -> TexturePoints:
    """Return texture points seen in three views or more; `pixel` is a pixel's length at the focus.

    Only the views that are paired for depth take part.
    """
    direction = common_direction(views)
    paired = sorted({k for pair in graph.pairs for k in pair})
    if len(paired) < MIN_TRACK:
        return TexturePoints.none(len(views))
    features = {
        k: texture_features(views[k], maps[k], direction, graph.focus, pixel) for k in paired
    }
    uv, seen = feature_tracks(features, views, graph.pairs)
    if not len(uv):
        return TexturePoints.none(len(views))
    return triangulated(views, uv, CORNER_SD_PX, seen)


def triangulated(
    views: Sequence[View], uv: FloatArray, sd_px: float, seen: NDArray[np.bool_]
) -> TexturePoints:
    """Return the points in front of the cameras with three inlier views or more, and these views.

    `uv` (n, V, 2) are pixels with this standard deviation, where `seen` (n, V).
    """
    cameras = Cameras.of([view.projection for view in views])
    cov = np.broadcast_to(sd_px**2 * np.eye(2), (*seen.shape, 2, 2))
    agreed = agreeing_views(cameras, Sightings.of(cameras, uv, cov, seen))
    rows = np.flatnonzero(agreed.stands & ~agreed.behind)
    points = cameras.origin + cameras.scale * agreed.points[rows]
    return TexturePoints(points, cameras.scale**2 * agreed.covs[rows], agreed.inliers[rows])
