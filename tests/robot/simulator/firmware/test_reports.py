"""What the firmware reports: SIP, encoders, inputs and outputs, the true pose."""

import math
import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.robot.pioneer.packets.commands import Command, make_integer_command
from facetlog.robot.pioneer.packets.packet import Packet
from facetlog.robot.pioneer.packets.reports import (
    ServerInformation,
)
from facetlog.robot.pose2 import Pose2
from facetlog.robot.rendering.solids import cuboid, placed
from facetlog.robot.simulator.body import MotionErrors
from tests.robot.simulator.clients import Client, connected, make_firmware


def kinds(packets: list[Packet]) -> list[int]:
    return [packet.kind for packet in packets]


def test_ten_reports_come_a_second_whoever_asks_how_often() -> None:
    client = connected(make_firmware())
    assert len([client.wait(0.1) for _ in range(50)]) == 50
    assert len(client.packets) - 3 == pytest.approx(50, abs=1)
    client = connected(make_firmware(cycle_ms=50))
    assert len(client.wait(5.0)) == pytest.approx(100, abs=1)


@pytest.mark.parametrize(
    ("model", "tail"),
    [("pion1m", 4), ("p2dx", 4), ("p3dx", 6), ("p3dx-sh", 8)],
)
def test_later_firmware_sends_more_fields(model: str, tail: int) -> None:
    report = connected(make_firmware(model)).report()
    fields = ("gripper", "analog", "digital_in", "digital_out", "battery_10", "charge_state")
    fields += ("turning", "faults", "sideways")
    there = [name for name in fields if getattr(report, name) is not None]
    assert there == list(fields[:tail])


def test_motors_and_stop_button_stand_in_the_flags_from_aros_on() -> None:
    client = connected(make_firmware("p3dx"))
    assert client.report().flags & 0b100001 == 0b1
    client.firmware.drive.press_stop_button(client.now, pressed=True)
    assert client.report().flags & 0b100001 == 0b100000
    client.command(Command.ENABLE, 1)
    assert not client.report().flags & 1, "the button is still pressed"
    client.firmware.drive.press_stop_button(client.now, pressed=False)
    client.command(Command.ENABLE, 1)
    assert client.report().flags & 0b100001 == 0b1


@pytest.mark.parametrize(("model", "bits"), [("p3dx", 12), ("pion1m", 15)])
def test_odometry_rolls_over_and_differences_modulo_it_add_up(model: str, bits: int) -> None:
    client = connected(make_firmware(model, position_bits=bits))
    unit = client.firmware.drive.parameters.distance
    client.command(Command.VEL, -300)
    total, before, rolled = 0, 0, False
    for _ in range(200):
        client.command(Command.PULSE)
        x = client.report().x
        assert 0 <= x < 1 << bits
        step = (x - before + (1 << bits - 1)) % (1 << bits) - (1 << bits - 1)
        rolled |= abs(x - before) > 1 << bits - 1
        total, before = total + step, x
    assert rolled
    assert total * unit == pytest.approx(client.truth.x, abs=0.04)


def test_headings_and_speeds_are_in_the_units_of_the_model() -> None:
    client = connected(make_firmware("p2at"))
    client.command(Command.RVEL, 30)
    client.wait_pulsing(3.0)
    client.command(Command.RVEL, 0)
    client.wait_pulsing(1.0)
    assert client.report().heading == round(client.truth.heading / math.tau * 4096)
    client.command(Command.VEL, 200)
    client.wait_pulsing(2.0)
    report = client.report()
    assert report.left == report.right == 200
    assert report.y * 1.32e-3 == pytest.approx(client.truth.y, abs=0.01)


def test_sim_stat_gives_the_true_pose_in_amrisims_layout() -> None:
    start = Pose2(1.25, -0.5, math.radians(-30))
    errors = MotionErrors(left=0.01, right=-0.02)
    client = connected(make_firmware(start=start, errors=errors))
    client.command(Command.SIM_STAT, 1)
    (packet,) = (p for p in client.wait(0.01) if p.kind == 0x62)
    data = packet.payload
    assert data[:2] == b"\0\0"
    flags, *intervals = struct.unpack_from("<IHHH", data, 2)
    assert flags == 4
    assert intervals == [100] * 3
    assert struct.unpack_from("<iiii", data, 12) == (1250, -500, 0, -30)
    assert struct.unpack_from("<iiii", data, 28) == (0, 0, 0, -1)
    assert struct.unpack_from("<iii", data, 44) == (100_000, -200_000, 0)
    assert len(data) == 56
    client.command(Command.SIM_STAT, 2)
    assert kinds(client.wait(1.0)).count(0x62) == 10


def test_sonars_fire_one_after_the_other_and_each_reading_is_reported_once() -> None:
    wall = placed(cuboid(0.2, 4.0, 0.5), 2.1, 0.0)
    client = connected(make_firmware("p3dx", wall))
    client.wait(0.05)
    client.packets.clear()
    seen = [
        reading
        for packet in client.wait(3.2)
        for reading in ServerInformation.from_packet(packet).sonar
    ]
    # 16 sonars in two arrays, each fires 25 times a second
    assert len(seen) == pytest.approx(160, abs=4)
    assert {reading.index for reading in seen} == set(range(16))
    ahead = {reading.range for reading in seen if reading.index == 3}
    # sonar 3 sits 0.210 m ahead, turned 10 degrees to the left; its beam of 30 degrees covers 0
    assert [*ahead] == [pytest.approx(2000 - 210, abs=3)]
    assert {reading.range for reading in seen if reading.index == 8} == {5000}


def test_sonar_0_silences_the_sonars() -> None:
    client = connected(make_firmware())
    client.command(Command.SONAR, 0)
    assert client.report().sonar == ()


def test_unknown_and_malformed_commands_change_nothing() -> None:
    client: Client = connected(make_firmware())
    for packet in (
        Packet(Command.VEL, b"\x3b\x10"),
        Packet(Command.VEL, b"\x77\x10\x10"),
        Packet(Command.TTY2, b"\x2b\x09abc"),
        Packet(Command.HOSTBAUD, b"\x3b\x63\x00"),
        Packet(200, b"anything"),
        make_integer_command(Command.GETAUX2, 5),
    ):
        client.say(packet)
    client.wait(1.0)
    assert client.truth == Pose2(0.0, 0.0, 0.0)
    assert client.firmware.opened


def test_a_command_in_pieces_is_put_together_and_half_a_one_is_given_up() -> None:
    client = connected(make_firmware())
    data = make_integer_command(Command.VEL, 200).to_bytes()
    for byte in data:
        client.firmware.receive(bytes([byte]), client.now)
        client.wait(0.03)
    client.wait(1.0)
    assert client.speed == pytest.approx(0.2)
    client.firmware.receive(data[:5], client.now)
    client.wait(0.2)
    client.command(Command.VEL, 0)
    client.wait(1.0)
    assert client.speed == 0.0


@settings(max_examples=60)
@given(st.lists(st.binary(min_size=1, max_size=250), max_size=8))
def test_no_bytes_make_the_robot_fail_or_move(pieces: list[bytes]) -> None:
    client = connected(make_firmware("p2dx"))
    for piece in pieces:
        client.firmware.receive(piece, client.now)
        client.wait(0.07)
    # a command out of random bytes has its checksum right once in 65,536
    assert client.truth == Pose2(0.0, 0.0, 0.0)
