"""The wait state: what the firmware answers before a session is open."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.robot.pioneer.packets.commands import (
    Command,
    make_integer_command,
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


def test_the_bytes_of_the_echoes_are_those_of_the_manual(client: Client) -> None:
    client.firmware.receive(bytes.fromhex("FA FB 03 00 00 00"), 0.0)
    assert client.firmware.pending(0.0) == bytes.fromhex("FA FB 03 00 00 00")
    client.firmware.receive(bytes.fromhex("FA FB 03 01 00 01"), 0.1)
    assert client.firmware.pending(0.1) == bytes.fromhex("FA FB 03 01 00 01")


def test_no_report_is_sent_before_open(client: Client) -> None:
    for number in range(3):
        client.say(Packet(number))
    client.wait(0.0)
    assert client.wait(1.0) == []
    client.command(Command.OPEN)
    assert len(client.wait(1.0)) == 10


def test_open_with_an_argument_opens_too(client: Client) -> None:
    for number in range(3):
        client.say(Packet(number))
    client.command(Command.OPEN, 1)
    client.wait(0.0)
    assert len(client.wait(0.5)) == 5


def test_a_repeated_sync_is_echoed_again(client: Client) -> None:
    for number in (0, 0, 1, 1, 2, 2):
        client.say(Packet(number))
        assert [packet.kind for packet in client.wait(0.05)] == [number]
    client.command(Command.OPEN)
    assert client.firmware.opened


@pytest.mark.parametrize("wrong", [1, 2])
def test_a_sync_out_of_order_loses_the_count(client: Client, wrong: int) -> None:
    client.say(Packet(wrong))
    assert client.wait(0.05) == [Packet(0xFF)]
    client.open()
    assert client.firmware.opened


def test_a_sync_left_out_loses_the_count(client: Client) -> None:
    client.say(Packet(0))
    client.wait(0.05)
    client.say(Packet(2))
    assert client.wait(0.05) == [Packet(0xFF)]


def test_an_open_that_comes_too_early_is_not_taken_for_a_sync(client: Client) -> None:
    client.command(Command.OPEN, 1)
    assert client.wait(0.05) == []
    client.open()


def test_other_packets_are_echoed_and_move_nothing(client: Client) -> None:
    packet = make_integer_command(Command.VEL, 200)
    client.say(make_integer_command(Command.ENABLE, 1), packet)
    assert client.wait(1.0)[1:] == [packet]
    assert client.truth.x == 0.0


def test_junk_and_the_radio_modems_greeting_are_skipped(client: Client) -> None:
    client.firmware.receive(b"WMS2\r\xfa\x00garbage\xfa\xfa", 0.0)
    client.open()


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


def test_the_reset_command_restarts_the_robot() -> None:
    client = connected(make_firmware())
    client.command(Command.RESET)
    client.wait(0.0)
    assert client.wait(BOOT_SECONDS + 0.1) == [Packet(0xFF)]
