"""A collection as MCAP, read back by the format's own library and a decoder of its own."""

import math
from collections import defaultdict
from fractions import Fraction
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from scipy.spatial.transform import Rotation

from facetlog.errors import InputError
from facetlog.perception.types import FloatArray
from facetlog.pipeline import open_models
from facetlog.recordings.frames import read_recorded_optics
from facetlog.recordings.mcap_recording import McapRecording
from facetlog.recordings.recording_request import record_collection
from facetlog.robot.pioneer.state import OdometryErrors
from tests.recordings.collected import BEGAN, OPTICS, SPEED, START, Collection, collection

ANSWERS = dict[str, list[tuple[int, Any]]]


@pytest.fixture(scope="module")
def collected() -> Collection:
    return collection()


@pytest.fixture(scope="module")
def heard(collected: Collection, tmp_path_factory: pytest.TempPathFactory) -> ANSWERS:
    path = tmp_path_factory.mktemp("recording") / "deep" / "views.mcap"
    recording = McapRecording(path)
    for moment in collected.moments():
        recording.add(moment)
    recording.close()
    assert [each.name for each in path.parent.iterdir()] == ["views.mcap"]
    return messages(path)


def messages(path: Path) -> ANSWERS:
    """Topics, and when each message was logged (nanoseconds)."""
    found: ANSWERS = defaultdict(list)
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages():
            found[channel.topic].append((message.log_time, decoded))
    return found


def stamp(header: Any) -> int:
    return int(header.stamp.sec * 1_000_000_000 + header.stamp.nanosec)


def nanoseconds(at: float) -> int:
    return round(Fraction(at) * 1_000_000_000)


def matrix(place: Any, turn: Any) -> FloatArray:
    found = np.eye(4)
    found[:3, :3] = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_matrix()
    found[:3, 3] = place.x, place.y, place.z
    return found


def frames_at(heard: ANSWERS, at: float) -> dict[tuple[str, str], FloatArray]:
    """The transforms of one moment, by parent and child."""
    ((_, message),) = [each for each in heard["/tf"] if abs(each[0] / 1e9 - at) < 1e-6][-1:]
    return {
        (each.header.frame_id, each.child_frame_id): matrix(
            each.transform.translation, each.transform.rotation
        )
        for each in message.transforms
    }


def test_the_chain_of_frames_ends_where_the_camera_was(
    heard: ANSWERS, collected: Collection
) -> None:
    for view in collected.taken:
        frames = frames_at(heard, view.time)
        chain = (
            frames["map", "odom"]
            @ frames["odom", "base_link"]
            @ frames["base_link", "camera_optical_frame"]
        )
        assert chain[:3, :3] == pytest.approx(view.pose.rotation, abs=1e-9)
        assert chain[:3, 3] == pytest.approx(view.pose.centre, abs=1e-9)
        # Along the view is ahead and down: z of an optical frame; the mast carries it.
        assert frames["base_link", "camera_optical_frame"][2, 3] == pytest.approx(0.724, abs=0.02)
        assert chain[2, 2] < 0


def test_odometry_is_in_metres_and_seconds_from_where_the_robot_was_connected(
    heard: ANSWERS,
) -> None:
    for at, message in heard["/odom"]:
        assert stamp(message.header) == at
        assert (message.header.frame_id, message.child_frame_id) == ("odom", "base_link")
        place = message.pose.pose.position
        seconds = at / 1e9 - BEGAN
        assert (place.x, place.y, place.z) == pytest.approx((SPEED * seconds, 0.0, 0.0), abs=1e-6)
        speed = SPEED if at > heard["/odom"][0][0] else 0.0
        assert message.twist.twist.linear.x == pytest.approx(speed, abs=1e-6)
        assert message.twist.twist.angular.z == pytest.approx(0.0, abs=1e-9)
    # What came after the last view is not part of what was seen.
    assert len(heard["/odom"]) == 61
    start = frames_at(heard, BEGAN + 6.0)["map", "odom"]
    assert start[:2, 3] == pytest.approx((START.x, START.y))
    assert math.atan2(start[1, 0], start[0, 0]) == pytest.approx(START.heading)


def test_odometry_has_the_covariance_that_the_robots_slip_makes(heard: ANSWERS) -> None:
    found = [np.array(m.pose.covariance).reshape(6, 6) for _, m in heard["/odom"]]
    assert not found[0].any()
    # Straight ahead 1 % of the way and 3 mm in the root of a metre; a floor holds z and tilts fast.
    for way in (0.5, 1.2):
        cov = found[round(way / SPEED / 0.1)]
        errors = OdometryErrors()
        assert cov[0, 0] == pytest.approx((errors.way * way) ** 2 + errors.way_noise**2 * way)
        heading = (errors.drift * way) ** 2 + errors.drift_noise**2 * way
        assert cov[5, 5] == pytest.approx(heading)
        assert not cov[2:5].any()
        assert np.linalg.eigvalsh(cov[np.ix_((0, 1, 5), (0, 1, 5))]).min() > 0
    sizes = [np.trace(each) for each in found]
    assert sizes == sorted(sizes)


def test_candidates_are_balls_of_which_the_chosen_one_says_what_it_promised(
    heard: ANSWERS, collected: Collection
) -> None:
    ((at, message),) = heard["/facetlog/candidates"]
    assert at == nanoseconds(collected.taken[1].time)
    balls = [each for each in message.markers if each.ns == "candidates"]
    assert [each.type for each in balls] == [2, 2, 2]
    assert [each.pose.position.x for each in balls] == [1.0, 0.0, 0.0]
    best, half, none = (each.scale.x for each in balls)
    assert (best / half) ** 2 == pytest.approx(2.0)
    assert 0 < none < half
    ((words,),) = [[each.text for each in message.markers if each.ns == "why"]]
    assert words == "may turn 0.40 verdicts, in 8 s"


def test_pictures_come_with_their_camera_and_the_heads_angles(
    heard: ANSWERS, collected: Collection
) -> None:
    for topic in ("/camera/image/compressed", "/camera/camera_info", "/joint_states"):
        assert [at for at, _ in heard[topic]] == [nanoseconds(v.time) for v in collected.taken]
    for (_, message), image in zip(
        heard["/camera/image/compressed"], collected.images, strict=True
    ):
        data = np.frombuffer(bytes(message.data), dtype=np.uint8)
        assert (cv2.imdecode(data, cv2.IMREAD_UNCHANGED) == image).all()
        assert (message.format, message.header.frame_id) == ("png", "camera_optical_frame")
    camera = heard["/camera/camera_info"][0][1]
    assert (camera.width, camera.height, camera.distortion_model) == (64, 48, "plumb_bob")
    assert list(camera.k) == [50.0, 0.0, 31.0, 0.0, 51.0, 23.5, 0.0, 0.0, 1.0]
    assert list(camera.d) == [-0.1, 0.0, 0.0, 0.002, 0.0]
    for (_, joints), view in zip(heard["/joint_states"], collected.taken, strict=True):
        assert dict(zip(joints.name, joints.position, strict=True)) == {
            "head_pan": view.pan,
            "head_tilt": view.tilt,
        }


def test_the_cameras_pose_has_its_covariance(heard: ANSWERS, collected: Collection) -> None:
    for (_, message), view in zip(heard["/camera/pose"], collected.taken, strict=True):
        assert message.header.frame_id == "map"
        found = np.array(message.pose.covariance).reshape(6, 6)
        assert found == pytest.approx(view.covariance)


def test_faces_and_verdicts_are_markers_that_replace_those_before(
    heard: ANSWERS, collected: Collection
) -> None:
    marker = 3  # DELETEALL
    assert [each.action for each in heard["/facetlog/faces"][0][1].markers] == [marker]
    first, *faces = heard["/facetlog/faces"][1][1].markers
    assert first.action == marker
    assert len(faces) == len(collected.scene.faces)
    for each, face in zip(faces, collected.scene.faces, strict=True):
        assert (each.header.frame_id, each.ns, each.type) == ("map", "faces", 4)
        corners = [(p.x, p.y, p.z) for p in each.points]
        assert corners[0] == corners[-1]
        assert np.array(corners[:-1]) == pytest.approx(collected.scene.points[list(face.outline)])
    ((_, verdicts),) = heard["/facetlog/verdicts"]
    said = [each for each in verdicts.markers if each.action != marker]
    assert any("is a box" in each.text for each in said)
    assert len({(each.ns, each.id) for each in said}) == len(said)


def test_the_folder_gives_the_same_recording_afterwards(
    collected: Collection, heard: ANSWERS, tmp_path: Path
) -> None:
    """But for what two pictures of noise do not show."""
    folder = tmp_path / "views"
    collected.write(folder)
    found = read_recorded_optics(folder)
    assert found.camera == OPTICS.camera
    assert dict(found.coefficients) == dict(OPTICS.coefficients)
    path = tmp_path / "again.mcap"
    with open_models() as base:
        assert record_collection(folder, path, base) == 2
    again = messages(path)
    for topic in ("/joint_states", "/camera/camera_info", "/camera/image/compressed"):
        assert [at for at, _ in again[topic]] == [at for at, _ in heard[topic]]
    assert len(again["/odom"]) == len(heard["/odom"])
    for (_, one), (_, other) in zip(again["/odom"], heard["/odom"], strict=True):
        assert list(one.pose.covariance) == pytest.approx(list(other.pose.covariance), abs=1e-7)
    assert [at for at, _ in again["/facetlog/candidates"]] == [nanoseconds(collected.taken[1].time)]
    last, before = (frames_at(each, collected.taken[-1].time) for each in (again, heard))
    for pair, transform in before.items():
        assert last[pair] == pytest.approx(transform, abs=1e-9)


def test_what_cannot_be_recorded_is_said_with_the_way_out(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"--mcap .*ends in \.mcap"):
        McapRecording(tmp_path / "views.bag")
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        McapRecording(tmp_path / "file" / "views.mcap")
    with open_models() as base, pytest.raises(InputError, match="no collection"):
        record_collection(tmp_path, tmp_path / "a.mcap", base)
