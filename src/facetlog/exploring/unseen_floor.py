"""From where unseen floor is looked at: the place that shows most of it for each second.

Frontier exploration (Yamauchi 1997), by how much of the unseen floor a place shows (Gonzalez-Banos
and Latombe 2002): rays go out from every place that can be reached, until something stops them.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facetlog.exploring.floor_ways import FloorWays, Lattice
from facetlog.perception.types import FloatArray
from facetlog.robot.collecting.route import Point
from facetlog.robot.collecting.steering import Pace
from facetlog.robot.pose2 import Pose2, wrapped

__all__ = ["Sweep", "best_sweep", "shown_from"]

RAYS = 48
BEARINGS = math.tau * np.arange(RAYS) / RAYS
# Of the places that can be reached every third in each direction is asked.
EVERY = 3


@dataclass(frozen=True, slots=True)
class Sweep:
    """A place from which unseen floor shows: how much it is worth, m², and seconds to it."""

    place: Point
    floor: float
    seconds: float


def best_sweep(
    worth: FloatArray,
    stopped: NDArray[np.bool_],
    ways: FloorWays,
    lattice: Lattice,
    here: Pose2,
    pace: Pace,
    *,
    reach: float,
    least: float,
) -> Sweep | None:
    """The place that shows most unseen floor a second; None if none shows the `least`, m².

    `worth` is how much unseen floor each cell (rows, columns) counts as, in cells; `stopped` are
    those that stop a look, which goes as far as `reach` (m).
    """
    lengths = ways.lengths
    asked = np.zeros(lattice.shape, np.bool_)
    asked[::EVERY, ::EVERY] = True
    cells = np.argwhere(np.isfinite(lengths) & asked)
    if not len(cells):
        return None
    row, column = cells.T
    places = lattice.middles[row, column]
    shown = _shown(places, worth, stopped, lattice, reach)
    step = places - [here.x, here.y]
    bearings = np.arctan2(step[:, 1], step[:, 0])
    turns = np.array([abs(wrapped(float(b) - here.heading)) for b in bearings])
    # What takes no time at all would be best whatever it shows: a stop is a second or so.
    seconds = lengths[row, column] / pace.speed + turns / pace.turning + 1.0
    rates = np.where(shown >= least, shown / seconds, 0.0)
    best = int(np.argmax(rates))
    if rates[best] <= 0.0:
        return None
    x, y = places[best].tolist()
    return Sweep((x, y), float(shown[best]), float(seconds[best]))


def _shown(
    places: FloatArray,
    worth: FloatArray,
    stopped: NDArray[np.bool_],
    lattice: Lattice,
    reach: float,
) -> FloatArray:
    """How much unseen floor (n,) shows from each place (n, 2), m²: ∫∫ r dr dφ along rays."""
    found = np.zeros(len(places))
    for angle in BEARINGS:
        radii, inside, row, column = _along(places, float(angle), lattice, reach)
        passed = np.cumsum(~inside | stopped[row, column], axis=1) == 0
        found += (passed * worth[row, column]) @ radii
    area: FloatArray = found * lattice.side * (math.tau / RAYS)
    return area


def shown_from(
    place: Point, stopped: NDArray[np.bool_], lattice: Lattice, reach: float
) -> NDArray[np.bool_]:
    """The cells (rows, columns) that a place shows."""
    found = np.zeros(lattice.shape, np.bool_)
    at = np.array([place])
    # So many rays that the last cells are not passed by, and those by which places are compared:
    # what was counted on is shown, and never gone for again.
    fine = np.arange(0.0, math.tau, lattice.side / reach / 2)
    for angle in np.concatenate([BEARINGS, fine]):
        _, inside, row, column = _along(at, float(angle), lattice, reach)
        passed = np.cumsum(~inside | stopped[row, column], axis=1) == 0
        found[row[passed], column[passed]] = True
    return found


def _along(
    places: FloatArray, angle: float, lattice: Lattice, reach: float
) -> tuple[FloatArray, NDArray[np.bool_], NDArray[np.intp], NDArray[np.intp]]:
    """Distances (k,) along a ray from each place, whether there is a cell (n, k), and which."""
    radii = lattice.side * (np.arange(int(reach / lattice.side), dtype=np.float64) + 0.5)
    step = np.array([math.cos(angle), math.sin(angle)])
    points = places[:, None] + radii[:, None] * step
    index = np.floor((points - lattice.low) / lattice.side).astype(np.intp)
    column, row = index[..., 0], index[..., 1]
    rows, columns = lattice.shape
    inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
    return radii, inside, np.clip(row, 0, rows - 1), np.clip(column, 0, columns - 1)
