"""Problems while driving: their cause, a message, and whether the robot was stopped."""

from dataclasses import dataclass
from enum import StrEnum

__all__ = ["Cause", "Problem"]


class Cause(StrEnum):
    """Kinds of problems."""

    BUMPER = "bumper"
    STALL = "stall"
    STOP_BUTTON = "stop button"
    MOTORS_OFF = "motors off"
    NOT_MOVING = "not moving"
    LOW_BATTERY = "low battery"
    EMERGENCY = "emergency stop"
    LEASE = "lease"
    """The lease ran out: the program did not renew it."""
    HELD_UP = "held up"
    """The program did not run for a while as the robot drove; the robot is halted."""
    QUIET = "quiet"
    """No reports for a while."""
    LINK_LOST = "link lost"
    RESET = "reset"
    REPORTS_AGAIN = "reports again"
    """Reports come again after a silence while the robot drove."""
    ODOMETRY = "odometry"
    SCALE = "scale"
    """What the robot reports disagrees on its own scale."""
    LOG = "log"
    CALLBACK = "callback"


@dataclass(frozen=True, slots=True)
class Problem:
    """One of them; `at` is a time of the driver's clock in seconds."""

    cause: Cause
    text: str
    """What happened, and what to do where something can be done; one line."""
    at: float
    stopped: bool = False
    """Whether the robot was stopped for it."""

    def __str__(self) -> str:
        return self.text
