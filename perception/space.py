"""The space of things whose surface is known from all sides: what they fill, and what they leave.

Of others nothing is stated here: where a picture shows no surface, there may be one.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from facetlog.perception.flat_faces import Estimate, FlatFace
from facetlog.perception.levels import ROUNDING, Level, level_at
from facetlog.perception.occupancy import Grid, occupancy
from facetlog.perception.things import Thing
from facetlog.perception.types import FloatArray, Scene

__all__ = ["Space", "curved_share", "spaces"]

# A face that leans less than this from level has a level: sin 60°.
LEVEL_ENOUGH = 0.866


@dataclass(frozen=True, eq=False, slots=True)
class Space:
    """A thing's `footprint` (area), `solidity` (its share of the least box round it, 0..1), and the
    levels of its faces that lie about level (by index of the face).

    Without a known up the box is square to the largest face, and there are no levels and no
    footprint.
    """

    footprint: Estimate | None
    solidity: Estimate
    levels: dict[int, Level]


def curved_share(scene: Scene, faces: tuple[FlatFace, ...], thing: Thing) -> float:
    """How much of a thing's surface is not flat, 0..1."""
    curved = float(sum(scene.patches[i].areas.sum() for i in thing.patches))
    flat = sum(faces[i].area for i in thing.faces)
    return curved / (curved + flat) if curved > 0.0 else 0.0


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


def _footprint(grid: Grid) -> Estimate:
    cells = float(grid.footprint.sum())
    area = cells * grid.cell**2
    return Estimate(area, 2.0 * ROUNDING / np.sqrt(cells) * area)


def _standing(grid: Grid | None, faces: tuple[FlatFace, ...], up: FloatArray) -> Space | None:
    if grid is None:
        return None
    return Space(_footprint(grid), _solidity(grid), dict(_levels(grid, faces, up)))


def _lying(grid: Grid | None) -> Space | None:
    return None if grid is None else Space(None, _solidity(grid), {})


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
        sd = _corner_sd(scene, own)
        if scene.up is None:
            axis = _axis(own, outer[index])
            grid = occupancy(own, outer[index], others, axis, corner_sd=sd, on_ground=False)
            space = _lying(grid)
        else:
            grid = occupancy(own, outer[index], others, scene.up, corner_sd=sd)
            space = _standing(grid, own, scene.up)
        if space is not None:
            found[index] = space
    return found
