"""Messages of the driver and of a collection in the options of the command line.

The driver's errors name the call that helps ("call enable_motors()"). Who collects or mounts a head
cannot call it: the command is run again, with options.
"""

import math
import re
from typing import TypeVar

from facetlog.errors import FacetlogError
from facetlog.robot.pose2 import Pose2, wrapped

Fault = TypeVar("Fault", bound=FacetlogError)

RESUME = "go on with --resume --start "
COLLECT_AGAIN = f"{RESUME}X,Y,HEADING_DEG"
AGAIN = "AGAIN"
# In this order: the driver adds the first to others that say what to do.
WORDS = (
    (re.compile(r"(enable_motors\(\).*); then call clear_stop\(\) to drive on"), r"\1"),
    (re.compile(r"then call clear_stop\(\) to drive on"), f"then {AGAIN}"),
    (re.compile(r"(MOTORS button) or call enable_motors\(\)"), rf"\1, then {AGAIN}"),
    (re.compile(r"then (call enable_motors\(\)|switch the motors on)"), f"then {AGAIN}"),
    (re.compile(r"then (go on with )?--resume(?! --start)"), f"then {AGAIN}"),
    # Something else is to be done first: how to go on comes after it.
    (re.compile(rf", then {AGAIN}(; see that the STOP button is out)"), rf"\1, then {AGAIN}"),
    (re.compile(rf"[,;] then {AGAIN}(?=.*[,;] then {AGAIN})", re.DOTALL), ""),
    (re.compile(r"\bmodel= "), "--model "),
    (re.compile(r"\bbaud=(?=\d)"), "--baud "),
    (
        re.compile(r"(the CTS line of its port \(pin 2\) is high)(?!; a Canon)"),
        r"\1; a Canon head whose cable carries no answers needs --head-unheard",
    ),
)


def worded(fault: Fault, again: str) -> Fault:
    """Return the error in the command line's words; `again` says how to continue the command.

    One that is worded already stays as it is.

    >>> from facetlog.errors import DeviceError
    >>> stop = DeviceError("STOP button pressed: pull it out, then call enable_motors()")
    >>> str(worded(stop, "call facetlog mount again"))
    'STOP button pressed: pull it out, then call facetlog mount again'
    """
    text = str(fault)
    for pattern, words in WORDS:
        text = pattern.sub(words, text)
    return type(fault)(text.replace(AGAIN, again))


def describe_resume(robot: Pose2 | None) -> str:
    """Return how to go on with a collection whose robot is there in the world, if that is known."""
    return COLLECT_AGAIN if robot is None else RESUME + format_start_pose(robot)


def format_start_pose(pose: Pose2) -> str:
    """Return a pose as `--start` takes it: metres, and degrees within ±180.

    >>> format_start_pose(Pose2(1.5, 0.25, math.radians(-251.6)))
    '1.500,0.250,108.4'
    """
    return f"{pose.x:.3f},{pose.y:.3f},{math.degrees(wrapped(pose.heading)):.1f}"
