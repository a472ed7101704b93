"""The interface of a pan-tilt head, its limits, and waiting until it stands at its goal."""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, TypeVar

from facetlog.errors import DeviceError, DeviceTimeout, InputError

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class HeadState:
    """A head's angles: radians, pan left positive, tilt up positive, zero ahead and level."""

    pan: float
    tilt: float
    zoom: int
    """In the device's own counts, 0 the widest; not linear in the angle of view."""
    at: float
    """Time of the report, in seconds of the monotonic clock."""
    reported: bool = True
    """Whether the head reported them; False where it cannot answer: the commanded angles."""


@dataclass(frozen=True, slots=True)
class HeadLimits:
    """How far a head can turn and in what steps, radians; the largest zoom in its own counts."""

    pan_min: float
    pan_max: float
    tilt_min: float
    tilt_max: float
    pan_step: float
    tilt_step: float
    zoom_max: int

    def check(self, pan: float, tilt: float) -> None:
        """Raise InputError if the head cannot look there; half a step beyond a limit is allowed."""
        for name, angle, lowest, highest, step in (
            ("pan", pan, self.pan_min, self.pan_max, self.pan_step),
            ("tilt", tilt, self.tilt_min, self.tilt_max, self.tilt_step),
        ):
            # Written so that NaN is refused as well.
            if not lowest - step / 2 <= angle <= highest + step / 2:
                raise InputError(
                    f"{name} {math.degrees(angle):.1f}° is beyond the {math.degrees(lowest):.1f}° …"
                    f" {math.degrees(highest):.1f}° of this camera head: turn the robot, or leave"
                    " the view out of the tour"
                )


class PanTiltHead(Protocol):
    """A camera head on a line; one thread at a time may use it.

    DeviceTimeout where it does not answer or finish in time, DeviceError where it refuses,
    InputError for angles and zooms that it cannot reach.
    """

    @property
    def limits(self) -> HeadLimits:
        """How far it can turn; of a family of heads, known for certain after `start`."""

    def start(self) -> None:
        """Switch it on if it is off, set its widest zoom, and wait until it accepts commands."""

    def look(self, pan: float, tilt: float, timeout: float = 10.0) -> HeadState:
        """Turn to `pan`, `tilt` (radians) and return where it stands once it is still."""

    def close(self) -> None:
        """Give its line back; the head stays as it stands."""


Counts = tuple[int, ...]
"""Positions of pan and tilt, or of the zoom, in the device's own steps."""

POLL_S = 0.1
"""Between two inquiries, seconds: a robot with P2OS accepts one command in each of its cycles of
0.05 to 0.1 s, and an inquiry through it takes four commands."""
STILL_S = 0.3
"""Within tolerance of its target a head stands if its position has not changed for so long,
seconds: one that creeps at a degree a second changes it by a count in 0.1."""
STARTING_S = 0.6
"""A head that has not begun to move by then will not, seconds (a command takes effect within a few
pictures; the rest is for a slow line)."""


@dataclass(frozen=True, slots=True)
class Clock:
    """The time in seconds and a way to let it pass; tests give their own."""

    now: Callable[[], float] = time.monotonic
    sleep: Callable[[float], None] = time.sleep


def wait_until_still(
    read: Callable[[], Counts],
    target: Counts,
    tolerance: Counts,
    deadline: float,
    clock: Clock,
) -> tuple[Counts, bool]:
    """Return the position at rest, by equal answers of `read`, and whether that is at `target`.

    At the target itself two equal answers are enough; within `tolerance` of it they must be equal
    for `STILL_S`, elsewhere, where it may not have begun to move, for `STARTING_S`. DeviceTimeout
    if it still moves at `deadline`.
    """
    before = read()
    since = clock.now()
    while True:
        clock.sleep(POLL_S)
        here = read()
        now = clock.now()
        if here == before:
            there = all(
                abs(place - goal) <= most
                for place, goal, most in zip(here, target, tolerance, strict=True)
            )
            enough = 0.0 if here == target else STILL_S if there else STARTING_S
            if now - since >= enough:
                return here, there
        else:
            before, since = here, now
        if now > deadline:
            raise DeviceTimeout(
                f"the camera head is at {here} of its counts and not still at {target} in the time"
                " it was given: give it more, or see whether something holds it"
            )


READ_ATTEMPTS = 5
"""Attempts before a head counts as silent: where one byte in fifty is lost, five answers of
fourteen bytes in a row are spoilt once in a thousand times."""


def ask_repeatedly(
    ask: Callable[[], T], pause: Callable[[], None], *, unreadable: type[Exception], checks: str
) -> T:
    """Return what `ask` returns, at most READ_ATTEMPTS times with a pause between.

    Raise DeviceTimeout if the head never answers, with further `checks` in words, and DeviceError
    if no answer can be decoded.
    """
    fault: Exception | None = None
    for attempt in range(READ_ATTEMPTS):
        if attempt:
            pause()
        try:
            return ask()
        except (DeviceTimeout, unreadable) as exc:
            if not isinstance(fault, unreadable):
                fault = exc
    if isinstance(fault, unreadable):
        raise DeviceError(
            f"the camera head answers what cannot be read ({fault}): check that the line runs"
            " at 9600 baud and that nothing else talks on it"
        ) from fault
    raise DeviceTimeout(
        "the camera head does not answer: check that it has power, that its cable is in the"
        f" port that was named (of the robot: AUX1, AUX2 or AUX3){checks}"
    ) from fault
