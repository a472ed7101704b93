"""The procedure before a board, with a simulated robot and corners as a camera would see them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from facetlog.errors import DeviceError, InputError
from facetlog.perception.types import Image, Pose
from facetlog.robot.camera.optics import Optics
from facetlog.robot.collecting.drive import MobileBase
from facetlog.robot.collecting.mount_session import BoardRig, take_sightings
from facetlog.robot.collecting.steering import Pace
from facetlog.robot.head.head import HeadState
from facetlog.robot.mount.board import Board
from facetlog.robot.mount.fit import fit_mount
from facetlog.robot.mount.kinematics import Gaze, camera_pose
from facetlog.robot.mount.mount import DEFAULT_MOUNT, PARAMETERS, Mount
from facetlog.robot.pose2 import Pose2
from facetlog.robot.tour import tour_camera
from tests.robot.collecting.fakes import FakeCamera, FakeHead, FakeRobot
from tests.robot.mount.test_board import CHARUCO, seen_by

CAMERA = tour_camera()
FACING = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
BOARD = Pose(FACING, np.array([1.5, 0.3, 0.85]))
TRUE = Mount(
    x=0.06, z=0.72, yaw=math.radians(2.0), pitch=math.radians(-1.0), tilt_zero=math.radians(0.8),
    skew=math.radians(0.5), pinhole_ahead=0.03,
)  # fmt: skip


def _rig(robot: FakeRobot, *, board: Board = CHARUCO, at: Pose = BOARD) -> BoardRig:
    head = FakeHead(robot)

    def picture(place: Pose2, looks: HeadState) -> Image:
        return seen_by(board, camera_pose(place, TRUE, Gaze(looks.pan, looks.tilt)), at)

    base = MobileBase(robot, Pose2(), pace=Pace())
    camera = FakeCamera(robot, head, picture)
    return BoardRig(base, head, camera, Optics(CAMERA), DEFAULT_MOUNT, board, 0.25)


def test_the_mount_is_found_by_driving_before_a_board() -> None:
    robot = FakeRobot()
    robot.state = replace(robot.state, covariance=np.diag([0.002**2, 0.002**2, 0.003**2]))
    told: list[str] = []
    sightings = list(take_sightings(_rig(robot), told.append))
    assert len({s.station for s in sightings}) == 7
    assert len(sightings) > 25
    assert len(told) == 8
    fit = fit_mount(sightings, CAMERA, DEFAULT_MOUNT, board_height=float(BOARD.centre[2]))
    assert fit.undetermined == ()
    assert fit.rms_px < 0.3
    for name, value, true, sd in zip(
        PARAMETERS, fit.mount.values, TRUE.values, fit.mount.sds, strict=True
    ):
        # The head's steps (0.1 degrees) are errors that the corners' own noise does not tell of.
        slack = math.radians(0.15) if "pinhole" not in name and name not in "xyz" else 0.004
        assert abs(value - true) < 4 * sd + slack, name
    nearest = min(math.dist((p.x, p.y), BOARD.centre[:2]) for p in robot.true_path)
    assert nearest > 0.5 + 0.25


def test_no_board_is_reported_with_the_way_out() -> None:
    rig = _rig(FakeRobot())
    rig.camera.picture = lambda *_: np.full((480, 640), 90, np.uint8)  # type: ignore[attr-defined]
    told: list[str] = []
    with pytest.raises(InputError, match=r"nowhere in sight: put it 1 to 2 m before the robot"):
        list(take_sightings(rig, told.append))
    # Each look takes seconds: nobody is to think that nothing happens.
    assert len(told) == 15
    assert told[1] == "the board is not in sight at pan -30°, tilt +0° (look 2 of 15)"


def test_something_in_the_way_ends_it() -> None:
    robot = FakeRobot(wall=(0.5, 0.0, 0.35))
    with pytest.raises(DeviceError, match="touched something"):
        list(take_sightings(_rig(robot), lambda _: None))
    assert robot.stops > 0
