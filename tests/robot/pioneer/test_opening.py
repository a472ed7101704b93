"""From the answered handshake to a session that reports, in simulated time."""

import math
from dataclasses import replace
from itertools import pairwise

import pytest

from facetlog.errors import DeviceError, DeviceTimeout
from facetlog.robot.pioneer.connecting import connect_over
from facetlog.robot.pioneer.opening import Opening
from facetlog.robot.pioneer.packets.packet import Packet, Receiver
from facetlog.robot.pioneer.packets.reports import SIP_KINDS
from tests.robot.pioneer.lines import Line, TimedPort, answering
from tests.robot.pioneer.scripted import CONFIGURATION, ScriptedRobot

AUTOBAUD = replace(CONFIGURATION, autobaud=2)


def synchronised(**changes: object) -> ScriptedRobot:
    return ScriptedRobot(session="synchronised", **changes)  # type: ignore[arg-type]


def opened(line: Line, baud: int | None = None, fast_baud: int | None = None) -> Opening:
    machine = Opening(line.now, Receiver(), baud=baud, fast_baud=fast_baud)
    line.run(machine)
    return machine


class SwitchingRobot:
    """A robot whose port changes its rate at HOSTBAUD, as AROS does."""

    def __init__(self, *, fast_works: bool = True, comes_back: bool = True) -> None:
        self.robot = synchronised(configuration=AUTOBAUD)
        self.rate = 9600
        self.fast_works, self.comes_back = fast_works, comes_back
        self._valid_at = 0.0

    def __call__(self, data: bytes, now: float, baud: int | None) -> bytes:
        heard = baud == self.rate and (self.rate == 9600 or self.fast_works)
        before = len(self.robot.commands)
        if data and heard:
            self.robot.receive(data, now)
        if len(self.robot.commands) > before:
            self._valid_at = now
            if self.robot.commands[-1][1:] == ("HOSTBAUD", 2):
                self.rate = 38400
        if self.rate != 9600 and now - self._valid_at > 0.5 and self.comes_back:
            self.rate = 9600
        said = self.robot.pending(now)
        return said if heard else bytes(b ^ 0x33 for b in said)


def test_the_first_packet_after_open_is_stop() -> None:
    line = Line(answering(synchronised()))
    machine = opened(line)
    assert line.commands()[:3] == ["SYNC1", "STOP", "CONFIG"]  # OPEN is 1 as well
    assert line.writes[0][2].hex(" ") == "fa fb 03 01 00 01 fa fb 03 1d 00 1d"
    assert machine.configuration is not None
    assert machine.configuration.watchdog_ms == 2000
    assert machine.received[0].packet.kind in SIP_KINDS


def test_config_is_requested_a_bounded_number_of_times() -> None:
    line = Line(answering(synchronised(configuration=None)))
    machine = opened(line)
    assert (machine.failure, machine.configuration) == (None, None)
    assert line.commands().count("CONFIG") == 3
    assert line.now - 100.0 < 2.0


def test_a_session_that_never_reports_is_closed_and_it_is_said_what_to_check() -> None:
    robot = ScriptedRobot(cycle=math.inf)
    port = TimedPort(robot)
    with pytest.raises(DeviceTimeout, match=r"no reports come after OPEN; .*check the cable"):
        connect_over(port, port.clock)
    assert robot.session == "waiting"
    assert robot.names()[-1] == "CLOSE"


def test_an_unknown_model_is_closed_and_the_way_out_is_named() -> None:
    robot = ScriptedRobot(subclass="patrolbot")
    port = TimedPort(robot)
    with pytest.raises(DeviceError, match=r"patrolbot.*model="):
        connect_over(port, port.clock)
    assert robot.session == "waiting"
    found = connect_over(port, port.clock, model="p3at")
    assert (found.parameters.name, found.names.subclass) == ("p3at", "patrolbot")


def test_a_reset_while_the_session_is_opened_is_said() -> None:
    machine = opened(Line(lambda data, *_: Packet(0xFF).to_bytes() if data else b""))
    assert "reset" in str(machine.failure)


def test_the_rate_is_raised_where_the_robot_says_that_it_takes_it() -> None:
    line = Line(SwitchingRobot())
    machine = opened(line, 9600, 38400)
    assert (machine.failure, machine.baud) == (None, 38400)
    rates = [baud for _, baud, _ in line.writes]
    assert rates.index(38400) > 0
    assert "PULSE" not in line.commands()


@pytest.mark.parametrize("configuration", [CONFIGURATION, None])
def test_the_rate_stays_where_config_does_not_say_so(configuration: object) -> None:
    line = Line(answering(synchronised(configuration=configuration)))
    machine = opened(line, 9600, 38400)
    assert (machine.failure, machine.baud) == (None, 9600)
    assert "HOSTBAUD" not in line.commands()


def test_the_rate_goes_back_where_the_faster_one_is_silent() -> None:
    line = Line(SwitchingRobot(fast_works=False))
    machine = opened(line, 9600, 38400)
    assert (machine.failure, machine.baud) == (None, 9600)


def test_a_port_that_is_silent_at_both_rates_is_said() -> None:
    line = Line(SwitchingRobot(fast_works=False, comes_back=False))
    machine = opened(line, 9600, 38400)
    assert isinstance(machine.failure, DeviceTimeout)
    assert "baud=9600" in str(machine.failure)


def test_all_that_comes_is_kept_for_odometry() -> None:
    line = Line(answering(synchronised(configuration=None)))
    reports = [r for r in opened(line).received if r.packet.kind in SIP_KINDS]
    assert len(reports) >= 15
    assert all(a.at < b.at for a, b in pairwise(reports))
