"""Bytes to a device on an AUX port and back, through a scripted robot in real time."""

from collections.abc import Iterator

import pytest

from facetlog.errors import DeviceTimeout
from facetlog.robot.pioneer.packets.packet import Packet
from facetlog.robot.pioneer.pioneer import Pioneer
from tests.robot.pioneer.scripted import ScriptedPort, ScriptedRobot

pytestmark = pytest.mark.usefixtures("quick")

QUESTION, ANSWER = (
    bytes.fromhex("81 09 06 12 FF"),
    bytes.fromhex("90 50 00 01 00 08 0F 0F 08 08 FF"),
)


@pytest.fixture
def scripted() -> ScriptedRobot:
    return ScriptedRobot(aux_answers={QUESTION: ANSWER})


@pytest.fixture
def robot(scripted: ScriptedRobot) -> Iterator[Pioneer]:
    with Pioneer.connect(ScriptedPort(scripted)) as robot:
        yield robot


def aux_words(scripted: ScriptedRobot) -> list[tuple[str, int | bytes | None]]:
    return [(n, a) for _, n, a in scripted.commands if n in ("TTY2", "GETAUX", "AUX1BAUD")]


def test_an_answer_comes_back_through_the_tunnel_in_the_order_that_drivers_use(
    robot: Pioneer, scripted: ScriptedRobot
) -> None:
    line = robot.aux()
    line.flush()
    line.send(QUESTION)
    assert line.receive(11, 5.0) == ANSWER
    assert aux_words(scripted) == [("GETAUX", 0), ("TTY2", QUESTION), ("GETAUX", 11)]


def test_a_device_that_says_nothing_is_a_time_out_that_says_what_to_check(robot: Pioneer) -> None:
    line = robot.aux()
    with pytest.raises(DeviceTimeout, match=r"AUX1.*0 of 6 bytes.*power, cable"):
        line.receive(6, 0.2)


def test_a_lost_request_is_made_again(robot: Pioneer, scripted: ScriptedRobot) -> None:
    line = robot.aux()
    line.send(QUESTION)
    take, lost = scripted._take, [1]

    def lossy(packet: Packet, now: float) -> None:
        if packet.kind == 43 and lost:
            lost.pop()
        else:
            take(packet, now)

    scripted._take = lossy  # type: ignore[method-assign]
    assert line.receive(11, 10.0) == ANSWER


def test_long_texts_go_in_as_many_packets_as_it_takes(
    robot: Pioneer, scripted: ScriptedRobot
) -> None:
    data = bytes(range(256)) * 2
    robot.aux().send(data)
    assert b"".join(scripted.aux_out) == data
    assert max(map(len, scripted.aux_out)) <= 195


def test_ports_that_there_are_not_are_refused(robot: Pioneer) -> None:
    for number in (0, 4):
        with pytest.raises(ValueError, match="AUX"):
            robot.aux(number)
