"""Where parts stand: on the ground, and under or on a level face at its rim."""

from collections.abc import Iterator, Sequence

import numpy as np
import shapely

from facetlog.perception.batch_linalg import dots
from facetlog.perception.flat_faces import plane_axes
from facetlog.perception.ragged import Bools, Indices
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.surfaces.floors import LEVEL_ENOUGH
from facetlog.perception.surfaces.things import Thing
from facetlog.perception.types import FloatArray

__all__ = ["RIM_SHARE", "at_rim"]

# A part whose middle is this near to the outline, as a share of the face's width, is at the rim:
# legs are inset by 5 to 12 % of a table's width.
RIM_SHARE = 0.15
# Parts that lean less than this from upright stand: sin 30°.
LEANS_LITTLE = 0.5


def at_rim(
    ups: FloatArray,
    table: FaceTable,
    widths: FloatArray,
    edges: Indices,
    things: Sequence[Thing],
) -> Iterator[tuple[int, bool, int, int]]:
    """(scene, loose, part, face) where a part of a thing stands at the rim of a face about level.

    Parts are upright faces and, where that is so, `loose` edges (e, 2) of vertices. `ups` (s, 3)
    are the scenes', zero where up is not known: nothing is level there. `widths` (f,) are the
    faces'.
    """
    axes = plane_axes(ups, np.eye(3)[np.abs(ups).argmin(axis=1)])
    rise = np.abs(dots(table.planes.normals, ups[table.scene]))
    level: Bools = (rise > LEVEL_ENOUGH) & (table.areas > 0.0)
    stands: Bools = (rise < LEANS_LITTLE) & np.asarray(ups.any(axis=1))[table.scene]
    corners = np.where(table.there[..., None], table.points[table.outlines], 0.0)
    middles = corners.sum(axis=1) / np.maximum(table.sizes, 1)[:, None]
    rises = _rising(table.points[edges], ups, things)
    for thing in things:
        faces = np.array(thing.faces, dtype=np.intp)
        rims, upright = faces[level[faces]], faces[stands[faces]]
        loose = np.array([i for i in thing.edges if rises[i]], dtype=np.intp)
        if not len(rims) or not len(upright) + len(loose):
            continue
        plan = axes[thing.scene]
        rings = [shapely.linearrings(corners[f, table.there[f]] @ plan.T) for f in rims.tolist()]
        standing = np.concatenate([middles[upright], table.points[edges[loose]].mean(axis=1)])
        away = shapely.distance(np.array(rings)[:, None], shapely.points(standing @ plan.T)[None])
        parts = np.concatenate([upright, loose])
        for row, column in np.argwhere(away <= RIM_SHARE * widths[rims, None]).tolist():
            is_loose = column >= len(upright)
            yield thing.scene, is_loose, int(parts[column]), int(rims[row])


def _rising(ends: FloatArray, ups: FloatArray, things: Sequence[Thing]) -> Bools:
    """Which loose edges of things, of all with `ends` (e, 2, 3), reach farther up than aside."""
    scene = np.zeros(len(ends), dtype=np.intp)
    for thing in things:
        scene[list(thing.edges)] = thing.scene
    up, span = ups[scene], ends[:, 1] - ends[:, 0]
    height = dots(span, up)
    aside = span - height[:, None] * up
    farther: Bools = np.abs(height) > np.sqrt(dots(aside, aside)) * np.tan(np.deg2rad(30.0))
    return farther
