"""Up where it is not given: from the floor or table that things stand on, or from the cameras."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from facetlog.perception.shapes.regions.floor_and_walls import FacedSurface, Floor, find_floors
from facetlog.perception.types import FloatArray

FROM_FLOOR = "up was found from the plane on which everything stands"
FROM_CAMERAS = "up was found from the way the cameras were held"
HELD_OTHERWISE = f"{FROM_FLOOR}, but the cameras were held otherwise: if it is a wall, say up"
"""How up was found, as in a scene's warnings."""

# Of two planes that could both be the floor, as a room's wall could, one is so much larger.
CLEARLY_LARGER = 1.5
# Planes within 20 degrees of each other are one level (cosine).
ONE_LEVEL = float(np.cos(np.deg2rad(20.0)))
# Cameras are held upright: their mean up is known if it is this long (1: all the same).
LEAST_AGREEMENT = 0.8


@dataclass(frozen=True, eq=False, slots=True)
class Up:
    """Unit vector upwards (3,), the region that is the floor (None: none), and how it was found.

    `around` are the other regions on which or within which things stand: further pieces of the
    floor, and the walls and the ceiling of a room.
    """

    direction: FloatArray
    floor: int | None
    how: str
    around: tuple[int, ...] = ()


def find_up(
    surface: FacedSurface, up: FloatArray | None = None, *, metric: bool = False
) -> Up | None:
    """Return up from the one plane on which everything else stands; None where there is none, or
    where there are two.

    A wall carries things too: there must be one that can only stand. With a known `up` only level
    planes are considered, and the result says which of them is the floor; where lengths are also
    metres (`metric`), also that of an empty room.
    """
    found: list[Floor] = sorted(
        find_floors(surface, up, metric=metric), key=lambda floor: -floor.area
    )
    if not found:
        return None
    first = found[0]
    for other in found[1:]:
        # beside a larger floor the others are walls; one that faces it, as a ceiling does, is
        # ambiguous
        facing = float(first.normal @ other.normal) < -ONE_LEVEL
        if facing or first.area < CLEARLY_LARGER * other.area:
            return None
    direction = first.normal if up is None else up
    return Up(direction, first.region, FROM_FLOOR, first.around)


def up_from_cameras(camera_ups: FloatArray) -> Up | None:
    """Return up as the cameras (n, 3) were held, unit vectors; None where they do not agree."""
    if not len(camera_ups):
        return None
    mean = camera_ups.mean(axis=0)
    length = float(np.linalg.norm(mean))
    # a tour round a thing with the camera on its side would have no agreement
    pairs = list(combinations(range(min(len(camera_ups), 2)), 2))
    if length < LEAST_AGREEMENT or not pairs:
        return None
    return Up(mean / length, None, FROM_CAMERAS)
