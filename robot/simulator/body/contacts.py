"""Bumpers and stalls of a robot that runs into something, and how long they last."""

import math
from dataclasses import dataclass, field

from facetlog.robot.simulator.body.dynamics import Contact, Truth

__all__ = ["Contacts", "pressed"]

STALL_SECONDS = 0.5
"""How long the wheels push before they are found to be stalled: "a second or more" without bumpers
on a robot that is built to climb (Pioneer 2 manual, page 45); a still world stops it sooner."""


def pressed(contact: Contact | None, truth: Truth, front: int, rear: int) -> tuple[int, int]:
    """Bits of the bumpers that a contact presses: in front (leftmost lowest), behind (rightmost).

    Each ring covers half of the robot with so many segments.
    """
    if contact is None:
        return 0, 0
    angle = math.remainder(contact.direction - truth.heading, 2 * math.pi)
    if abs(angle) <= math.pi / 2:
        return _bit(math.pi / 2 - angle, front), 0
    return 0, _bit((-angle - math.pi / 2) % (2 * math.pi), rear)


def _bit(angle: float, count: int) -> int:
    """Of the segment at this angle of half a circle."""
    return 1 << min(int(angle / math.pi * count), count - 1) if count else 0


@dataclass(slots=True)
class Contacts:
    """Stall bits of the wheels, from pushing too long or from a bumper that counts as a stall."""

    pause: float
    """Seconds for which a stalled wheel is not driven again (StallCount)."""
    _pushing: float | None = field(default=None, init=False)
    _until: float | None = field(default=None, init=False)

    @property
    def stalled(self) -> bool:
        """Whether both wheels are said to be stalled."""
        return self._until is not None

    def stall(self, now: float, seconds: float = 0.0) -> None:
        """Stalls the wheels for a while, at least for the pause."""
        self._until = max(self._until or 0.0, now + max(seconds, self.pause))

    def free(self) -> None:
        """Ends a stall."""
        self._until, self._pushing = None, None

    def step(self, now: float, *, blocked: bool, bumped: bool) -> None:
        """Updates the stall after a step of motion: whether something `blocked` the robot.

        `bumped`: a bumper that counts as a stall is pressed.
        """
        if self._until is not None:
            if now >= self._until:
                self.free()
        elif not blocked:
            self._pushing = None
        else:
            self._pushing = now if self._pushing is None else self._pushing
            if bumped or now - self._pushing >= STALL_SECONDS:
                self.stall(now)
