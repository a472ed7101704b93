"""What a collection leaves in its folder, read by others and by itself."""

import errno
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from facetlog.errors import InputError
from facetlog.perception.reading.read_views import read_views
from facetlog.perception.types import Image
from facetlog.robot.camera.checks import Quality
from facetlog.robot.camera.optics import Optics
from facetlog.robot.collecting.record import (
    LOG_FILE,
    Record,
    Taken,
    format_robot_tum,
    read_log,
    read_record,
    read_robot_tum,
)
from facetlog.robot.mount.kinematics import Gaze, camera_pose
from facetlog.robot.mount.mount import DEFAULT_MOUNT
from facetlog.robot.pose2 import Pose2
from facetlog.robot.tour import tour_camera

OPTICS = Optics(tour_camera(), "OPENCV", (("k1", -0.1), ("p2", 0.001)))


def _view(number: int) -> Taken:
    robot = Pose2(0.3 * number, -0.2, 0.4 * number)
    gaze = Gaze(0.3, -0.4)
    root = np.diag([0.01, 0.02, 0.0, 0.001, 0.001, 0.02])
    return Taken(
        number,
        f"view{number:03d}.png",
        camera_pose(robot, DEFAULT_MOUNT, gaze),
        root @ root,
        robot,
        Pose2(1.0, 2.0, 3.0),
        gaze.pan,
        gaze.tilt,
        0,
        1.7e9 + number,
        Quality(12.5, 3.5, 0.01),
        ("taken twice",) if number == 2 else (),
    )


def _picture(number: int) -> Image:
    rng = np.random.default_rng(number)
    return rng.integers(0, 256, (480, 640, 3)).astype(np.uint8)


def _recorded(folder: Path, count: int = 3) -> Record:
    record = Record(folder, OPTICS, {"tour": "t"})
    for number in range(1, count + 1):
        record.add(_view(number), _picture(number))
    return record


def test_perception_reads_the_poses_that_were_written(tmp_path: Path) -> None:
    record = Record(tmp_path, Optics(tour_camera()), {})
    for number in (1, 2, 3):
        record.add(_view(number), _picture(number))
    views = read_views(tmp_path, unit="m").views
    assert [view.name for view in views] == ["view001.png", "view002.png", "view003.png"]
    for number, view in enumerate(views, start=1):
        wanted = _view(number).pose
        np.testing.assert_allclose(view.pose.rotation, wanted.rotation, atol=1e-12)
        np.testing.assert_allclose(view.pose.centre, wanted.centre, atol=1e-12)
        assert view.camera == tour_camera()


def test_colmaps_files_give_the_same_poses(tmp_path: Path) -> None:
    """By the format's definition: world to camera, quaternion w first, pixel centres at 0.5."""
    _recorded(tmp_path)
    camera = (tmp_path / "cameras.txt").read_text(encoding="utf-8").splitlines()[-1].split()
    assert camera[:4] == ["1", "OPENCV", "640", "480"]
    assert [float(v) for v in camera[4:]] == pytest.approx(
        [tour_camera().fx, tour_camera().fy, 320.0, 240.0, -0.1, 0.0, 0.0, 0.001]
    )
    text = (tmp_path / "images.txt").read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    assert lines[1::2] == ["", "", ""]
    for number, line in enumerate(lines[0::2], start=1):
        told = line.split()
        assert (int(told[0]), told[8], told[9]) == (number, "1", f"view{number:03d}.png")
        w, x, y, z, *shift = (float(v) for v in told[1:8])
        turn = Rotation.from_quat([x, y, z, w]).as_matrix()
        pose = _view(number).pose
        np.testing.assert_allclose(turn, pose.rotation.T, atol=1e-9)
        np.testing.assert_allclose(-turn.T @ np.array(shift), pose.centre, atol=1e-9)
    assert (tmp_path / "points3D.txt").read_text(encoding="utf-8").startswith("#")


@pytest.mark.parametrize("headings", [(), (0.5,), (0.5, -3.0, 3.1)])
def test_the_robots_way_is_read_as_it_was_written(
    tmp_path: Path, headings: tuple[float, ...]
) -> None:
    way = [(1.7e9 + i, Pose2(0.1 * i, -0.2, heading)) for i, heading in enumerate(headings)]
    path = tmp_path / "odometry.tum"
    path.write_text(format_robot_tum(way), encoding="utf-8")
    again = read_robot_tum(path)
    assert [at for at, _ in again] == [at for at, _ in way]
    for (_, here), (_, there) in zip(again, way, strict=True):
        assert (here.x, here.y) == pytest.approx((there.x, there.y))
        assert here.heading == pytest.approx(there.heading, abs=1e-5)


def test_a_record_is_read_again_as_it_was(tmp_path: Path) -> None:
    _recorded(tmp_path)
    about, taken = read_record(tmp_path)
    assert about["tour"] == "t"
    for number, view in enumerate(taken, start=1):
        wanted = _view(number)
        assert (view.number, view.name, view.notes) == (number, wanted.name, wanted.notes)
        np.testing.assert_allclose(view.pose.rotation, wanted.pose.rotation, atol=1e-12)
        np.testing.assert_allclose(view.covariance, wanted.covariance, atol=1e-15)
        assert view.robot.heading == pytest.approx(wanted.robot.heading)
        assert (view.time, view.quality) == (wanted.time, wanted.quality)


def test_a_view_without_its_picture_is_taken_anew(tmp_path: Path) -> None:
    _recorded(tmp_path)
    (tmp_path / "view002.png").unlink()
    _, taken = read_record(tmp_path)
    assert [view.number for view in taken] == [1, 3]


def test_a_later_run_keeps_what_the_earlier_ones_said_of_themselves(tmp_path: Path) -> None:
    """Odometry begins anew with each run: the views before a line belong to the `start` above."""
    record = Record(tmp_path, OPTICS, {"start": [0.0, 0.0, 0.0]})
    record.add(_view(1), _picture(1))
    record.add(_view(2), _picture(2))
    record.note({"result": "ended", "fault": "the robot touched something"})
    (tmp_path / "view001.png").unlink()
    _, taken = read_record(tmp_path)
    again = Record(tmp_path, OPTICS, {"start": [1.0, 2.0, 90.0]}, taken, read_log(tmp_path))
    again.add(_view(1), _picture(1))
    again.note({"result": "ended", "fault": None})
    told = [line.get("start", line.get("image", line.get("fault"))) for line in read_log(tmp_path)]
    assert told == [
        [0.0, 0.0, 0.0],
        *("view001.png", "view002.png", "the robot touched something"),
        [1.0, 2.0, 90.0],
        *("view001.png", None),
    ]
    _, taken = read_record(tmp_path)
    assert [view.number for view in taken] == [2, 1]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is not of the form"),
        ('{"schema": "other/1"}\n', "is not of the form"),
        ("{nonsense\n", "cannot be read"),
        ('{"schema": "facetlog-collect/1"}\n{"result": "taken"}\n', r"collect.jsonl:2: is no line"),
    ],
)
def test_a_record_that_cannot_be_read_is_reported(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / LOG_FILE).write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=said):
        read_record(tmp_path)


def test_a_full_disk_is_reported_and_leaves_the_files_that_were_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    record = _recorded(tmp_path, 2)
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}

    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(InputError, match=r"view003.png cannot be written: No space .* --resume"):
        record.add(_view(3), _picture(3))
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before
    _, taken = read_record(tmp_path)
    assert len(taken) == 2


def test_a_third_radial_coefficient_needs_colmaps_full_model(tmp_path: Path) -> None:
    Record(tmp_path, Optics(tour_camera(), "OPENCV", (("k1", 0.1), ("k3", 0.02))), {})
    camera = (tmp_path / "cameras.txt").read_text(encoding="utf-8").splitlines()[-1].split()
    assert camera[1] == "FULL_OPENCV"
    assert [float(v) for v in camera[8:]] == [0.1, 0.0, 0.0, 0.0, 0.02, 0.0, 0.0, 0.0]
