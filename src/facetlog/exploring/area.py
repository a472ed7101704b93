"""Explores an area: sonars find what stands there, pictures settle what it is.

Where most of the sonars' beams end something stands: a place to look at. The nearest one is looked
at first, from rings round it that can be reached over known floor, by the choice of views for one
target (explorer.py). Where no place is left that can be looked at, the robot goes to where most of
the unseen floor shows a second, until none of it can be reached.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from facetlog.exploring.area_end import at, end_of_area
from facetlog.exploring.area_floor import CLEARANCE, SIDE, Area, AreaFloor, KeptOff
from facetlog.exploring.area_groups import (
    End,
    Group,
    Rings,
    ends_json,
    ends_of,
    parts_of,
    rings_round,
)
from facetlog.exploring.echoes import Echo
from facetlog.exploring.explorer import Explorer
from facetlog.exploring.floor_ways import FloorWays
from facetlog.exploring.needs import Interest
from facetlog.exploring.on_the_way import view_on_the_way
from facetlog.exploring.standing import (
    may_be_off_so_far,
    moved_beside,
    standing_by_pictures,
)
from facetlog.exploring.sweeps import Sweeps
from facetlog.mapping.place import OVERHANG, Place, places_of, thing_at
from facetlog.mapping.placed_thing import pose_covariance_at
from facetlog.mapping.room_map import ScenePart
from facetlog.mapping.same_thing import MappedThing, merged
from facetlog.mapping.visit import Visit
from facetlog.perception.fewest_views import FEWEST_VIEWS
from facetlog.perception.types import FloatArray
from facetlog.robot.collecting.next_stop import EXPLORED, Around, Chosen, Finished, place_sd
from facetlog.robot.collecting.record import Taken
from facetlog.robot.collecting.ring_views import PLACES
from facetlog.robot.pioneer.state import SonarRange
from facetlog.robot.pose2 import Pose2
from facetlog.view_verdicts import ViewVerdict

__all__ = ["AreaExplorer", "AreaJudge"]

MOST_OF_A_PLACE = 12
"""Views of one place at most: half of the paper's tour."""
# Of the views on both rings so many can be reached before a place is looked at, as long as there is
# unseen floor to go to: half of the inner one.
ENOUGH = PLACES // 2

AreaJudge: TypeAlias = Callable[[tuple[str, ...], Interest], tuple[ViewVerdict, ScenePart]]
"""What the views of these names show: the verdict with what is undecided, and things in the world.
All things are of one visit."""


class AreaExplorer:
    """Chooses views until no floor of the area that is unseen can be reached, and no verdict on
    what stands there can change any more.
    """

    def __init__(
        self, judge: AreaJudge, area: Area, *, most: int, of_a_place: int = MOST_OF_A_PLACE
    ) -> None:
        self._judge, self._most, self._of_a_place = judge, most, of_a_place
        self.area = area
        self.floor = AreaFloor(area)
        self.groups: list[Group] = []
        self.reached = False
        """Whether it ended by itself."""
        self._said: list[str] = []
        self._here: Pose2 | None = None
        self._counted: set[str] = set()
        self._sent: tuple[str, int] | None = None
        self._sweeps = Sweeps(self.floor)

    @property
    def most(self) -> int:
        """The most views of the whole collection."""
        return self._most

    @property
    def things(self) -> tuple[MappedThing, ...]:
        """The things found so far, each once."""
        return merged(group.thing for group in self.groups if group.thing is not None)[0]

    def heard(self, place: Pose2, sonars: Sequence[SonarRange]) -> None:
        """Takes what the sonars said of the robot at a place."""
        self.floor.heard(place, sonars)

    def resume(self, lines: Sequence[Mapping[str, object]], visit: Visit) -> None:
        """Takes up a collection as it was before its last view was judged: the choices so far by
        the lines of its collect.jsonl, which are judged again, and what was heard and driven.

        InputError where the lines do not say how the area was explored.
        """
        around = Around.recorded(lines)
        for pose in visit.way:
            self.floor.moved(pose)
        self.floor.add(visit.driven.beams)
        taken = visit.taken
        there = {view.name for view in taken}
        self._counted = set(there)
        self._sweeps.resume(line for line in lines if line.get("image") in there)
        ends, parts = ends_of(lines), parts_of(lines)
        for place in places_of(lines):
            group = self._add_group(np.array([place.x, place.y]), place.reach)
            group.part = place.number in parts
            group.names = [name for name in place.names if name in there]
            own, end = group.taken(taken), ends.get(group.number, End())
            group.retried = end.retried
            # As the earlier run did: the last view is looked for where those before it showed it.
            group.explorer.recall(self._looked_at(group, around), own[:-1])
            if not end.why:
                continue
            if len(own) >= FEWEST_VIEWS:
                group.explorer.weigh(self._looked_at(group, around), own)
            self._end(group, end.why)
            group.offered = end.offered

    def next_stop(self, around: Around, taken: tuple[Taken, ...]) -> Chosen | Finished:
        """The next stop after the views `taken`, or why there is none."""
        self.floor.begin((around.here.x, around.here.y))
        self._said, self._here = [], None
        self._sort(taken)
        number = 1 + max((view.number for view in taken), default=0)
        ended: dict[int, End] = {}
        while True:
            kept, spot = self.kept_off(taken), (around.here.x, around.here.y)
            ways = self.floor.ways(spot, around.body, kept, around.reach.closed)
            group = self._active()
            full = len(taken) >= self._most
            if group is None and full:
                why = f"there are {len(taken)} views, as many as --max-views allows"
                return self._finished(why, around, kept, ended)
            if not taken:
                # Sonars are heard while it moves or stands to take a picture.
                first = view_on_the_way(
                    around.here, (spot, spot), number, around.reach, "first look"
                )
                return self._noted(first, ended)
            group = group or self._next_group(around, ways, kept, number, ENOUGH)
            if group is None:
                sweep = self._sweeps.next_view(around, ways, kept, number)
                if sweep is not None:
                    self._sent = sweep.stop.view.name, 0
                    return self._noted(sweep, ended)
                group = self._next_group(around, ways, kept, number, FEWEST_VIEWS)
                group = group or self._again(around, ways, taken, number)
                group = group or self._next_group(
                    around, ways, kept, number, FEWEST_VIEWS, halved=True
                )
                if group is None:
                    return self._finished("", around, kept, ended)
            found = self._view_of(group, around, ways, taken, number)
            if isinstance(found, Chosen) and not full:
                return self._noted(found, ended)
            if isinstance(found, Chosen):
                # Whoever resumes with more views goes on with it.
                self._end(group, "the views are all taken")
                continue
            self._end(group, found.reason)
            group.offered = len(self._rings(group, around, ways, taken).candidates(number))
            ended[group.number] = End(found.reason, group.offered)
            if (here := self._standing(group, around.here, taken)) is not None:
                self._here, around = here, replace(around, here=here)

    def _sort(self, taken: Sequence[Taken]) -> None:
        """Takes the view that came to its group."""
        if self._sent is None or not taken:
            return
        name, number = self._sent
        if taken[-1].name != name:
            return
        self._sent = None
        # Of a large place that was looked about from the next part is seen without another turn.
        self._sweeps.came(on_the_way=number == 0 or self.groups[number - 1].part)
        if number:
            self.groups[number - 1].names.append(name)

    def _active(self) -> Group | None:
        return next((group for group in self.groups if not group.ended), None)

    def kept_off(self, taken: Sequence[Taken]) -> tuple[KeptOff, ...]:
        """The plans of things, and how far off they are by what the robot drove since."""
        found = []
        for thing in self.things:
            sd = 0.0
            if taken:
                last, best = taken[-1], thing.best
                at = np.array([*best.pose[:2], best.high.value / 2])
                now = pose_covariance_at(at, [last.pose], last.covariance[None])
                sd = place_sd(now - best.common)
            found.append(KeptOff(thing.best.plan, sd, bool(thing.model)))
        return tuple(found)

    def _beside(self, group: Group, around: Around) -> float:
        """How far the robot's middle keeps off what is at a group's place, m."""
        return around.body + (OVERHANG if group.thing is None else CLEARANCE)

    def _looked_at(self, group: Group, around: Around) -> Around:
        """The rings round a group's thing, or its place while none is known."""
        return rings_round(group.place, group.thing, around, self._beside(group, around))

    def _rings(
        self, group: Group, around: Around, ways: FloorWays, taken: Sequence[Taken]
    ) -> Rings:
        first = group.taken(taken)[:1]
        begin = first[0].pose.centre if first else None
        off = self._beside(group, around)
        return Rings.of(group.place, group.thing, around, ways, off, begin)

    def _next_group(
        self,
        around: Around,
        ways: FloorWays,
        kept: Sequence[KeptOff],
        number: int,
        least: int,
        *,
        halved: bool = False,
    ) -> Group | None:
        """The place with an echo of which a view is nearest in time, of those of which so many
        views can be taken; `halved` with what is left of echoes that are too large for it.
        """
        best: tuple[float, Echo] | None = None
        left = list(self.floor.echoes(around.body, kept))
        while left:
            echo = left.pop(0)
            x, y = echo.middle.tolist()
            place, off = Place(0, x, y, echo.reach), around.body + OVERHANG
            views = Rings.of(place, None, around, ways, off).candidates(number)
            if len(views) < least:
                if halved and echo.reach > OVERHANG:
                    left += echo.halves()
                continue
            seconds = min(round(each.seconds, 9) for each in views)
            if seconds < (math.inf if best is None else best[0]):
                best = seconds, echo
        if best is None:
            return None
        group = self._add_group(best[1].middle, best[1].reach)
        group.part = halved
        self._said.append(f"place {group.number} at {at(group.target)} is looked at: echoes there")
        return group

    def _add_group(self, target: FloatArray, reach: float) -> Group:
        number = len(self.groups) + 1

        def judge(views: int, interest: Interest) -> ViewVerdict:
            return self._judged(self.groups[number - 1], views, interest)

        explorer = Explorer(judge, most=self._of_a_place, most_by="one place gets")
        group = Group(number, target, reach, explorer)
        self.groups.append(group)
        return group

    def _judged(self, group: Group, views: int, interest: Interest) -> ViewVerdict:
        verdict, part = self._judge(tuple(group.names[:views]), interest)
        group.thing, group.poses = thing_at(group.place, part.things), part.poses
        return verdict

    def _view_of(
        self,
        group: Group,
        around: Around,
        ways: FloorWays,
        taken: Sequence[Taken],
        number: int,
    ) -> Chosen | Finished:
        """The next view of a place, or why it gets none."""
        own = group.taken(taken)
        rings = self._rings(group, around, ways, taken)
        found = group.explorer.next_stop(rings, own, number)
        said = tuple(f"place {group.number}: {line}" for line in found.said)
        if isinstance(found, Finished):
            self._said += said
            if len(own) < FEWEST_VIEWS:
                reason = "no further view of it can be reached over floor that is known"
                return replace(found, reason=reason)
            return found
        self._sent = found.stop.view.name, group.number
        part = {"part": True} if group.part else {}
        return replace(found, line={**found.line, **group.place.to_json(), **part}, said=said)

    def _end(self, group: Group, why: str) -> None:
        """No more views of a place; where they brought no new thing it is not asked for again."""
        group.ended = why
        self._said.append(f"place {group.number} at {at(group.target)} is done: {why}")
        things = [g.thing for g in self.groups if g.thing is not None and g is not group]
        known = group.thing is not None and len(merged([*things, group.thing])[0]) == len(
            merged(things)[0]
        )
        if group.thing is None or known:
            off = self.floor.lattice.away((float(group.target[0]), float(group.target[1])))
            self.floor.asked |= off <= group.reach + _beside_what_was_asked(group)

    def _standing(self, group: Group, here: Pose2, taken: Sequence[Taken]) -> Pose2 | None:
        """Where the robot stands by the pictures of a place that it just looked at."""
        own = group.taken(taken)
        if not own or own[-1].name != taken[-1].name or own[-1].name not in group.poses:
            return None
        # Whoever resumes says where it stands; and what a view says of that counts once.
        if own[-1].name in self._counted:
            return None
        self._counted.add(own[-1].name)
        last, aligned = own[-1], group.poses[own[-1].name]
        found = standing_by_pictures(here, last, aligned)
        said = f"place {group.number}: {moved_beside(here, found)}"
        if may_be_off_so_far(last, aligned):
            self._said.append(said)
            return found
        self._said.append(f"{said}, which it cannot be: it was pushed, or something moved")
        return None

    def _again(
        self, around: Around, ways: FloorWays, taken: Sequence[Taken], number: int
    ) -> Group | None:
        """A place of which more views can be reached than when it ended: once more."""
        for group in self.groups:
            if group.settled or group.retried:
                continue
            offered = len(self._rings(group, around, ways, taken).candidates(number))
            if offered < group.offered + FEWEST_VIEWS:
                continue
            group.retried, group.ended = True, ""
            return group
        return None

    def _noted(self, found: Chosen, ended: Mapping[int, End]) -> Chosen:
        """A choice with what was said before it, and which places came to their end."""
        line = {**found.line, **ends_json(ended)}
        return replace(found, line=line, said=(*self._said, *found.said), here=self._here)

    def _finished(
        self, why: str, around: Around, kept: Sequence[KeptOff], ended: Mapping[int, End]
    ) -> Finished:
        self.reached = not why
        reason = end_of_area(why, self.area, self.floor, self.groups, self.things, around, kept)
        line = {"result": EXPLORED, "reason": reason, "undecided": [], **ends_json(ended)}
        return Finished(reason, line, tuple(self._said), self._here)


def _beside_what_was_asked(group: Group) -> float:
    """How far beside a place that was looked at echoes are those of the place, m."""
    return SIDE if group.thing is None else OVERHANG / 2
