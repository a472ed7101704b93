"""The tunnel to a device behind the robot's own serial ports."""

from dataclasses import dataclass, field

import pytest

from facetlog.robot.pioneer.packets.commands import Command, make_text_command
from facetlog.robot.pioneer.packets.packet import Packet
from tests.robot.simulator.clients import Client, connected, make_firmware

PORTS = [
    (0, Command.TTY2, Command.GETAUX, 0xB0),
    (1, Command.TTY3, Command.GETAUX2, 0xB8),
    (2, Command.TTY4, Command.GETAUX3, 0xC8),
]


@dataclass
class Parrot:
    """A device that says what it hears again, `delay` seconds later."""

    delay: float = 0.02
    heard: bytes = b""
    _said: list[tuple[float, bytes]] = field(default_factory=list)

    def receive(self, data: bytes, now: float) -> None:
        self.heard += data
        self._said.append((now + self.delay, data))

    def pending(self, now: float) -> bytes:
        due = b"".join(data for at, data in self._said if at <= now)
        self._said = [(at, data) for at, data in self._said if at > now]
        return due

    def angles(self, now: float) -> tuple[float, float, float]:  # noqa: ARG002
        return 0.0, 0.0, 0.0


def with_parrot(number: int = 0) -> tuple[Client, Parrot]:
    firmware, parrot = make_firmware("p2dx"), Parrot()
    firmware.ports[number].device = parrot
    return connected(firmware), parrot


def answers(packets: list[Packet]) -> list[Packet]:
    return [packet for packet in packets if packet.kind in (0xB0, 0xB8, 0xC8)]


@pytest.mark.parametrize(("number", "send", "ask", "kind"), PORTS)
def test_bytes_go_out_at_once_and_come_back_on_request(
    number: int, send: Command, ask: Command, kind: int
) -> None:
    client, parrot = with_parrot(number)
    client.command(ask, 0)
    client.say(make_text_command(send, b"\x81\x00\x09\xff"))
    assert parrot.heard == b"\x81\x00\x09\xff"
    assert answers(client.wait(0.3)) == []
    client.command(ask, 4)
    assert answers(client.wait(0.05)) == [Packet(kind, b"\x81\x00\x09\xff")]


def test_an_answer_comes_in_chunks_and_only_once_each_is_complete() -> None:
    client, _ = with_parrot()
    client.command(Command.GETAUX, 6)
    client.say(make_text_command(Command.TTY2, b"abcdefghij"))
    assert answers(client.wait(0.05)) == [Packet(0xB0, b"abcdef")]
    client.command(Command.GETAUX, 5)
    assert answers(client.wait(0.5)) == []
    client.say(make_text_command(Command.TTY2, b"k"))
    assert answers(client.wait(0.05)) == [Packet(0xB0, b"ghijk")]


def test_getaux_0_clears_the_buffer_and_the_request() -> None:
    client, _ = with_parrot()
    client.say(make_text_command(Command.TTY2, b"old"))
    client.wait(0.1)
    client.command(Command.GETAUX, 8)
    client.command(Command.GETAUX, 0)
    client.say(make_text_command(Command.TTY2, b"new"))
    assert answers(client.wait(0.2)) == []
    client.command(Command.GETAUX, 3)
    assert answers(client.wait(0.2)) == [Packet(0xB0, b"new")]


def test_the_buffer_of_a_port_is_finite_and_large_requests_are_cut() -> None:
    client, _ = with_parrot()
    for _ in range(4):
        client.say(make_text_command(Command.TTY2, bytes(100)))
    client.wait(0.1)
    client.command(Command.GETAUX, 250)
    assert [len(packet.payload) for packet in answers(client.wait(0.1))] == [200]
    client.command(Command.GETAUX, 57)
    assert answers(client.wait(0.5)) == []
    client.command(Command.GETAUX, 56)
    assert [len(packet.payload) for packet in answers(client.wait(0.1))] == [56]
