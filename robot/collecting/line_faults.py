"""Whether a bad line to the robot may have caused a fault that looks like another one."""

from collections.abc import Iterable

from facetlog.errors import DeviceError
from facetlog.robot.pioneer.problems import Cause, Problem

__all__ = ["with_line"]

# The line is suspect if reports ceased this often within so many seconds before a fault: once may
# be a machine that was busy for a moment.
BACK, OFTEN = 30.0, 2


def with_line(fault: DeviceError, problems: Iterable[Problem], now: float) -> DeviceError:
    """The fault, with a remark about the line if reports ceased repeatedly before it.

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
