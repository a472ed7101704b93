"""The driver's control logic, without I/O, clock or thread: reports and commands in, packets out.

`Pioneer` passes it the robot's packets and the time, and sends the packets that it returns.
"""

from collections import deque
from collections.abc import Callable, Iterable

from facetlog.errors import DeviceError, DeviceTimeout
from facetlog.robot.pioneer.guard import Guard
from facetlog.robot.pioneer.limits import Limits
from facetlog.robot.pioneer.line.last_will import NotStoppedError
from facetlog.robot.pioneer.motion import LONGEST_LEASE, WATCHDOG, Motion
from facetlog.robot.pioneer.odometry import OdometryErrors
from facetlog.robot.pioneer.packets.commands import Command, argument_of, integer_command
from facetlog.robot.pioneer.packets.configuration import Configuration
from facetlog.robot.pioneer.packets.packet import Packet, PacketError, Received
from facetlog.robot.pioneer.packets.reports import Report
from facetlog.robot.pioneer.packets.server_information import SIP_KINDS, ServerInformation
from facetlog.robot.pioneer.parameters import Parameters
from facetlog.robot.pioneer.problems import Cause, Problem
from facetlog.robot.pioneer.scale_check import ScaleCheck
from facetlog.robot.pioneer.settings import limit_settings, restored_settings
from facetlog.robot.pioneer.state import RobotState, StateMaker, reports_motors

__all__ = ["LOST_AFTER", "QUIET_AFTER", "Control"]

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
        self.limits = (limits or Limits()).of_robot(parameters, configuration)
        watchdog_ms = configuration.watchdog_ms if configuration else None
        self._watchdog = None if watchdog_ms is None else watchdog_ms / 1e3
        self.motion = Motion(now, self.limits, self._watchdog or WATCHDOG)
        self.state: RobotState | None = None
        self.halted: Problem | None = None
        """The problem that stopped the robot, until it is cleared."""
        self.lost: DeviceError | None = None
        """Why there is no session any more."""
        self._maker = StateMaker(parameters, configuration, errors)
        self._reports_motors = reports_motors(parameters)
        # On connecting the robot's motors are off, whatever they were before (manuals of both).
        self._maker.motors_thought_on = False
        self._motors_wanted = False
        self._scale = ScaleCheck(parameters)
        self._guard = Guard(self.limits.battery_v or 0.0)
        self._limit_settings = limit_settings(self.limits, configuration)
        self._restored_settings = restored_settings(configuration)
        self._last_report = self._last_sign = self._looked = now
        self._quiet = False
        self._problems: deque[Problem] = deque(maxlen=PROBLEMS_KEPT)
        self._untold: deque[Problem] = deque(maxlen=PROBLEMS_KEPT)

    @property
    def problems(self) -> tuple[Problem, ...]:
        """What went wrong so far, the last thousand."""
        return tuple(self._problems)

    def new_problems(self) -> list[Problem]:
        """Those not returned before."""
        new = list(self._untold)
        self._untold.clear()
        return new

    def take(self, received: Received) -> None:
        """Takes a packet of the robot."""
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
        """Notes that the line has been read up to `now`, and whether damaged packets came."""
        self._looked = max(self._looked, now)
        if damaged:
            self._last_sign = self._looked

    def advance(self, now: float) -> list[Packet]:
        """The packets to send at `now`."""
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
        """Commands speeds for `lease` seconds; returns them as clipped to the limits.

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
        """Ends the lease: zero speeds from now on."""
        self.motion.rest()

    def emergency_stop(self, now: float) -> None:
        """Stops as hard as it can; driving is blocked until that is cleared."""
        self.motion.rest(hard=True)
        self.halted = Problem(Cause.EMERGENCY, "the program called for a stop", now, stopped=True)
        self.say(self.halted)

    def clear_stop(self) -> None:
        """Clears the stop; a cause that still holds refuses the next drive."""
        self.halted = None

    def switching(self, on: bool) -> list[Packet]:
        """The packets that switch the motors, to be sent slowly."""
        self.motion.rest()
        if not on:
            return [integer_command(Command.ENABLE, 0)]
        self.halted = None
        return [*self._limit_settings, integer_command(Command.ENABLE, 1)]

    def goes_out(self, packet: Packet) -> None:
        """Notes that a packet of another part of the driver is sent now."""
        if packet.kind == Command.ENABLE:
            self._motors_wanted = bool(argument_of(packet))
            self._maker.motors_thought_on = None if self._motors_wanted else False

    def went_out(self, packet: Packet) -> None:
        """Notes, in the replay of a log, that a packet was sent."""
        self.goes_out(packet)
        self.motion.went_out(packet)

    @property
    def reports_motors(self) -> bool:
        """Whether reports include the state of the motors."""
        return self._reports_motors

    def parting(self) -> list[Packet]:
        """Commands that restore the robot's own settings for its next client."""
        return self._restored_settings

    def check(self) -> None:
        """DeviceError if there is no session any more."""
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
            error = type(error)(f"{error}{self._coasting()}")
        self.lost = error
        self.motion.rest(in_time=True)
        self.say(Problem(cause, str(error), now, stopped=not not_stopped))

    def _coasting(self) -> str:
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
        """Records problems for `problems` and `new_problems`."""
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
        if not state.standing and not self._reports_motors and self._motors_wanted:
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
            if problem.cause is Cause.NOT_MOVING and not self._reports_motors:
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
