"""A robot that explores a target in simulated time, and who judges its views in a test."""

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from facetlog.commands.robot_words import format_early_end
from facetlog.exploring.explorer import Explorer, Judge
from facetlog.exploring.open_questions import Lead, Needs, Open
from facetlog.judging.view_verdicts import ViewVerdict
from facetlog.mapping.sonar_beams import FARTHEST
from facetlog.perception.types import Image
from facetlog.robot.camera.optics import Optics
from facetlog.robot.collecting.drive import Body, MobileBase
from facetlog.robot.collecting.next_stop import Around, ChosenStops
from facetlog.robot.collecting.plan import Reach
from facetlog.robot.collecting.record import LOG_FILE, Record, Taken, read_log, read_record
from facetlog.robot.collecting.ring_views import bearing
from facetlog.robot.collecting.route import Circle, measure_distance_to
from facetlog.robot.collecting.session import Ended, Rig, collect, record_end
from facetlog.robot.collecting.steering import Pace
from facetlog.robot.head.head import HeadState
from facetlog.robot.mount.mount import DEFAULT_MOUNT
from facetlog.robot.pioneer.parameters import find_parameters
from facetlog.robot.pioneer.state import SonarRange
from facetlog.robot.pose2 import Pose2
from facetlog.robot.tour import tour_camera
from tests.robot.collecting.fakes import SONY, FakeCamera, FakeHead, FakeRobot, FakeState

TARGET = np.array([1.5, 0.0, 0.08])
FORBIDDEN = (Circle(1.5, 0.0, 0.75),)
OPTICS = Optics(tour_camera())
REACH = Reach(DEFAULT_MOUNT, SONY, OPTICS.camera, (FORBIDDEN[0].grown(0.03),))
START = Pose2(0.1, 0.2, 0.3)
CHEQUER = np.kron(np.indices((12, 16)).sum(axis=0) % 2, np.ones((40, 40))) * 160 + 40
OPEN = Needs.of_nothing(TARGET)
ROBOT = find_parameters("p3dx")


def led(degree: float, wrong: float = 0.0) -> Needs:
    """A table of some degree, of which one condition is open; it is wrong so probably."""
    opened = (Open("", "table", 0.5), Open("", "desk", assumed=wrong, likely=wrong))
    return Needs(opened, OPEN.things, Lead("", "table", {"table": degree}))


def all_open(views: int) -> ViewVerdict:
    """Whatever was seen, all of the target is open."""
    return ViewVerdict(views, needs=OPEN)


def judged(answer: Callable[[int], ViewVerdict]) -> Judge:
    """Who judges by the number of views alone."""
    return lambda views, _: answer(views)


def log_of(folder: Path) -> list[Mapping[str, object]]:
    """The lines of collect.jsonl."""
    lines = (folder / LOG_FILE).read_text(encoding="utf-8").splitlines()
    return [json.loads(line) for line in lines]


class Seeing(FakeRobot):
    """A robot whose sonars see round things."""

    def __init__(self, start: Pose2, things: tuple[Circle, ...]) -> None:
        super().__init__(start)
        self.things = things
        self.faults.append(self._look)

    @property
    def nearest(self) -> float:
        """How near its rim came to any of them, m."""
        path = [(place.x, place.y) for place in self.true_path]
        return min(measure_distance_to(self.things, place) for place in path) - ROBOT.radius

    def _look(self, state: FakeState) -> FakeState:
        return replace(state, sonars=tuple(self._ranges(state.at)))

    def _ranges(self, at: float) -> list[SonarRange]:
        found = []
        for index, place in enumerate(ROBOT.sonars):
            there = self.true.compose(Pose2(place.x, place.y, place.heading))
            echo = min((_echo(there, thing) for thing in self.things), default=FARTHEST)
            found.append(SonarRange(index, echo, at, place))
        return found


def _echo(sonar: Pose2, thing: Circle) -> float:
    x, y = thing.x - sonar.x, thing.y - sonar.y
    far = math.hypot(x, y)
    off = abs(math.remainder(math.atan2(y, x) - sonar.heading, math.tau))
    half = math.radians(15.0) + math.asin(min(thing.radius / far, 1.0))
    return min(max(far - thing.radius, 0.0), FARTHEST) if off < half else FARTHEST


class Heard:
    """Keeps what a listener is told."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def view_taken(self, done: int, total: int, view: Taken) -> None:
        assert 1 <= done <= total
        self.lines.append(view.name)

    def warn(self, message: str) -> None:
        self.lines.append(message)

    def note(self, message: str) -> None:
        self.lines.append(message)

    def ended_early(self, ended: Ended, there: int, total: int) -> None:
        self.lines.append(format_early_end(ended, there, total))


class Exploration:
    """A robot before a target, and all that belongs to it; `resume` goes on in the folder.

    With `sees` it drives by its sonars.
    """

    def __init__(
        self,
        folder: Path,
        explorer: Explorer,
        robot: FakeRobot | None = None,
        *,
        start: Pose2 = START,
        resume: bool = False,
        sees: bool = False,
    ) -> None:
        self.robot = robot or FakeRobot(start)
        self.head = FakeHead(self.robot)
        self.camera = FakeCamera(self.robot, self.head, picture)
        self.base = MobileBase(
            self.robot,
            start,
            pace=Pace(),
            closed=FORBIDDEN,
            moved=lambda _, __: None,
            body=Body(ROBOT.radius, ROBOT.width) if sees else None,
        )
        self.rig = Rig(self.base, self.head, self.camera, OPTICS, REACH, 1.7e9)
        first = bearing(TARGET, (start.x, start.y))
        self.around = Around(TARGET, 0.83, first, REACH, Pace(), start)
        taken = read_record(folder)[1] if resume else ()
        lines = read_log(folder) if resume else ()
        about = {"tour": "explore", "explore": self.around.to_json()}
        folder.mkdir(exist_ok=True)
        self.record = Record(folder, OPTICS, about, taken, lines)
        self.heard = Heard()
        self.stops = ChosenStops(
            explorer, self.around, self.base, self.record, self.heard, wide=ROBOT.radius + 0.03
        )

    def run(self) -> Ended:
        with record_end(self.rig, len(self.stops), self.record, self.heard):
            return collect(self.rig, self.stops, self.record, self.heard, guide=self.stops)


def picture(robot: Pose2, head: HeadState) -> Image:
    shift = round(100 * (robot.x + robot.y + head.pan)) % 40
    return np.roll(CHEQUER, shift, axis=1).astype(np.uint8)
