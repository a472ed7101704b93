"""The driver's control logic, without I/O, clock or thread: reports and commands in, packets out.

Speeds are repeated while their lease is renewed, and zeros are sent as soon as it runs out. A robot
that has received nothing for its watchdog's time stops, and resumes its last speed with the next
packet of any kind (Pioneer 2 manual, pages 40 and 42): so after a gap the first packets are zeros,
whatever else is to be sent.
"""

import math
from collections import deque
from collections.abc import Callable, Iterable

from facetlog.errors import DeviceError, DeviceTimeout
from facetlog.robot.pioneer.guard import Cause, Guard, Problem, ScaleCheck
from facetlog.robot.pioneer.limits import Limits, make_limit_settings, make_restoring_settings
from facetlog.robot.pioneer.line.dead_man import NotStoppedError
from facetlog.robot.pioneer.packets.commands import (
    Command,
    make_integer_command,
    make_plain_command,
    read_argument,
)
from facetlog.robot.pioneer.packets.packet import Packet, PacketError, Received
from facetlog.robot.pioneer.packets.reports import (
    SIP_KINDS,
    Configuration,
    Report,
    ServerInformation,
)
from facetlog.robot.pioneer.parameters import Parameters
from facetlog.robot.pioneer.state import OdometryErrors, RobotState, StateMaker

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
        """Return the packets that stop the robot as it was commanded last, hard if it must be."""
        zeros = [make_integer_command(Command.VEL, 0), make_integer_command(Command.RVEL, 0)]
        hard = not self._limits.can_brake_in_time(*self.commanded)
        return [make_plain_command(Command.ESTOP), *zeros] if hard else zeros

    @property
    def due(self) -> float:
        """When `advance` is to be called at the latest."""
        if self._round_speeds() != self._sent:
            return self._pair_at + (SPACING if any(self._round_speeds()) else 0.0)
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
        """Set the speeds until `now + lease`, as long as `alive` returns true."""
        self._wanted, self._until, self._alive = (speed, turning), now + lease, alive

    def rest(self, *, hard: bool = False, in_time: bool = False) -> None:
        """Set zero speeds from now on.

        `hard`: with an emergency stop; `in_time`: with one if the robot would otherwise not stand
        within `BRAKING_TIME`.
        """
        hard = hard or (in_time and not self._limits.can_brake_in_time(*self.commanded))
        self._wanted, self._alive = (0.0, 0.0), None
        self._zeros, self._stands = 0, False
        self._hard = self._hard or hard

    def saw(self, standing: bool) -> None:
        """Note a report: whether the robot stands."""
        if not standing:
            self._stands = False
        elif self._zeros >= ZEROS and not any(self._sent):
            self._stands = True

    def take_ended(self) -> tuple[Cause, str] | None:
        """Return why the last lease ended if it ran out or its thread did; returned once."""
        ended, self._ended = self._ended, None
        return ended

    def held_up(self, now: float) -> bool:
        """Return whether nothing was sent for so long that the watchdog may have stopped the
        robot.
        """
        return now - self._last_out >= self._gap

    def list_packets_before(self, now: float) -> list[Packet]:
        """Return the packets that must precede another part's packet at `now`."""
        packets = self._send_zeros_after_gap(now)
        self._last_out = now
        return packets

    def replay_outgoing(self, packet: Packet) -> None:
        """Update the commanded speeds from a packet, in the replay of a log."""
        if packet.kind in (Command.VEL, Command.RVEL):
            value = read_argument(packet)
            speed, turning = self._sent
            if isinstance(value, int):
                self._sent = (value, turning) if packet.kind == Command.VEL else (speed, value)

    def advance(self, now: float) -> list[Packet]:
        """Return the packets to send at `now`."""
        packets = self._send_zeros_after_gap(now)
        if packets:
            return packets
        self._check_lease(now)
        if self._hard:
            self._hard = False
            return [make_plain_command(Command.ESTOP), *self._pair((0, 0), now)]
        if now < self.due:
            return []
        wanted = self._round_speeds()
        if wanted != self._sent or any(wanted) or not self._stands:
            return self._pair(wanted, now)
        self._last_out = now
        return [make_plain_command(Command.PULSE)]

    def _send_zeros_after_gap(self, now: float) -> list[Packet]:
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
        first = [make_plain_command(Command.ESTOP)] if hard else []
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

    def _round_speeds(self) -> tuple[int, int]:
        return round(self._wanted[0] * 1e3), round(math.degrees(self._wanted[1]))

    def _pair(self, values: tuple[int, int], now: float) -> list[Packet]:
        self._sent, self._pair_at, self._last_out = values, now, now
        self._zeros = 0 if any(values) else self._zeros + 1
        if any(values):
            self._stands = False
        return [
            make_integer_command(Command.VEL, values[0]),
            make_integer_command(Command.RVEL, values[1]),
        ]


QUIET_AFTER = 0.5
"""Seconds without a report after which the robot is stopped: five reports."""
LOST_AFTER = 2.0
"""Seconds without a report, whole or damaged, after which the link counts as lost."""
NOISY_LOST_AFTER = 10.0
"""Seconds of damaged reports only: of 84 bytes with one in twenty damaged one in 75 is whole."""
DEAF_AFTER = 1.0
"""Seconds without reading the line after which the robot's state counts as unknown."""
PROBLEMS_KEPT = 1000


class Control:
    """One session from the first report on."""

    def __init__(
        self,
        now: float,
        parameters: Parameters,
        configuration: Configuration | None = None,
        limits: Limits | None = None,
        errors: OdometryErrors | None = None,
    ) -> None:
        self.limits = (limits or Limits()).restrict_to_robot(parameters, configuration)
        watchdog_ms = configuration.watchdog_ms if configuration else None
        self._watchdog = None if watchdog_ms is None else watchdog_ms / 1e3
        self.motion = Motion(now, self.limits, self._watchdog or WATCHDOG)
        self.state: RobotState | None = None
        self.halted: Problem | None = None
        """The problem that stopped the robot, until it is cleared."""
        self.lost: DeviceError | None = None
        """Why there is no session any more."""
        self._maker = StateMaker(parameters, configuration, errors)
        self.reports_motors = parameters.generation.reports_motors
        """Whether reports include the state of the motors."""
        # On connecting the robot's motors are off, whatever they were before (manuals of both).
        self._maker.motors_thought_on = False
        self._motors_wanted = False
        self._scale = ScaleCheck(parameters)
        self._guard = Guard(self.limits.battery_v or 0.0)
        self._limit_settings = make_limit_settings(self.limits, configuration)
        self._restored_settings = make_restoring_settings(configuration)
        self._last_report = self._last_sign = self._looked = now
        self._quiet = False
        self._problems: deque[Problem] = deque(maxlen=PROBLEMS_KEPT)
        self._untold: deque[Problem] = deque(maxlen=PROBLEMS_KEPT)

    @property
    def problems(self) -> tuple[Problem, ...]:
        """The last thousand problems so far."""
        return tuple(self._problems)

    def take_new_problems(self) -> list[Problem]:
        """Return the problems not returned before."""
        new = list(self._untold)
        self._untold.clear()
        return new

    def take(self, received: Received) -> None:
        """Take a packet of the robot."""
        kind = received.packet.kind
        if kind in (Report.RESET_1, Report.RESET_2):
            self.fail(
                DeviceError("the robot was reset, its session is over: connect again"),
                Cause.RESET,
                received.at,
            )
        elif kind in SIP_KINDS:
            try:
                sip = ServerInformation.from_packet(received.packet)
            except PacketError:
                return  # the next comes within a tenth of a second
            self._take_report(sip, received.at)

    def looked(self, now: float, *, damaged: bool = False) -> None:
        """Note that the line has been read up to `now`, and whether damaged packets came."""
        self._looked = max(self._looked, now)
        if damaged:
            self._last_sign = self._looked

    def advance(self, now: float) -> list[Packet]:
        """Return the packets to send at `now`."""
        self._check_link(now)
        packets = self.motion.advance(now)
        if (ended := self.motion.take_ended()) is not None:
            problem = Problem(*ended, now, stopped=True)
            self.say(problem)
            if problem.cause is Cause.HELD_UP and self.halted is None:
                self.halted = problem  # much may have changed where the robot drives
        return packets

    @property
    def due(self) -> float:
        """When `advance` is to be called at the latest."""
        return self.motion.due

    def drive(
        self,
        speed: float,
        turning: float,
        lease: float,
        now: float,
        alive: Callable[[], bool] | None = None,
    ) -> tuple[float, float]:
        """Command speeds for `lease` seconds; return them as clipped to the limits.

        DeviceError if the robot cannot be driven or was stopped; the text says what to do.
        """
        if not 0 < lease <= LONGEST_LEASE:
            raise ValueError(
                f"a lease of {lease} s: it is more than 0 and at most {LONGEST_LEASE}, so that"
                " the robot stands soon after its program died"
            )
        speed, turning = self.limits.clip(speed, turning)
        self.check()
        if self.halted is not None:
            raise DeviceError(f"{self.halted}; then call clear_stop() to drive on")
        if self.state is None:
            raise DeviceError("no report of the robot yet")
        if (reason := self._guard.refusal(self.state, speed)) is not None:
            raise DeviceError(reason)
        if self._quiet:
            speed = turning = 0.0
        self.motion.drive(speed, turning, lease, now, alive)
        return speed, turning

    def stop(self) -> None:
        """End the lease: zero speeds from now on."""
        self.motion.rest()

    def emergency_stop(self, now: float) -> None:
        """Stop as hard as it can; driving is blocked until that is cleared."""
        self.motion.rest(hard=True)
        self.halted = Problem(Cause.EMERGENCY, "the program called for a stop", now, stopped=True)
        self.say(self.halted)

    def clear_stop(self) -> None:
        """Clear the stop; a cause that still holds refuses the next drive."""
        self.halted = None

    def list_switching_packets(self, on: bool) -> list[Packet]:
        """Return the packets that switch the motors, to be sent slowly."""
        self.motion.rest()
        if not on:
            return [make_integer_command(Command.ENABLE, 0)]
        self.halted = None
        return [*self._limit_settings, make_integer_command(Command.ENABLE, 1)]

    def note_outgoing(self, packet: Packet) -> None:
        """Note that a packet of another part of the driver is sent now."""
        if packet.kind == Command.ENABLE:
            self._motors_wanted = bool(read_argument(packet))
            self._maker.motors_thought_on = None if self._motors_wanted else False

    def replay_outgoing(self, packet: Packet) -> None:
        """Note, in the replay of a log, that a packet was sent."""
        self.note_outgoing(packet)
        self.motion.replay_outgoing(packet)

    def parting(self) -> list[Packet]:
        """Return commands that restore the robot's own settings for its next client."""
        return self._restored_settings

    def check(self) -> None:
        """Raise DeviceError if the session has ended."""
        if self.lost is not None:
            raise type(self.lost)(*self.lost.args) from self.lost

    def fail(self, error: DeviceError, cause: Cause, now: float) -> None:
        """End the session for a reason; the first one stays.

        Where it is not known that the robot was stopped, the reason says how far it may go on.
        """
        if self.lost is not None:
            return
        not_stopped = isinstance(error, NotStoppedError)
        if not_stopped or (cause is Cause.LINK_LOST and isinstance(error, DeviceTimeout)):
            error = type(error)(f"{error}{self._describe_coasting()}")
        self.lost = error
        self.motion.rest(in_time=True)
        self.say(Problem(cause, str(error), now, stopped=not not_stopped))

    def _describe_coasting(self) -> str:
        """Return how far the robot may go on by itself, "" if it stood by its last report."""
        if self.state is None or self.state.standing:
            return ""
        speed = max(abs(self.state.speed), abs(self.motion.commanded[0]))
        watchdog = WATCHDOG if self._watchdog is None else self._watchdog
        drove = f". It drove at {speed:.2f} m/s by its last report"
        if watchdog == 0.0:
            return f"{drove}, and has no watchdog: press its STOP button"
        whose = "its own watchdog stops it" if self._watchdog else "a watchdog usually stops it"
        return (
            f"{drove}: {whose} after {watchdog:g} s without commands, up to"
            f" {speed * watchdog:.1f} m on"
        )

    def say(self, *problems: Problem) -> None:
        """Record problems for `problems` and `take_new_problems`."""
        self._problems.extend(problems)
        self._untold.extend(problems)

    def _take_report(self, sip: ServerInformation, at: float) -> None:
        state, doubt = self._maker.state(sip, at)
        if self._quiet and self.state is not None and not self.state.standing:
            silent, speed = at - self._last_report, abs(self.state.speed)
            text = (
                f"for {silent:.1f} s no report came of the robot, which drove at {speed:.2f} m/s:"
                f" commands may not have reached it either, for up to {silent * speed:.2f} m"
            )
            self.say(Problem(Cause.REPORTS_AGAIN, text, at))
        self._last_report, self._last_sign, self._quiet = at, at, False
        if doubt is not None:
            self.say(Problem(Cause.ODOMETRY, doubt, at))
        if not state.standing and not self.reports_motors and self._motors_wanted:
            self._maker.motors_thought_on = True
        self.state = state
        self.motion.saw(state.standing)
        problems = self._guard.look(state, self.motion.commanded, self._motors_wanted)
        if (wrong := self._scale.find_fault(state)) is not None:
            problems.append(Problem(Cause.SCALE, wrong, at, stopped=True))
        self._halt(problems)

    def _halt(self, problems: Iterable[Problem]) -> None:
        for problem in problems:
            self.say(problem)
            self.motion.rest(in_time=True)
            if problem.cause is Cause.NOT_MOVING and not self.reports_motors:
                self._maker.motors_thought_on = False
            if self.halted is None:
                self.halted = problem

    def _check_link(self, now: float) -> None:
        if self.lost is not None:
            return
        silent = self._looked - self._last_report
        deaf = now - self._looked
        if self._looked - self._last_sign >= LOST_AFTER or silent >= NOISY_LOST_AFTER:
            check = "check cable, battery and that the robot is on"
            if silent > self._looked - self._last_sign:
                check = "what comes is damaged; check cable and baud rate"
            self.fail(
                DeviceTimeout(
                    f"no report of the robot for {silent:.1f} s: the link is lost; {check}, then"
                    " connect again"
                ),
                Cause.LINK_LOST,
                now,
            )
        if self._quiet or (silent < QUIET_AFTER and deaf < DEAF_AFTER):
            return
        self._quiet = True
        self.motion.rest(in_time=True)
        text = f"no report of the robot for {max(silent, deaf):.1f} s: stopped until one comes"
        self.say(Problem(Cause.QUIET, text, now, stopped=True))
