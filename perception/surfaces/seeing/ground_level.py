"""The ground's exact place, by its print: where most windows of it look the same in several views.

Lines tell the ground to some pixels, and a part of a degree. Beside its place hardly any print
agrees, so it has a sharp peak there; what stands on the ground does not matter: it is elsewhere.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.evidence.photo_consistency import GreyLevels
from facetlog.perception.surfaces.seeing.ground_lattice import PITCH_PX, GroundLattice
from facetlog.perception.surfaces.seeing.ground_windows import Windows
from facetlog.perception.types import FloatArray, View

__all__ = ["aligned_ground"]

# So many views, spread among all, are compared.
COMPARED = 8
# How far off the ground may be, px, and between which heights one more is tried.
FARTHEST, STEP = 6, 0.5
# A peak has this many times as many windows that agree as the median of all heights, and so many of
# those that are pictured: less is chance.
PEAK, LEAST_SHARE = 1.5, 0.01
# A ground that is this near to level may be level: cos 3°.
MAY_BE_LEVEL = 0.9986

Plane = tuple[FloatArray, float]


def aligned_ground(
    views: Sequence[View],
    levels: GreyLevels,
    seeing: NDArray[np.intp],
    weight: FloatArray,
    ground: Plane,
    up: FloatArray | None = None,
) -> Plane:
    """The ground, normal (3,) and height along it, where its print agrees; as given without print.

    `seeing` are the views (indices) above it, `weight` (V,) is that of all views beside views
    almost like them. Where `up` is known and the ground about level both its own tilt and none are
    tried.
    """
    chosen = seeing[np.unique(np.linspace(0, len(seeing) - 1, COMPARED).round().astype(np.intp))]
    some = [views[k] for k in chosen]
    lattice = GroundLattice.under(some, *ground)
    if lattice is None or len(chosen) < 3:
        return ground
    pixel = float(np.linalg.norm(lattice.steps[0])) / PITCH_PX
    middle = lattice.corner + 0.5 * (np.array(lattice.shape) @ lattice.steps)
    normals = [ground[0]]
    if up is not None and float(up @ ground[0]) > MAY_BE_LEVEL:
        normals.append(up)

    counts = weight[chosen].astype(np.float32)

    def agreeing(plane: Plane) -> tuple[int, int]:
        return _agreeing(some, levels, chosen, counts, plane)

    tried = [(plane, agreeing(plane)) for plane in _heights(normals, middle, pixel)]
    best, (most, pictured) = max(tried, key=lambda one: one[1][0])
    usual = float(np.median([count for _, (count, _) in tried]))
    if most < PEAK * usual or most < LEAST_SHARE * pictured:
        return ground
    beside = [(best[0], best[1] + side * STEP * pixel) for side in (-1.0, 1.0)]
    finer = [(plane, agreeing(plane)) for plane in beside]
    return max([(best, (most, pictured)), *finer], key=lambda one: one[1][0])[0]


def _heights(normals: Sequence[FloatArray], middle: FloatArray, pixel: float) -> Iterator[Plane]:
    """Planes about a point, pixel by pixel, the nearest first."""
    for offset in sorted(range(-FARTHEST, FARTHEST + 1), key=abs):
        for normal in normals:
            yield normal, float(middle @ normal) + offset * pixel


def _agreeing(
    views: Sequence[View],
    levels: GreyLevels,
    chosen: NDArray[np.intp],
    weight: NDArray[np.float32],
    plane: Plane,
) -> tuple[int, int]:
    """How many windows views show with the same print in the middle of a plane, half its lattice
    across, and of how many they picture.
    """
    lattice = GroundLattice.under(views, *plane)
    if lattice is None:
        return 0, 1
    rows, columns = lattice.shape
    corner = lattice.corner + np.array([rows // 4, columns // 4]) @ lattice.steps
    lattice = replace(lattice, corner=corner, shape=(rows // 2, columns // 2))
    windows = Windows(levels, chosen, [lattice.pixels(view) for view in views], lattice.shape)
    seen = windows.printed(weight)
    return int(seen.sum()), int(windows.pictured.sum())
