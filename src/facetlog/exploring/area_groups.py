"""Places of an area that are looked at, each with views of its own, and what they showed."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from facetlog.exploring.explorer import Explorer
from facetlog.exploring.floor_ways import FloorWays
from facetlog.mapping.anchored import covariances_beside_first
from facetlog.mapping.place import Place
from facetlog.mapping.placed_thing import PlacedThing
from facetlog.perception.types import FloatArray, Pose
from facetlog.robot.collecting.next_stop import Around, reach_of_mount
from facetlog.robot.collecting.plan import Reach
from facetlog.robot.collecting.record import Taken
from facetlog.robot.collecting.ring_views import Candidate, bearing, turns_along
from facetlog.robot.collecting.route import route_length

__all__ = ["End", "Group", "Rings", "ends_json", "ends_of", "parts_of", "reach_of", "rings_round"]

# How far off views are taken beyond the outermost point, for the height of the pinhole: the paper's
# tour sees its block so steeply, and a thing of a metre is whole in the picture.
AWAY_PER_HEIGHT = 0.83
# Room between the inner ring and what the robot's middle keeps out of, m: how far its stops may be
# off, and a cell.
ROOM = 0.15
# What is looked at first of a thing of which only an echo is known: a share of the pinhole's
# height, at which pictures show the floor before it and its top.
AIMED_AT = 0.25


@dataclass(eq=False, slots=True)
class Group:
    """A place that is looked at: its number, `target` (2,) and how far what is there reaches, m.

    `names` are its views, `thing` is what they show there, `poses` those of its views as aligned by
    what all show. `ended` says why there are no more: then
    so many views were `offered`, as could be reached. It is `settled` where its verdict cannot
    change, and `part` of a place that was too large.
    """

    number: int
    target: FloatArray
    reach: float
    explorer: Explorer
    names: list[str] = field(default_factory=list)
    thing: PlacedThing | None = None
    poses: Mapping[str, Pose] = field(default_factory=dict)
    ended: str = ""
    offered: int = 0
    retried: bool = False
    part: bool = False

    @property
    def settled(self) -> bool:
        """Whether its verdict is."""
        return self.explorer.settled

    def taken(self, views: Sequence[Taken]) -> tuple[Taken, ...]:
        """Its views, whose poses are as sure as beside the first of them."""
        own = [view for view in views if view.name in set(self.names)]
        covs = np.array([view.covariance for view in own]).reshape(-1, 6, 6)
        beside = covariances_beside_first([view.pose for view in own], covs)
        return tuple(replace(view, covariance=cov) for view, cov in zip(own, beside, strict=True))

    @property
    def place(self) -> Place:
        """As collect.jsonl and the map have it."""
        x, y = self.target.tolist()
        return Place(self.number, x, y, self.reach, tuple(self.names))


@dataclass(frozen=True, eq=False, slots=True)
class Rings:
    """The views of a group's target from rings round it, by ways over known floor."""

    around: Around
    ways: FloorWays

    @property
    def target(self) -> FloatArray:
        """What is looked at (3,)."""
        return self.around.target

    @property
    def radius(self) -> float:
        """That of the inner ring, m."""
        return self.around.radius

    @property
    def reach(self) -> Reach:
        """Mount, head and camera."""
        return self.around.reach

    @classmethod
    def of(
        cls,
        place: Place,
        thing: PlacedThing | None,
        around: Around,
        ways: FloorWays,
        beside: float,
        begin: FloatArray | None = None,
    ) -> "Rings":
        """Those of a place, round the thing if one is known; the robot's middle keeps `beside` (m)
        off what is there. They begin at the bearing of `begin` (2 or more,), else of the robot.
        """
        return cls(rings_round(place, thing, around, beside, begin), ways)

    def candidates(self, number: int) -> tuple[Candidate, ...]:
        """Those that can be reached, as view `number`: by a way no longer than half round the inner
        ring, for odometry drifts, and what lies between is known sooner from elsewhere.
        """
        found = []
        pace, here = self.around.pace, self.around.here
        for each in self.around.candidates(number):
            there = each.stop.robot
            route = self.ways.route_to((there.x, there.y))
            if route is None or route_length(route) > math.pi * self.radius:
                continue
            way, turns = route_length(route), turns_along(route, here, there)
            longer = (way - each.way) / pace.speed + (turns - each.turns) / pace.turning
            stop = replace(each.stop, route=route)
            seconds = each.seconds + longer
            found.append(replace(each, stop=stop, way=way, turns=turns, seconds=seconds))
        return tuple(found)


def rings_round(
    place: Place,
    thing: PlacedThing | None,
    around: Around,
    beside: float,
    begin: FloatArray | None = None,
) -> Around:
    """The rings of `Rings.of`, whatever can be reached."""
    mount, here = around.reach.mount, around.here
    if thing is None:
        target, out = np.array([place.x, place.y, AIMED_AT * mount.z]), place.reach
    else:
        target, out = np.array([*thing.pose[:2], thing.high.value / 2]), reach_of(thing)
    off = max(beside + ROOM + reach_of_mount(mount), AWAY_PER_HEIGHT * mount.z)
    return replace(
        around,
        target=target,
        radius=out + off,
        first=bearing(target, (here.x, here.y) if begin is None else begin),
        reach=replace(around.reach, closed=()),
    )


@dataclass(frozen=True, slots=True)
class End:
    """Why a place gets no more views, empty while it does, and how many were `offered` then.

    `retried` is one that got more after it had ended.
    """

    why: str = ""
    offered: int = 0
    retried: bool = False


def ends_json(ends: Mapping[int, End]) -> Mapping[str, object]:
    """The places that ended, as part of a line of collect.jsonl."""
    if not ends:
        return {}
    return {
        "ended": {str(number): end.why for number, end in ends.items()},
        "offered": {str(number): end.offered for number, end in ends.items()},
    }


def ends_of(lines: Iterable[Mapping[str, object]]) -> Mapping[int, End]:
    """How it ended, by the number of the place, as the lines of collect.jsonl say in their order;
    older ones do not say what was offered.
    """
    ends: dict[int, End] = {}
    for line in lines:
        match line:
            case {"ended": dict() as ended}:
                offers = line.get("offered")
                for key, why in ended.items():
                    offered = offers.get(key) if isinstance(offers, dict) else None
                    number, there = int(key), offered if isinstance(offered, int) else 0
                    ends[number] = End(str(why), there, retried=number in ends)
        match line:
            case {"looks_at": int() as number} if number in ends:
                ends[number] = End(retried=True)
    return ends


def parts_of(lines: Iterable[Mapping[str, object]]) -> frozenset[int]:
    """The numbers of the places that are parts of larger ones, by the lines of collect.jsonl."""
    return frozenset(
        number
        for line in lines
        if line.get("part") and isinstance(number := line.get("looks_at"), int)
    )


def reach_of(thing: PlacedThing) -> float:
    """From the middle of a thing's plan to its farthest point, m."""
    return float(np.linalg.norm(thing.outline - thing.pose[:2], axis=1).max())
