"""What is taken for granted of a robot that says it is simulated, and of no other."""

import math
from dataclasses import dataclass
from pathlib import Path

import pytest

from facetlog.cli import main
from facetlog.errors import DeviceTimeout, InputError
from facetlog.robot.camera.optics import Optics
from facetlog.robot.collecting.simulated_robot import (
    check_start,
    choose_camera_and_optics,
)
from facetlog.robot.pioneer.packets.reports import Configuration
from facetlog.robot.pose2 import Pose2
from facetlog.robot.simulator.world_file import RobotSetup, StartSetup, WorldSetup
from facetlog.robot.tour import tour_camera
from tests.robot.simulator.running import SMALL, Running

CAMERA = "http://127.0.0.1:8100/"


@dataclass
class ConnectedRobot:
    serial_number: str | None = f"facetlog {CAMERA}"
    true: Pose2 | None = None

    @property
    def configuration(self) -> Configuration | None:
        if self.serial_number is None:
            return None
        return Configuration("Pioneer", "p3dx", self.serial_number)

    def ask_true_pose(self) -> Pose2:
        if self.true is None:
            raise DeviceTimeout("the robot does not report the true pose")
        return self.true


def _quiet(message: str) -> None:
    pytest.fail(message)


@pytest.mark.parametrize(
    "true",
    [Pose2(1.5, 0.71, 0.75), Pose2(0.06), Pose2(heading=math.radians(4)), Pose2(heading=3.14)],
)
def test_a_simulated_robot_that_stands_elsewhere_is_refused(true: Pose2) -> None:
    with pytest.raises(InputError, match=r"give --start .* or restart facetlog simulate") as no:
        check_start(ConnectedRobot(true=true), Pose2(), _quiet)
    place = str(no.value).split("--start ")[1].split(", or")[0]
    x, y, heading = map(float, place.split(","))
    check_start(ConnectedRobot(true=true), Pose2(x, y, math.radians(heading)), _quiet)


@pytest.mark.parametrize("serial_number", [None, "", "AB1234", "SIM"])
def test_the_true_pose_of_a_real_robot_is_not_requested(serial_number: str | None) -> None:
    check_start(ConnectedRobot(serial_number, Pose2(3.0)), Pose2(), _quiet)


@pytest.mark.parametrize("address", ["tcp:127.0.0.1:8101", "localhost:8101", "/dev/pts/3"])
def test_only_a_robot_that_says_so_has_the_simulated_camera(address: str) -> None:
    said: list[str] = []
    seen = choose_camera_and_optics(ConnectedRobot(), address, None, None, said.append)
    assert seen.camera == CAMERA
    assert "--camera" in said[0]
    assert "--camera-file" in said[1]
    for serial_number in (None, "AB1234", "SIM"):
        robot = ConnectedRobot(serial_number)
        with pytest.raises(InputError, match=f"which camera is on {address}.* --camera"):
            choose_camera_and_optics(robot, address, None, None, _quiet)
        # The calibration is not that of the simulated camera either, wherever a tunnel ends.
        with pytest.raises(InputError, match="needs its calibration: give --camera-file"):
            choose_camera_and_optics(robot, address, "http://127.0.0.1:8080/", None, _quiet)
        optics = Optics(tour_camera())
        assert choose_camera_and_optics(robot, address, "0", optics, _quiet).optics is optics


@pytest.mark.parametrize(
    ("setup", "said"),
    [
        (RobotSetup(start=StartSetup(x=0.3)), "stands at 0.300, 0.000, 0.0 (m, m, degrees): give"),
        (RobotSetup(config={"serial_number": "AB12"}), "which camera is on tcp:127.0.0.1:"),
    ],
    ids=["elsewhere", "real"],
)
@pytest.mark.slow
def test_collect_refuses_before_anything_moves(
    setup: RobotSetup,
    said: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    running = Running(WorldSetup(robot=setup, camera=SMALL))
    try:
        robot = running.station.addresses.robot
        argv = ["collect", robot, "--tour", "paper", "-o", str(tmp_path / "out")]
        assert main(argv) == 2
        assert said in capsys.readouterr().err
        assert running.state()["motors"] is False
    finally:
        running.close()
