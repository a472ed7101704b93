"""Where the ground shows: on a lattice of its points, which views see each.

What a line of sight to the ground passes through is free. The level of a pixel alone hardly says
where it ends: beneath a plain thing the views agree on the thing's own grey. So views see the
ground where they show the same print round a point of it, or a level that the ground shows and the
faces that hide it do not. These faces say how often either is wrong.

Lines tell the ground to some pixels, and a part of a degree. Beside its place hardly any print
agrees, so the number of windows that do has a sharp peak there; what stands on the ground does not
matter: it is elsewhere.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.evidence.photo_consistency import GreyLevels
from facetlog.perception.scene import SeenLattice
from facetlog.perception.surfaces.seeing.ground_lattice import PITCH_PX, GroundLattice
from facetlog.perception.surfaces.seeing.ground_windows import EVERY, KEPT, Windows
from facetlog.perception.surfaces.seeing.seen_faces import BEFORE_PX
from facetlog.perception.types import FloatArray, View

__all__ = ["GroundViews", "seen_ground"]

# The time grows with the square of their number.
MOST_VIEWS = 32
# Of points that are known to be hidden so many pass as seen, or it is left: a place that two views
# pass by mistake is one in 25.
MOST_WRONG = 0.2

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
_Bits = NDArray[np.bool_]


@dataclass(frozen=True, eq=False, slots=True)
class GroundViews:
    """Views above the ground, with the levels of all pictures: `chosen` (v,) are theirs.

    `weight` (v,) is that of each view beside views almost like it.
    """

    views: Sequence[View]
    levels: GreyLevels
    chosen: NDArray[np.intp]
    weight: NDArray[np.float32]

    def windows(self, lattice: GroundLattice) -> Windows:
        """Return what the views show at the points of a lattice."""
        pixels = [lattice.pixels(view) for view in self.views]
        return Windows(self.levels, self.chosen, pixels, lattice.shape)

    def spread(self, count: int) -> "GroundViews":
        """Return so many of the views at most, spread evenly among all."""
        last = len(self.views) - 1
        rows = np.unique(np.linspace(0, last, count).round().astype(np.intp))
        views = [self.views[k] for k in rows]
        return GroundViews(views, self.levels, self.chosen[rows], self.weight[rows])

    def aligned(self, ground: Plane, up: FloatArray | None = None) -> Plane:
        """Return the ground where most of its print agrees; as given without print.

        The ground is its normal (3,) and the height along it. Where `up` is known and the ground
        about level both its own tilt and none are tried.
        """
        some = self.spread(COMPARED)
        lattice = GroundLattice.under(some.views, *ground)
        if lattice is None or len(some.views) < 3:
            return ground
        pixel = float(np.linalg.norm(lattice.steps[0])) / PITCH_PX
        middle = lattice.corner + 0.5 * (np.array(lattice.shape) @ lattice.steps)
        normals = [ground[0]]
        if up is not None and float(up @ ground[0]) > MAY_BE_LEVEL:
            normals.append(up)

        tried = [(plane, some.agreeing(plane)) for plane in _heights(normals, middle, pixel)]
        best, (most, pictured) = max(tried, key=lambda one: one[1][0])
        usual = float(np.median([count for _, (count, _) in tried]))
        if most < PEAK * usual or most < LEAST_SHARE * pictured:
            return ground
        beside = [(best[0], best[1] + side * STEP * pixel) for side in (-1.0, 1.0)]
        finer = [(plane, some.agreeing(plane)) for plane in beside]
        return max([(best, (most, pictured)), *finer], key=lambda one: one[1][0])[0]

    def agreeing(self, plane: Plane) -> tuple[int, int]:
        """Return how many windows views show with the same print in the middle of a plane, half its
        lattice across, and of how many they picture.
        """
        lattice = GroundLattice.under(self.views, *plane)
        if lattice is None:
            return 0, 1
        rows, columns = lattice.shape
        corner = lattice.corner + np.array([rows // 4, columns // 4]) @ lattice.steps
        lattice = replace(lattice, corner=corner, shape=(rows // 2, columns // 2))
        windows = self.windows(lattice)
        return int(windows.printed(self.weight).sum()), int(windows.pictured.sum())


def seen_ground(
    views: Sequence[View],
    levels: GreyLevels,
    weight: FloatArray,
    faces: Sequence[Sequence[FloatArray]],
    ground: tuple[FloatArray, float],
    up: FloatArray | None = None,
) -> tuple[SeenLattice, ...]:
    """Return up to two lattices on the ground: what the views see of it by its print, and by its
    levels.

    `levels` are those of the views, and `weight` (V,) is as in `PhotometricViews`; `faces` are the
    rings of corners, each (k, 3), of what may hide the ground, which is a normal (3,) to the views'
    side and the height along it: about, for it is put where most of its print agrees, level with
    `up` if more agrees then. A lattice is left out where nothing of it is seen or where it is
    often wrong, that of levels also where no face says whether it is.
    """
    normal, height = ground
    above = np.flatnonzero([view.pose.centre @ normal > height for view in views])
    if not len(above):
        return ()
    weights = weight[above].astype(np.float32)
    seeing = GroundViews([views[int(k)] for k in above], levels, above, weights).spread(MOST_VIEWS)
    lattice = GroundLattice.under(seeing.views, *seeing.aligned(ground, up))
    if lattice is None:
        return ()
    windows = seeing.windows(lattice)
    shadows = [lattice.shadow(faces, view) for view in seeing.views]
    hidden = windows.pictured & np.array([shadow[KEPT] for shadow in shadows])
    beside = windows.pictured & np.array([_widened(shadow)[KEPT] for shadow in shadows])
    # Windows of print reach over what they are beside, and two of them may show it. A level tells
    # by itself which of the two a pixel shows, however far off the outline of what hides is.
    found = [(windows.printed(seeing.weight), beside)]
    if hidden.any():
        found.append((windows.unlike(seeing.weight, hidden), hidden))
    origins = np.array([view.pose.centre for view in seeing.views])
    named = tuple(seeing.chosen.tolist())
    lattices = []
    for seen, covered in found:
        wrong = float(seen[hidden].mean()) if hidden.any() else None
        seen &= ~covered
        if seen.any() and (wrong is None or wrong <= MOST_WRONG):
            steps = EVERY * lattice.steps
            lattices.append(SeenLattice(lattice.corner, steps, origins, seen, named, wrong))
    return tuple(lattices)


def _widened(shadow: _Bits) -> _Bits:
    # By as much as the outlines of faces may be off.
    across = 2 * round(BEFORE_PX / PITCH_PX) + 1
    return cv2.dilate(shadow.view(np.uint8), np.ones((across, across), np.uint8)).view(np.bool_)


def _heights(normals: Sequence[FloatArray], middle: FloatArray, pixel: float) -> Iterator[Plane]:
    """Return planes about a point, pixel by pixel, the nearest first."""
    for offset in sorted(range(-FARTHEST, FARTHEST + 1), key=abs):
        for normal in normals:
            yield normal, float(middle @ normal) + offset * pixel
