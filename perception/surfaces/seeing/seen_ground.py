"""Where the ground shows: on a lattice of its points, which views see each.

What a line of sight to the ground passes through is free. The level of a pixel alone hardly says
where it ends: beneath a plain thing the views agree on the thing's own grey. So views see the
ground where they show the same print round a point of it, or a level that the ground shows and the
faces that hide it do not. These faces say how often either is wrong.
"""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.evidence.photo_consistency import GreyLevels
from facetlog.perception.scene import SeenLattice
from facetlog.perception.surfaces.seeing.eyes import BEFORE_PX
from facetlog.perception.surfaces.seeing.ground_lattice import PITCH_PX, GroundLattice
from facetlog.perception.surfaces.seeing.ground_level import aligned_ground
from facetlog.perception.surfaces.seeing.ground_windows import EVERY, KEPT, Windows
from facetlog.perception.types import FloatArray, View

__all__ = ["seen_ground"]

# The time grows with the square of their number.
MOST_VIEWS = 32
# Of points that are known to be hidden so many pass as seen, or it is left: a place that two views
# pass by mistake is one in 25.
MOST_WRONG = 0.2

_Bits = NDArray[np.bool_]


def seen_ground(
    views: Sequence[View],
    levels: GreyLevels,
    weight: FloatArray,
    faces: Sequence[Sequence[FloatArray]],
    ground: tuple[FloatArray, float],
    up: FloatArray | None = None,
) -> tuple[SeenLattice, ...]:
    """Up to two lattices on the ground: what the views see of it by its print, and by its levels.

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
    chosen = above[np.unique(np.linspace(0, len(above) - 1, MOST_VIEWS).round().astype(np.intp))]
    seeing = [views[k] for k in chosen]
    normal, height = aligned_ground(views, levels, chosen, weight, (normal, height), up)
    lattice = GroundLattice.under(seeing, normal, height)
    if lattice is None:
        return ()
    windows = Windows(levels, chosen, [lattice.pixels(view) for view in seeing], lattice.shape)
    shadows = [lattice.shadow(faces, view) for view in seeing]
    hidden = windows.pictured & np.array([shadow[KEPT] for shadow in shadows])
    beside = windows.pictured & np.array([_widened(shadow)[KEPT] for shadow in shadows])
    counts = weight[chosen].astype(np.float32)
    # Windows of print reach over what they are beside, and two of them may show it. A level tells
    # by itself which of the two a pixel shows, however far off the outline of what hides is.
    found = [(windows.printed(counts), beside)]
    if hidden.any():
        found.append((windows.unlike(counts, hidden), hidden))
    origins = np.array([view.pose.centre for view in seeing])
    named = tuple(chosen.tolist())
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
