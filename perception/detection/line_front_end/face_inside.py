"""Whether the inside of an outline is surface: views that face it agree there, or see through."""

from collections.abc import Sequence

import numpy as np
import shapely

from facetlog.perception.detection.edge_maps import EdgeMap
from facetlog.perception.detection.line_front_end.line_support import project_points
from facetlog.perception.detection.line_front_end.photo_consistency import GreyLevels, agreement
from facetlog.perception.detection.line_front_end.plane_hypotheses import plane_basis
from facetlog.perception.types import FloatArray, View

__all__ = ["FACING_SINE", "InsideJudge", "inner_points"]

# A view faces a plane when it looks at it by more than this sine: else it is seen edge-on.
FACING_SINE = 0.2
# Points inside an outline at which levels are compared, and the lattice they are taken from.
INNER_POINTS, LATTICE = 60, 24


class InsideJudge:
    """Judges outlines by all views; `weight` (V,) is how much each counts."""

    def __init__(self, views: Sequence[View], maps: Sequence[EdgeMap], weight: FloatArray) -> None:
        self._views = views
        self._levels = GreyLevels(views, maps)
        self._weight = weight
        self._centres = np.array([view.pose.centre for view in views])

    def surface_share(self, corners: FloatArray, normal: FloatArray) -> float:
        """Share of a polygon (k, 3) where a surface is likelier than none; 0 if no view faces it.

        By the views on the side that the unit normal points to.
        """
        points = inner_points(corners, normal)
        rays = self._centres - corners.mean(axis=0)
        facing = rays @ normal > FACING_SINE * np.linalg.norm(rays, axis=1)
        chosen = np.nonzero(facing)[0].tolist()
        if not chosen or not len(points):
            return 0.0
        pixels, inside = [], []
        for k in chosen:
            uv, depth = project_points(self._views[k].projection, points)
            height, width = self._views[k].image.shape
            seen = (depth > 0) & (uv > 1).all(axis=1) & (uv < [width - 2, height - 2]).all(axis=1)
            pixels.append(uv[:, None])
            inside.append(seen[:, None])
        levels = self._levels.read(chosen, pixels, inside)
        return float((agreement(levels, self._weight[chosen]).ratio > 0).mean())


def inner_points(corners: FloatArray, normal: FloatArray) -> FloatArray:
    """Up to INNER_POINTS points (n, 3) spread evenly over the inside of a flat polygon (k, 3)."""
    basis = plane_basis(normal)
    polygon = shapely.Polygon(corners @ basis).buffer(0)
    if polygon.is_empty:
        return np.zeros((0, 3))
    low, high = np.array(polygon.bounds).reshape(2, 2)
    # A thin or winding outline fills little of its box: the finer the lattice must be.
    filled = polygon.area / max(float(np.prod(high - low)), 1e-300)
    count = int(LATTICE / np.sqrt(np.clip(filled, 0.01, 1.0)))
    steps = (np.arange(count) + 0.5) / count
    grid = low + np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2) * (high - low)
    inside = grid[shapely.contains_xy(polygon, grid)]
    if len(inside) > INNER_POINTS:
        inside = inside[np.linspace(0, len(inside) - 1, INNER_POINTS).astype(int)]
    points: FloatArray = normal * float(normal @ corners.mean(axis=0)) + inside @ basis.T
    return points
