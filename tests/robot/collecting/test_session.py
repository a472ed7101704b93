"""A whole collection with a simulated robot, and what may end it."""

import json
import math
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from facetlog.commands.robot_words import format_early_end
from facetlog.errors import DeviceError, DeviceTimeout, InputError
from facetlog.perception.types import Image
from facetlog.robot.camera.optics import Optics
from facetlog.robot.camera.source import Frame
from facetlog.robot.collecting.drive import MobileBase
from facetlog.robot.collecting.map_picture import Floor, map_png
from facetlog.robot.collecting.plan import Plan, Reach, plan_stops
from facetlog.robot.collecting.record import LOG_FILE, Record, Taken, read_record
from facetlog.robot.collecting.route import Circle
from facetlog.robot.collecting.session import SETTLE, Ended, Rig, collect, record_end
from facetlog.robot.collecting.steering import Pace
from facetlog.robot.collecting.tour_file import make_paper_tour
from facetlog.robot.head.head import HeadState
from facetlog.robot.mount.mount import DEFAULT_MOUNT
from facetlog.robot.pose2 import Pose2
from facetlog.robot.tour import tour_camera
from tests.robot.collecting.fakes import SONY, FakeCamera, FakeHead, FakeRobot, FakeState

TOUR = make_paper_tour()
OPTICS = Optics(tour_camera())
TARGET = TOUR.target
assert TARGET is not None
FORBIDDEN = (Circle(float(TARGET[0]), float(TARGET[1]), 0.75),)
REACH = Reach(DEFAULT_MOUNT, SONY, OPTICS.camera, (FORBIDDEN[0].grown(0.03),))
START = Pose2(0.1, 0.2, 0.3)
# Small pictures with corners: a chequer, at some place that depends on the view.
CHEQUER = np.kron(np.indices((12, 16)).sum(axis=0) % 2, np.ones((40, 40))) * 160 + 40


class Heard:
    def __init__(self) -> None:
        self.views: list[Taken] = []
        self.warnings: list[str] = []

    def view_taken(self, done: int, total: int, view: Taken) -> None:
        assert 1 <= done <= total
        self.views.append(view)

    def warn(self, message: str) -> None:
        self.warnings.append(message)

    def note(self, message: str) -> None:
        self.warnings.append(message)

    def ended_early(self, ended: Ended, there: int, total: int) -> None:
        self.warnings.append(format_early_end(ended, there, total))


def _picture(robot: Pose2, head: HeadState) -> Image:
    shift = round(100 * (robot.x + robot.y + head.pan)) % 40
    return np.roll(CHEQUER, shift, axis=1).astype(np.uint8)


class Scene:
    """A robot before a tour, and all that belongs to it."""

    def __init__(self, folder: Path, robot: FakeRobot | None = None) -> None:
        self.robot = robot or FakeRobot(START)
        self.head = FakeHead(self.robot)
        self.camera = FakeCamera(self.robot, self.head, _picture)
        self.way: list[Pose2] = []
        self.base = MobileBase(
            self.robot,
            START,
            pace=Pace(),
            closed=FORBIDDEN,
            moved=lambda _, place: self.way.append(place),
        )
        self.rig = Rig(self.base, self.head, self.camera, OPTICS, REACH, 1.7e9)
        self.record = Record(folder, OPTICS, {"tour": TOUR.name})
        self.heard = Heard()

    def plan(self, *numbers: int) -> Plan:
        return plan_stops(TOUR, START, REACH, order=[n - 1 for n in numbers])


def _log(folder: Path) -> list[dict[str, object]]:
    lines = (folder / LOG_FILE).read_text(encoding="utf-8").splitlines()
    return [json.loads(line) for line in lines]


def test_the_papers_tour_is_collected_at_its_places(tmp_path: Path) -> None:
    scene = Scene(tmp_path)
    plan = plan_stops(TOUR, START, REACH)
    ended = collect(scene.rig, plan.stops, scene.record, scene.heard)
    assert (ended.taken, ended.wanted, ended.fault) == (24, 24, None)
    _, taken = read_record(tmp_path)
    for view, stop in zip(taken, plan.stops, strict=True):
        off = view.pose.centre[:2] - stop.view.pose.centre[:2]
        assert np.hypot(*off) < 0.04
        # The head makes up for how the robot stands: the middle of the picture is where it was
        # to be, but for the head's steps.
        ray = view.pose.rotation.T @ (stop.point - view.pose.centre)
        assert math.hypot(ray[0], ray[1]) / ray[2] < math.radians(0.2)
    nearest = min(math.dist((p.x, p.y), TARGET[:2]) for p in scene.robot.true_path)
    assert nearest > FORBIDDEN[0].radius
    assert len(list(tmp_path.glob("*.png"))) == 24
    assert not scene.heard.warnings


def test_a_picture_is_taken_after_the_robot_and_the_head_have_stood(tmp_path: Path) -> None:
    scene = Scene(tmp_path)
    speeds: list[tuple[float, float]] = []
    advance = scene.robot.advance

    def watched(seconds: float) -> None:
        advance(seconds)
        speeds.append((scene.robot.state.at, abs(scene.robot.state.speed)))

    scene.robot.advance = watched  # type: ignore[method-assign]
    collect(scene.rig, scene.plan(2, 4).stops, scene.record, scene.heard)
    assert len(scene.camera.shots) == 2
    for after in scene.camera.shots:
        assert all(v < 0.003 for at, v in speeds if after - SETTLE <= at <= after)


def test_a_bumper_ends_the_collection_and_keeps_what_there_is(tmp_path: Path) -> None:
    wall = (1.70, 0.86, 0.12)  # across the way from view 7 to view 8
    scene = Scene(tmp_path, FakeRobot(START, wall=wall))
    ended = collect(scene.rig, scene.plan(6, 7, 8, 9).stops, scene.record, scene.heard)
    assert isinstance(ended.fault, DeviceError)
    assert "touched something at its front (bumper 3)" in str(ended.fault)
    assert 0 < ended.taken < 4
    assert scene.robot.stops > 0
    _, taken = read_record(tmp_path)
    assert len(taken) == ended.taken
    assert _log(tmp_path)[-1]["fault"] == str(ended.fault)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"stalled": (True, False)}, "wheels are stalled"),
        ({"stop_button": True}, "stop button is pressed"),
        ({"motors_on": False}, "motors are off"),
        ({"rear_bumpers": (True, False)}, r"at its rear \(bumper 1\)"),
    ],
)
def test_whatever_the_robot_reports_stops_it(
    tmp_path: Path, change: dict[str, object], said: str
) -> None:
    scene = Scene(tmp_path)

    def fault(state: FakeState) -> FakeState:
        return replace(state, **change) if state.at > 103 else state  # type: ignore[arg-type]

    scene.robot.faults.append(fault)
    ended = collect(scene.rig, scene.plan(9).stops, scene.record, scene.heard)
    assert ended.fault is not None
    with pytest.raises(DeviceError, match=said):
        raise ended.fault
    at = scene.robot.state.at
    scene.robot.advance(2.0)
    assert scene.robot.state.at > at
    assert scene.robot.state.speed == 0


def test_a_robot_that_is_held_is_noticed_without_any_flag(tmp_path: Path) -> None:
    scene = Scene(tmp_path, FakeRobot(START, held=103.0))
    ended = collect(scene.rig, scene.plan(9).stops, scene.record, scene.heard)
    assert "does not move though it is commanded to" in str(ended.fault)
    assert scene.robot.state.at < 103 + 6


def test_a_blurred_picture_is_taken_again(tmp_path: Path) -> None:
    scene = Scene(tmp_path)
    shot = scene.camera.shot
    blurred: list[int] = []

    def sometimes(after: float, timeout: float) -> Frame:
        frame = shot(after, timeout)
        if len(scene.camera.shots) == 5:
            blurred.append(len(scene.camera.shots))
            smooth = cv2.blur(frame.image, (9, 1))
            return Frame(np.asarray(smooth, np.uint8), frame.arrived)
        return frame

    scene.camera.shot = sometimes  # type: ignore[method-assign]
    ended = collect(scene.rig, scene.plan(1, 2, 3, 4, 6).stops, scene.record, scene.heard)
    assert ended.taken == 5
    assert blurred == [5]
    assert len(scene.camera.shots) == 6
    note = scene.heard.views[-1].notes[0]
    assert note.startswith("taken twice, the first was blurred")
    first, last = (scene.heard.views[i].quality.across for i in (0, -1))
    assert last == pytest.approx(first, rel=0.5)


def test_a_camera_that_was_silent_for_a_while_is_noted_once(tmp_path: Path) -> None:
    scene = Scene(tmp_path)
    shot = scene.camera.shot

    def late(after: float, timeout: float) -> Frame:
        frame = shot(after, timeout)
        return replace(frame, silent=7.2) if len(scene.camera.shots) == 2 else frame

    scene.camera.shot = late  # type: ignore[method-assign]
    ended = collect(scene.rig, scene.plan(1, 2, 3, 4).stops, scene.record, scene.heard)
    said = "no picture came from the camera for 7 s before this one; it goes on"
    assert ended.fault is None
    assert [view.notes for view in scene.record.taken] == [(), (said,), (), ()]
    assert scene.heard.warnings == [f"{scene.record.taken[1].name}: {said}"]


def test_ctrl_c_stops_the_robot(tmp_path: Path) -> None:
    scene = Scene(tmp_path)
    drive = scene.robot.drive

    def interrupted(speed: float, turning: float, lease: float = 0.3) -> None:
        drive(speed, turning, lease)
        if scene.robot.state.at > 104:
            raise KeyboardInterrupt

    scene.robot.drive = interrupted  # type: ignore[method-assign]
    with pytest.raises(KeyboardInterrupt):
        _collected(scene, 1, 9)
    assert scene.robot.stops > 0
    scene.robot.advance(1.0)
    end = _log(tmp_path)[-1]
    assert (end["result"], end["taken"], end["fault"]) == ("ended", 1, "interrupted")
    assert isinstance(end["robot"], list)
    # Standing, not where it was told to stop.
    true = scene.robot.true
    assert end["robot"] == pytest.approx([true.x, true.y, math.degrees(true.heading)])
    assert scene.heard.warnings[-1:] == [
        f"interrupted; go on with --resume --start {true.x:.3f},{true.y:.3f},"
        f"{math.degrees(true.heading):.1f} (where it stands by odometry); 1 of 2 views are there"
    ]


def _collected(scene: Scene, *numbers: int) -> None:
    stops = scene.plan(*numbers).stops
    with record_end(scene.rig, len(stops), scene.record, scene.heard):
        collect(scene.rig, stops, scene.record, scene.heard)


def test_a_full_disk_that_takes_no_line_more_is_reported_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = Scene(tmp_path)

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    collect(scene.rig, scene.plan(1).stops, scene.record, scene.heard)
    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(InputError, match="No space left on device: make room"):
        _collected(scene, 2)
    said = scene.heard.warnings[-1]
    assert "make room, then go on with --resume --start " in said
    assert said.count("--resume") == 1
    assert said.endswith("; 1 of 2 views are there")


def test_the_map_shows_every_pose_and_the_circle(tmp_path: Path) -> None:
    scene = Scene(tmp_path)
    collect(scene.rig, scene.plan(1, 7, 13, 20).stops, scene.record, scene.heard)
    missed = (0.0, 2.5)
    floor = Floor((Circle(*TARGET[:2], 0.4),), TARGET, 0.25, (missed,))
    data = map_png(scene.way, scene.record.taken, floor, OPTICS)
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert image is not None
    assert max(image.shape[:2]) == 1200
    # The circle of 0.4 m, 3 pixels wide, on a picture of at least 3 pixels for a centimetre.
    circle = (image == (150, 150, 240)).all(axis=2).sum()
    assert circle > 0.5 * 2 * math.pi * 0.4 * 300 * 2
    assert (image == (190, 120, 20)).all(axis=2).sum() > 500


def test_a_frozen_camera_ends_the_collection(tmp_path: Path) -> None:
    scene = Scene(tmp_path)
    shot = scene.camera.shot

    def frozen(after: float, timeout: float) -> Frame:
        if len(scene.camera.shots) >= 2:
            raise DeviceTimeout("camera is frozen")
        return shot(after, timeout)

    scene.camera.shot = frozen  # type: ignore[method-assign]
    ended = collect(scene.rig, scene.plan(1, 2, 3, 4).stops, scene.record, scene.heard)
    assert (ended.taken, str(ended.fault)) == (2, "camera is frozen")


def test_pictures_of_another_size_than_the_calibration_are_refused(tmp_path: Path) -> None:
    scene = Scene(tmp_path)
    scene.camera.picture = lambda *_: np.zeros((240, 320), np.uint8)
    ended = collect(scene.rig, scene.plan(1).stops, scene.record, scene.heard)
    assert "pictures are 320 x 240, its calibration is for 640 x 480" in str(ended.fault)


def test_a_full_disk_stops_the_collection(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = Scene(tmp_path)

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    stops = scene.plan(1, 2).stops
    collect(scene.rig, stops[:1], scene.record, scene.heard)
    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(InputError, match="No space left on device: make room"):
        collect(scene.rig, stops[1:], scene.record, scene.heard)
    scene.robot.advance(1.0)
    assert scene.robot.state.speed == 0
    _, taken = read_record(tmp_path)
    assert len(taken) == 1
