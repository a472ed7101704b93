"""Defaults and checks for a simulated robot: its true pose, its camera and calibration.

An address does not identify it: a real robot, too, can be reached at 127.0.0.1, through a tunnel or
a serial server. What counts is the serial number that the robot reports in CONFIG: that of
`facetlog simulate` names it and its camera, others ("SIM" of AMRISim) have cameras of their own.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol
from urllib.parse import urlsplit

from facetlog.errors import DeviceTimeout, InputError
from facetlog.robot.camera.optics import Optics
from facetlog.robot.pioneer.packets.configuration import Configuration
from facetlog.robot.pose2 import Pose2
from facetlog.robot.tour import tour_camera

__all__ = [
    "CameraAndOptics",
    "ConnectedRobot",
    "camera_and_optics",
    "check_start",
    "is_simulated",
]

# Hosts of robots and cameras on this machine.
LOCAL = ("127.", "localhost", "/dev/pts/")
# How far the robot may stand from the given start: small enough to count as the same place.
NEAR, NEAR_HEADING = 0.05, math.radians(3.0)


class ConnectedRobot(Protocol):
    """The part of the driver that is used here."""

    @property
    def configuration(self) -> Configuration | None:
        """The robot's CONFIG report; None from old firmware."""

    def true_pose(self) -> Pose2:
        """The true pose of a simulated robot; DeviceTimeout if it is not reported."""


@dataclass(frozen=True, eq=False, slots=True)
class CameraAndOptics:
    """A camera's address, and its calibration."""

    camera: str
    optics: Optics


def is_simulated(robot: ConnectedRobot) -> bool:
    """Return whether the robot reports that it is of `facetlog simulate`."""
    return robot.configuration is not None and robot.configuration.simulated


def check_start(robot: ConnectedRobot, start: Pose2, warn: Callable[[str], None]) -> None:
    """InputError if a simulated robot stands elsewhere than at `start` in its world.

    It stays where an earlier session left it, and unlike a real robot's that place is not visible.
    """
    if not is_simulated(robot):
        return
    try:
        true = robot.true_pose()
    except DeviceTimeout:
        warn("the simulated robot does not report its true pose: check that --start is right")
        return
    off = start.between(true)
    if math.hypot(off.x, off.y) <= NEAR and abs(off.heading) <= NEAR_HEADING:
        return
    place = f"{true.x:.3f},{true.y:.3f},{math.degrees(true.heading):.1f}"
    raise InputError(
        f"the simulated robot stands at {place.replace(',', ', ')} (m, m, degrees): give --start "
        f"{place}, or restart facetlog simulate"
    )


def camera_and_optics(
    robot: ConnectedRobot,
    address: str,
    camera: str | None,
    optics: Optics | None,
    note: Callable[[str], None],
) -> CameraAndOptics:
    """The given camera and optics, with those of the simulated camera where none are given.

    InputError where they must be given: for a robot that is not simulated, or not on this machine.
    """
    simulated = None if robot.configuration is None else robot.configuration.simulated_camera
    if camera is None:
        place = address.removeprefix("tcp:").removeprefix("serial:")
        if simulated is None or not place.startswith(LOCAL):
            raise InputError(
                f"which camera is on {address}? Give --camera: 0, /dev/video0, http://…"
            )
        camera = simulated
        note(f"no --camera: it is {camera}, as the simulated robot reports")
    if optics is None:
        if simulated is None or not (urlsplit(camera).hostname or "").startswith(LOCAL):
            raise InputError(f"camera {camera} needs its calibration: give --camera-file")
        note("no --camera-file: the camera is taken to be the simulated one, 640 x 480, 65° across")
        optics = Optics(tour_camera())
    return CameraAndOptics(camera, optics)
