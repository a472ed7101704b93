"""The driver's messages, and how a collection ended early, worded for the command line.

The driver's errors name the call that helps ("call enable_motors()"). At the command line it cannot
be called: the command is run again, with options.
"""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, TypeVar

from facetlog.errors import DeviceError, FacetlogError

if TYPE_CHECKING:
    from facetlog.robot.collecting.session import Ended

__all__ = [
    "COLLECT_AGAIN",
    "MOUNT_AGAIN",
    "early_end_line",
    "resumed_from",
    "worded",
    "wording_errors",
]

Fault = TypeVar("Fault", bound=FacetlogError)

RESUME = "go on with --resume --start "
COLLECT_AGAIN = f"{RESUME}X,Y,HEADING_DEG"
MOUNT_AGAIN = "call facetlog mount again"
AGAIN = "AGAIN"
# In this order: the driver adds the first to others that say what to do.
WORDS = (
    (re.compile(r"(enable_motors\(\).*); then call clear_stop\(\) to drive on"), r"\1"),
    (re.compile(r"then call clear_stop\(\) to drive on"), f"then {AGAIN}"),
    (re.compile(r"(MOTORS button) or call enable_motors\(\)"), rf"\1, then {AGAIN}"),
    (re.compile(r"then (call enable_motors\(\)|switch the motors on)"), f"then {AGAIN}"),
    (re.compile(r"then (go on with )?--resume(?! --start)"), f"then {AGAIN}"),
    (re.compile(r"\bmodel= "), "--model "),
    (re.compile(r"\bbaud=(?=\d)"), "--baud "),
    (
        re.compile(r"(the CTS line of its port \(pin 2\) is high)"),
        r"\1; a Canon head whose cable carries no answers needs --head-unheard",
    ),
)


def worded(fault: Fault, again: str) -> Fault:
    """The error in the command line's words; `again` says how to continue the command.

    >>> stop = DeviceError("STOP button pressed: pull it out, then call enable_motors()")
    >>> str(worded(stop, MOUNT_AGAIN))
    'STOP button pressed: pull it out, then call facetlog mount again'
    """
    text = str(fault)
    for pattern, words in WORDS:
        text = pattern.sub(words, text)
    return type(fault)(text.replace(AGAIN, again))


@contextmanager
def wording_errors(again: str) -> Iterator[None]:
    """Device errors of the body leave it in the command line's words."""
    try:
        yield
    except DeviceError as exc:
        raise worded(exc, again) from exc


def resumed_from(ended: "Ended") -> str:
    """How to go on after a collection that ended early, from the robot's place if that is known."""
    from facetlog.robot.collecting.last_place import stated_pose

    return COLLECT_AGAIN if ended.robot is None else RESUME + stated_pose(ended.robot)


def early_end_line(ended: "Ended", there: int, total: int, *, most: str = "") -> str:
    """The one line on a collection that ended early: why, how to go on, and what is there.

    `most` goes before the total.
    """
    again = resumed_from(ended)
    where = (
        "where it stands by odometry"
        if ended.stands
        else "where it was last heard, and may have gone on"
    )
    if ended.robot is None:
        where = "where the robot stands"
    views = f"{there} of {most}{total} views are there"
    why = ended.why if ended.fault is None else str(worded(ended.fault, again))
    on = "" if again in why else f"; {again}"
    return f"{why}{on} ({where}); {views}"
