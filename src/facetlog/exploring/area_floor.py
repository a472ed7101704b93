"""The floor of an area while it is explored: what sonars passed and met, and where one may drive.

What sonars passed is free at their height, some 20 cm. A table is met by its legs, so the robot
keeps farther from what nobody has looked at yet than from a thing whose plan is known.

Odometry drifts: what was heard long ago lies elsewhere by now. What is heard anew weighs more.
"""

import math
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.exploring.echoes import Echo, clusters, within
from facetlog.exploring.floor_ways import FloorWays, Lattice
from facetlog.mapping.beam_counts import BeamCounts
from facetlog.mapping.place import OVERHANG
from facetlog.mapping.sonar_beams import Beam, new_beams
from facetlog.perception.types import FloatArray
from facetlog.robot.collecting.next_stop import MOST_DRIFT
from facetlog.robot.collecting.route import Circle, Point
from facetlog.robot.pioneer.state import SonarRange
from facetlog.robot.pose2 import Pose2

__all__ = ["CLEARANCE", "LEAST_FLOOR", "SIDE", "Area", "AreaFloor", "KeptOff"]

Area = tuple[float, float, float, float]
"""x and y of the lowest corner, width and height, metres."""

SIDE = 0.1
"""The side of a cell for planning, m: a fifth of the robot."""
CLEARANCE = 0.06
"""What ways keep free beside the robot's radius, m: driving misses its route by 2 cm and stops
within 2 cm, and half a diagonal of a cell is left."""
LEAST_FLOOR = 0.25
"""A look is worth it from so much unseen floor, m²: the robot's own place."""
# An echo's arc is no wider than what may overhang it: 30 degrees of 2.3 m.
FARTHEST_ECHO = 2 * OVERHANG / math.radians(30.0)
# After so many metres a cell's counts weigh e times less: wheels that differ by half a per cent put
# a robot off by a cell in some ten metres.
FORGETS = 10.0
# The robot's way is kept in steps of half a cell, m.
NOTED = SIDE / 2
# Whoever starts the robot has put it where it can turn: its radius and so much more is free, m.
BEGUN = 0.25
# A cell beside the plan of a thing, and what drives aside, belongs to the thing: an arc's width.
BESIDE = 0.3


@dataclass(frozen=True, eq=False, slots=True)
class KeptOff:
    """The plan of a thing that was found, how far off it may be by now, m, and whether it is known
    what it is: of another there may be more than its plan.
    """

    plan: shapely.Geometry
    sd: float
    known: bool = True


class AreaFloor:
    """What is known of an area's floor, of a robot with a radius (m)."""

    def __init__(self, area: Area) -> None:
        self.lattice = Lattice.of_area(area, SIDE)
        self._counts = BeamCounts(
            self.lattice.low, SIDE, self.lattice.shape, farthest_echo=FARTHEST_ECHO
        )
        self._known: dict[int, float] = {}
        self._last: Pose2 | None = None
        self._faded = 0.0
        self._places: list[Point] = []
        self._way: deque[Point] = deque(maxlen=round(FORGETS / NOTED))
        self._bodies = np.zeros(self.lattice.shape, np.bool_)
        self._begun: Point | None = None
        self.given_up = np.zeros(self.lattice.shape, np.bool_)
        """Cells (rows, columns) that were looked at from where they show, and stay unseen."""
        self.asked = np.zeros(self.lattice.shape, np.bool_)
        """Cells at which pictures looked for what echoes there, and found nothing new."""

    def begin(self, here: Point) -> None:
        """Says where the robot stood at first."""
        self._begun = self._begun or here

    def heard(self, place: Pose2, sonars: Iterable[SonarRange]) -> None:
        """Takes what sonars said of a robot at a place in the world."""
        self.moved(place)
        self.add(new_beams(place, sonars, self._known))

    def moved(self, place: Pose2) -> None:
        """Takes where the robot is by now."""
        last = place if self._last is None else self._last
        way = math.dist((place.x, place.y), (last.x, last.y))
        if self._last is None or way >= NOTED:
            self._places.append((place.x, place.y))
            self._way.append((place.x, place.y))
            self._last = place
            self._faded += way
        if self._faded >= 1.0:
            self._counts.fade(math.exp(-self._faded / FORGETS))
            self._faded = 0.0

    def add(self, beams: Iterable[Beam]) -> None:
        """Takes beams, in the order in which they were heard."""
        for beam in beams:
            self._counts.add(beam)

    def bodies(self, radius: float) -> NDArray[np.bool_]:
        """The cells (rows, columns) in which the robot's body was, and where it began."""
        for place in self._places:
            self._bodies |= self.lattice.away(place) <= radius
        self._places.clear()
        if self._begun is not None:
            self._bodies |= self.lattice.away(self._begun) <= radius + BEGUN
        return self._bodies

    def echoed(self, radius: float) -> NDArray[np.bool_]:
        """The cells in which something is by the sonars, and the robot was not just now."""
        return np.asarray(self._counts.echoed & ~self._lately(radius))

    def passed(self, radius: float) -> NDArray[np.bool_]:
        """The cells in which nothing is, by the sonars or because the robot was there."""
        return np.asarray(self._counts.passed | self.bodies(radius))

    def unseen(self, radius: float, things: Sequence[KeptOff]) -> NDArray[np.bool_]:
        """The cells of which nothing is known, and that no thing stands on."""
        known = self.passed(radius) | self._counts.echoed
        return np.asarray(~known & ~self.beside(things))

    def worth(self, radius: float, things: Sequence[KeptOff]) -> FloatArray:
        """How much each cell (rows, columns) is worth a look, as so many cells of unseen floor: one
        that echoed from afar alone as much as a sweep asks for. What was given up is worth none.
        """
        afar = self._counts.echoed_afar & ~self.bodies(radius) & ~self.beside(things) & ~self.asked
        found = np.where(afar, LEAST_FLOOR / SIDE**2, self.unseen(radius, things))
        return np.asarray(np.where(self.given_up, 0.0, found), dtype=np.float64)

    def beside(self, things: Sequence[KeptOff]) -> NDArray[np.bool_]:
        """The cells on which things stand or that are beside them."""
        found = np.zeros(self.lattice.shape, np.bool_)
        for thing in things:
            found |= self._away(thing) <= BESIDE + min(thing.sd, OVERHANG)
        return found

    def echoes(self, radius: float, things: Sequence[KeptOff]) -> tuple[Echo, ...]:
        """Clusters of what echoes, and is neither a thing nor was asked for; what may overhang two
        echoes is one.
        """
        left = self.echoed(radius) & ~self.beside(things) & ~self.asked
        return tuple(clusters(left, self._counts.hits, self.lattice, 2 * OVERHANG))

    def ways(
        self, here: Point, radius: float, things: Sequence[KeptOff], closed: Sequence[Circle]
    ) -> FloorWays:
        """Ways from a place, off what echoes, off things, and out of circles for its middle."""
        passed, echoed = self.passed(radius), self.echoed(radius)
        # From a cell's middle to the rim of the nearest that is not known to be free.
        free = np.pad(passed & ~echoed, 1).astype(np.uint8)
        away = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
        rim = (away - 0.5) * SIDE
        bare = rim >= radius
        open_ = rim >= radius + CLEARANCE
        known = [thing for thing in things if thing.known]
        near = within(echoed & ~self.beside(known), radius + OVERHANG, SIDE)
        for thing in things:
            off = self._away(thing)
            bare &= off >= radius
            # What has drifted farther is kept off by its echoes, which are heard where it is now.
            open_ &= off >= radius + CLEARANCE + min(thing.sd, MOST_DRIFT)
        for circle in closed:
            off = self.lattice.away((circle.x, circle.y))
            bare &= off >= min(circle.radius, circle.distance(here))
            open_ &= off >= circle.radius
        # Whatever overhangs what is heard there by now: the robot came by with its mast.
        driven = self._driven()
        came, back = open_ & driven, bare & driven
        return FloorWays(self.lattice, open_ & ~near, bare, here, came, back)

    def _lately(self, radius: float) -> NDArray[np.bool_]:
        """As `bodies`, as far back as odometry knows them to a cell: since then something may have
        come there, or the robot was elsewhere.
        """
        found = within(self._way_cells(), radius, SIDE)
        if self._begun is not None and len(self._way) < (self._way.maxlen or 0):
            found |= self.lattice.away(self._begun) <= radius + BEGUN
        return found

    def _driven(self) -> NDArray[np.bool_]:
        """The cells by which the robot came, as far back as odometry knows them to a cell."""
        return within(self._way_cells(), SIDE, SIDE)

    def _way_cells(self) -> NDArray[np.bool_]:
        found = np.zeros(self.lattice.shape, np.bool_)
        for cell in map(self.lattice.cell, self._way):
            if self.lattice.holds(cell):
                found[cell] = True
        return found

    def _away(self, thing: KeptOff) -> FloatArray:
        points = shapely.points(self.lattice.middles.reshape(-1, 2))
        shapely.prepare(thing.plan)
        found: FloatArray = shapely.distance(thing.plan, points).reshape(self.lattice.shape)
        return found

    def area_of(self, cells: NDArray[np.bool_]) -> float:
        """How much floor that is, m²."""
        return float(cells.sum()) * SIDE**2
