"""Views on the way through an area that show unseen floor, and what echoed from afar alone."""

import math
from collections.abc import Iterable, Mapping, Sequence

from facetlog.exploring.area_floor import LEAST_FLOOR, SIDE, AreaFloor, KeptOff
from facetlog.exploring.floor_ways import FloorWays
from facetlog.exploring.on_the_way import arriving, view_on_the_way
from facetlog.exploring.unseen_floor import best_sweep, shown_from
from facetlog.robot.collecting.next_stop import Around, Chosen
from facetlog.robot.collecting.route import Point
from facetlog.robot.pose2 import Pose2

__all__ = ["Sweeps"]

# How far a sweep looks, m: as far as an echo counts; beams that pass go on.
SWEEP = 2.3
# Where it gets to no place at all, it turns on the spot by a quarter, once round.
QUARTER, QUARTERS = math.pi / 2, 3


class Sweeps:
    """Chooses them over a floor; what it was sent for and does not see then is given up."""

    def __init__(self, floor: AreaFloor) -> None:
        self._floor = floor
        self._swept: list[Point] = []
        self._quarters = 0

    def resume(self, lines: Iterable[Mapping[str, object]]) -> None:
        """Takes up the choices of an earlier run, of views that were taken."""
        for line in lines:
            match line:
                case {"looks_at": 0, "way": 0.0, "after": after}:
                    # The very first view is taken on the spot too, and is no turn.
                    self._quarters += after != 0
                case {"looks_at": 0, "robot": [float() | int() as x, float() | int() as y, *_]}:
                    self._swept.append((float(x), float(y)))
                    self._quarters = 0
                case {"looks_at": _, "part": True}:
                    pass
                case {"looks_at": _}:
                    self._quarters = 0

    def came(self, *, on_the_way: bool) -> None:
        """A view was taken, of a place or `on_the_way`, or of a part of a place: after another than
        a turn on the spot the robot may turn once round again, but for parts.
        """
        if not on_the_way or self._swept:
            self._quarters = 0

    def next_view(
        self, around: Around, ways: FloorWays, kept: Sequence[KeptOff], number: int
    ) -> Chosen | None:
        """View `number` from where most unseen floor shows a second; where nothing can be reached a
        quarter turn. None where nothing is left that is worth it.
        """
        here, floor = around.here, self._floor
        stopped = floor.echoed(around.body) | floor.beside(kept)
        for place in self._swept:
            floor.given_up |= shown_from(place, stopped, floor.lattice, SWEEP)
        self._swept.clear()
        worth = floor.worth(around.body, kept)
        sweep = best_sweep(
            worth,
            stopped,
            ways,
            floor.lattice,
            here,
            around.pace,
            reach=SWEEP,
            least=LEAST_FLOOR,
        )
        if sweep is None:
            left = worth.sum() * SIDE**2 >= LEAST_FLOOR or floor.echoes(around.body, kept)
            if self._quarters == QUARTERS or not left:
                return None
            self._quarters += 1
            turned = Pose2(here.x, here.y, here.heading + QUARTER)
            spot = ((here.x, here.y),) * 2
            why = "looks about on the spot"
            return view_on_the_way(turned, spot, number, around.reach, why)
        route = ways.route_to(sweep.place)
        assert route is not None  # noqa: S101 - the place is one of those that can be reached
        self._swept.append(sweep.place)
        why = f"unseen floor and echoes from afar, worth {sweep.floor:.1f} m², show from there"
        return view_on_the_way(arriving(route, here), route, number, around.reach, why)
