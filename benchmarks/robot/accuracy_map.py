"""Is each thing of a room on the map once, where it is, and as what it is?

Rooms with four to eight boxes, tables, chairs, stools and desks of real size, which a robot with a
mast of 1.45 m visits twice. On the first visit it drives round each thing for twelve views, on the
second for eight of every other thing, from another start. It is simulated without a clock: views
are rendered from where it truly is, and its odometry drifts by .2° and .4 % of the way from view to
view, as that of the simulated robot. Poses are those of odometry, with its covariance; the map
corrects and merges what the views show. The tours know where things are; what they are and where
is found anew.
"""

import math
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely
from scipy.stats import chi2

from benchmarks.common import Cell, Report, Settings, Table
from benchmarks.knowledge.calibration_scenes import get_world_truth
from benchmarks.processes import spread
from benchmarks.robot.rooms import Room, TrueThing, make_room
from facetlog.mapping.floor_grid import Cell as FloorCell
from facetlog.mapping.room_map import RoomMap, build_room_map
from facetlog.mapping.same_thing import MappedThing
from facetlog.perception.types import Pose, View
from facetlog.pipeline import open_models
from facetlog.robot.camera.checks import Quality
from facetlog.robot.camera.optics import Optics
from facetlog.robot.collecting.plan import Reach, Stop, stop_for
from facetlog.robot.collecting.record import WAY_FILE, Record, Taken, format_robot_tum
from facetlog.robot.collecting.route import Circle, Route, find_shortest_route, measure_route
from facetlog.robot.collecting.tour_file import TourView
from facetlog.robot.head.sony_models import EVI_D30
from facetlog.robot.mount.kinematics import camera_pose, stand_for
from facetlog.robot.mount.mount import DEFAULT_MOUNT, PARAMETERS
from facetlog.robot.pose2 import Pose2
from facetlog.robot.rendering.views import add_drift, views_of
from facetlog.robot.rendering.worlds import INCH
from facetlog.robot.tour import tour_camera

NAME = "accuracy_map"
SEEDS = 20
# Views of each thing on the two visits: the second one looks at every other thing.
FIRST, SECOND = 12, 8
# The height of the pinhole, m: a table's top is seen from above.
MAST = 1.45
# The robot's radius and what its routes keep clear besides, m.
RADIUS, CLEAR = 0.25, 0.1
# From the outermost point of a thing to the pinholes that look at it, m.
AWAY = 1.2
# Errors of odometry from view to view: the simulated robot's wheels go .2 and .3 % too far, which
# is .17° and .25 % of the way after a metre; and somewhat more for what is not systematic.
TURN_SD, WAY_SD = math.radians(0.2), 0.004
# Grey levels of a camera's noise, as the simulator's camera has.
NOISE = 3.0
GATE_SHARE = 0.9973


@dataclass(frozen=True, eq=False, slots=True)
class Outcome:
    """What the map of one room came to, with the robot's ways in metres.

    `sightings` count for each true thing how many of the map's are it; `distances` are those of the
    poses of the ones that are there once, in standard deviations (three numbers), `errors` metres
    and radians of these; `nearest` is how near the robot's rim came to a thing.
    """

    seed: int
    sightings: tuple[int, ...]
    extra: int
    distances: tuple[float, ...]
    errors: tuple[tuple[float, float], ...]
    named: int
    views: int
    metres: float
    nearest: float
    wrongly_free: float
    """The share of the things' plans that the map says is free."""

    @property
    def within(self) -> int:
        """How many poses are right by the gate of 3 standard deviations."""
        return count_within_gate(self.distances)


def count_within_gate(distances: Sequence[float]) -> int:
    """Return how many of these, of poses in standard deviations, are within the gate of 3."""
    return sum(d <= math.sqrt(float(chi2.ppf(GATE_SHARE, 3))) for d in distances)


def measure(settings: Settings) -> Report:
    """Measure all rooms over the seeds."""
    seeds = settings.seeds(SEEDS)
    return report(spread(outcome, seeds), seeds)


def report(outcomes: Sequence[Outcome], seeds: range) -> Report:
    """Return the tables of some rooms."""
    total = _row("all", outcomes)
    return Report(
        NAME,
        (
            Table("All rooms", (total,)),
            Table("Each room", tuple(_row(str(each.seed), [each]) for each in outcomes)),
        ),
        {
            "seeds": len(seeds),
            "first seed": seeds.start,
            "views of a thing": f"{FIRST} and {SECOND}",
        },
        (
            "once: exactly one thing of the map stands in it; extra: the map's that stand in none.",
            "within 3 sd: of x, y and heading together, 99.73% by chi-square.",
            "named: the name that stands first is one of the thing's.",
        ),
    )


def _row(room: str, outcomes: Sequence[Outcome]) -> dict[str, Cell]:
    things = sum(len(each.sightings) for each in outcomes)
    once = sum(each.sightings.count(1) for each in outcomes)
    errors = np.array([e for each in outcomes for e in each.errors]).reshape(-1, 2)
    squares = [d * d for each in outcomes for d in each.distances]
    return {
        "room": room,
        "things": things,
        "once": once,
        "missed": sum(each.sightings.count(0) for each in outcomes),
        "extra": sum(each.extra for each in outcomes),
        "within 3 sd": f"{sum(each.within for each in outcomes)} of {once}",
        "NEES / 3": round(float(np.median(squares)) / 3, 2) if squares else None,
        "off, cm": round(100 * float(np.median(errors[:, 0])), 1) if len(errors) else None,
        "off, deg": round(math.degrees(float(np.median(errors[:, 1]))), 1) if len(errors) else None,
        "named": f"{sum(each.named for each in outcomes)} of {things}",
        "views": sum(each.views for each in outcomes),
        "metres": round(sum(each.metres for each in outcomes), 1),
        "nearest, m": round(float(min(each.nearest for each in outcomes)), 2),
        "wrongly free": f"{np.mean([each.wrongly_free for each in outcomes]):.1%}",
    }


class _Drive:
    """A robot without a clock in a room: where it was sent, and what it saw there."""

    def __init__(self, room: Room, start: Pose2) -> None:
        self._room, self._here = room, start
        values = dict(zip(PARAMETERS, DEFAULT_MOUNT.values, strict=True)) | {"z": MAST}
        closed = tuple(
            Circle(*thing.box.values[:2].tolist(), thing.reach + RADIUS + CLEAR)
            for thing in room.things
        )
        mount = DEFAULT_MOUNT.replace_values(tuple(values.values()))
        self._reach = Reach(mount, EVI_D30.limits, tour_camera(), closed)
        self.poses: list[Pose] = []
        self.routes: list[Route] = []
        self.metres = 0.0
        self.nearest = math.inf

    def round(self, number: int, count: int) -> None:
        """Drive round a thing, for so many views as even as those that can be reached."""
        thing = self._room.things[number]
        first = math.atan2(self._here.y - thing.middle[1], self._here.x - thing.middle[0])
        wanted = [first + math.tau * k / count for k in range(count)]
        for angle in wanted:
            stop = self._stop(thing, angle)
            if stop is not None:
                self._go(stop)

    def _stop(self, thing: TrueThing, angle: float) -> Stop | None:
        """Return the view of a thing from that bearing, if it can be taken."""
        away = thing.reach + AWAY
        x, y = (thing.middle[:2] + away * np.array([math.cos(angle), math.sin(angle)])).tolist()
        mount, number = self._reach.mount, len(self.poses) + 1
        robot, gaze = stand_for((x, y), angle + math.pi, mount, thing.middle)
        view = TourView(f"view{number:03d}.png", camera_pose(robot, mount, gaze))
        stop = stop_for(number, view, thing.middle, self._here, (), self._reach)
        return stop if isinstance(stop, Stop) else None

    def _go(self, stop: Stop) -> None:
        there = stop.robot
        ends = (self._here.x, self._here.y), (there.x, there.y)
        route = find_shortest_route(*ends, self._reach.closed)
        assert route is not None
        way = shapely.LineString(route if len(route) > 1 else [*route, *route])
        for thing in self._room.things:
            self.nearest = min(self.nearest, shapely.distance(way, thing.plan) - RADIUS)
        self.metres += measure_route(route)
        self.routes.append(route)
        self._here = there
        self.poses.append(camera_pose(there, self._reach.mount, stop.gaze))

    def write(self, folder: Path, seed: int) -> None:
        """Write the collection that it made, with poses as odometry has them."""
        small = [Pose(pose.rotation, pose.centre / INCH) for pose in self.poses]
        seen = views_of(self._room.world, small, tour_camera(), seed=seed, noise_sd=NOISE)
        true = [
            View(view.name, view.image, view.camera, pose)
            for view, pose in zip(seen, self.poses, strict=True)
        ]
        rng = np.random.default_rng([seed, len(true)])
        views, covs = add_drift(true, rng, turn_sd=TURN_SD, way_sd=WAY_SD)
        about = {"tour": "room", "start": [0.0, 0.0, 0.0], "start_stated": True}
        record = Record(folder, Optics(tour_camera()), about)
        way = []
        for number, (view, cov) in enumerate(zip(views, covs, strict=True), start=1):
            x, y = view.pose.centre[:2].tolist()
            ahead = view.pose.rotation[:, 2]
            robot = Pose2(x, y, math.atan2(ahead[1], ahead[0]))
            at, sharp = 1e9 + 10.0 * number, Quality(1.0, 1.0, 0.0)
            taken = Taken(number, view.name, view.pose, cov, robot, robot, 0, 0, 0, at, sharp)
            record.add(taken, view.image)
            # Its way as odometry has it: off by as much as where it ends.
            off = view.pose.centre - self.poses[number - 1].centre
            way += [
                (at - 1.0, Pose2(px + float(off[0]), py + float(off[1]), robot.heading))
                for px, py in self.routes[number - 1]
            ]
        (folder / WAY_FILE).write_text(format_robot_tum(way), encoding="utf-8")


def outcome(seed: int) -> Outcome:
    """Return the room of a seed, visited twice and mapped."""
    room = make_room(seed)
    x, y, width, height = room.area
    starts = Pose2(x, y, 0.8), Pose2(x + width, y + height, -2.0)
    every = range(len(room.things))
    plans = (every, FIRST), (every[::2], SECOND)
    drives = []
    with tempfile.TemporaryDirectory() as kept, open_models() as base:
        folders = []
        for visit, (start, (numbers, count)) in enumerate(zip(starts, plans, strict=True)):
            drive = _Drive(room, start)
            for number in _order_nearest_first(room, start, numbers):
                drive.round(number, count)
            folders.append(Path(kept) / f"visit{visit + 1}")
            drive.write(folders[-1], 2 * seed + visit)
            drives.append(drive)
        return _outcome(seed, room, build_room_map(folders, base), drives)


def _order_nearest_first(room: Room, start: Pose2, numbers: range) -> list[int]:
    """Return the things in the order in which each is the nearest to the one before."""
    left, order = list(numbers), []
    here = np.array([start.x, start.y])
    while left:
        off = [float(np.linalg.norm(room.things[k].middle[:2] - here)) for k in left]
        order.append(left.pop(int(np.argmin(off))))
        here = room.things[order[-1]].middle[:2]
    return order


def _outcome(seed: int, room: Room, found: RoomMap, drives: Sequence[_Drive]) -> Outcome:
    standing: list[list[MappedThing]] = [[] for _ in room.things]
    extra = 0
    for thing in found.things:
        shared = [compute_shared_plan(thing, true) for true in room.things]
        if max(shared) > 0.5:
            standing[int(np.argmax(shared))].append(thing)
        else:
            extra += 1
    distances, errors, named = [], [], 0
    for true, mapped in zip(room.things, standing, strict=True):
        if mapped:
            named += get_world_truth(true.kind, mapped[0].model) is True
        if len(mapped) == 1:
            distance, off = measure_pose_error(true, mapped[0])
            distances.append(distance)
            errors.append(off)
    plans = shapely.union_all([true.plan for true in room.things])
    inside = shapely.contains_xy(plans, *np.moveaxis(found.floor.middles, -1, 0))
    free = found.floor.cells == FloorCell.FREE
    return Outcome(
        seed,
        tuple(map(len, standing)),
        extra,
        tuple(distances),
        tuple(errors),
        named,
        len(found.taken),
        sum(drive.metres for drive in drives),
        min(drive.nearest for drive in drives),
        float((free & inside).sum() / max(int(inside.sum()), 1)),
    )


def compute_shared_plan(thing: MappedThing, true: TrueThing) -> float:
    """Return which share of the lesser plan lies within the other."""
    plan = thing.best.plan.buffer(0.01)
    least = min(plan.area, true.plan.area)
    return float(shapely.intersection(plan, true.plan).area / least)


def measure_pose_error(true: TrueThing, mapped: MappedThing) -> tuple[float, tuple[float, float]]:
    """Return the distance of a pose from the true one in standard deviations, and in m and
    radians.
    """
    best = mapped.best
    alike = min(best.box.turns_alike, true.box.turns_alike)
    apart = best.pose - true.box.values[:3]
    apart[2] = math.remainder(float(apart[2]), alike)
    distance = float(np.sqrt(apart @ np.linalg.solve(best.cov, apart)))
    return distance, (float(np.hypot(*apart[:2])), abs(float(apart[2])))
