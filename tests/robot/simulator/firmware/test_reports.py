"""What the firmware reports: SIP, encoders, inputs and outputs, the true pose."""

import math
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.robot.pioneer.packets.commands import Command, make_integer_command, make_text_command
from facetlog.robot.pioneer.packets.packet import Packet
from facetlog.robot.pioneer.packets.reports import (
    Configuration,
    Encoders,
    InputsOutputs,
    ServerInformation,
)
from facetlog.robot.rendering.solids import cuboid, placed
from facetlog.robot.simulator.body import MotionErrors, Truth
from tests.robot.simulator.clients import Client, connected, make_firmware


def kinds(packets: list[Packet]) -> list[int]:
    return [packet.kind for packet in packets]


def test_ten_reports_come_a_second_whoever_asks_how_often() -> None:
    client = connected(make_firmware())
    assert len([client.wait(0.1) for _ in range(50)]) == 50
    assert len(client.packets) - 3 == pytest.approx(50, abs=1)
    client = connected(make_firmware(cycle_ms=50))
    assert len(client.wait(5.0)) == pytest.approx(100, abs=1)


def test_the_kind_of_a_report_says_whether_the_robot_moves() -> None:
    client = connected(make_firmware())
    client.wait(0.5)
    assert set(kinds(client.wait(0.5))) == {0x32}
    client.command(Command.VEL, 100)
    client.wait(0.2)
    assert set(kinds(client.wait(0.5))) == {0x33}


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


def test_on_p2os_the_flags_say_nothing_of_the_motors() -> None:
    client = connected(make_firmware("p2dx"))
    on = client.report().flags
    client.command(Command.ENABLE, 0)
    assert client.report().flags == on == 0


def test_the_stop_button_stalls_the_wheels_unless_e_stall_is_off() -> None:
    client = connected(make_firmware("p3dx"))
    client.firmware.drive.press_stop_button(client.now, pressed=True)
    assert client.report().stall_left
    client = connected(make_firmware("p3dx"))
    client.command(Command.E_STALL, 0)
    client.firmware.drive.press_stop_button(client.now, pressed=True)
    assert not client.report().stall_left


@pytest.mark.parametrize("model", ["p2dx", "p3dx", "pion1m"])
@pytest.mark.parametrize("bits", [12, 15])
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
    client.command(Command.HEAD, 90)
    client.wait_pulsing(5.0)
    assert client.report().heading == 1024
    assert client.report().control == 1024
    client.command(Command.VEL, 200)
    client.wait_pulsing(2.0)
    report = client.report()
    assert report.left == report.right == 200
    assert report.x == 0 or report.x > 1 << 14
    assert report.y * 1.32e-3 == pytest.approx(client.truth.y, abs=0.01)


def test_battery_is_reported_in_tenths_of_a_volt() -> None:
    client = connected(make_firmware())
    client.firmware.battery_v = 11.2
    report = client.report()
    assert (report.battery, report.battery_10) == (112, 112)


@pytest.mark.parametrize("value", [2, 3])
def test_encoder_is_sent_once_streamed_and_stopped(value: int) -> None:
    client = connected(make_firmware())
    client.wait(0.05)
    client.command(Command.ENCODER, 1)
    assert kinds(client.wait(0.01)) == [0x90]
    assert 0x90 not in kinds(client.wait(1.0))
    client.command(Command.ENCODER, value)
    assert kinds(client.wait(1.0)).count(0x90) == 10
    client.command(Command.ENCODER, 0)
    assert 0x90 not in kinds(client.wait(1.0))


def test_encoders_count_both_ways_in_ticks() -> None:
    client = connected(make_firmware(ticks_mm=128))
    client.command(Command.MOVE, -500)
    client.wait_pulsing(5.0)
    client.command(Command.RVEL, 10)
    client.wait_pulsing(2.0)
    client.command(Command.ENCODER, 1)
    (told,) = (Encoders.from_packet(p) for p in client.wait(0.01) if p.kind == 0x90)
    assert (told.left + told.right) / 2 == pytest.approx(-500 * 128, abs=128)
    turned = client.truth.heading * client.firmware.drive.body.track
    assert (told.right - told.left) / 128e3 == pytest.approx(turned, abs=1e-3)


def test_inputs_and_outputs_are_sent_on_request_and_digout_changes_what_its_mask_says() -> None:
    client = connected(make_firmware())
    client.command(Command.DIGOUT, 0x0F0A)
    client.command(Command.DIGOUT, 0x03FF)
    client.command(Command.IOREQUEST, 1)
    told = [InputsOutputs.from_packet(p) for p in client.wait(0.01) if p.kind == 0xF0]
    assert [each.digital_out for each in told] == [b"\x0b"]
    assert len(told[0].analog) == 8
    assert client.report().digital_out == 0x0B
    client.command(Command.IOREQUEST, 2)
    assert kinds(client.wait(1.0)).count(0xF0) == 10
    client.command(Command.IOREQUEST, 0)
    assert 0xF0 not in kinds(client.wait(1.0))


def test_sim_stat_gives_the_true_pose_in_amrisims_layout() -> None:
    start = Truth(1.25, -0.5, math.radians(-30))
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


def test_config_is_complete_and_read_back_by_the_codec() -> None:
    client = connected(make_firmware("p2dx"))
    client.command(Command.CONFIG)
    (packet,) = (p for p in client.wait(0.01) if p.kind == 0x20)
    told = Configuration.from_packet(packet)
    assert (told.robot_class, told.subclass) == ("Pioneer", "p2dx")
    assert told.simulated
    assert (told.cycle_ms, told.watchdog_ms, told.front_bumpers) == (100, 2000, 5)
    assert None not in [getattr(told, name) for name in told.__dataclass_fields__]


def test_every_report_fits_into_a_packet_of_200_bytes() -> None:
    for model in ("p2dx", "p3at-sh"):
        client = connected(make_firmware(model))
        client.command(Command.CONFIG)
        for packet in client.wait(2.0):
            assert len(packet.to_bytes()) <= 200


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


def test_the_first_report_has_only_what_was_measured_since_the_sonars_were_on() -> None:
    client = Client(make_firmware("p3dx"))
    client.wait(5.0)
    client.open()
    # 100 ms at 40 ms a sonar, in two arrays
    assert len(client.report().sonar) == 4
    client.command(Command.SONAR, 0)
    client.wait(5.0)
    client.command(Command.SONAR, 1)
    assert len(client.report().sonar) <= 6


def test_ranges_are_in_the_unit_of_the_model() -> None:
    wall = placed(cuboid(0.2, 4.0, 0.5), 1.31, 0.0)
    client = connected(make_firmware("p2dx", wall))
    ranges = [r.range for _ in range(5) for r in client.report().sonar if r.index == 3]
    assert ranges[0] * 0.268 == pytest.approx(1000, abs=3)


def test_sonar_0_silences_the_sonars_and_polling_chooses_among_them() -> None:
    client = connected(make_firmware())
    client.command(Command.SONAR, 0)
    assert client.report().sonar == ()
    client.command(Command.SONAR, 1)
    client.say(make_text_command(Command.POLLING, bytes([3, 5])))
    client.report()
    told = {reading.index for _ in range(5) for reading in client.report().sonar}
    assert told == {2, 4}


def test_unknown_and_malformed_commands_change_nothing() -> None:
    client: Client = connected(make_firmware())
    for packet in (
        Packet(Command.VEL, b"\x3b\x10"),
        Packet(Command.VEL, b"\x77\x10\x10"),
        Packet(Command.VEL2, b""),
        Packet(Command.SIM_SET_POSE, b"\0\1"),
        Packet(Command.TTY2, b"\x2b\x09abc"),
        Packet(Command.HOSTBAUD, b"\x3b\x63\x00"),
        Packet(200, b"anything"),
        make_integer_command(Command.GETAUX2, 5),
    ):
        client.say(packet)
    client.wait(1.0)
    assert client.truth == Truth(0.0, 0.0, 0.0)
    assert client.firmware.opened


def test_a_command_of_more_than_200_bytes_is_ignored() -> None:
    client = connected(make_firmware())
    longest = Packet(Command.VEL, b"\x3b\xc8\x00" + bytes(194))
    longer = Packet(Command.VEL, b"\x3b\xc8\x00" + bytes(195))
    client.say(longer)
    client.wait(1.0)
    assert client.speed == 0.0
    client.say(longest)
    client.wait(1.0)
    assert client.speed > 0.1


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


def test_a_garbled_length_does_not_swallow_the_commands_behind_it_for_long() -> None:
    client = connected(make_firmware())
    client.command(Command.VEL, 200)
    client.wait(1.0)
    client.firmware.receive(bytes.fromhex("FA FB C0 0B 3B"), client.now)
    for _ in range(5):  # a client that repeats its stop every 50 ms
        client.command(Command.VEL, 0)
        client.wait(0.05)
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
    assert client.truth == Truth(0.0, 0.0, 0.0)


def test_a_stream_of_damaged_commands_is_survived() -> None:
    rng = np.random.default_rng(0)
    commands = [
        make_integer_command(command, int(value)).to_bytes()
        for command in Command
        for value in rng.integers(-500, 500, 3)
    ]
    client = connected(make_firmware("p3dx"))
    for _ in range(1500):
        data = bytearray(commands[rng.integers(len(commands))])
        if rng.random() < 0.5:
            data[rng.integers(len(data))] = rng.integers(256)
        client.firmware.receive(bytes(data), client.now)
        client.wait(0.01)
        assert abs(client.speed) <= 1.5 + 1e-9
    client.firmware.power_cycle(client.now)
    client.wait(3.0)
    client.open()
