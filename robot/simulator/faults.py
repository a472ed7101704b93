"""Faults of the simulated robot, on demand or by a world file, and a line that loses bytes."""

import heapq
import itertools
from collections import deque
from enum import StrEnum
from typing import Annotated

import numpy as np
from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass

Share = Annotated[float, Field(ge=0.0, le=1.0, allow_inf_nan=False)]
Seconds = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]


class FaultKind(StrEnum):
    """Each with the fields of `Fault` that it uses."""

    LOST = "lost"
    """`rate`: bytes of the line to the client that do not arrive, either way."""
    CORRUPT = "corrupt"
    """`rate`: bytes that arrive as others."""
    LATE = "late"
    """`rate`: pieces of traffic that arrive `delay` seconds later; their order is kept."""
    FROZEN = "frozen"
    """Nothing gets through for so many `seconds`; then everything at once."""
    HUNG_UP = "hung-up"
    """The client's TCP connection is closed; the robot is as it was, and takes another."""
    POWER_CYCLE = "power-cycle"
    """The robot is off for so many `seconds`, and starts anew."""
    LOW_BATTERY = "low-battery"
    """`volts`."""
    STALL = "stall"
    """The wheels stall, for `seconds`."""
    MOTORS_OFF = "motors-off"
    """Somebody presses the button that switches the motors off."""
    STOP_BUTTON = "stop-button"
    """The red button is pressed."""
    HEAD_SILENT = "head-silent"
    """The camera head neither hears nor answers."""
    CAMERA_FROZEN = "camera-frozen"
    """The camera sends the same picture again and again."""
    CAMERA_SILENT = "camera-silent"
    """The camera sends nothing."""


# Faults that last until they are ended if no duration is given; the others are over at once.
DEFAULT_SECONDS = {
    FaultKind.FROZEN: 0.5,
    FaultKind.HUNG_UP: 0.0,
    FaultKind.POWER_CYCLE: 1.0,
    FaultKind.STALL: 1.0,
}


@dataclass(frozen=True, slots=True, config=ConfigDict(extra="forbid"))
class Fault:
    """One fault. `on = false` ends one; with `seconds` it ends by itself after so long."""

    kind: FaultKind
    on: bool = True
    rate: Share = 0.05
    delay: Seconds = 0.2
    seconds: Seconds | None = None
    volts: Annotated[float, Field(ge=0.0, le=25.5, allow_inf_nan=False)] = 10.8

    @property
    def lasts(self) -> float | None:
        """Seconds; None: until it is ended."""
        return DEFAULT_SECONDS.get(self.kind) if self.seconds is None else self.seconds

    @property
    def end(self) -> "Fault | None":
        """The fault that ends it, for those that must be ended explicitly."""
        if not self.on or self.lasts is None or self.kind in DEFAULT_SECONDS:
            return None
        return Fault(self.kind, on=False)


class Schedule:
    """Faults in the order of their times, seconds of the simulation."""

    def __init__(self) -> None:
        self._heap: list[tuple[float, int, Fault]] = []
        self._count = itertools.count()

    def add(self, at: float, fault: Fault) -> None:
        """Add a fault to come, and its end if it has one."""
        heapq.heappush(self._heap, (at, next(self._count), fault))
        if fault.end is not None and fault.lasts is not None:
            heapq.heappush(self._heap, (at + fault.lasts, next(self._count), fault.end))

    @property
    def next_at(self) -> float | None:
        """When the next one is due."""
        return self._heap[0][0] if self._heap else None

    def due(self, now: float) -> list[Fault]:
        """Return the faults whose time has come; each once."""
        found = []
        while self._heap and self._heap[0][0] <= now:
            found.append(heapq.heappop(self._heap)[2])
        return found


class FaultyLine:
    """Bytes that go in come out, in their order; rates are shares in [0, 1], times in seconds."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self.lost = 0.0
        """Share of bytes that do not arrive."""
        self.corrupt = 0.0
        """Share of bytes that arrive as others."""
        self.late = 0.0
        """Share of pieces that arrive `delay` later, with all that comes after them."""
        self.delay = 0.0
        self.frozen_until = 0.0
        """Until when nothing comes out."""
        self._queue: deque[tuple[float, bytes]] = deque()

    def push(self, data: bytes, now: float) -> None:
        """Take a piece of traffic."""
        if not data:
            return
        due = now
        if self.late and self._rng.random() < self.late:
            due += self.delay
        if self._queue:
            due = max(due, self._queue[-1][0])
        self._queue.append((due, self._pass_through_line(data)))

    @property
    def next_at(self) -> float | None:
        """When the next bytes are due."""
        return max(self._queue[0][0], self.frozen_until) if self._queue else None

    def pull(self, now: float) -> bytes:
        """Return the bytes that have arrived by `now`; each once."""
        found = b""
        while (due := self.next_at) is not None and due <= now:
            found += self._queue.popleft()[1]
        return found

    def _pass_through_line(self, data: bytes) -> bytes:
        if not (self.lost or self.corrupt):
            return data
        values = np.frombuffer(data, dtype=np.uint8)
        wrong = self._rng.random(len(values)) < self.corrupt
        # Adding 1 to 255 modulo 256 gives any other value than the true one.
        shift = self._rng.integers(1, 256, len(values), dtype=np.uint8)
        changed = np.where(wrong, values + shift, values).astype(np.uint8)
        return changed[self._rng.random(len(values)) >= self.lost].tobytes()
