"""The handshake in simulated time: every state a robot may be found in."""

import random

import pytest

from facetlog.errors import DeviceError, DeviceTimeout
from facetlog.robot.pioneer.opening import BAUDS, Handshake
from facetlog.robot.pioneer.packets.packet import Packet
from facetlog.robot.pioneer.packets.reports import Names
from tests.robot.pioneer.lines import Answer, Line, answering
from tests.robot.pioneer.scripted import ScriptedRobot


def shake(line: Line, longest: float = 60.0) -> Handshake:
    machine = Handshake(line.now, line.bauds)
    line.run(machine, longest)
    return machine


def test_a_waiting_robot_is_synchronised_and_named() -> None:
    line = Line(answering(ScriptedRobot()))
    machine = shake(line)
    assert machine.names == Names("scripted", "Pioneer", "p3dx")
    assert line.commands() == ["SYNC0", "SYNC1", "SYNC2"]
    assert machine.baud is None


def test_nothing_is_sent_before_the_line_was_listened_to() -> None:
    line = Line(answering(ScriptedRobot()))
    shake(line)
    assert line.writes[0][0] >= 100.3


def test_an_open_session_is_stopped_and_closed_before_anything_else_is_sent() -> None:
    robot = ScriptedRobot()
    robot.open_session(100.0, speed=0.3)
    line = Line(answering(robot))
    machine = shake(line)
    assert machine.names is not None
    assert line.commands() == ["STOP", "SYNC2", "SYNC0", "SYNC1", "SYNC2"]  # CLOSE is 2 as well


def test_a_robot_that_the_watchdog_stopped_does_not_jump_when_a_client_connects() -> None:
    robot = ScriptedRobot(deceleration=0.6)
    robot.open_session(95.0, speed=0.5)
    robot.advance(100.0)
    assert robot.speed == 0
    where = robot.x
    fastest = 0.0

    def answer(data: bytes, now: float, baud: int | None) -> bytes:
        nonlocal fastest
        fastest = max(fastest, abs(robot.speed))
        return answering(robot)(data, now, baud)

    assert shake(Line(answer)).names is not None
    assert (fastest, robot.x) == (0.0, where)


def test_a_lost_answer_to_sync2_closes_the_half_open_session() -> None:
    robot = ScriptedRobot()
    swallow = True

    def answer(data: bytes, now: float, baud: int | None) -> bytes:
        nonlocal swallow
        said = answering(robot)(data, now, baud)
        if b"scripted" in said and swallow:
            swallow = False
            return b""
        return said

    line = Line(answer)
    assert shake(line).names is not None
    assert "STOP" in line.commands()


def test_a_close_that_the_robot_took_for_sync2_is_as_good_as_it() -> None:
    """Both have the number 2; the robot had not heard the SYNC2 that was meant."""
    robot, lost = ScriptedRobot(), [1]

    def answer(data: bytes, now: float, baud: int | None) -> bytes:
        if data[3:4] == b"\x02" and lost:
            lost.pop()
            return b""
        return answering(robot)(data, now, baud)

    line = Line(answer)
    assert shake(line).names is not None
    assert line.commands() == ["SYNC0", "SYNC1", "SYNC2", "STOP", "SYNC2"]
    assert robot.session == "synchronised"


def test_reports_in_the_midst_of_the_handshake_close_the_old_session() -> None:
    robot = ScriptedRobot()
    late = ScriptedRobot().report().to_packet().to_bytes()

    def answer(data: bytes, now: float, baud: int | None) -> bytes:
        nonlocal late
        if data[3:4] == b"\x01" and late:
            said, late = late, b""
            return said
        return answering(robot)(data, now, baud)

    line = Line(answer)
    assert shake(line).names is not None
    assert line.commands()[:4] == ["SYNC0", "SYNC1", "STOP", "SYNC2"]


@pytest.mark.parametrize("rate", [9600, 57600])
def test_the_rate_of_a_serial_line_is_found(rate: int) -> None:
    line = Line(answering(ScriptedRobot(), at_baud=rate), bauds=BAUDS)
    machine = shake(line)
    assert (machine.names is not None, machine.baud) == (True, rate)


def test_a_session_left_open_at_a_faster_rate_is_found_and_closed() -> None:
    robot = ScriptedRobot()
    robot.open_session(100.0)
    line = Line(answering(robot, at_baud=38400), bauds=BAUDS)
    machine = shake(line)
    assert (machine.names is not None, machine.baud) == (True, 38400)
    assert line.now < 103.0, "what comes in at the wrong rate tells so at once"


def test_a_silent_serial_line_is_tried_at_every_rate_and_given_up() -> None:
    line = Line(lambda *_: b"", bauds=BAUDS)
    machine = shake(line)
    assert isinstance(machine.failure, DeviceTimeout)
    assert all(str(baud) in str(machine.failure) for baud in BAUDS)
    assert {baud for _, baud, _ in line.writes} == set(BAUDS)
    assert line.now - 100.0 < 40.0


REPORT = ScriptedRobot().report().to_packet().to_bytes()


@pytest.mark.parametrize(
    ("answer", "bauds", "expected"),
    [
        (lambda *_: b"\xaa\x55", BAUDS, "no packet of a robot"),
        (lambda _, now, __: REPORT if round(now * 100) % 10 == 0 else b"", (), "not take CLOSE"),
        (lambda data, *_: data, (), "echo"),
        (lambda data, *_: Packet(0xFF).to_bytes() if data else b"", (), "loses count"),
    ],
)
def test_a_line_without_a_usable_robot_is_told_apart(
    answer: Answer, bauds: tuple[int, ...], expected: str
) -> None:
    machine = shake(Line(answer, bauds=bauds), 120.0)
    assert isinstance(machine.failure, DeviceError)
    assert expected in str(machine.failure)


def test_packets_behind_the_names_are_kept() -> None:
    robot = ScriptedRobot()
    report = robot.report().to_packet()

    def answer(data: bytes, now: float, baud: int | None) -> bytes:
        said = answering(robot)(data, now, baud)
        return said + report.to_bytes() if b"scripted" in said else said

    assert [each.packet for each in shake(Line(answer)).left_over] == [report]


@pytest.mark.parametrize("seed", range(4))
def test_a_line_with_damage_is_synchronised_in_the_end(seed: int) -> None:
    """One byte in fifty, both ways: one packet in ten of the handshake, half of the names."""
    robot, chance = ScriptedRobot(), random.Random(seed)

    def damaged(data: bytes) -> bytes:
        return bytes(chance.randrange(256) if chance.random() < 0.02 else b for b in data)

    def answer(data: bytes, now: float, baud: int | None) -> bytes:
        return damaged(answering(robot)(damaged(data), now, baud))

    assert shake(Line(answer)).names == Names("scripted", "Pioneer", "p3dx")
