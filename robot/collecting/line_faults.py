"""Whether a bad line to the robot may be behind a fault, and what a line that is cut would mean."""

from collections.abc import Iterable

from facetlog.errors import DeviceError
from facetlog.robot.pioneer.motion import WATCHDOG
from facetlog.robot.pioneer.packets.configuration import Configuration
from facetlog.robot.pioneer.problems import Cause, Problem

__all__ = ["coasts_when_cut", "with_line"]

# The line is suspect if reports ceased this often within so many seconds before a fault: once may
# be a machine that was busy for a moment.
BACK, OFTEN = 30.0, 2
# A robot that goes on for no more than this when its line is cut is not worth a word, m.
COASTS = 0.2


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


def coasts_when_cut(configuration: Configuration | None, speed: float) -> str:
    """Return what to say of a robot at a speed (m/s) that goes on for long where its line is cut,
    "" where it does not.

    No command of a client sets the time: it is a parameter in the robot's FLASH.

    >>> coasts_when_cut(None, 0.05)
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
