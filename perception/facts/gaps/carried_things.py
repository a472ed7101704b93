"""Parts that end above the ground belong to the thing that carries them: the nearest one.

A chair's back ends above its seat, with a rounded edge between them that is no face; where views
show the ground beneath, it is of one thing with the seat. What is nearer to the ground stands on
something that was not found; and what another thing reaches beneath stands on that. What carries a
board's one side carries the other.
"""

from collections.abc import Iterator, Sequence

import numpy as np
import shapely

from facetlog.perception.attached_edges import MAX_GAP_SHARE, MIN_DEPTH_SHARE
from facetlog.perception.batch_linalg import dots
from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.polygons import find_intersection, make_polygon
from facetlog.perception.ragged import Indices
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.components import components
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.surfaces.floors import LEVEL_ENOUGH, measure_above_ground
from facetlog.perception.surfaces.things import Thing
from facetlog.perception.types import FloatArray

# Of a thin board pictures often show both sides and no rim between them, so that no edge says that
# they belong together. But two faces that lie back to back, with no room for anything between them,
# are the sides of one board.

# The two sides of a board look away from each other within this angle.
OPPOSITE = float(np.cos(np.deg2rad(10.0)))
# They cover each other by this share of the smaller one.
SHARED = 0.5


def find_board_sides(table: FaceTable, things: Sequence[Thing]) -> Iterator[tuple[int, int]]:
    """Yield pairs of things, by their numbers, that have the two sides of a board."""
    owners = np.full(len(table), -1, dtype=np.intp)
    for number, thing in enumerate(things):
        owners[list(thing.faces)] = number
    normals = table.planes.normals
    usable = np.flatnonzero((owners >= 0) & (table.areas > 0.0))
    for one in usable.tolist():
        apart = owners[usable] != owners[one]
        opposite = usable[(usable > one) & apart & (normals[usable] @ normals[one] < -OPPOSITE)]
        for other in opposite.tolist():
            if _are_back_to_back(
                _outline(table, one), _outline(table, other), normals[one], normals[other]
            ):
                yield int(owners[one]), int(owners[other])


def _outline(table: FaceTable, face: int) -> FloatArray:
    outline: FloatArray = table.points[table.outlines[face, table.there[face]]]
    return outline


def _are_back_to_back(
    one: FloatArray, other: FloatArray, normal: FloatArray, other_normal: FloatArray
) -> bool:
    """Return whether outlines (k, 3), (l, 3) cover each other, the second a board's thickness
    behind.
    """
    middle = one.mean(axis=0)
    axes = make_plane_axes(normal, one[1] - one[0])
    first, second = (make_polygon((ring - middle) @ axes.T) for ring in (one, other))
    least = min(first.area, second.area)
    shared = find_intersection(first, second)
    if shared.area < SHARED * least:
        return False
    place = middle + shapely.get_coordinates(shared.centroid)[0] @ axes
    depth = float((place - other.mean(axis=0)) @ other_normal) / float(normal @ other_normal)
    size = float(np.sqrt(least))
    return -MIN_DEPTH_SHARE * size < depth < MAX_GAP_SHARE * size


# What carries a thing reaches as low or lower, and is nearer to it than this share of its height
# above the ground.
NEARER = 0.25
# What ends less than so many standard deviations above the ground stands on it.
NOISE_SDS = 3.0
# What stands on a face takes this much of it at most, along it.
STANDS_WITHIN = 2.0 / 3.0


def join_carried_things(
    scene: Scene, table: FaceTable, edges: Indices, things: tuple[Thing, ...]
) -> tuple[Thing, ...]:
    """Return the things of a scene, of which those that end above the ground are one with their
    carriers, and those that have the two sides of a board one with each other.

    `edges` (e, 2) are vertices. Without a ground that views show
    the things are as they were, and where they were told apart as the scene was read (bodies).
    """
    above = measure_above_ground(scene, table.points)
    if above is None or scene.up is None or scene.bodies or len(things) < 2:
        return things
    from facetlog.perception.facts.gaps.thing_gaps import gaps  # scenes without a ground do without

    vertices = [_vertices(table, edges, thing) for thing in things]
    lowest = np.array([own[np.argmin(above[own])] for own in vertices])
    high = above[lowest]
    sds = np.sqrt(dots(scene.up @ table.covs[lowest], scene.up))
    high = np.where(high > NOISE_SDS * sds, high, 0.0)
    axes = make_plane_axes(scene.up, np.eye(3)[int(np.argmin(np.abs(scene.up)))])
    heights, flat = table.points @ scene.up, table.points @ axes.T
    nearest: dict[int, tuple[float, int]] = {}
    for gap in gaps(table, edges, things):
        for one, other in ((gap.first, gap.second), (gap.second, gap.first)):
            near = gap.distance.value <= NEARER * high[one] and high[other] <= high[one] > 0.0
            if near and not any(
                _is_standing_on(table, heights, flat, vertices[one], face)
                for face in things[other].faces
                if float(table.planes.normals[face] @ scene.up) > LEVEL_ENOUGH
            ):
                found = (gap.distance.value, other)
                nearest[one] = min(found, nearest.get(one, found))
    carried = ((one, other) for one, (_, other) in nearest.items())
    groups = components(len(things), (*carried, *find_board_sides(table, things)))
    together: dict[int, list[Thing]] = {}
    for group, thing in zip(groups, things, strict=True):
        together.setdefault(group, []).append(thing)
    return tuple(_join_things(some) for some in together.values())


def _vertices(table: FaceTable, edges: Indices, thing: Thing) -> Indices:
    of_faces = table.find_member_rows(np.array(thing.faces, dtype=np.intp))[1]
    of_edges = edges[np.array(thing.edges, dtype=np.intp)].ravel()
    return np.unique(np.concatenate([of_faces, of_edges]))


def _is_standing_on(
    table: FaceTable, heights: FloatArray, flat: FloatArray, own: Indices, face: int
) -> bool:
    """Return whether a thing of these vertices lies over a level face, and takes only some
    of it.
    """
    corners = table.outlines[face, table.there[face]]
    if heights[own].mean() < heights[corners].mean():
        return False
    plan = shapely.convex_hull(shapely.MultiPoint(flat[own]))
    top = shapely.convex_hull(shapely.MultiPoint(flat[corners]))
    middle = shapely.centroid(plan)
    if not shapely.contains(top, middle):
        return False
    spans = flat[own][:, None] - flat[own][None]
    lengths = np.sqrt((spans**2).sum(axis=-1))
    longest = spans[np.unravel_index(int(np.argmax(lengths)), lengths.shape)]
    extent = float(np.ptp(flat[corners] @ longest))
    return float(longest @ longest) <= STANDS_WITHIN * extent


def _join_things(things: Sequence[Thing]) -> Thing:
    first = things[0]
    if len(things) == 1:
        return first
    faces = tuple(sorted(i for thing in things for i in thing.faces))
    edges = tuple(sorted(i for thing in things for i in thing.edges))
    patches = tuple(sorted(i for thing in things for i in thing.patches))
    return Thing(faces, edges, patches, whole=False)
