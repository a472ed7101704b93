"""Does a robot that explores a room by itself find each thing once, name it, and touch nothing?

The rooms of accuracy_map, of which it knows the area alone. It begins in a corner and drives by the
code that drives a real one (`facetlog collect --explore --area`), with the wheels' errors, sonars
and contacts of the simulated robot, in simulated time (room_robot.py): every echo, slip and blocked
way is one that such a robot has. Its mast is of 1.45 m. Where it believes to be drifts as odometry
does, by half a metre at the end of a room, and so do the things that it finds there: each counts as
the true thing that is nearest to it, if that is within half the gap between two.
"""

import math
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import shapely

from benchmarks.common import Cell, Report, Settings, Table
from benchmarks.knowledge.calibration_scenes import world_truth
from benchmarks.processes import spread
from benchmarks.robot.accuracy_map import MAST, NOISE, off_truth, within_gate
from benchmarks.robot.room_robot import KIND, RoomCamera, RoomHead, RoomRobot
from benchmarks.robot.rooms import APART, Room, make_room
from facetlog.exploring.area import AreaExplorer
from facetlog.exploring.area_judge import place_verdict
from facetlog.exploring.needs import Interest
from facetlog.mapping.room_map import ScenePart
from facetlog.mapping.same_thing import MappedThing
from facetlog.pipeline import open_models
from facetlog.robot.camera.optics import Optics
from facetlog.robot.collecting.drive import MobileBase
from facetlog.robot.collecting.keep_out import CLEARANCE
from facetlog.robot.collecting.next_stop import MOST_DRIFT, Around, ChosenStops
from facetlog.robot.collecting.plan import Reach
from facetlog.robot.collecting.record import Record, Taken
from facetlog.robot.collecting.session import Ended, Rig, collect
from facetlog.robot.collecting.steering import Pace
from facetlog.robot.collecting.way_ahead import Body
from facetlog.robot.mount.mount import DEFAULT_MOUNT, PARAMETERS
from facetlog.robot.pose2 import Pose2
from facetlog.robot.simulator.body.dynamics import MotionErrors
from facetlog.robot.tour import tour_camera
from facetlog.view_verdicts import ViewVerdict

__all__ = ["NAME", "Outcome", "explored_room", "measure", "report"]

NAME = "accuracy_area"
SEEDS = 7
MOST = 120
# Where it begins, from the lowest corner of the area, m.
CORNER = 1.1


@dataclass(frozen=True, eq=False, slots=True)
class Outcome:
    """What one room came to: of each true thing how many were found, `extra` ones, and of those
    that were found once how far off they are in standard deviations and in metres.

    `named` have a right name, `misnamed` a wrong one; `nearest` is how near the rim of the robot
    came to a thing's plan (m), which a table's top may overhang; `touched` is whether its body met
    anything of its height, or its mast came beneath a top. `known` is the share of the area's floor
    that sonars reached, `end` why it ended.
    """

    seed: int
    sightings: tuple[int, ...]
    extra: int
    distances: tuple[float, ...]
    off: tuple[float, ...]
    named: int
    misnamed: int
    views: int
    metres: float
    nearest: float
    touched: bool
    known: float
    end: str

    @property
    def within(self) -> int:
        """How many poses are right by the gate of 3 standard deviations."""
        return within_gate(self.distances)


def measure(settings: Settings) -> Report:
    """All rooms over the seeds."""
    seeds = settings.seeds(SEEDS)
    return report(spread(explored_room, seeds), seeds)


def report(outcomes: Sequence[Outcome], seeds: range) -> Report:
    """The tables of some rooms."""
    return Report(
        NAME,
        (
            Table("All rooms", (_row("all", outcomes),)),
            Table("Each room", tuple(_row(str(each.seed), [each]) for each in outcomes)),
            Table(
                "How each ended", tuple({"room": each.seed, "end": each.end} for each in outcomes)
            ),
        ),
        {"seeds": len(seeds), "first seed": seeds.start, "most views": MOST},
        (
            "once: exactly one thing that was found is nearest to it; extra: those that are near "
            "none.",
            "within 3 sd: of x, y and heading together, 99.73% by chi-square; what odometry drifts "
            "by is in these standard deviations.",
            "nearest: of the robot's rim to the plan of a thing; touched: rooms in which its body "
            "met anything, or its mast came beneath a top.",
            "Rooms 0 to 2, 4, 8 to 10, 13, 14, 17 and 21 were looked at while it was made, others "
            "were not.",
        ),
    )


def _row(room: str, outcomes: Sequence[Outcome]) -> dict[str, Cell]:
    things = sum(len(each.sightings) for each in outcomes)
    once = sum(each.sightings.count(1) for each in outcomes)
    off = [o for each in outcomes for o in each.off]
    return {
        "room": room,
        "things": things,
        "once": once,
        "missed": sum(each.sightings.count(0) for each in outcomes),
        "extra": sum(each.extra for each in outcomes),
        "within 3 sd": f"{sum(each.within for each in outcomes)} of {once}",
        "off, cm": round(100 * float(np.median(off)), 1) if off else None,
        "named": f"{sum(each.named for each in outcomes)} of {things}",
        "misnamed": sum(each.misnamed for each in outcomes),
        "views": sum(each.views for each in outcomes),
        "metres": round(sum(each.metres for each in outcomes), 1),
        "nearest, m": round(float(min(each.nearest for each in outcomes)), 2),
        "touched": sum(each.touched for each in outcomes),
        "floor": f"{np.mean([each.known for each in outcomes]):.0%}",
    }


class _Silent:
    """Listens to nothing."""

    def view_taken(self, done: int, total: int, view: Taken) -> None:
        """Nothing."""

    def warn(self, message: str) -> None:
        """Nothing."""

    def note(self, message: str) -> None:
        """Nothing."""

    def ended_early(self, ended: Ended, there: int, total: int) -> None:
        """Nothing."""


def explored_room(seed: int) -> Outcome:
    """The room of a seed, explored."""
    room = make_room(seed)
    x, y, *_ = room.area
    start = Pose2(x + CORNER, y + CORNER, 0.8)
    robot = RoomRobot(room, start, MotionErrors.usual(skids=False), seed)
    head = RoomHead(robot)
    values = dict(zip(PARAMETERS, DEFAULT_MOUNT.values, strict=True)) | {"z": MAST}
    mount = DEFAULT_MOUNT.with_values(tuple(values.values()))
    camera = RoomCamera(room, robot, head, mount, seed, NOISE)
    optics, pace = Optics(tour_camera()), Pace()
    reach = Reach(mount, head.limits, optics.camera)
    around = Around(np.zeros(3), 0.0, 0.0, reach, pace, start, KIND.radius)
    with tempfile.TemporaryDirectory() as kept, open_models() as models:
        folder = Path(kept) / "views"

        def judge(names: tuple[str, ...], interest: Interest) -> tuple[ViewVerdict, ScenePart]:
            found = place_verdict(folder, names, interest, models)
            return found.verdict, found.part

        explorer = AreaExplorer(judge, room.area, most=MOST)
        record = Record(folder, optics, {"tour": "area"})
        body = Body(KIND.radius, KIND.width)
        base = MobileBase(robot, start, pace=pace, heard=explorer.heard, body=body)
        rig = Rig(base, head, camera, optics, reach, 0.0)
        stops = ChosenStops(
            explorer,
            around,
            base,
            record,
            _Silent(),
            wide=KIND.radius + CLEARANCE,
            detours=MOST,
            drift=MOST_DRIFT,
        )
        ended = collect(rig, stops, record, _Silent(), guide=stops)
    end = stops.reason if ended.fault is None else str(ended.fault)
    return _outcome(seed, room, explorer, robot, ended.taken, end)


def _outcome(
    seed: int, room: Room, explorer: AreaExplorer, robot: RoomRobot, views: int, end: str
) -> Outcome:
    standing: list[list[MappedThing]] = [[] for _ in room.things]
    extra = 0
    for thing in explorer.things:
        apart = [shapely.distance(thing.best.plan, true.plan) for true in room.things]
        if min(apart) < APART / 2:
            standing[int(np.argmin(apart))].append(thing)
        else:
            extra += 1
    distances, off = [], []
    truths = []
    for true, found in zip(room.things, standing, strict=True):
        if found:
            truths.append(world_truth(true.kind, found[0].model) if found[0].model else None)
        if len(found) == 1:
            distance, (metres, _) = off_truth(true, found[0])
            distances.append(distance)
            off.append(metres)
    path = [(place.x, place.y) for place in robot.path]
    line = shapely.LineString(path)
    plans = shapely.union_all([true.plan for true in room.things])
    floor = explorer.floor
    unseen = floor.area_of(floor.unseen(KIND.radius, explorer.kept_off(())))
    return Outcome(
        seed,
        tuple(map(len, standing)),
        extra,
        tuple(distances),
        tuple(off),
        truths.count(True),
        truths.count(False),
        views,
        sum(math.dist(a, b) for a, b in pairwise(path)),
        shapely.distance(line, plans) - KIND.radius,
        robot.touched or bool(shapely.intersects(line, plans)),
        1.0 - unseen / (room.area[2] * room.area[3]),
        end,
    )
