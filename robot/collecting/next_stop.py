"""Stops that are chosen one after the other, by what the views so far show.

Who chooses knows verdicts, of which the robot knows nothing: it is given where the robot stands and
what can be taken from there, and says which view is next, or why none is.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, replace
from typing import Protocol

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.types import Camera, FloatArray
from facetlog.robot.collecting.drive import MobileBase, WayBlockedError
from facetlog.robot.collecting.plan import Reach, Stop
from facetlog.robot.collecting.record import Record, Taken
from facetlog.robot.collecting.ring_views import PLACES, Candidate, list_ring_candidates
from facetlog.robot.collecting.route import Circle
from facetlog.robot.collecting.session import BLOCKED, Listener
from facetlog.robot.collecting.steering import Pace
from facetlog.robot.head.head import HeadLimits
from facetlog.robot.mount.mount import Mount
from facetlog.robot.pose2 import Pose2

CHOSEN, EXPLORED = "chosen", "explored"
"""What a line of collect.jsonl about a choice has as its `result`, and one about the last."""


OUTSIDE = 0.01
"""Metres that a robot which found its way blocked stands outside of what it then keeps out of."""


@dataclass(frozen=True, eq=False, slots=True)
class Around:
    """The rings round a target (3,), for a robot at `here`: see `list_ring_candidates`."""

    target: FloatArray
    radius: float
    first: float
    reach: Reach
    pace: Pace
    here: Pose2

    def candidates(self, number: int) -> tuple[Candidate, ...]:
        """Return the views that can be taken from here, as view `number`."""
        return list_ring_candidates(
            self.target, self.radius, self.first, number, self.here, self.reach, self.pace
        )

    def enlarge_keep_out(self, margin: float) -> "Around":
        """Return the rings with radius and keep-out circles larger by a margin, m."""
        closed = tuple(circle.grown(margin) for circle in self.reach.closed)
        reach = replace(self.reach, closed=closed)
        return replace(self, radius=self.radius + margin, reach=reach)

    def to_json(self) -> Mapping[str, object]:
        """Return what the first line of collect.jsonl says of it; metres, radians."""
        limits, mount, camera = self.reach.limits, self.reach.mount, self.reach.camera
        return {
            "target": self.target.tolist(),
            "radius": self.radius,
            "first": self.first,
            "closed": [astuple(circle) for circle in self.reach.closed],
            "pace": [self.pace.speed, self.pace.turning],
            "here": astuple(self.here),
            "mount": [mount.values, mount.sds],
            "camera": astuple(camera),
            "head": [
                [limits.pan_min, limits.pan_max],
                [limits.tilt_min, limits.tilt_max],
                [limits.pan_step, limits.tilt_step],
                limits.zoom_max,
            ],
        }

    @classmethod
    def from_json(cls, about: object) -> "Around":
        """Read the output of `to_json`; InputError if it is something else."""
        try:
            if not isinstance(about, dict):
                raise TypeError("it is no object")
            values, sds = (tuple(map(float, each)) for each in about["mount"])
            pan, tilt, step, zoom = about["head"]
            limits = HeadLimits(pan[0], pan[1], tilt[0], tilt[1], step[0], step[1], zoom)
            mount = Mount(sds=sds).replace_values(values)
            closed = tuple(Circle(*map(float, each)) for each in about["closed"])
            width, height, fx, fy, cx, cy = about["camera"]
            camera = Camera(width, height, fx, fy, cx, cy)
            reach = Reach(mount, limits, camera, closed)
            return cls(
                np.array(about["target"], dtype=np.float64).reshape(3),
                float(about["radius"]),
                float(about["first"]),
                reach,
                Pace(*map(float, about["pace"])),
                Pose2(*map(float, about["here"])),
            )
        except (KeyError, TypeError, ValueError) as exc:
            raise InputError(
                "collect.jsonl does not say how its target was explored: give a folder that was "
                "collected by --explore"
            ) from exc

    @classmethod
    def recorded(cls, lines: Sequence[Mapping[str, object]]) -> "Around":
        """Return the rings of the last run in collect.jsonl, which keep out of what blocked its way
        too; InputError where it was none that explored.
        """
        found: object = None
        blocked: list[object] = []
        for line in lines:
            if "explore" in line:
                found, blocked = line["explore"], []
            elif line.get("result") == BLOCKED:
                blocked.append(line.get("closed"))
        if isinstance(found, dict) and isinstance(closed := found.get("closed"), list):
            found = {**found, "closed": [*closed, *blocked]}
        return cls.from_json(found)


@dataclass(frozen=True, eq=False, slots=True)
class Chosen:
    """The next stop; `line` goes to collect.jsonl, `said` to the listener."""

    stop: Stop
    line: Mapping[str, object]
    said: tuple[str, ...]


@dataclass(frozen=True, eq=False, slots=True)
class Finished:
    """Why there is no next stop; else as `Chosen`."""

    reason: str
    line: Mapping[str, object]
    said: tuple[str, ...]


class Chooser(Protocol):
    """Chooses the next view."""

    @property
    def most(self) -> int:
        """The most views of the whole collection."""

    def next_stop(self, around: Around, taken: tuple[Taken, ...]) -> Chosen | Finished:
        """Return the next stop after the views `taken`, or why there is none."""


class ChosenStops:
    """The stops that a chooser chooses, each when it is asked for; `reason` is why they ended.

    They are at most as many as the chooser takes beside those that are in the record already. They
    and their ways keep off by one standard deviation more of where the robot stands. `wide` is the
    radius of the circle for the robot's middle about what blocks its way, m; it is blocked as often
    as there are places round the target before that ends the collection.
    """

    def __init__(
        self,
        chooser: Chooser,
        around: Around,
        base: MobileBase,
        record: Record,
        listener: Listener,
        *,
        wide: float = 0.0,
    ) -> None:
        self._chooser, self._around, self._base = chooser, around, base
        self._wide, self._detours = wide, PLACES
        self._record, self._listener = record, listener
        self._most = max(chooser.most - len(record.taken), 0)
        self.closed = around.reach.closed
        """What the way to the last stop keeps out of."""
        self.reason = ""

    def __len__(self) -> int:
        return self._most

    def avoid(self, fault: WayBlockedError) -> Circle | None:
        """Return the circle about what blocks the way, of which later stops and their ways keep
        out.

        None where it is not known, or when the robot has found its way blocked all round.
        """
        if fault.at is None or self._detours == 0:
            return None
        self._detours -= 1
        here = self._base.place(self._base.state)
        # It stands outside, by as much as a route's end may be off.
        radius = min(self._wide, math.dist((here.x, here.y), fault.at) - OUTSIDE)
        circle = Circle(*fault.at, max(radius, 0.0))
        reach = self._around.reach
        closed = (*reach.closed, circle)
        self._around = replace(self._around, reach=replace(reach, closed=closed))
        return circle

    def __iter__(self) -> Iterator[Stop]:
        while True:
            here = self._base.place(self._base.state)
            margin = place_sd(self._base.state.covariance)
            around = replace(self._around.enlarge_keep_out(margin), here=here)
            self.closed = around.reach.closed
            found = self._chooser.next_stop(around, self._record.taken)
            self._record.note(found.line)
            for line in found.said:
                self._listener.note(line)
            if isinstance(found, Finished):
                # Said with the result, when the robot has stopped.
                self.reason = found.reason
                return
            yield found.stop


def place_sd(covariance: FloatArray) -> float:
    """Return the standard deviation of a place (x, y) in the direction in which it is largest, m,
    of its covariance (2 or more, 2 or more).
    """
    return math.sqrt(max(float(np.linalg.eigvalsh(covariance[:2, :2])[-1]), 0.0))


def measure_mount_reach(mount: Mount) -> float:
    """Return how far from the robot's middle the pinhole may be, metres on the floor or more."""
    return math.hypot(mount.x, mount.y) + math.hypot(
        mount.pinhole_ahead, mount.pinhole_left, mount.pinhole_up
    )
