"""A robot that explores an area in simulated time: what it finds, and that it touches nothing."""

import copy
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from facetlog.exploring.area import AreaExplorer, AreaJudge
from facetlog.exploring.area_groups import parts_of
from facetlog.exploring.needs import Interest
from facetlog.mapping.placed_thing import PlacedThing
from facetlog.mapping.room_map import ScenePart
from facetlog.mapping.visit import read_visit
from facetlog.perception.fewest_views import FEWEST_VIEWS
from facetlog.robot.collecting.drive import MobileBase
from facetlog.robot.collecting.next_stop import (
    MOST_DRIFT,
    Around,
    Chooser,
    Chosen,
    ChosenStops,
    Finished,
)
from facetlog.robot.collecting.plan import Reach
from facetlog.robot.collecting.record import Record, Taken, read_log, read_record
from facetlog.robot.collecting.route import Circle
from facetlog.robot.collecting.run_sessions import runs_of
from facetlog.robot.collecting.session import Ended, Rig, collect
from facetlog.robot.collecting.steering import Pace
from facetlog.robot.collecting.way_ahead import Body
from facetlog.robot.mount.kinematics import Gaze, camera_pose
from facetlog.robot.mount.mount import DEFAULT_MOUNT
from facetlog.robot.pose2 import Pose2
from facetlog.view_verdicts import ViewVerdict
from tests.exploring.explorations import OPTICS, ROBOT, Heard, Seeing, led, log_of, picture
from tests.mapping.rooms import box_thing
from tests.robot.collecting.fakes import SONY, FakeCamera, FakeHead, FakeState

AREA = (0.0, 0.0, 6.0, 5.0)
START = Pose2(1.0, 1.0, 0.4)
THINGS = (Circle(3.2, 1.4, 0.15), Circle(3.8, 3.6, 0.2))
# Their echoes are one place.
ROW = tuple(Circle(1.0 + k, 2.5, 0.2) for k in range(5))
PACE = Pace(speed=0.4, turning=math.radians(60.0))


def _judge(things: Sequence[Circle], asked: list[tuple[str, ...]] | None = None) -> AreaJudge:
    """Says of the thing that is nearest to what is looked at that it is a sure box."""

    def judge(names: tuple[str, ...], interest: Interest) -> tuple[ViewVerdict, ScenePart]:
        if asked is not None:
            asked.append(names)
        near = [t for t in things if math.dist((t.x, t.y), interest.target[:2]) < 1.0]
        found: tuple[PlacedThing, ...] = tuple(
            box_thing(t.x, t.y, 0.0, (2 * t.radius, 2 * t.radius, 0.3), visit="area") for t in near
        )
        return ViewVerdict(len(names), needs=led(1.0) if near else None), ScenePart(found, ())

    return judge


class Area:
    """A robot in an area with things, and all that belongs to it."""

    def __init__(
        self,
        folder: Path,
        explorer: AreaExplorer,
        things: tuple[Circle, ...] = THINGS,
        *,
        start: Pose2 = START,
        resume: bool = False,
        chooser: Chooser | None = None,
    ) -> None:
        self.robot = Seeing(start, things)
        head = FakeHead(self.robot)
        camera = FakeCamera(self.robot, head, picture)
        reach = Reach(DEFAULT_MOUNT, SONY, OPTICS.camera)
        self.around = Around(np.zeros(3), 0.0, 0.0, reach, PACE, start, ROBOT.radius)
        self.base = base = MobileBase(
            self.robot,
            start,
            pace=PACE,
            heard=explorer.heard,
            body=Body(ROBOT.radius, ROBOT.width),
        )
        rig = Rig(base, head, camera, OPTICS, reach, 1.7e9)
        about = {
            "tour": "area",
            "start": [start.x, start.y, math.degrees(start.heading)],
            "area": list(AREA),
            "explore": self.around.to_json(),
        }
        taken = read_record(folder)[1] if resume else ()
        lines = read_log(folder) if resume else ()
        self.record = Record(folder, OPTICS, about, taken, lines)
        self.heard = Heard()
        wide = ROBOT.radius + 0.03
        self.stops = ChosenStops(
            chooser or explorer,
            self.around,
            base,
            self.record,
            self.heard,
            wide=wide,
            detours=20,
            drift=MOST_DRIFT,
        )
        self._rig = rig

    def run(self) -> Ended:
        return collect(self._rig, self.stops, self.record, self.heard, guide=self.stops)


def test_each_thing_is_looked_at_once_and_none_is_touched(tmp_path: Path) -> None:
    asked: list[tuple[str, ...]] = []
    explorer = AreaExplorer(_judge(THINGS, asked), AREA, most=60)
    area = Area(tmp_path, explorer)
    ended = area.run()
    assert ended.fault is None
    assert explorer.reached
    assert area.stops.reason.startswith("no unseen floor of the area can be reached")
    assert "2 things found" in area.stops.reason
    places = sorted(thing.best.pose[:2].tolist() for thing in explorer.things)
    assert places == [pytest.approx((t.x, t.y), abs=1e-6) for t in THINGS]
    assert area.robot.nearest > 0.0
    x, y, width, height = AREA
    for place in area.robot.true_path:
        assert x < place.x < x + width
        assert y < place.y < y + height
    # What the map is made from: the places, each with views of its own.
    visit = read_visit(tmp_path)
    assert {frozenset(place.names) for place in visit.places} >= set(map(frozenset, asked[-1:]))
    assert all(len(place.names) >= 3 for place in visit.places)


def test_things_in_a_row_that_no_ring_goes_round_are_looked_at_each(tmp_path: Path) -> None:
    explorer = AreaExplorer(_judge(ROW), AREA, most=80)
    area = Area(tmp_path, explorer, ROW)
    assert area.run().fault is None
    assert explorer.reached
    places = sorted(thing.best.pose[:2].tolist() for thing in explorer.things)
    assert places == [pytest.approx((t.x, t.y), abs=1e-6) for t in ROW]
    assert "echoes at" not in area.stops.reason
    assert area.robot.nearest > 0.0
    # Who resumes knows which of the places are parts.
    lines, resumed = log_of(tmp_path), AreaExplorer(_judge(ROW), AREA, most=80)
    assert parts_of(lines)
    resumed.resume(lines, read_visit(tmp_path))
    assert [g.part for g in resumed.groups] == [g.part for g in explorer.groups]


class Drifting(Area):
    """A robot whose odometry turns too far; its pictures of a place are aligned if they are asked
    to be: beside the first of them each is where it was taken.
    """

    def __init__(self, folder: Path, *, aligned: bool, most: int = 60) -> None:
        self._folder, self._aligned = folder, aligned
        self._true: dict[tuple[float, float], Pose2] = {}
        self.explorer = AreaExplorer(self.judged, AREA, most=most)
        super().__init__(folder, self.explorer)
        self.robot.errors = 0.005, 0.02
        self.robot.faults.append(self._reported)

    def _reported(self, state: FakeState) -> FakeState:
        self._true[_place(state.pose)] = self.robot.true
        return replace(state, covariance=1e-4 * (state.at - 99.0) * np.eye(3))

    def judged(self, names: tuple[str, ...], interest: Interest) -> tuple[ViewVerdict, ScenePart]:
        """What the views show; their poses with it, if they are aligned."""
        verdict, part = _judge(THINGS)(names, interest)
        taken = {view.name: view for view in read_record(self._folder)[1]}
        first, last = taken[names[0]], taken[names[-1]]
        begun, ended = (self._true[_place(view.odometry)] for view in (first, last))
        gaze = Gaze(last.pan, last.tilt)
        pose = camera_pose(first.robot.compose(begun.between(ended)), DEFAULT_MOUNT, gaze)
        return verdict, replace(part, poses={last.name: pose} if self._aligned else {})


def _place(odometry: Pose2) -> tuple[float, float]:
    return round(odometry.x, 9), round(odometry.y, 9)


def test_pictures_of_a_place_put_right_where_odometry_has_the_robot(tmp_path: Path) -> None:
    off = {}
    for aligned in (False, True):
        folder = tmp_path / str(aligned)
        area = Drifting(folder, aligned=aligned)
        assert area.run().fault is None
        assert len(area.explorer.things) == 2
        off[aligned] = area.robot.true.between(area.base.place(area.robot.state))
        lines = read_log(folder)
        placed = sum(line.get("result") == "placed" for line in lines)
        assert placed == sum("odometry was off by" in line for line in area.heard.lines)
        assert bool(placed) == aligned
        # Who reads the folder has the robot's way and its sonars where it was.
        (run,) = runs_of(lines, folder)
        start = run.place(Pose2(), math.inf)
        assert area.base.start.between(start).heading == pytest.approx(0.0, abs=1e-9)
    assert abs(off[True].heading) < abs(off[False].heading)
    assert math.hypot(off[True].x, off[True].y) < math.hypot(off[False].x, off[False].y)


@pytest.mark.parametrize("most", [5, 8])
def test_what_the_last_pictures_say_of_where_it_stands_is_kept(tmp_path: Path, most: int) -> None:
    area = Drifting(tmp_path, aligned=True, most=most)
    area.run()
    placed = sum(line.get("result") == "placed" for line in read_log(tmp_path))
    assert placed == sum("odometry was off by" in line for line in area.heard.lines) > 0
    assert area.explorer.next_stop(area.around, area.record.taken).here is None


def test_a_run_that_resumes_stands_where_it_is_said_to_stand(tmp_path: Path) -> None:
    area = Drifting(tmp_path, aligned=True, most=5)
    area.run()
    lines = read_log(tmp_path)
    # As if it had been killed when its last view was written.
    last = max(k for k, line in enumerate(lines) if line.get("result") == "taken")
    explorer = AreaExplorer(area.judged, AREA, most=60)
    explorer.resume(lines[: last + 1], read_visit(tmp_path))
    taken = area.record.taken
    found = explorer.next_stop(replace(area.around, here=taken[-1].robot), taken)
    assert isinstance(found, Chosen)
    assert any("is done" in line for line in found.said)
    assert explorer.groups[0].poses
    assert found.here is None


def test_floor_without_anything_is_looked_at_and_nothing_is_judged(tmp_path: Path) -> None:
    asked: list[tuple[str, ...]] = []
    explorer = AreaExplorer(_judge((), asked), AREA, most=60)
    area = Area(tmp_path, explorer, ())
    assert area.run().fault is None
    assert explorer.reached
    assert not asked
    assert "0 things found; sonars did not reach 0.0 of 30.0 m²" in area.stops.reason
    assert len(area.record.taken) < 15


def test_what_pictures_do_not_show_is_asked_for_once(tmp_path: Path) -> None:
    """Something that echoes and has no face: it ends, and keeps off it."""
    explorer = AreaExplorer(_judge(()), AREA, most=80, of_a_place=5)
    area = Area(tmp_path, explorer, THINGS[:1])
    assert area.run().fault is None
    assert explorer.reached
    assert not explorer.things
    assert 1 <= len(explorer.groups) <= 3
    assert area.robot.nearest > 0.0


def test_with_as_many_views_as_are_allowed_it_says_what_is_left(tmp_path: Path) -> None:
    explorer = AreaExplorer(_judge(THINGS), AREA, most=6)
    area = Area(tmp_path, explorer)
    ended = area.run()
    assert (ended.taken, ended.fault) == (6, None)
    assert not explorer.reached
    assert "there are 6 views, as many as --max-views allows" in area.stops.reason


def test_a_place_that_was_cut_off_before_a_thing_could_be_found_is_no_place_without_one(
    tmp_path: Path,
) -> None:
    cut = []
    for most in (3, 4, 5):
        explorer = AreaExplorer(_judge(THINGS), AREA, most=most)
        area = Area(tmp_path / str(most), explorer)
        area.run()
        cut += [group for group in explorer.groups if 0 < len(group.names) < FEWEST_VIEWS]
        assert "nothing is found at" not in area.stops.reason
        assert "not looked at yet" in area.stops.reason
    assert cut


def test_a_walled_in_robot_looks_about_and_ends(tmp_path: Path) -> None:
    wall = tuple(
        Circle(1.0 + 0.8 * math.cos(a), 1.0 + 0.8 * math.sin(a), 0.15)
        for a in np.arange(0.0, math.tau, 0.3).tolist()
    )
    explorer = AreaExplorer(_judge(()), AREA, most=60)
    area = Area(tmp_path, explorer, wall)
    ended = area.run()
    assert ended.fault is None
    assert area.robot.nearest > 0.0
    assert "echoes at" in area.stops.reason
    assert "sonars did not reach" in area.stops.reason


def test_a_second_run_goes_on_with_the_places_of_the_first(tmp_path: Path) -> None:
    first = Area(tmp_path, AreaExplorer(_judge(THINGS), AREA, most=7))
    first.run()
    before = len(read_record(tmp_path)[1])
    asked: list[tuple[str, ...]] = []
    explorer = AreaExplorer(_judge(THINGS, asked), AREA, most=60)
    explorer.resume(read_log(tmp_path), read_visit(tmp_path))
    known = [group.place for group in explorer.groups]
    second = Area(tmp_path, explorer, start=first.robot.true, resume=True)
    assert second.run().fault is None
    assert explorer.reached
    assert "2 things found" in second.stops.reason
    assert [group.place.reach for group in explorer.groups][: len(known)] == [
        pytest.approx(place.reach, abs=1e-3) for place in known
    ]
    names = [view.name for view in read_record(tmp_path)[1]]
    assert len(names) == len(set(names)) > before


def test_a_place_that_the_most_views_cut_off_is_gone_on_with(tmp_path: Path) -> None:
    near = _judge(THINGS)

    def judge(names: tuple[str, ...], interest: Interest) -> tuple[ViewVerdict, ScenePart]:
        verdict, part = near(names, interest)
        return replace(verdict, needs=led(0.6, wrong=0.4 / len(names))), part

    first = AreaExplorer(judge, AREA, most=6)
    Area(tmp_path, first).run()
    assert first.groups[0].ended == "the views are all taken"
    resumed = AreaExplorer(judge, AREA, most=60)
    resumed.resume(read_log(tmp_path), read_visit(tmp_path))
    (group,) = resumed.groups
    assert len(group.names) > FEWEST_VIEWS
    assert group.ended == ""


def test_every_choice_says_what_it_is_of_and_why(tmp_path: Path) -> None:
    area = Area(tmp_path, AreaExplorer(_judge(THINGS), AREA, most=60))
    area.run()
    chosen = [line for line in log_of(tmp_path) if line.get("result") == "chosen"]
    assert all(line["why"] and isinstance(line["looks_at"], int) for line in chosen)
    assert {line["looks_at"] for line in chosen} >= {0, 1, 2}
    assert any(line.startswith("place 1") and "is done" in line for line in area.heard.lines)


class Resuming:
    """Chooses as the explorer does that drives, and notes what one that resumed there chooses."""

    def __init__(self, explorer: AreaExplorer, judge: AreaJudge, folder: Path) -> None:
        self._explorer, self._judge, self._folder = explorer, judge, folder
        self.most = explorer.most
        self.choices: list[tuple[object, object]] = []

    def next_stop(self, around: Around, taken: tuple[Taken, ...]) -> Chosen | Finished:
        resumed = AreaExplorer(self._judge, AREA, most=self.most)
        # A test has no traffic: what was heard is the same, what was concluded from it is not.
        vars(resumed.floor).update(copy.deepcopy(vars(self._explorer.floor)))
        resumed.floor.asked[:] = resumed.floor.given_up[:] = False
        if taken:
            resumed.resume(read_log(self._folder), read_visit(self._folder))
            again = resumed.next_stop(around, taken)
        found = self._explorer.next_stop(around, taken)
        if taken:
            self.choices.append((found.line, again.line))
        return found


@pytest.mark.slow
def test_at_every_view_a_run_that_resumes_chooses_as_the_one_that_drove(tmp_path: Path) -> None:
    near = _judge(THINGS)

    def judge(names: tuple[str, ...], interest: Interest) -> tuple[ViewVerdict, ScenePart]:
        verdict, part = near(names, interest)
        if len(names) in {3, 5}:  # What leads after four views was excluded before.
            return replace(verdict, needs=None, excluded=("table",)), part
        return replace(verdict, needs=led(0.96)), part

    explorer = AreaExplorer(judge, AREA, most=60)
    resuming = Resuming(explorer, judge, tmp_path)
    area = Area(tmp_path, explorer, chooser=resuming)
    assert area.run().fault is None
    assert explorer.reached
    assert len(resuming.choices) == len(area.record.taken) > 12
    for live, resumed in resuming.choices:
        assert live == resumed


def test_the_next_choice_is_told_from_the_record_alone(tmp_path: Path) -> None:
    area = Area(tmp_path, AreaExplorer(_judge(THINGS), AREA, most=4))
    area.run()
    explorer = AreaExplorer(_judge(THINGS), AREA, most=60)
    explorer.resume(read_log(tmp_path), read_visit(tmp_path))
    lines = log_of(tmp_path)
    around = Around.from_json(lines[0]["explore"])
    taken = read_record(tmp_path)[1]
    found = explorer.next_stop(replace(around, here=taken[-1].robot), taken)
    assert isinstance(found, Chosen)
    assert found.stop.number == 5
