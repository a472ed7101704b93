"""The ground beneath each thing, where views show it or a floor was measured.

What ends above the ground stands on something that was not found, or on another thing: heights
count from the ground where no other thing reaches beneath it.
"""

from collections.abc import Sequence

import numpy as np
import shapely

from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.ragged import Indices
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.types import FloatArray

LEVEL_ENOUGH = 0.866
"""Normals within 30° of the vertical point this much up or down: cos 30°."""


def measure_above_ground(scene: Scene, points: FloatArray) -> FloatArray | None:
    """Return how high points (n, 3) are above the ground, along the scene's up; None where it is
    not known, or the views show no ground that is about level.
    """
    if scene.up is None or not scene.seen_ground:
        return None
    lattice = scene.seen_ground[0]
    normal = np.cross(*lattice.steps)
    normal /= np.linalg.norm(normal)
    rise = float(normal @ scene.up)
    if abs(rise) < LEVEL_ENOUGH:
        return None
    heights: FloatArray = (points - lattice.corner) @ normal / rise
    return heights


def find_floor_heights(
    scene: Scene, table: FaceTable, owners: Indices, members: Sequence[Indices]
) -> FloatArray:
    """Return the height (t,) of the ground under the lowest of each thing's vertices `members`,
    along up.

    Infinite where the ground is not known or another thing reaches beneath. `owners` (f,) are the
    things of all faces, -1 for none.
    """
    floors = np.full(len(members), np.inf)
    if scene.up is None:
        return floors
    above = measure_above_ground(scene, table.points)
    axes = make_plane_axes(scene.up, np.eye(3)[int(np.argmin(np.abs(scene.up)))])
    heights, flat = table.points @ scene.up, table.points @ axes.T
    level = np.flatnonzero(table.planes.normals @ scene.up > LEVEL_ENOUGH)
    outlines = [table.outlines[i, table.there[i]] for i in level.tolist()]
    plans = [shapely.convex_hull(shapely.MultiPoint(flat[outline])) for outline in outlines]
    middles = table.middles[level] @ scene.up
    # faces of no thing are the floor that they stand on
    floor = owners[level] < 0
    for thing, own in enumerate(members):
        if not len(own):
            continue
        lowest = own[int(np.argmin(heights[own]))]
        others = (owners[level] != thing) & ~floor & (middles < heights[lowest])
        plan = shapely.convex_hull(shapely.MultiPoint(flat[own]))
        if any(plan.intersects(plans[i]) for i in np.flatnonzero(others)):
            continue
        if above is not None:
            floors[thing] = heights[lowest] - above[lowest]
            continue
        beneath = [level[i] for i in np.flatnonzero(floor) if plan.intersects(plans[i])]
        rises = [_measure_vertex_rise(table, face, lowest, scene.up) for face in beneath]
        floors[thing] = heights[lowest] - min((r for r in rises if r > 0.0), default=-np.inf)
    return floors


def _measure_vertex_rise(table: FaceTable, face: int, vertex: int, up: FloatArray) -> float:
    """Return how far a vertex is above a face's plane, along up."""
    normal = table.planes.normals[face]
    above = float(normal @ table.points[vertex] + table.planes.offsets[face])
    return above / float(normal @ up)
