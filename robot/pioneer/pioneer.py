"""A Pioneer that is driven from Python: connect, look, drive under a lease, and always stop.

    with Pioneer.connect("tcp:localhost:8101") as robot:
        robot.enable_motors()
        while robot.state.pose.x < 1.0:
            robot.drive(0.2, 0.0)
            time.sleep(0.1)

A speed lasts as long as its lease, which `drive` renews: if the program hangs or dies the robot
stops. All calls are thread-safe.
"""

import atexit
import contextlib
import os
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Self

from facetlog.errors import DeviceError, DeviceTimeout, InputError
from facetlog.robot.pioneer.connecting import Connected, check_model, connect_over
from facetlog.robot.pioneer.control import LONGEST_LEASE, Control
from facetlog.robot.pioneer.guard import Cause, Problem
from facetlog.robot.pioneer.limits import Limits, send_until_confirmed
from facetlog.robot.pioneer.line.port import Port
from facetlog.robot.pioneer.line.process import LineProcess
from facetlog.robot.pioneer.link import AuxLine, Link
from facetlog.robot.pioneer.packets.commands import (
    Command,
    make_integer_command,
    make_plain_command,
)
from facetlog.robot.pioneer.packets.packet import Packet, PacketError
from facetlog.robot.pioneer.packets.reports import (
    Configuration,
    Names,
    Report,
    TruePose,
)
from facetlog.robot.pioneer.parameters import Parameters
from facetlog.robot.pioneer.state import OdometryErrors, RobotState
from facetlog.robot.pioneer.traffic import TrafficLog
from facetlog.robot.pose2 import Pose2

LEASE = LONGEST_LEASE
"""Seconds that a speed lasts: two rounds of a program that drives ten times a second, and one."""
ASK_TRIES, ASK_EACH = 4, 0.3
"""Attempts at a request to the robot, and seconds for each: a packet in twenty may be damaged."""
ENABLE_TRIES, ENABLE_EACH = 5, 0.4
SET_TRIES = 2
STAND_TIMEOUT = 1.5
"""Seconds for standing before the connection is closed: 0.3 m/s take 1.0 at 0.3 m/s²."""
OFF_TRIES, OFF_EACH = 3, 0.25

_OPEN: set["Pioneer"] = set()


class Pioneer:
    """A connected robot; made by `connect`."""

    def __init__(
        self,
        connected: Connected,
        port: Port,
        *,
        clock: Callable[[], float],
        limits: Limits,
        errors: OdometryErrors | None,
        log: TrafficLog | None,
    ) -> None:
        self._connected, self._log, self._clock = connected, log, clock
        self._process = os.getpid()
        self.address = port.address
        self._control = Control(
            clock(), connected.parameters, connected.configuration, limits, errors
        )
        for received in connected.received:
            self._control.take(received)
        if isinstance(port, LineProcess):
            port.part([packet.to_bytes() for packet in self._list_closing_packets()])
        self._link = Link(port, self._control, connected.receiver, clock, log)
        self._closed = False
        self._close_lock = threading.Lock()
        if log is not None:
            log.on_failure(self._log_failed)
        _OPEN.add(self)
        self._link.start()

    @classmethod
    def connect(
        cls,
        address: str | Port,
        *,
        model: str | None = None,
        limits: Limits | None = None,
        log: Path | str | None = None,
        baud: int | None = None,
        errors: OdometryErrors | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> Self:
        """Return a robot at an address (see `open_port`), its motors off.

        The line of an address is owned by a process of its own, which stops the robot when this
        one dies or is suspended; a port that is given has no such process, and may have a `clock`
        of its own. `model` overrides the one that the robot reports; `log` is a file that the
        traffic is appended to; a `baud` is the only one tried on a serial line. InputError for a
        bad argument; DeviceError or DeviceTimeout with what was tried and what to check.
        """
        if model is not None:
            check_model(model)
        if isinstance(address, str):
            if clock is not time.monotonic:
                raise ValueError("only a port that is given can have a clock of its own")
            port: Port = LineProcess(address, baud)
        elif baud is not None and not address.has_baud:
            raise InputError(f"{address.address}: has no baud rate; leave it out")
        else:
            port = address
        traffic: TrafficLog | None = None
        try:
            if log is not None:
                traffic = TrafficLog(Path(log))
                traffic.start(clock(), port.address, serial=port.has_baud, model=model, baud=baud)
            connected = connect_over(port, clock, model=model, baud=baud, log=traffic)
            return cls(
                connected, port, clock=clock, limits=limits or Limits(), errors=errors, log=traffic
            )
        except BaseException:
            port.close()
            if traffic is not None:
                traffic.close()
            raise

    @property
    def names(self) -> Names:
        """The names that the robot reports."""
        return self._connected.names

    @property
    def parameters(self) -> Parameters:
        """Parameters of its model, or of the one that was given."""
        return self._connected.parameters

    @property
    def configuration(self) -> Configuration | None:
        """The robot's CONFIG report; None from firmware that does not know the request."""
        return self._connected.configuration

    @property
    def baud(self) -> int | None:
        """The serial line's rate; None where there is none."""
        return self._connected.baud

    @property
    def limits(self) -> Limits:
        """The limits in force: the given ones, no higher than the robot's own."""
        return self._control.limits

    @property
    def state(self) -> RobotState:
        """The state by the last report; DeviceError once the link is lost or closed."""
        self._check()
        with self._link.changed:
            self._control.check()
            return self._last()

    @property
    def problems(self) -> tuple[Problem, ...]:
        """The last thousand problems since connecting."""
        with self._link.changed:
            return self._control.problems

    @property
    def halted(self) -> Problem | None:
        """The problem that stopped the robot and still blocks driving, or None."""
        with self._link.changed:
            return self._control.halted

    def on_problem(self, callback: Callable[[Problem], None]) -> None:
        """Call back with each problem from now on, from a thread of the driver.

        The callback may stop the robot, but must not wait for it.
        """
        self._check()
        self._link.on_problem(callback)

    def drive(self, speed: float, turning: float, lease: float = LEASE) -> tuple[float, float]:
        """Drive at m/s ahead and rad/s counter-clockwise for `lease` seconds, `LEASE` at most.

        The speeds are scaled down by one factor where they exceed the limits, and are zero while no
        reports come; the commanded ones are returned (whole mm/s and degrees/s on the wire).
        DeviceError, which says what to do, if the robot may not be driven: after a bumper, a
        stall, the STOP button, motors off, a low battery, an emergency stop, a lost link, or where
        the program itself was held up while the robot drove.
        """
        self._check()
        alive = threading.current_thread().is_alive
        with self._link.changed:
            commanded = self._control.drive(speed, turning, lease, self._clock(), alive)
        self._link.wake()
        return commanded

    def stop(self) -> None:
        """Stop; the robot may be driven on. Does not wait: `wait_for(lambda s: s.standing, …)`."""
        if self._is_own_process():
            with self._link.changed:
                self._control.stop()
            self._link.wake()

    def emergency_stop(self) -> None:
        """Stop as hard as it can; it is not driven on before `clear_stop`."""
        if self._is_own_process():
            with self._link.changed:
                self._control.emergency_stop(self._clock())
            self._link.wake()

    def clear_stop(self) -> None:
        """Allow driving after a stop; a cause that still holds refuses the next drive."""
        self._check()
        with self._link.changed:
            self._control.clear_stop()

    def enable_motors(self) -> None:
        """Switch the motors on, and clear what stopped the robot.

        DeviceError if they stay off. Old firmware (P2OS, PSOS) does not report it: there it shows
        when the robot is driven. Only this call switches them on.
        """
        self._check()
        if self.state.stop_button:
            raise DeviceError("the STOP button is pressed: pull it out, then switch the motors on")
        self._switch(on=True, tries=ENABLE_TRIES, each=ENABLE_EACH)
        if self._control.reports_motors and not self.state.motors_on:
            raise DeviceError(
                "the motors stay off: press the MOTORS button, see that the STOP button is out and"
                " that the charger is unplugged"
            )

    def switch_sonars(self, on: bool) -> None:
        """Switch the sonars on, as they are at first, or off.

        Without them reports are half as long: a slow line keeps up, a bad one loses fewer.
        """
        self._check()
        self._link.send(make_integer_command(Command.SONAR, int(on)))

    def wait_for(self, condition: Callable[[RobotState], bool], timeout: float) -> RobotState:
        """Return the first state from now on that meets a condition; DeviceTimeout if none does in
        time.

        The present state counts. DeviceError if the link is lost meanwhile.
        """
        self._check()
        if not self._wait(condition, timeout):
            raise DeviceTimeout(f"the robot did not reach the awaited state in {timeout:.1f} s")
        return self.state

    def aux(self, number: int = 1) -> AuxLine:
        """Return the line to a device on the robot's AUX port 1, 2 or 3."""
        self._check()
        return AuxLine(self._link, number)

    def ask_true_pose(self) -> Pose2:
        """Return where a simulated robot truly is in its world; DeviceTimeout if it is not
        simulated.
        """
        self._check()
        question = make_integer_command(Command.SIM_STAT, 1)
        packet = self._link.ask(question, Report.SIM_STAT, tries=ASK_TRIES, each=ASK_EACH)
        if packet is None:
            raise DeviceTimeout(
                f"{self.address}: the robot does not report the true pose (a simulator?)"
            )
        try:
            return TruePose.from_packet(packet).pose
        except PacketError as error:
            raise DeviceError(f"{self.address}: {error}") from error

    def close(self) -> None:
        """Stop the robot, switch its motors off, end the session; again does no harm."""
        if not self._is_own_process():
            return  # a fork: the robot and the line are its parent's
        with self._close_lock:
            if self._closed:
                return
            self._closed = True
            _OPEN.discard(self)
            try:
                self._part()
            finally:
                self._link.close()
                if self._log is not None:
                    self._log.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _part(self) -> None:
        """Stop the robot and free its line; a failing step must not prevent the others."""
        zeros = [make_integer_command(Command.VEL, 0), make_integer_command(Command.RVEL, 0)]
        with contextlib.suppress(DeviceError):
            self.stop()
            self._wait(lambda state: state.standing, STAND_TIMEOUT)
        with contextlib.suppress(DeviceError):
            self._switch(on=False, tries=OFF_TRIES, each=OFF_EACH)
        # Also where nothing is received any more: what is sent may still arrive.
        off, *rest = self._list_closing_packets()
        self._link.send_anyway(*zeros, off)
        self._link.send_anyway(*rest, slowly=True)

    def _list_closing_packets(self) -> list[Packet]:
        """Return the commands that end a session: motors off, the robot's own settings, CLOSE."""
        off, close = make_integer_command(Command.ENABLE, 0), make_plain_command(Command.CLOSE)
        return [off, *self._control.parting(), close]

    def _switch(self, *, on: bool, tries: int, each: float) -> None:
        with self._link.changed:
            packets = self._control.list_switching_packets(on)
        self._link.wake()
        send_until_confirmed(
            packets[:-1],
            lambda some: self._link.send(*some, slowly=True),
            self._request_configuration,
        )
        # Where reports do not include it, wait at least for a report since the command.
        states = (on,) if self._control.reports_motors else ((None, True) if on else (False,))
        for _ in range(tries):
            self._link.send(packets[-1])
            if self._wait(lambda state: state.motors_on in states, each):
                break
        if not self._control.reports_motors:
            self._link.send(packets[-1])

    def _request_configuration(self) -> Configuration | None:
        """Ask for CONFIG with the present settings; None if it is not answered."""
        if self.configuration is None:
            return None
        question = make_integer_command(Command.CONFIG, 1)
        answer = self._link.ask(question, Report.CONFIG, tries=SET_TRIES, each=ASK_EACH)
        return None if answer is None else Configuration.from_packet(answer)

    def _last(self) -> RobotState:
        state = self._control.state
        if state is None:
            raise DeviceError(f"{self.address}: no report of the robot yet")
        return state

    def _wait(self, condition: Callable[[RobotState], bool], timeout: float) -> bool:
        with self._link.changed:
            return self._link.wait_until(lambda: condition(self._last()), timeout)

    def _is_own_process(self) -> bool:
        return os.getpid() == self._process

    def _check(self) -> None:
        if not self._is_own_process():
            raise DeviceError(
                f"{self.address}: the connection belongs to the process that was forked; connect"
                " again in this one"
            )
        if self._closed:
            raise DeviceError(f"{self.address}: the connection is closed")

    def _log_failed(self, text: str) -> None:
        with self._link.changed:
            self._control.say(Problem(Cause.LOG, text, self._clock()))


def _stop_all() -> None:
    for robot in tuple(_OPEN):
        robot.close()


atexit.register(_stop_all)
