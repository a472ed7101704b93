"""The wait state: what the firmware answers before a session is open."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.robot.pioneer.packets.commands import (
    Command,
    make_plain_command,
)
from facetlog.robot.pioneer.packets.packet import Packet
from facetlog.robot.pioneer.packets.reports import Names
from facetlog.robot.simulator.firmware.firmware import BOOT_SECONDS
from tests.robot.simulator.clients import Client, connected, make_firmware


@pytest.fixture
def client() -> Client:
    return Client(make_firmware("p2dx"))


def test_syncs_are_echoed_and_the_last_one_names_the_robot(client: Client) -> None:
    for number in range(2):
        client.say(Packet(number))
        assert client.wait(0.05) == [Packet(number)]
    client.say(Packet(2))
    (answer,) = client.wait(0.05)
    assert Names.from_packet(answer) == Names("Test", "Pioneer", "p2dx")


@pytest.mark.parametrize("wrong", [1, 2])
def test_a_sync_out_of_order_loses_the_count(client: Client, wrong: int) -> None:
    client.say(Packet(wrong))
    assert client.wait(0.05) == [Packet(0xFF)]
    client.open()
    assert client.firmware.opened


@given(st.binary(max_size=60))
def test_the_first_sync_is_heard_soon_after_any_junk(junk: bytes) -> None:
    client = Client(make_firmware())
    client.firmware.receive(junk, 0.0)
    client.wait(0.5)  # what looked like the beginning of a command has been given up
    client.say(Packet(0))
    assert client.wait(0.05) == [Packet(0)]


def test_a_sync_within_a_session_is_a_pulse_and_is_not_answered() -> None:
    client = connected(make_firmware())
    client.wait(0.05)
    client.say(Packet(0))
    assert all(packet.kind == 0x32 for packet in client.wait(1.0))
    assert client.firmware.opened


def test_close_ends_reports_and_motors_and_goes_back_to_the_syncs() -> None:
    client = connected(make_firmware())
    client.command(Command.VEL, 300)
    client.wait(1.0)
    client.say(make_plain_command(Command.CLOSE))
    client.wait(0.0)
    assert client.wait(2.0) == []
    assert client.speed == 0.0
    assert not client.firmware.drive.motors
    client.open(motors=False)
    assert not client.firmware.drive.motors


def test_after_a_power_cycle_the_session_is_gone_and_the_robot_says_so() -> None:
    client = connected(make_firmware())
    client.command(Command.VEL, 300)
    client.wait(1.0)
    client.firmware.power_cycle(client.now)
    assert client.wait(BOOT_SECONDS / 2) == []
    client.command(Command.VEL, 300)
    assert client.wait(BOOT_SECONDS) == [Packet(0xFF)]
    assert client.speed == 0.0
    assert client.firmware.drive.odometry.x == 0.0
    client.open()
