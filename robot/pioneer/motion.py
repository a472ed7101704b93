"""What is sent to the robot when: speeds under a lease, zeros until it stands, then its heartbeat.

No I/O, no thread: times come in, packets go out. Speeds are repeated while their lease is renewed,
and zeros are sent as soon as it runs out. A robot that has received nothing for its watchdog's time
stops, and with the next packet of any kind resumes its last speed (Pioneer 2 manual, pages 40 and
42): so after a gap the first packets are zeros, whatever else is to be sent.
"""

import math
from collections.abc import Callable

from facetlog.robot.pioneer.limits import Limits
from facetlog.robot.pioneer.packets.commands import (
    Command,
    argument_of,
    integer_command,
    plain_command,
)
from facetlog.robot.pioneer.packets.packet import Packet
from facetlog.robot.pioneer.problems import Cause

__all__ = ["LONGEST_LEASE", "WATCHDOG", "Motion"]

REPEAT = 0.15
"""Seconds after which speeds are sent again: two packets, of about one in 50 ms that P2OS takes."""
SPACING = 0.05
"""Seconds between two changes of speed, for the same reason."""
ZERO_REPEAT = 0.1
"""Seconds between zeros until the robot is reported to stand: a zero may be lost too."""
PULSE_SHARE = 0.25
"""Share of the watchdog's time after which a standing robot gets a heartbeat."""
ZEROS = 3
"""Zeros that must be sent before a report of standing counts."""
WATCHDOG = 2.0
"""Seconds, the maker's default."""
GAP_SHARE = 0.6
"""Share of the watchdog's time: a gap that long may have been longer for the robot."""
LONGEST_LEASE = 0.3
"""Seconds: with 0.05 until P2OS looks at the zeros and `limits.BRAKING_TIME` the robot stands 0.6 s
after whoever drove it hangs."""


class Motion:
    """Turns leases into packets."""

    def __init__(self, now: float, limits: Limits, watchdog: float = WATCHDOG) -> None:
        self._limits = limits
        self._gap, self._pulse = GAP_SHARE * watchdog, PULSE_SHARE * watchdog
        self._wanted = (0.0, 0.0)
        self._until = now
        self._alive: Callable[[], bool] | None = None
        self._sent = (0, 0)
        self._pair_at = -math.inf
        self._last_out = now
        self._zeros = 0
        self._stands = False
        self._hard = False
        self._ended: tuple[Cause, str] | None = None

    @property
    def commanded(self) -> tuple[float, float]:
        """The last speeds sent, m/s and rad/s."""
        return self._sent[0] / 1e3, math.radians(self._sent[1])

    @property
    def lease_end(self) -> float | None:
        """Until when what was sent last may last; None if the robot is known to stand."""
        if self._stands and not any(self._sent):
            return None
        return self._until if any(self._sent) else self._pair_at + LONGEST_LEASE

    def stopping(self) -> list[Packet]:
        """The packets that stop the robot as it was commanded last, hard if it must be."""
        zeros = [integer_command(Command.VEL, 0), integer_command(Command.RVEL, 0)]
        hard = not self._limits.brakes_in_time(*self.commanded)
        return [plain_command(Command.ESTOP), *zeros] if hard else zeros

    @property
    def due(self) -> float:
        """When `advance` is to be called at the latest."""
        if self._integers() != self._sent:
            return self._pair_at + (SPACING if any(self._integers()) else 0.0)
        if any(self._sent):
            return min(self._pair_at + REPEAT, self._until)
        if not self._stands:
            return self._pair_at + ZERO_REPEAT
        return self._last_out + self._pulse

    def drive(
        self,
        speed: float,
        turning: float,
        lease: float,
        now: float,
        alive: Callable[[], bool] | None = None,
    ) -> None:
        """Sets the speeds until `now + lease`, as long as `alive` returns true."""
        self._wanted, self._until, self._alive = (speed, turning), now + lease, alive

    def rest(self, *, hard: bool = False, in_time: bool = False) -> None:
        """Sets zero speeds from now on.

        `hard`: with an emergency stop; `in_time`: with one if the robot would otherwise not stand
        within `BRAKING_TIME`.
        """
        hard = hard or (in_time and not self._limits.brakes_in_time(*self.commanded))
        self._wanted, self._alive = (0.0, 0.0), None
        self._zeros, self._stands = 0, False
        self._hard = self._hard or hard

    def saw(self, standing: bool) -> None:
        """Notes a report: whether the robot stands."""
        if not standing:
            self._stands = False
        elif self._zeros >= ZEROS and not any(self._sent):
            self._stands = True

    def take_ended(self) -> tuple[Cause, str] | None:
        """Why the last lease ended if it ran out or its thread did; returned once."""
        ended, self._ended = self._ended, None
        return ended

    def held_up(self, now: float) -> bool:
        """Whether nothing was sent for so long that the watchdog may have stopped the robot."""
        return now - self._last_out >= self._gap

    def before_other(self, now: float) -> list[Packet]:
        """The packets that must precede another part's packet at `now`."""
        packets = self._zeros_first(now)
        self._last_out = now
        return packets

    def went_out(self, packet: Packet) -> None:
        """Updates the commanded speeds from a packet, in the replay of a log."""
        if packet.kind in (Command.VEL, Command.RVEL):
            value = argument_of(packet)
            speed, turning = self._sent
            if isinstance(value, int):
                self._sent = (value, turning) if packet.kind == Command.VEL else (speed, value)

    def advance(self, now: float) -> list[Packet]:
        """The packets to send at `now`."""
        packets = self._zeros_first(now)
        if packets:
            return packets
        self._check_lease(now)
        if self._hard:
            self._hard = False
            return [plain_command(Command.ESTOP), *self._pair((0, 0), now)]
        if now < self.due:
            return []
        wanted = self._integers()
        if wanted != self._sent or any(wanted) or not self._stands:
            return self._pair(wanted, now)
        self._last_out = now
        return [plain_command(Command.PULSE)]

    def _zeros_first(self, now: float) -> list[Packet]:
        if not self.held_up(now):
            return []
        if any(self._wanted) or any(self._sent):
            seconds = now - self._last_out
            text = (
                f"the program was held up for {seconds:.1f} s while the robot drove, and the robot"
                " was stopped: see where it stands and that its way is free"
            )
            self._ended = Cause.HELD_UP, text
        hard = self._hard
        self.rest()
        self._hard = False
        first = [plain_command(Command.ESTOP)] if hard else []
        return first + self._pair((0, 0), now)

    def _check_lease(self, now: float) -> None:
        if not any(self._wanted):
            return
        if self._alive is not None and not self._alive():
            self._ended = Cause.LEASE, "the thread that drove the robot has ended"
        elif now >= self._until:
            text = "the lease on the speed ran out: drive() was not called again in time"
            self._ended = Cause.LEASE, text
        else:
            return
        self.rest(in_time=True)

    def _integers(self) -> tuple[int, int]:
        return round(self._wanted[0] * 1e3), round(math.degrees(self._wanted[1]))

    def _pair(self, values: tuple[int, int], now: float) -> list[Packet]:
        self._sent, self._pair_at, self._last_out = values, now, now
        self._zeros = 0 if any(values) else self._zeros + 1
        if any(values):
            self._stands = False
        return [
            integer_command(Command.VEL, values[0]),
            integer_command(Command.RVEL, values[1]),
        ]
