"""A mesh as a scene: clean → objects → flat regions → sides → polygons → what is bare → scene.

Which side of a piece of surface is outside is found by visibility: the share of free directions. A
closed sheet's normals point out already. For others the winding does not decide: both sides are
tested. Each object gets a grid of cubes; for every cube, in 26 directions, it is known whether the
ray out is free. A side sees the share of the directions in front of it that are free.

- The side that sees more is outside.
- Where the other sees at least a quarter as much, the piece is a sheet with two sides: a table top
  of a single layer has an upper and a lower face, the walls of a tray an inner and an outer one. A
  deep box without a bottom is open below, but its walls see little from inside, and have one side.
- A piece that sees nothing on either side is inside the object, and is no surface of it. Nor are
  the walls of gaps narrower than some 2 % of the object, which the grid does not resolve.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from facetlog.errors import InputError
from facetlog.perception.batch_linalg import dots
from facetlog.perception.pieces.body_solids import add_solids
from facetlog.perception.pieces.exact.find_pieces import find_solid_pieces
from facetlog.perception.ragged import Indices, iter_groups, sum_by_group
from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.meshes.clean_mesh import (
    MEND,
    MOST_LOST,
    Surface,
    clean_mesh,
    find_boxes_round,
    measure_part_sizes,
)
from facetlog.perception.shapes.meshes.flat_pieces import Piece, find_flat_pieces
from facetlog.perception.shapes.meshes.mesh_bodies import Solids, find_bodies
from facetlog.perception.shapes.meshes.mesh_floor import find_surroundings
from facetlog.perception.shapes.meshes.mesh_regions import cut_off, find_regions
from facetlog.perception.shapes.regions.flat_region import FlatRegion, Rest
from facetlog.perception.shapes.regions.scene_from_regions import assemble_scene, make_unit_vector
from facetlog.perception.shapes.regions.surface_samples import (
    Samples,
    sample_count,
    sample_triangles,
    thinned,
)
from facetlog.perception.shapes.regions.visibility_grid import CUBES, FreeWays
from facetlog.perception.types import FloatArray

# Repair tools and scanners leave slivers behind, by the hundred thousand. Each would be an object
# with two faces of its own, compared with every other one; of so many no facts are made.
MANY_PARTS = 1_000
"""Parts that share no corner with others. With two faces each more have too many for facts
(most_faces.py)."""
# Samples are half a cube apart, so that no cube that the surface crosses is missed.
SAMPLES_PER_CUBE = 2.0
SPACING_SHARE = 1.0 / (CUBES * SAMPLES_PER_CUBE)
"""How far apart samples lie, as a share of the object's diagonal."""
# Visibility is tested this far in front of the surface, in cubes: beyond the surface's own.
STAND_OFF = 1.5
# Both sides are outside where the lesser sees at least this share of what the greater sees. Within
# a tray a wall sees 30 %: of nine directions the three that go up over the far wall.
SHEET_SHARE = 0.25
# A side that sees less than this share of the directions is not seen; one of 13 is 8 %.
LEAST_SIGHT = 0.01
# Surfaces nearer than the stand-off, seen along the normal, that face along it by this cosine.
FACING = 0.7
# So many samples of a piece are enough to vote.
VOTES = 40
# Of nearest samples so many are looked at: its own piece's come first at the rim.
NEIGHBOURS = 8
# Samples of a surface are this near to any place of it, in their spacings: √2 and a bit.
REACH = 1.5


@dataclass(frozen=True, eq=False, slots=True)
class Sides:
    """For each piece (p,): whether to turn normals, whether both sides are faces, whether
    hidden.
    """

    turned: NDArray[np.bool_]
    sheets: NDArray[np.bool_]
    hidden: NDArray[np.bool_]


def find_sides(
    surface: Surface, samples: Samples, bodies: Indices, pieces: Indices, count: int
) -> Sides:
    """Return the outer sides of each of `count` pieces; `bodies`, `pieces` (m,) number each
    triangle.

    `samples` of the whole surface lie at most SPACING_SHARE of its size apart.
    """
    front, back = np.ones(count), np.zeros(count)
    trusted = np.ones(count, dtype=bool)
    np.logical_and.at(trusted, pieces, surface.closed)
    for own in iter_groups(bodies):
        if len(own) == 1:  # nothing stands before or behind a triangle by itself
            back[pieces[own]] = 1.0
            continue
        names, local = np.unique(pieces[own], return_inverse=True)
        one_closed = trusted[names].all() and len(np.unique(surface.sheets[own])) == 1
        if not one_closed:  # a single closed sheet hides nothing of itself
            if len(own) < len(bodies):
                corners = surface.points[surface.triangles[own]]
                low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
                extent = float(np.linalg.norm(high - low))
                near = sample_triangles(corners, SPACING_SHARE * extent)
            else:
                near, extent = samples, surface.size
            front[names], back[names] = _sights(
                near, surface.normals[own], local, trusted[names], extent
            )
    unseen = (front < LEAST_SIGHT) & (trusted | (back < LEAST_SIGHT))
    turned = ~trusted & (back > front)
    sheets = ~trusted & ~unseen & (np.minimum(front, back) >= SHEET_SHARE * np.maximum(front, back))
    return Sides(turned, sheets, unseen)


def _sights(
    samples: Samples,
    normals: FloatArray,
    pieces: Indices,
    trusted: NDArray[np.bool_],
    extent: float,
) -> tuple[FloatArray, FloatArray]:
    """Return share of free directions (p,) in front of and behind each piece, 0 behind those that
    are `trusted` (p,); `extent` is the diagonal.

    Of the triangles that the samples lie on, `normals` (m, 3) and `pieces` (m,).
    """
    count = len(trusted)
    cube = extent / CUBES
    free = FreeWays.of(samples.points, cube, margin=STAND_OFF)
    owner = pieces[samples.triangles]
    kept, _, areas = thinned(samples.points, samples.areas, owner, cube / SAMPLES_PER_CUBE)
    points, owner = samples.points[kept], owner[kept]
    normals = normals[samples.triangles[kept]]
    tree = cKDTree(points, balanced_tree=False, compact_nodes=False)
    votes = _choose_some_of_each(owner, count)
    sights = []
    for sign in (1.0, -1.0):
        if sign < 0.0:
            votes = votes[~trusted[owner[votes]]]
        ahead = sign * normals[votes]
        seen = free.share(points[votes] + STAND_OFF * cube * ahead, ahead)
        open_ = np.flatnonzero(seen)
        blocked = _find_faced(tree, points, normals, owner, votes[open_], ahead[open_], cube)
        seen[open_[blocked]] = 0.0
        weight = sum_by_group(owner[votes], areas[votes], count)
        total = sum_by_group(owner[votes], areas[votes] * seen, count)
        sights.append(total / np.maximum(weight, 1e-300))
    return sights[0], sights[1]


def _choose_some_of_each(owner: Indices, count: int) -> Indices:
    """Return indices of at most VOTES samples of each piece, spread evenly over them."""
    order = np.argsort(owner, kind="stable")
    members = np.bincount(owner, minlength=count)
    starts = np.cumsum(members) - members
    nth = np.arange(len(owner)) - starts[owner[order]]
    step = np.maximum(members // VOTES, 1)[owner[order]]
    some: Indices = order[nth % step == 0]
    return some


def _find_faced(
    tree: cKDTree,
    points: FloatArray,
    normals: FloatArray,
    owner: Indices,
    votes: Indices,
    ahead: FloatArray,
    cube: float,
) -> NDArray[np.bool_]:
    """Return whether another piece faces this one, nearer than the point where visibility is
    tested.

    That is the underside of a thin board, which the cubes cannot distinguish from the upper side.
    """
    blocked = np.zeros(len(votes), dtype=bool)
    step = cube / SAMPLES_PER_CUBE
    reach = REACH * step
    for nth in range(1, int(np.ceil(STAND_OFF * SAMPLES_PER_CUBE)) + 1):
        left = np.flatnonzero(~blocked)
        own, way = points[votes[left]], ahead[left]
        places = own + nth * step * way
        gaps, near = tree.query(places, k=NEIGHBOURS, distance_upper_bound=reach)
        row, column = np.nonzero(np.isfinite(gaps))
        found = np.asarray(near)[row, column]
        other = owner[found] != owner[votes[left[row]]]
        row, found = row[other], found[other]
        before = dots(points[found] - own[row], way[row])
        facing = np.abs(dots(normals[found], way[row])) > FACING
        blocked[left[row[facing & (before > 0.0)]]] = True
    return blocked


def drop_loose_strips(surface: Surface) -> Surface:
    """Return the surface, of which narrow loose parts are left out if there are many parts.

    They are open, and narrower than its samples lie apart. Where they are most of it, they stay.
    """
    count = int(surface.bodies.max()) + 1
    if count <= MANY_PARTS:
        return surface
    low, high = find_boxes_round(surface.corners, surface.bodies, count)
    areas = sum_by_group(surface.bodies, surface.areas, count)
    # Of a triangle that is the height on its longest side; of a box much more than any width.
    widths = 2.0 * areas / np.sqrt(((high - low) ** 2).sum(axis=1))
    is_open = np.bincount(surface.bodies, ~surface.closed, minlength=count) > 0
    strips = is_open & (widths < SPACING_SHARE * surface.size)
    if not strips.any():
        return surface
    left = strips[surface.bodies]
    share = float(surface.areas[left].sum() / surface.areas.sum())
    if share > MOST_LOST:
        return surface
    line = (
        f"{int(strips.sum()):,} loose parts narrower than {SPACING_SHARE:.1%} of the mesh were "
        f"left out, {100.0 * share:.2g}% of its surface"
    )
    mesh = Mesh(
        surface.points + surface.centre,
        surface.triangles[~left],
        name=surface.name,
        step=surface.step,
    )
    rest = clean_mesh(mesh)
    return replace(rest, warnings=(*surface.warnings, *rest.warnings, line))


# What is not flat is sampled at this share of its object's diagonal, and thinned to cells of it,
# so that a grid of 1/64 of the diagonal has no hole where there is surface.
REST_SPACING_SHARE = 1 / 128
# Each takes 80 bytes while it is made: 3 GB. Files hold half as many triangles at most.
MOST_SAMPLES = 40_000_000
# Facts are made of this many faces at most (facts/most_faces.py), and an object has one or more.
MOST_OBJECTS = 2_000
# A solid's triangles share corners. Where more than this share of a surface shares none, it is no
# surface of solids, and what lies behind it is not known to be inside.
MOST_LONE = 0.5
# Sheets of a single layer have no outer side; pieces of one plane are oriented to the side of this
# direction, which is not near any axis of a model.
REFERENCE = np.array([0.5377, 0.6172, 0.5743])


def make_mesh_scene(
    mesh: Mesh, *, up: ArrayLike | None = None, metric: bool = False, solid_parts: bool = True
) -> Scene:
    """Return the scene of a mesh, in the mesh's own frame and unit; `metric` says that it is the
    metre.

    `up` is taken from the mesh where it is not given; where it is known, the floor that things
    stand on, and in metres the room round them, are of no object. Without `solid_parts` these
    are not looked for. Raise InputError for a mesh without area, and for one in too many pieces.
    """
    surface = drop_loose_strips(clean_mesh(mesh))
    samples = _samples(surface)
    upwards = mesh.up if up is None else up
    around = None
    if upwards is not None:
        around = find_surroundings(surface, samples, make_unit_vector(upwards), metric=metric)
    taken = None
    if around is not None:
        surface, taken = cut_off(surface, around.triangles, around.planes)
        samples = _samples(surface)
    bodies = _number_by_area(surface, find_bodies(surface, taken), taken)
    labels = find_regions(surface, bodies, rough=around is not None and around.is_rough)
    _check_objects(surface, bodies[labels >= 0])
    connected, said = _connected(surface, bodies)
    count = int(labels.max()) + 1
    # the sides of triangles in no region are determined by their sheets
    pieces = np.where(labels >= 0, labels, count + surface.sheets)
    sides = find_sides(surface, samples, bodies, pieces, int(pieces.max()) + 1)
    surface = _turned(surface, labels, pieces, sides)
    seen = np.where(sides.hidden[pieces], -1, labels)
    sizes = measure_part_sizes(surface.corners, bodies)
    found = find_flat_pieces(surface, seen, 2 * bodies + sides.sheets[pieces], sizes)
    flat = np.zeros(len(sides.hidden), dtype=bool)
    flat[[piece for f in found for piece in f.pieces]] = True
    rest = _rest(surface, bodies, ~flat[pieces] & ~sides.hidden[pieces], sides.sheets[pieces])
    body_of = np.zeros(len(sides.hidden), dtype=np.int64)
    body_of[pieces] = bodies
    solids = Solids.of(surface, bodies)
    # the surroundings, the last object, are none
    none = -1 if taken is None else int(bodies.max())
    regions = [
        _moved(replace(left, body=-1) if left.body == none else left, surface.centre)
        for f in found
        for region in _faces_of(f, body_of, sides)
        for left in solids.iter_uncovered(region, surface.sheets[np.isin(pieces, f.pieces)])
    ]
    scene = assemble_scene(
        mesh.name,
        regions,
        replace(
            rest,
            points=rest.points + surface.centre,
            bodies=np.where(rest.bodies == none, -1.0, rest.bodies),
        ),
        up=upwards,
        metric=metric,
        whole=connected,
        warnings=(*mesh.warnings, *surface.warnings, *said),
    )
    if not connected or not solid_parts:
        return scene
    cut = find_solid_pieces(mesh.vertices, mesh.triangles, step=mesh.step, up=scene.up)
    return add_solids(scene, cut)


def _samples(surface: Surface) -> Samples:
    """Sample the whole surface; raise InputError if long thin triangles have too many samples."""
    spacing = SPACING_SHARE * surface.size
    if sample_count(surface.corners, spacing) > MOST_SAMPLES:
        raise InputError(
            f"{surface.name}: its {len(surface.triangles):,} triangles are too long and thin to be "
            f"looked at each: {MEND}"
        )
    return sample_triangles(surface.corners, spacing)


def _check_objects(surface: Surface, bodies: Indices) -> None:
    """Raise InputError if the triangles in faces are of too many objects."""
    count = len(np.unique(bodies))
    if count > MOST_OBJECTS:
        raise InputError(
            f"{surface.name}: falls into {count:,} objects, at most {MOST_OBJECTS:,} are judged: "
            f"{MEND}, or leave out those that do not matter"
        )


def _connected(surface: Surface, bodies: Indices) -> tuple[bool, tuple[str, ...]]:
    """Return whether triangles make a surface together, with a warning if not; those that are an
    object by themselves are of no other.
    """
    lone, areas = surface.lone, surface.areas
    share = float(areas[lone].sum() / areas.sum())
    several = (np.bincount(bodies) > 1)[bodies]
    of_others = float(areas[lone & several].sum()), float(areas[several].sum())
    if len(lone) == 1 or share <= MOST_LONE or of_others[0] < MOST_LONE * of_others[1]:
        return True, ()
    return False, (
        f"{int(lone.sum()):,} of {len(lone):,} triangles, {share:.1%} of the surface, share no "
        f"corner with another, and enclose nothing: {MEND}",
    )


def _number_by_area(surface: Surface, bodies: Indices, taken: NDArray[np.bool_] | None) -> Indices:
    """Return the objects numbered by their surface, the largest first, but what is `taken` (m,)
    last.
    """
    areas = np.bincount(bodies, surface.areas)
    if taken is not None:
        areas[bodies[taken]] = 0.0
    order = np.argsort(-areas, kind="stable")
    number = np.empty(len(order), dtype=np.int64)
    number[order] = np.arange(len(order))
    return number[bodies]


def _turned(surface: Surface, labels: Indices, pieces: Indices, sides: Sides) -> Surface:
    """Return the surface with normals outwards."""
    turn = sides.turned[pieces]
    normals = np.where(turn[:, None], -surface.normals, surface.normals)
    # of a sheet with two sides one is taken, the same for all pieces of a plane
    means = sum_by_group(pieces, surface.areas[:, None] * normals, len(sides.sheets))
    wrong = (sides.sheets & (means @ REFERENCE < 0.0))[pieces] & (labels >= 0)
    normals = np.where(wrong[:, None], -normals, normals)
    turn ^= wrong
    triangles = np.where(turn[:, None], surface.triangles[:, ::-1], surface.triangles)
    return replace(surface, normals=normals, triangles=triangles)


def _faces_of(piece: Piece, body_of: Indices, sides: Sides) -> list[FlatRegion]:
    """Return the region with the object that it is of, and of a sheet its back as well."""
    front = replace(piece.region, body=int(body_of[piece.pieces[0]]))
    if not sides.sheets[piece.pieces[0]]:
        return [front]
    return [front, front.flipped()]


def _moved(region: FlatRegion, centre: FloatArray) -> FlatRegion:
    """Return the region in the mesh's frame."""
    plane = region.plane
    # n · (x - c) + d = 0: with the offset d - n · c; its covariance by that lever
    lever = np.eye(4)
    lever[3, :3] = -centre
    return replace(
        region,
        plane=replace(
            plane,
            offset=plane.offset - float(plane.normal @ centre),
            cov=lever @ plane.cov @ lever.T,
        ),
        outline=region.outline + centre,
        holes=tuple(hole + centre for hole in region.holes),
    )


def _rest(
    surface: Surface, bodies: Indices, left: NDArray[np.bool_], sheets: NDArray[np.bool_]
) -> Rest:
    """Return points on the triangles that are left, with a density by each object's size.

    Of `sheets`, which show both their sides, neither is the outer one: no normal is known.
    """
    parts: list[tuple[FloatArray, FloatArray, FloatArray, FloatArray]] = []
    rows = np.flatnonzero(left)
    for own in (rows[some] for some in iter_groups(bodies[rows])):
        body = int(bodies[own[0]])
        whole = surface.points[surface.triangles[bodies == body].ravel()]
        spacing = REST_SPACING_SHARE * float(np.linalg.norm(np.ptp(whole, axis=0)))
        samples = sample_triangles(surface.points[surface.triangles[own]], spacing)
        triangle = own[samples.triangles]
        group = np.zeros(len(triangle), dtype=np.int64)
        kept, place, areas = thinned(samples.points, samples.areas, group, spacing)
        outwards = np.where(sheets[triangle], 0.0, samples.areas)
        weighted = outwards[:, None] * surface.normals[triangle]
        normals = sum_by_group(place, weighted, len(kept))
        # the middle of a cell's samples does not depend on their order
        middles = sum_by_group(place, samples.areas[:, None] * samples.points, len(kept))
        lengths = np.sqrt((normals**2).sum(axis=1))
        normals = normals / np.where(lengths > 0.0, lengths, 1.0)[:, None]
        parts.append((middles / areas[:, None], normals, areas, np.full(len(kept), float(body))))
    if not parts:
        return Rest(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0))
    points, normals, areas, owners = (np.concatenate(p) for p in zip(*parts, strict=True))
    return Rest(points, normals, areas, owners)
