"""Measures of the space that things fill, and of the space that they leave."""

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from facetlog.perception.facts.levels.levels import Bounded, Level, hollow, level_at
from facetlog.perception.flat_faces import Estimate
from facetlog.perception.ragged import Indices
from facetlog.perception.scene import Scene
from facetlog.perception.space.grid import CELLS, HARDLY_LARGER, ROUNDING, Grid
from facetlog.perception.space.space import Space
from facetlog.perception.space.thing_space import ThingSurface, thing_space
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.surfaces.floors import LEVEL_ENOUGH
from facetlog.perception.surfaces.things import Thing
from facetlog.perception.types import FloatArray

# A direction this near one of a box's own is the same: cos 5°.
SAME_DIRECTION = 0.996
# Lines of sight from so many places make a cell free: a scanner measures where they end, a picture
# only agrees with others.
PLACES_OF_SCANS, PLACES_OF_PICTURES = 1, 2


@dataclass(frozen=True, eq=False, slots=True)
class FilledSpace:
    """A thing's `footprint` (area), `solidity` (its share of the least box round it, 0..1), how
    `hollow` the sides of that box are (0..1), and the levels of its faces that lie about level (by
    index of the face); whether it is `known` from all sides, and the volume of that `box`.

    The box is upright, or square to the largest face where that box is clearly smaller. Without a
    known up there are no levels and no footprint. `space` and `surface` are what all that was
    measured on; `tipped` is the space square to the largest face, where its box is the one.
    """

    space: Space
    surface: ThingSurface
    known: bool
    box: float
    footprint: Bounded | None
    solidity: Bounded
    hollow: Bounded
    levels: dict[int, Level]
    tipped: Space | None = None


def curved_share(scene: Scene, areas: FloatArray, thing: Thing) -> float:
    """Return how much of a thing's surface is not flat, 0..1; `areas` (f,) are those of all
    faces.
    """
    curved = float(sum(scene.patches[i].areas.sum() for i in thing.patches))
    if not curved > 0.0:
        return 0.0
    return curved / (curved + float(sum(areas[list(thing.faces)].tolist())))


def compute_filled_spaces(
    scene: Scene,
    table: FaceTable,
    edges: Indices,
    things: Sequence[Thing],
    members: Sequence[Indices],
    floors: FloatArray,
    kinds: Collection[str] | None = None,
) -> dict[int, FilledSpace]:
    """Return the filled space of each thing (by its index); `edges` (e, 2) are the scene's,
    `members` the vertices of each thing, and `floors` (t,) the heights of the ground beneath,
    infinite where it is not known. Levels have the measures of some `kinds`, or of all.
    """
    found: dict[int, FilledSpace] = {}
    for index, (thing, vertices) in enumerate(zip(things, members, strict=True)):
        if len(vertices) < 2:
            continue
        places = PLACES_OF_PICTURES if scene.views else PLACES_OF_SCANS
        outer = _extend_to_floor(table.points[vertices], scene.up, float(floors[index]))
        surface = _surface(scene, table, thing, table.points[edges[list(thing.edges)]], outer)
        measured = _Measured(scene, surface, places, kinds)
        filled = measured.lying() if scene.up is None else measured.standing(scene.up)
        if filled is not None:
            found[index] = filled
    return found


def _surface(
    scene: Scene, table: FaceTable, thing: Thing, lines: FloatArray, outer: FloatArray
) -> ThingSurface:
    own = tuple(table.faces[i] for i in thing.faces)
    none = np.zeros((0, 3))
    patches = [scene.patches[i] for i in thing.patches]
    return ThingSurface(
        own,
        outer,
        np.concatenate([none, *(patch.points for patch in patches)]),
        np.concatenate([none, *(patch.normals for patch in patches)]),
        lines,
        _compute_corner_sd(table, thing.faces),
        thing.whole,
    )


def _extend_to_floor(points: FloatArray, up: FloatArray | None, floor: float) -> FloatArray:
    """Return points (n, 3) of a thing, and one on the floor where that is lower by a cell of its
    space.
    """
    if up is None or not len(points):
        return points
    heights = points @ up
    lowest = int(np.argmin(heights))
    reach = 2.0 * float(np.linalg.norm(points - points.mean(axis=0), axis=1).max())
    if CELLS * (heights[lowest] - floor) <= reach:
        return points
    return np.concatenate([points, points[None, lowest] + (floor - heights[lowest]) * up])


def _compute_corner_sd(table: FaceTable, faces: Sequence[int]) -> float:
    """Return the median sd of the faces' corners, along an axis; 0 without faces."""
    if not faces:
        return 0.0
    corners = np.unique(table.find_member_rows(np.array(faces))[1])
    variances = np.trace(table.covs[corners], axis1=1, axis2=2) / 3.0
    return float(np.sqrt(np.median(variances)))


@dataclass(frozen=True, eq=False, slots=True)
class _Measured:
    """A thing's surface in its scene, measured in lattices along one direction or another."""

    scene: Scene
    surface: ThingSurface
    places: int
    kinds: Collection[str] | None

    def standing(self, up: FloatArray) -> FilledSpace | None:
        filled = self._filled(up, on_ground=True)
        if filled is None:
            return None
        space = filled.space
        filled = replace(
            filled,
            footprint=_both_ways(space, _footprint),
            levels=dict(self._levels(space, up)),
        )
        # A box that is tipped over fills the box round it no less.
        if float(np.abs(space.axes @ self._axis()).max()) < SAME_DIRECTION:
            tipped = self.lying()
            if tipped is not None and HARDLY_LARGER * tipped.box < filled.box:
                return replace(
                    filled,
                    box=tipped.box,
                    solidity=tipped.solidity,
                    hollow=tipped.hollow,
                    tipped=tipped.space,
                )
        return filled

    def lying(self) -> FilledSpace | None:
        return self._filled(self._axis(), on_ground=False)

    def _filled(self, up: FloatArray, *, on_ground: bool) -> FilledSpace | None:
        space = thing_space(
            self.surface,
            up,
            sights=self.scene.lines_of_sight,
            places=self.places,
            on_ground=on_ground,
        )
        if space is None:
            return None
        solidity = _both_ways(space, _solidity)
        hollow = _both_ways(space, partial(_hollow, on_ground=on_ground))
        box = space.lattice.volume
        return FilledSpace(space, self.surface, space.known, box, None, solidity, hollow, {})

    def _axis(self) -> FloatArray:
        """Return the normal of the largest face, or the direction in which the points vary
        least.
        """
        if self.surface.faces:
            return max(self.surface.faces, key=lambda face: face.area).normal
        normal: FloatArray = np.linalg.eigh(np.cov(self.surface.outer.T))[1][:, 0]
        return normal

    def _levels(self, space: Space, up: FloatArray) -> Iterator[tuple[int, Level]]:
        known: dict[int, Level | None] = {}
        for face in self.surface.faces:
            if abs(float(face.normal @ up)) < LEVEL_ENOUGH:
                continue
            height = float(face.middle @ up)
            layer = space.least().layer(height)
            if layer not in known:
                known[layer] = level_at(space, height, self.kinds)
            level = known[layer]
            if level is not None:
                yield face.index, level


def _both_ways(space: Space, reading: Callable[[Grid], Estimate]) -> Bounded:
    """Return a reading of the space with all that is unseen free, and with all of it full."""
    least, most = space.least(), space.most()
    if most is least:
        return Bounded.sure(reading(least))
    return Bounded.between(reading(least), reading(most))


def _solidity(grid: Grid) -> Estimate:
    return Estimate(float(grid.solid.mean()), ROUNDING / min(grid.solid.shape))


def _hollow(grid: Grid, *, on_ground: bool) -> Estimate:
    return Estimate(hollow(grid, on_ground=on_ground), ROUNDING / min(grid.solid.shape))


def _footprint(grid: Grid) -> Estimate:
    cells = float(grid.footprint.sum())
    area = cells * grid.cell**2
    return Estimate(area, 2.0 * ROUNDING / float(np.sqrt(cells)) * area)
