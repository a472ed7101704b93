"""A mesh as a scene: clean → objects → flat regions → sides → polygons → what is bare → scene."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from facetlog.errors import InputError
from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.polygons import (
    find_difference,
    find_enclosed_area,
    find_union,
    make_valid,
)
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
from facetlog.perception.shapes.meshes.mesh_bodies import find_bodies
from facetlog.perception.shapes.meshes.mesh_floor import find_surroundings
from facetlog.perception.shapes.meshes.mesh_planes import cut_off
from facetlog.perception.shapes.meshes.mesh_regions import find_regions
from facetlog.perception.shapes.meshes.mesh_sides import SPACING_SHARE, Sides, find_sides
from facetlog.perception.shapes.meshes.region_polygons import Piece, find_flat_pieces
from facetlog.perception.shapes.regions.flat_region import FlatRegion, PlaneFrame, Rest
from facetlog.perception.shapes.regions.scene_from_regions import assemble_scene, make_unit_vector
from facetlog.perception.shapes.regions.surface_samples import (
    Samples,
    sample_count,
    sample_triangles,
    thinned,
)
from facetlog.perception.types import FloatArray

# Boards that are laid together are closed sheets that touch or reach into each other. Where one
# stands on another's face nobody sees that face, and the object has no surface there: a tread is
# as deep as what the step above leaves of it. So each region loses the sections that other closed
# sheets have just in front of its plane.

# Boards nearer than this share of the object's size touch; sections lie so far before a plane.
TOUCH_SHARE = 1e-4


@dataclass(frozen=True, eq=False, slots=True)
class Solids:
    """The closed sheets (s,) of a surface: number, object, box from `low` to `high` (s, 3), and
    which triangles are of each. `sizes` (b,) are those of all objects.
    """

    surface: Surface
    numbers: Indices
    bodies: Indices
    low: FloatArray
    high: FloatArray
    triangles: tuple[Indices, ...]
    sizes: FloatArray

    @classmethod
    def of(cls, surface: Surface, bodies: Indices) -> "Solids":
        """Find the closed sheets of a surface whose triangles (m,) are of these objects."""
        rows = np.flatnonzero(surface.closed)
        sizes = np.zeros(int(bodies.max()) + 1)
        sizes[bodies] = measure_part_sizes(surface.corners, bodies)
        groups = tuple(rows[own] for own in iter_groups(surface.sheets[rows]))
        corners = [surface.corners[own].reshape(-1, 3) for own in groups]
        first = np.array([own[0] for own in groups], dtype=np.intp)
        return cls(
            surface,
            surface.sheets[first],
            bodies[first],
            np.array([each.min(axis=0) for each in corners]).reshape(-1, 3),
            np.array([each.max(axis=0) for each in corners]).reshape(-1, 3),
            groups,
            sizes,
        )

    def iter_uncovered(self, region: FlatRegion, own: Indices) -> Iterator[FlatRegion]:
        """Yield the parts of a region that no solid of its object covers, but those of the sheets
        `own`.

        The region is in the surface's frame. It may fall apart, or vanish.
        """
        normal, touch = region.plane.normal, TOUCH_SHARE * float(self.sizes[region.body])
        before = region.outline + touch * normal
        near = (self.bodies == region.body) & ~np.isin(self.numbers, own)
        near &= (self.low < before.max(axis=0)).all(axis=1)
        near &= (self.high > before.min(axis=0)).all(axis=1)
        if not near.any():
            yield region
            return
        axes = make_plane_axes(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
        frame = PlaneFrame(np.zeros(3), axes)
        face = frame.polygon(region.outline, region.holes)
        distance = float(before[0] @ normal)
        sections = [
            self._section(nth, normal, distance, axes) for nth in np.flatnonzero(near).tolist()
        ]
        left = find_difference(face, find_union(sections))
        if left.area > face.area * (1.0 - TOUCH_SHARE):
            yield region
            return
        # neither slivers nor the gaps between boards that touch are anything by themselves
        left = left.buffer(-touch, join_style="mitre").buffer(touch, join_style="mitre")
        sd = float(np.hypot(region.corner_sd, touch))
        for part in shapely.get_parts(left):
            simple = part.simplify(touch)
            if isinstance(simple, shapely.Polygon) and simple.area > 0.0:
                rings = shapely.orient_polygons(simple)
                outline, holes = frame.lift_rings(rings, region.plane)
                yield replace(region, outline=outline, holes=holes, corner_sd=sd)

    def _section(
        self, nth: int, normal: FloatArray, distance: float, axes: FloatArray
    ) -> shapely.Geometry:
        """Return the section of a solid by the plane n · x = distance, in the plane's
        coordinates.
        """
        corners = self.surface.triangles[self.triangles[nth]]
        names, place = np.unique(corners, return_inverse=True)
        place = place.reshape(corners.shape)
        points = self.surface.points[names]
        heights = points @ normal - distance
        above = (heights > 0.0)[place]
        # two sides of each triangle that the plane passes through
        cut = above != np.roll(above, -1, axis=1)
        one, two = np.sort(np.stack([place[cut], np.roll(place, -1, axis=1)[cut]]), axis=0)
        # p + t (q - p), the same for both triangles at the side
        share = heights[one] / (heights[one] - heights[two])
        flat = (points[one] + share[:, None] * (points[two] - points[one])) @ axes.T
        area = find_enclosed_area(flat.reshape(-1, 2, 2))
        return shapely.Polygon() if area is None else make_valid(area)


# Repair tools and scanners leave slivers behind, by the hundred thousand. Each would be an object
# with two faces of its own, compared with every other one; of so many no facts are made.
MANY_PARTS = 1_000
"""Parts that share no corner with others. With two faces each more have too many for facts
(most_faces.py)."""


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


def make_mesh_scene(mesh: Mesh, *, up: ArrayLike | None = None, metric: bool = False) -> Scene:
    """Return the scene of a mesh, in the mesh's own frame and unit; `metric` says that it is the
    metre.

    `up` is taken from the mesh where it is not given; where it is known, the floor that things
    stand on, and in metres the room round them, are of no object. Raise InputError for a mesh
    without area, and for one in too many pieces.
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
    return assemble_scene(
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
