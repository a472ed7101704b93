"""Texture points triangulated from matched features, with the views that are inliers."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.points_3d.texture_points import TexturePoints
from facetlog.perception.estimation.point_consensus import agreeing_views
from facetlog.perception.estimation.point_views import Cameras, Sightings
from facetlog.perception.estimation.symmetric_matrices import unpacked
from facetlog.perception.types import FloatArray, View

__all__ = ["triangulated"]


def triangulated(
    views: Sequence[View], uv: FloatArray, sd_px: float, seen: NDArray[np.bool_]
) -> TexturePoints:
    """The points in front of the cameras with three inlier views or more, and these views.

    `uv` (n, V, 2) are pixels with this standard deviation, where `seen` (n, V).
    """
    cameras = Cameras.of([view.projection for view in views])
    cov = np.broadcast_to(sd_px**2 * np.eye(2), (*seen.shape, 2, 2))
    agreed = agreeing_views(cameras, Sightings.of(cameras, uv, cov, seen))
    rows = np.flatnonzero(agreed.stands & ~agreed.behind)
    points = cameras.origin + cameras.scale * agreed.points[rows]
    return TexturePoints(
        points, cameras.scale**2 * unpacked(agreed.covs[rows]), agreed.inliers[rows]
    )
