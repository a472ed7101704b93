"""Defaults and checks for a simulated robot, and hints where the line to a robot is bad.

An address does not identify a simulated robot: a real one, too, can be reached at 127.0.0.1. What
counts is the serial number that the robot reports in CONFIG: that of `facetlog simulate` names it
and its camera, others ("SIM" of AMRISim) have cameras of their own.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Protocol
from urllib.parse import urlsplit

from facetlog.errors import DeviceError, DeviceTimeout, InputError
from facetlog.robot.camera.optics import Optics
from facetlog.robot.pioneer.control import WATCHDOG
from facetlog.robot.pioneer.guard import Cause, Problem
from facetlog.robot.pioneer.packets.reports import Configuration
from facetlog.robot.pose2 import Pose2
from facetlog.robot.tour import tour_camera

# The line is suspect if reports ceased this often within so many seconds before a fault: once may
# be a machine that was busy for a moment.
BACK, OFTEN = 30.0, 2
# A robot that goes on for no more than this when its line is cut is not worth a word, m.
COASTS = 0.2


def add_line_hint(fault: DeviceError, problems: Iterable[Problem], now: float) -> DeviceError:
    """Return the fault, with a remark about the line if reports ceased repeatedly before it.

    `problems` are the driver's, `now` is a time of its clock. A lost link needs no remark.
    """
    problems = tuple(problems)
    silences = sum(each.cause is Cause.QUIET and now - each.at <= BACK for each in problems)
    if silences < OFTEN or any(each.cause is Cause.LINK_LOST for each in problems):
        return fault
    return type(fault)(
        f"{fault} - but first: {silences} times in {BACK:.0f} s no whole report of the robot came "
        "for half a second, so its line is damaged or this machine too busy; check cable and baud "
        "rate"
    )


def describe_coasting(configuration: Configuration | None, speed: float) -> str:
    """Return what to say of a robot at a speed (m/s) that goes on for long where its line is cut,
    "" where it does not.

    No command of a client sets the time: it is a parameter in the robot's FLASH.

    >>> describe_coasting(None, 0.05)
    ''
    """
    watchdog_ms = None if configuration is None else configuration.watchdog_ms
    if watchdog_ms is None:
        coasts, usual = speed * WATCHDOG, f"{WATCHDOG:g} s"
        if coasts <= COASTS:
            return ""
        return (
            f"the robot does not report its watchdog: with the usual {usual} it would go on for "
            f"{coasts:.1f} m, were its line cut while it drives, and without one for good"
        )
    if watchdog_ms == 0:
        return (
            "the robot's own watchdog is off: were its line cut while it drives, it would not stop"
        )
    coasts = speed * watchdog_ms / 1e3
    if coasts <= COASTS:
        return ""
    return (
        f"the robot's own watchdog is {watchdog_ms / 1e3:g} s: were its line cut while it drives, "
        f"it would go on for {coasts:.1f} m before it brakes"
    )


# Hosts of robots and cameras on this machine.
LOCAL = ("127.", "localhost", "/dev/pts/")
# How far the robot may stand from the given start: small enough to count as the same place.
NEAR, NEAR_HEADING = 0.05, math.radians(3.0)


class ConnectedRobot(Protocol):
    """The part of the driver that is used here."""

    @property
    def configuration(self) -> Configuration | None:
        """The robot's CONFIG report; None from old firmware."""

    def ask_true_pose(self) -> Pose2:
        """Return the true pose of a simulated robot; DeviceTimeout if it is not reported."""


@dataclass(frozen=True, eq=False, slots=True)
class CameraAndOptics:
    """A camera's address, and its calibration."""

    camera: str
    optics: Optics


def is_simulated(robot: ConnectedRobot) -> bool:
    """Return whether the robot reports that it is of `facetlog simulate`."""
    return robot.configuration is not None and robot.configuration.simulated


def check_start(robot: ConnectedRobot, start: Pose2, warn: Callable[[str], None]) -> None:
    """Raise InputError if a simulated robot is elsewhere than at `start` in its world.

    It stays where an earlier session left it, and unlike a real robot's that place is not visible.
    """
    if not is_simulated(robot):
        return
    try:
        true = robot.ask_true_pose()
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


def choose_camera_and_optics(
    robot: ConnectedRobot,
    address: str,
    camera: str | None,
    optics: Optics | None,
    note: Callable[[str], None],
) -> CameraAndOptics:
    """Return the given camera and optics, with those of the simulated camera where none are given.

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
