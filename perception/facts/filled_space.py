"""The space of things whose surface is known from all sides: what they fill, and what they leave.

Of others nothing is stated here: where a picture shows no surface, there may be one.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from facetlog.perception.facts.levels import ROUNDING, Level, level_at
from facetlog.perception.facts.sides import hollow
from facetlog.perception.flat_faces import Estimate, FlatFace
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.occupancy import Grid, occupancy
from facetlog.perception.surfaces.things import Thing
from facetlog.perception.types import FloatArray

__all__ = ["Space", "curved_share", "spaces"]

# A face that leans less than this from level has a level: sin 60°.
LEVEL_ENOUGH = 0.866
# A direction this near one of a box's own is the same: cos 5°.
SAME_DIRECTION = 0.996


@dataclass(frozen=True, eq=False, slots=True)
class Space:
    """A thing's `footprint` (area), `solidity` (its share of the least box round it, 0..1), how
    `hollow` the sides of that box are (0..1), and the levels of its faces that lie about level (by
    index of the face).

    The box is upright or square to the largest face, whichever is filled more. Without a known up
    there are no levels and no footprint.
    """

    footprint: Estimate | None
    solidity: Estimate
    hollow: Estimate
    levels: dict[int, Level]


def curved_share(scene: Scene, areas: FloatArray, thing: Thing) -> float:
    """How much of a thing's surface is not flat, 0..1; `areas` (f,) are those of all faces."""
    curved = float(sum(scene.patches[i].areas.sum() for i in thing.patches))
    if not curved > 0.0:
        return 0.0
    return curved / (curved + float(sum(areas[list(thing.faces)].tolist())))


def _levels(grid: Grid, faces: tuple[FlatFace, ...], up: FloatArray) -> Iterator[tuple[int, Level]]:
    known: dict[int, Level | None] = {}
    for face in faces:
        if abs(float(face.normal @ up)) < LEVEL_ENOUGH:
            continue
        height = float(face.middle @ up)
        layer = grid.layer(height)
        if layer not in known:
            known[layer] = level_at(grid, height)
        level = known[layer]
        if level is not None:
            yield face.index, level


def _solidity(grid: Grid) -> Estimate:
    return Estimate(float(grid.solid.mean()), ROUNDING / min(grid.solid.shape))


def _hollow(grid: Grid, *, on_ground: bool) -> Estimate:
    return Estimate(hollow(grid, on_ground=on_ground), ROUNDING / min(grid.solid.shape))


def _footprint(grid: Grid) -> Estimate:
    cells = float(grid.footprint.sum())
    area = cells * grid.cell**2
    return Estimate(area, 2.0 * ROUNDING / np.sqrt(cells) * area)


def _axis(faces: tuple[FlatFace, ...], points: FloatArray) -> FloatArray:
    """The normal of the largest face, or the direction in which the points vary least."""
    if faces:
        return max(faces, key=lambda face: face.area).normal
    normal: FloatArray = np.linalg.eigh(np.cov(points.T))[1][:, 0]
    return normal


def _corner_sd(scene: Scene, faces: tuple[FlatFace, ...]) -> float:
    """Median sd of the faces' corners, along an axis; 0 without faces."""
    corners = {i for face in faces for i in face.members}
    variances = [float(np.trace(scene.vertices[i].cov)) / 3.0 for i in corners]
    return float(np.sqrt(np.median(variances))) if variances else 0.0


@dataclass(frozen=True, eq=False, slots=True)
class _Surface:
    """A thing's faces, points that reach as far as it does, and points of what is curved."""

    faces: tuple[FlatFace, ...]
    outer: FloatArray
    curved: FloatArray
    corner_sd: float

    def standing(self, up: FloatArray) -> Space | None:
        grid = self._grid(up, on_ground=True)
        if grid is None:
            return None
        solidity, hollowed = _solidity(grid), _hollow(grid, on_ground=True)
        axis = _axis(self.faces, self.outer)
        # A box that is tipped over fills the box round it no less.
        if float(np.abs(grid.axes @ axis).max()) < SAME_DIRECTION:
            tipped = self.lying(axis)
            if tipped is not None and tipped.solidity > solidity:
                solidity, hollowed = tipped.solidity, tipped.hollow
        return Space(_footprint(grid), solidity, hollowed, dict(_levels(grid, self.faces, up)))

    def lying(self, axis: FloatArray) -> Space | None:
        grid = self._grid(axis, on_ground=False)
        return (
            None
            if grid is None
            else Space(None, _solidity(grid), _hollow(grid, on_ground=False), {})
        )

    def _grid(self, up: FloatArray, *, on_ground: bool) -> Grid | None:
        return occupancy(
            self.faces,
            self.outer,
            self.curved,
            up,
            corner_sd=self.corner_sd,
            on_ground=on_ground,
        )


def spaces(
    scene: Scene,
    faces: tuple[FlatFace, ...],
    things: tuple[Thing, ...],
    outer: Sequence[FloatArray],
) -> dict[int, Space]:
    """The space of each thing (by its index) that is known from all sides.

    `outer` are points (n, 3) that reach as far as each thing does.
    """
    found: dict[int, Space] = {}
    for index, thing in enumerate(things):
        if not thing.whole or len(outer[index]) < 2:
            continue
        own = tuple(faces[i] for i in thing.faces)
        curved = [scene.patches[i].points for i in thing.patches]
        others = np.concatenate([np.zeros((0, 3)), *curved])
        surface = _Surface(own, outer[index], others, _corner_sd(scene, own))
        if scene.up is None:
            space = surface.lying(_axis(own, outer[index]))
        else:
            space = surface.standing(scene.up)
        if space is not None:
            found[index] = space
    return found
