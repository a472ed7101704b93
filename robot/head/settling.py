"""Waiting until a head stands at its commanded position, by its own reports."""

import time
from collections.abc import Callable
from dataclasses import dataclass

from facetlog.errors import DeviceTimeout

__all__ = ["Clock", "Counts", "wait_until_still"]

Counts = tuple[int, ...]
"""Of pan and tilt, or of the zoom: places in the device's own steps."""

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
    """The position at rest, by equal answers of `read`, and whether that is at `target`.

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
