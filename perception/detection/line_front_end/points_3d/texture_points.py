"""The texture points of a scene, and which view sees which."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.edge_maps import EdgeMap
from facetlog.perception.detection.line_front_end.points_3d.feature_tracks import (
    CORNER_SD_PX,
    MIN_TRACK,
    feature_tracks,
)
from facetlog.perception.detection.line_front_end.points_3d.texture_features import (
    common_direction,
    texture_features,
)
from facetlog.perception.detection.view_graph import ViewGraph
from facetlog.perception.types import FloatArray, View

__all__ = ["TexturePoints", "Triangulate", "texture_points"]


@dataclass(frozen=True, eq=False, slots=True)
class TexturePoints:
    """Points (n, 3) of the scene, their covariances (n, 3, 3), and which view sees which (n, V)."""

    points: FloatArray
    covs: FloatArray
    seen: NDArray[np.bool_]

    @classmethod
    def none(cls, views: int) -> Self:
        """No points in so many views."""
        return cls(np.zeros((0, 3)), np.zeros((0, 3, 3)), np.zeros((0, views), dtype=np.bool_))

    def take(self, rows: NDArray[np.intp] | NDArray[np.bool_]) -> Self:
        """Some of the points."""
        return type(self)(self.points[rows], self.covs[rows], self.seen[rows])


Triangulate: TypeAlias = Callable[
    [Sequence[View], FloatArray, float, NDArray[np.bool_]], TexturePoints
]
"""From views, pixels (n, V, 2), their standard deviation px, and which were seen (n, V), to the
points that at least three views are inliers of."""


def texture_points(
    views: Sequence[View],
    maps: Sequence[EdgeMap],
    graph: ViewGraph,
    pixel: float,
    triangulate: Triangulate,
) -> TexturePoints:
    """Texture points seen in three views or more; `pixel` is a pixel's length at the focus.

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
    return triangulate(views, uv, CORNER_SD_PX, seen)
