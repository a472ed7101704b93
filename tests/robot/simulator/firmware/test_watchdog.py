"""The watchdog: it stops a robot whose client is silent, and lets it go on with any packet."""

import pytest

from facetlog.robot.pioneer.packets.commands import Command, make_plain_command, make_text_command
from facetlog.robot.pioneer.packets.packet import Packet
from tests.robot.simulator.clients import Client, connected, make_firmware


@pytest.fixture
def client() -> Client:
    client = connected(make_firmware())
    client.command(Command.VEL, 300)
    return client


def test_the_robot_stops_two_seconds_after_the_last_packet(client: Client) -> None:
    client.wait(1.99)
    assert client.speed == pytest.approx(0.3)
    client.wait(0.5)
    assert 0.0 < client.speed < 0.3
    client.wait(1.0)
    assert client.speed == 0.0


@pytest.mark.parametrize(
    "packet",
    [
        make_plain_command(Command.PULSE),
        make_plain_command(Command.CONFIG),
        make_text_command(Command.TTY2, b"\x81\x09\x06\x12\xff"),
        Packet(199),
    ],
)
def test_any_packet_lets_it_go_on_with_the_last_speed(client: Client, packet: Packet) -> None:
    client.wait(5.0)
    stopped = client.truth.x
    client.say(packet)
    client.wait(1.5)
    assert client.speed == pytest.approx(0.3)
    assert client.truth.x > stopped + 0.2


def test_a_stop_as_first_packet_after_the_gap_keeps_it_standing(client: Client) -> None:
    client.wait(5.0)
    stopped = client.truth
    client.command(Command.VEL, 0)
    client.wait_pulsing(3.0)
    assert client.truth == stopped


def test_packets_with_a_wrong_checksum_do_not_feed_it(client: Client) -> None:
    for _ in range(50):
        client.firmware.receive(bytes.fromhex("FA FB 03 00 00 01"), client.now)
        client.wait(0.1)
    assert client.speed == 0.0


def test_it_can_be_switched_off() -> None:
    client = connected(make_firmware(watchdog_ms=0))
    client.command(Command.VEL, 300)
    client.wait(10.0)
    assert client.speed == pytest.approx(0.3)
