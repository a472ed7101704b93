"""Open a session with a robot over a port."""

from collections.abc import Callable
from dataclasses import dataclass

from facetlog.errors import DeviceError, InputError
from facetlog.robot.pioneer.line.port import Port
from facetlog.robot.pioneer.opening import BAUDS, Handshake, Opening, SetBaud, Write
from facetlog.robot.pioneer.packets.commands import (
    Command,
    make_plain_command,
)
from facetlog.robot.pioneer.packets.packet import Received, Receiver
from facetlog.robot.pioneer.packets.reports import (
    Configuration,
    Names,
)
from facetlog.robot.pioneer.parameters import MODELS, Parameters, find_parameters
from facetlog.robot.pioneer.traffic import TrafficLog

READ_TIMEOUT = 0.05
"""Seconds between looks at the port: half a report's interval; a time-out is at most so late."""


@dataclass(frozen=True, slots=True)
class Connected:
    """An open session: the robot's names, parameters and configuration, and the packets so far."""

    names: Names
    parameters: Parameters
    configuration: Configuration | None
    receiver: Receiver
    received: tuple[Received, ...]
    baud: int | None


def check_model(model: str) -> Parameters:
    """Return parameters of a model that a user names; InputError with those that there are."""
    try:
        return find_parameters(model)
    except KeyError:
        raise InputError(
            f"{model!r} is no model that is known; there are {', '.join(MODELS)}"
        ) from None


def connect_over(
    port: Port,
    clock: Callable[[], float],
    *,
    model: str | None = None,
    baud: int | None = None,
    log: TrafficLog | None = None,
) -> Connected:
    """Open a session over a port.

    A `model` overrides the one that the robot reports; a `baud` is the only one tried, and stays.
    DeviceError or DeviceTimeout with the address, what was tried and what to check.
    """
    given = None if model is None else check_model(model)
    bauds = () if not port.has_baud else BAUDS if baud is None else (baud,)
    handshake = Handshake(clock(), bauds)
    _perform(handshake, port, clock, log)
    if handshake.names is None:
        error = handshake.failure or DeviceError("the handshake has failed")
        raise type(error)(f"{port.address}: {error}") from None
    names = handshake.names
    try:
        parameters = given or find_parameters(names.subclass)
    except KeyError:
        _close_session(port, clock, log)
        raise DeviceError(
            f"{port.address}: {names.name!r} is a {names.robot_class} {names.subclass!r}, which is"
            f" not known; say what it is like with model= ({', '.join(MODELS)})"
        ) from None
    fast = parameters.fast_baud if baud is None else None
    opening = Opening(
        clock(), handshake.receiver, handshake.left_over, baud=handshake.baud, fast_baud=fast
    )
    _perform(opening, port, clock, log)
    if opening.failure is not None:
        error = opening.failure
        # It may have received OPEN all the same, and would keep the session open.
        _close_session(port, clock, log)
        raise type(error)(f"{port.address}: {names.name!r} ({names.subclass}): {error}") from None
    return Connected(
        names,
        parameters,
        opening.configuration,
        handshake.receiver,
        tuple(opening.received),
        opening.baud,
    )


def _perform(
    machine: Handshake | Opening,
    port: Port,
    clock: Callable[[], float],
    log: TrafficLog | None,
) -> None:
    while True:
        for action in machine.actions():
            if isinstance(action, SetBaud):
                port.set_baud(action.baud)
                if log is not None:
                    log.note(clock(), baud=action.baud)
            else:
                _write(port, action, clock, log)
        if machine.over:
            return
        data = port.read(max(0.0, min(machine.due - clock(), READ_TIMEOUT)))
        now = clock()
        given_up = machine.receiver.given_up
        machine.receive(data, now)
        if log is not None and (data or machine.receiver.given_up != given_up):
            log.incoming(now, data)


def _close_session(port: Port, clock: Callable[[], float], log: TrafficLog | None) -> None:
    _write(port, Write(make_plain_command(Command.CLOSE).to_bytes(), "CLOSE"), clock, log)


def _write(port: Port, action: Write, clock: Callable[[], float], log: TrafficLog | None) -> None:
    port.write(action.data)
    if log is not None:
        log.log_outgoing(clock(), action.data, action.name)
