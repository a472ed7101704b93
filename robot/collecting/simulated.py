"""What a robot that is simulated may be taken for: where it truly stands, what it is seen with.

An address says nothing of that: a real robot too is reached by 127.0.0.1, through a tunnel or a
serial server. What counts is what the robot says of itself in CONFIG.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol
from urllib.parse import urlsplit

from facetlog.errors import DeviceTimeout, InputError
from facetlog.robot.collecting.optics import Optics
from facetlog.robot.pioneer.configuration import Configuration
from facetlog.robot.pose2 import Pose2
from facetlog.robot.tour import tour_camera

__all__ = ["SIMULATED_CAMERA", "Asked", "Sight", "check_start", "is_simulated", "sight"]

# The serial number that simulators give: AMRISim, and `facetlog simulate`.
SIMULATED_SERIAL_NUMBER = "SIM"
SIMULATED_CAMERA = "http://127.0.0.1:8100/"
"""What `facetlog simulate` offers if it is called without options."""
# Where robots and cameras are that are reached on this machine.
LOCAL = ("127.", "localhost", "/dev/pts/")
# How far the robot may stand from where it is said to: as much as nobody calls another place.
NEAR, NEAR_HEADING = 0.05, math.radians(3.0)


class Asked(Protocol):
    """Of the driver, what is asked here."""

    @property
    def configuration(self) -> Configuration | None:
        """What the robot says of itself; None from old firmware."""

    def true_pose(self) -> Pose2:
        """Where a simulated robot truly is; DeviceTimeout if it does not say so."""


@dataclass(frozen=True, eq=False, slots=True)
class Sight:
    """A camera's address, and its calibration."""

    camera: str
    optics: Optics


def is_simulated(robot: Asked) -> bool:
    """Whether the robot says that it is."""
    configuration = robot.configuration
    return configuration is not None and configuration.serial_number == SIMULATED_SERIAL_NUMBER


def check_start(robot: Asked, start: Pose2, warn: Callable[[str], None]) -> None:
    """InputError if a simulated robot stands elsewhere than at `start` in its world.

    It stays where an earlier session left it, which nobody sees as that of a real one is seen.
    """
    if not is_simulated(robot):
        return
    try:
        true = robot.true_pose()
    except DeviceTimeout:
        warn("the simulated robot does not say where it stands: see that --start is true")
        return
    off = start.between(true)
    if math.hypot(off.x, off.y) <= NEAR and abs(off.heading) <= NEAR_HEADING:
        return
    place = f"{true.x:.3f},{true.y:.3f},{math.degrees(true.heading):.1f}"
    raise InputError(
        f"the simulated robot stands at {place.replace(',', ', ')} (m, m, degrees): give --start "
        f"{place}, or start facetlog simulate anew"
    )


def sight(
    robot: Asked,
    address: str,
    camera: str | None,
    optics: Optics | None,
    note: Callable[[str], None],
) -> Sight:
    """What is told, and of what is not told the simulated camera's.

    InputError where that must be told: of a robot that is not simulated, or not on this machine.
    """
    simulated = is_simulated(robot)
    if camera is None:
        place = address.removeprefix("tcp:").removeprefix("serial:")
        if not (simulated and place.startswith(LOCAL)):
            raise InputError(
                f"which camera is on {address}? Give --camera: 0, /dev/video0, http://…"
            )
        camera = SIMULATED_CAMERA
    if optics is None:
        if not (simulated and (urlsplit(camera).hostname or "").startswith(LOCAL)):
            raise InputError(f"camera {camera} needs its calibration: give --camera-file")
        note("no --camera-file: the camera is taken to be the simulated one, 640 x 480, 65° across")
        optics = Optics(tour_camera())
    return Sight(camera, optics)
