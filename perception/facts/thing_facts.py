"""Facts about things: what belongs to them, how large they are, where their parts are in them."""

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.batch_linalg import dots
from facetlog.perception.facts import heights, measures, plan_view
from facetlog.perception.facts.levels.filled_space import curved_share
from facetlog.perception.facts.levels.levels import Bounded, shelves_below
from facetlog.perception.facts.named_rows import CollectedFacts
from facetlog.perception.facts.scene_memo import SceneMemo
from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.ragged import Bools, Indices, find_entries_of_rows
from facetlog.perception.space.space import LEAST_UNKNOWN, State
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.surfaces.floors import LEVEL_ENOUGH
from facetlog.perception.surfaces.things import Thing
from facetlog.perception.surfaces.tolerance import SDS
from facetlog.perception.types import FloatArray

# A part whose middle is this near to the outline, as a share of the face's width, is at the rim:
# legs are inset by 5 to 12 % of a table's width.
RIM_SHARE = 0.15
# Parts that lean less than this from upright stand: sin 30°.
LEANS_LITTLE = 0.5


def at_rim(
    up: FloatArray,
    table: FaceTable,
    widths: FloatArray,
    edges: Indices,
    things: Sequence[Thing],
) -> Iterator[tuple[bool, int, int]]:
    """Yield (loose, part, face) where a part of a thing stands at a level face's rim.

    Parts are upright faces and, where that is so, `loose` edges (e, 2) of vertices. `widths` (f,)
    are the faces'.
    """
    axes = make_plane_axes(up, np.eye(3)[np.abs(up).argmin()])
    rise = np.abs(dots(table.planes.normals, up))
    level: Bools = (rise > LEVEL_ENOUGH) & (table.areas > 0.0)
    stands: Bools = rise < LEANS_LITTLE
    corners = np.where(table.there[..., None], table.points[table.outlines], 0.0)
    middles = corners.sum(axis=1) / np.maximum(table.sizes, 1)[:, None]
    rises = _find_rising_edges(table.points[edges], up)
    for thing in things:
        faces = np.array(thing.faces, dtype=np.intp)
        rims, upright = faces[level[faces]], faces[stands[faces]]
        loose = np.array([i for i in thing.edges if rises[i]], dtype=np.intp)
        if not len(rims) or not len(upright) + len(loose):
            continue
        rings = [shapely.linearrings(corners[f, table.there[f]] @ axes.T) for f in rims.tolist()]
        standing = np.concatenate([middles[upright], table.points[edges[loose]].mean(axis=1)])
        away = shapely.distance(np.array(rings)[:, None], shapely.points(standing @ axes.T)[None])
        parts = np.concatenate([upright, loose])
        for row, column in np.argwhere(away <= RIM_SHARE * widths[rims, None]).tolist():
            is_loose = column >= len(upright)
            yield is_loose, int(parts[column]), int(rims[row])


def _find_rising_edges(ends: FloatArray, up: FloatArray) -> Bools:
    """Return which edges with `ends` (e, 2, 3) reach farther up than aside."""
    span = ends[:, 1] - ends[:, 0]
    height = dots(span, up)
    aside = span - height[:, None] * up
    farther: Bools = np.abs(height) > np.sqrt(dots(aside, aside)) * np.tan(np.deg2rad(30.0))
    return farther


# On the ground is what ends within this share of its thing's height from the lowest point.
GROUND = 0.03
# A face lies along the front of its level where its nearer side is turned from that by less than
# half of what would make the other side the nearer one: cos 22.5°.
ALONG = float(np.cos(np.pi / 8.0))


def thing_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add things and their parts."""
    rows.add("thing", s.thing_names)
    thing, part = _parts(s)
    rows.add("part_of", part, s.thing_names[thing])


def _parts(s: SceneMemo) -> tuple[Indices, NDArray[np.object_]]:
    """Return (thing, name) (p,) of the things' faces and edges, thing by thing, faces first."""
    (of_faces, face), (of_edges, edge) = s.thing_faces, s.thing_edges
    thing = np.concatenate((of_faces, of_edges))
    part = np.concatenate((s.face_names[face], s.edge_names[edge]))
    order = np.argsort(thing, kind="stable")
    return thing[order], part[order]


def box_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add the least boxes round things, those with faces first."""
    flat = np.array([bool(thing.faces) for thing in s.things], dtype=np.bool_)
    if s.groups:
        boxes = np.array(list(measures.find_thing_boxes(s.table, s.groups)))
        rows.add("thing_size", s.thing_names[flat], *boxes.T)
    for i in np.flatnonzero(~flat).tolist():
        if len(s.members[i]) > 1:
            box = measures.find_box_of_points(s.table.points[s.members[i]])
            rows.add_rows("thing_size", [(s.thing_names[i], *box)])


def _add_group_facts(
    functor: str, found: measures.Estimates, s: SceneMemo, rows: CollectedFacts
) -> None:
    _, face = s.thing_faces
    rows.add(functor, s.face_names[face], found.values, found.sds)


def share_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add the share of its thing's silhouette that each face is."""
    if s.groups:
        _add_group_facts("share", measures.shares(s.table, s.groups), s, rows)


def protrusion_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add how far things reach in front of their faces."""
    if s.groups:
        _add_group_facts("protrusion", measures.protrusions(s.table, s.groups), s, rows)


def reach_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add how far things reach behind their faces."""
    if s.groups:
        found = measures.measure_reaches_behind(s.table, s.groups, s.pairs)
        _add_group_facts("reach_behind", found, s, rows)


def gap_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add the least distances between things."""
    from facetlog.perception.facts.gaps.thing_gaps import gaps  # no model asks for them so far

    flat = [i for i, thing in enumerate(s.things) if thing.faces or thing.edges]
    found = []
    for i, j, distance in gaps(s.table, s.edges, tuple(s.things[i] for i in flat)):
        one, two = f"t{flat[i] + 1}", f"t{flat[j] + 1}"
        found += [(one, two, *distance), (two, one, *distance)]
    rows.add_rows("gap", found)


def tilt_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add the tilt of faces, and which face up or down."""
    if s.scene.up is None:
        return
    rows.add("tilt", s.face_names, np.rad2deg(s.leaning.values), np.rad2deg(s.leaning.sds))
    for functor, sense in (("upward", 1), ("downward", -1)):
        rows.add(functor, s.face_names[s.senses == sense])


def body_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add heights of things and their parts, and which of them are on the ground."""
    table, grounds = s.table, s.grounds
    if grounds is None:
        return
    (of_things, vertex), (of_faces, face), (of_edges, edge) = (
        s.thing_vertices,
        s.thing_faces,
        s.thing_edges,
    )
    every = np.arange(len(s.things))
    owners = np.concatenate((every, of_faces, of_edges))
    found = np.concatenate((s.thing_names, s.face_names[face], s.edge_names[edge]))
    own = np.concatenate(
        (
            np.bincount(of_things, minlength=len(every)),
            table.members.counts[face],
            np.full(len(edge), 2),
        )
    )
    vertices = np.concatenate((vertex, table.find_member_rows(face)[1], s.edges[edge].ravel()))
    # Thing by thing, of each itself, its faces and its edges.
    order = np.argsort(owners, kind="stable")
    vertices = vertices[find_entries_of_rows(own, order)]
    whole = order < len(every)
    owners, found = owners[order], found[order]
    tops, bottoms = heights.compute_extreme_heights(vertices, own[order], owners, grounds, table)
    for functor, each in (("top_of", tops), ("bottom_of", bottoms)):
        rows.add(functor, found, each.values, each.sds)
    reach = np.zeros(len(every))
    reach[owners[whole]] = tops.values[whole]
    least = np.maximum(GROUND * reach[owners], table.tolerance.finest)
    low = bottoms.values <= np.maximum(least, SDS * bottoms.sds)
    rows.add("on_ground", found[low])


def elevation_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add the heights of the middles of faces in their things."""
    thing, face = s.thing_faces
    if s.grounds is None or not len(face):
        return
    found = heights.compute_elevations(s.table, face, thing, s.grounds)
    rows.add("elevation", s.face_names[face], found.values, found.sds)


def overlap_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add pairs of faces that lie over each other, seen from above."""
    if s.plans is None:
        return
    one, two, share = plan_view.overlaps(s.plans)
    names = s.face_names
    rows.add_both_ways("overlap", names[one], names[two], share)


def clear_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add the free height under most of each face."""
    if s.plans is None or not len(s.plans.index):
        return
    lowest = np.full(len(s.things), np.inf)
    if s.grounds is not None:
        thing, vertex = s.thing_vertices
        np.minimum.at(lowest, thing, s.grounds.heights[vertex])
        lowest = np.minimum(lowest, s.floors)
    ground = np.full(len(s.table), np.inf)
    thing, face = s.thing_faces
    ground[face] = lowest[thing]
    found, free = plan_view.clear_below(s.plans, ground, s.contacts, s.senses)
    rows.add("clear_below", s.face_names[found], free)


def rim_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add parts that stand at the rim of a face about level."""
    if s.scene.up is None or not s.things or not len(s.table):
        return
    for loose, part, face in at_rim(
        s.scene.up, s.table, s.face_sizes.widths.values, s.edges, s.things
    ):
        name = (s.edge_names if loose else s.face_names)[part]
        rows.add_rows("at_rim", [(name, s.face_names[face])])


def surface_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add whether a thing's surface is known from all sides, and its curved share."""
    areas = s.table.areas
    curved = [curved_share(s.scene, areas, thing) for thing in s.things]
    rows.add("curved", s.thing_names, np.array(curved, dtype=np.float64))
    if not (rows.wants("whole") or rows.wants("scanned")):
        return
    if not s.scene.bodies:  # found in pictures, and not read from surface
        return
    for index, name in enumerate(s.thing_names.tolist()):
        filled = s.filled.get(index)
        known = filled is not None and filled.known
        rows.add_rows("whole" if known else "scanned", [(name,)])


def space_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add the measures of the space that things fill, and of their level faces."""
    for index, filled in s.filled.items():
        thing = s.thing_names[index]
        measures = [
            ("solidity", thing, filled.solidity),
            ("hollow_side", thing, filled.hollow),
        ]
        if filled.footprint is not None:
            measures.append(("footprint", thing, filled.footprint))
        for face, level in filled.levels.items():
            measures += [(name, s.face_names[face], each) for name, each in level.measures.items()]
        for functor, of, each in measures:
            _add_bounded(rows, functor, of, each)


def front_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add widths and depths of faces on whose levels the front is known."""
    if not len(s.table):
        return
    sizes = s.face_sizes
    for filled in s.filled.values():
        for face, level in filled.levels.items():
            if level.along_front is None:
                continue
            near = np.abs(sizes.ways[face] @ filled.space.axes[level.along_front])
            across = int(np.argmax(near))
            if near[across] < ALONG:
                continue
            both = (sizes.lengths, sizes.widths)
            for functor, of in (
                ("front_width", both[across]),
                ("front_depth", both[1 - across]),
            ):
                row = (s.face_names[face], float(of.values[face]), float(of.sds[face]))
                rows.add_rows(functor, [row])


def assumed_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add the share of the filled space that is only assumed to be full."""
    for index, filled in s.filled.items():
        cells = filled.space.cells
        assumed = int((cells == State.ASSUMED).sum())
        if assumed:
            row = (s.thing_names[index], assumed / int((cells >= State.ASSUMED).sum()))
            rows.add_rows("assumed_full", [row])


def unseen_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add the directions from which the unseen space round things would show."""
    for index, filled in s.filled.items():
        space = filled.space
        if space.closed or space.unseen <= LEAST_UNKNOWN:
            continue
        for axis, sense in product(range(3), (1, -1)):
            if s.scene.up is not None and (axis, sense) == (2, -1):
                continue  # nobody looks from below
            x, y, z = (sense * space.axes[axis]).tolist()
            row = (s.thing_names[index], x, y, z, space.measure_visible_unseen(axis, sense))
            rows.add_rows("unseen_towards", [row])


def shelf_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add the number of shelves beneath the level faces of things."""
    for filled in s.filled.values():
        known: dict[float, tuple[int, int] | None] = {}
        for face in filled.levels:
            height = float(s.table.faces[face].middle @ filled.space.axes[2])
            if height not in known:
                known[height] = shelves_below(filled.space, height)
            found = known[height]
            if found is not None:
                rows.add_rows("shelves_below", [(s.face_names[face], found[0])])
                if found[0] < found[1]:
                    rows.add_rows("shelves_unseen", [(s.face_names[face], *found)])


def _add_bounded(rows: CollectedFacts, functor: str, of: str, measure: Bounded) -> None:
    """Add a measure of space, and its bounds where these differ."""
    rows.add_rows(functor, [(of, measure.value, measure.sd)])
    if measure.open:
        rows.add_rows("unseen_bounds", [(functor, of, measure.if_free, measure.if_full)])
