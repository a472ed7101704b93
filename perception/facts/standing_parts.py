"""Where parts stand: on the ground, and under or on a level face at its rim."""

from collections.abc import Iterator

import numpy as np
import shapely

from facetlog.perception.flat_faces import plane_axes
from facetlog.perception.row_table import Indices
from facetlog.perception.surfaces.convex_hulls import least_rectangle
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.surfaces.things import Thing
from facetlog.perception.types import FloatArray

__all__ = ["RIM_SHARE", "at_rim"]

# A part whose middle is this near to the outline, as a share of the face's width, is at the rim:
# legs are inset by 5 to 12 % of a table's width.
RIM_SHARE = 0.15
# Faces that lean less than 30° from level have a rim to stand at, and parts that lean less than 30°
# from upright stand: cosine and sine.
ENOUGH = 0.866
LEANS_LITTLE = 0.5


def _rises(ends: FloatArray, up: FloatArray) -> bool:
    """Whether points (n, 3) reach farther up than to any side."""
    height = float(np.ptp(ends @ up))
    flat = ends - np.outer(ends @ up, up)
    return bool(height > float(np.linalg.norm(np.ptp(flat, axis=0))) * np.tan(np.deg2rad(30.0)))


def at_rim(
    up: FloatArray, table: FaceTable, edges: Indices, thing: Thing
) -> Iterator[tuple[bool, int, int]]:
    """(loose, part, face) where a part of a thing stands at the rim of a face of it about level.

    Parts are upright faces and, where that is so, `loose` edges (e, 2) of vertices. Nothing without
    a known up, which is zero then.
    """
    if not up.any():
        return
    axes = plane_axes(up, np.eye(3)[int(np.argmin(np.abs(up)))])
    points = table.points
    own = [table.faces[i] for i in thing.faces]
    level = [f for f in own if abs(float(f.normal @ up)) > ENOUGH and f.area > 0.0]
    standing = [
        (False, f.index, points[list(f.outline)].mean(axis=0))
        for f in own
        if abs(float(f.normal @ up)) < LEANS_LITTLE
    ]
    ends = ((i, points[edges[i]]) for i in thing.edges)
    standing += [(True, i, both.mean(axis=0)) for i, both in ends if _rises(both, up)]
    if not level or not standing:
        return
    rims = [shapely.linearrings(points[list(f.outline)] @ axes.T) for f in level]
    dots = shapely.points(np.array([middle for _, _, middle in standing]) @ axes.T)
    widths = np.array([least_rectangle(f.flatten(points[list(f.outline)]))[2] for f in level])
    away = shapely.distance(np.array(rims)[:, None], dots[None])
    for row, column in np.argwhere(away <= RIM_SHARE * widths[:, None]).tolist():
        yield *standing[column][:2], level[row].index
