"""Motion: what each command makes of the robot, in simulated time."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.robot.pioneer.packets.commands import Command, make_wheels_command
from facetlog.robot.pioneer.packets.packet import Packet
from facetlog.robot.pioneer.packets.reports import Configuration
from facetlog.robot.simulator.body import Truth
from tests.robot.simulator.clients import Client, connected, make_firmware

ACCELERATION = 0.3  # m/s², of the firmware as it comes


@pytest.fixture
def client() -> Client:
    return connected(make_firmware())


def test_motors_are_off_after_connecting_and_vel_is_ignored() -> None:
    client = connected(make_firmware(), motors=False)
    client.command(Command.VEL, 300)
    client.wait(0.5)
    client.command(Command.ENABLE, 1)
    client.wait(1.0)
    assert client.truth.x == 0.0
    client.command(Command.VEL, 300)
    client.wait(1.0)
    assert client.truth.x > 0.1


@pytest.mark.parametrize("speed", [200, -200])
def test_vel_accelerates_to_the_commanded_speed_and_no_faster(client: Client, speed: int) -> None:
    client.command(Command.VEL, speed)
    client.wait(0.4)
    assert client.speed == pytest.approx(math.copysign(0.4 * ACCELERATION, speed), abs=2e-3)
    client.wait(1.0)
    assert client.speed == pytest.approx(speed / 1e3)


@pytest.mark.parametrize("command", [Command.RVEL, Command.ROTATE])
@pytest.mark.parametrize("turning", [20, -20])
def test_rvel_turns_counter_clockwise_if_positive(
    client: Client, command: Command, turning: int
) -> None:
    client.command(command, turning)
    client.wait(1.0)
    assert math.degrees(client.turning) == pytest.approx(turning)
    # 0.2 s of acceleration at 100 degrees/s², then 0.8 s
    assert math.degrees(client.truth.heading) == pytest.approx(0.9 * turning, abs=0.2)


@pytest.mark.parametrize("way", [300, 1000, -300, -1000, 3])
def test_move_goes_the_commanded_distance(client: Client, way: int) -> None:
    client.command(Command.MOVE, way)
    client.wait_pulsing(8.0)
    assert client.speed == 0.0
    assert client.truth.x == pytest.approx(way / 1e3, abs=1e-3)


def test_move_is_unknown_to_the_pioneer_1() -> None:
    client = connected(make_firmware("pion1m"))
    client.command(Command.MOVE, 300)
    client.wait_pulsing(3.0)
    assert client.truth.x == 0.0


@pytest.mark.parametrize(("asked", "reached"), [(90, 90), (-90, -90), (270, -90), (359, -1)])
def test_head_turns_to_a_heading_the_shorter_way(
    client: Client, asked: int, reached: float
) -> None:
    client.command(Command.HEAD, asked)
    seen = []
    for _ in range(60):
        client.command(Command.PULSE)
        client.wait(0.1)
        seen.append(math.degrees(client.truth.heading))
    assert seen[-1] == pytest.approx(reached, abs=0.1)
    assert max(abs(heading) for heading in seen) < abs(reached) + 1.0


def test_dhead_is_from_the_present_heading_and_dchead_from_the_commanded_one(
    client: Client,
) -> None:
    client.command(Command.DHEAD, 40)
    client.command(Command.DCHEAD, 20)
    client.wait_pulsing(4.0)
    assert math.degrees(client.truth.heading) == pytest.approx(60, abs=0.1)
    client.command(Command.DHEAD, -45)
    client.wait_pulsing(4.0)
    assert math.degrees(client.truth.heading) == pytest.approx(15, abs=0.2)


@pytest.mark.parametrize(
    "packet",
    [
        make_wheels_command(left=5, right=10),
        Packet(Command.VEL2, bytes([0x3B, 10, 5])),
        Packet(Command.VEL2, bytes([0x1B]) + (-(5 << 8 | 10) & 0xFFFF).to_bytes(2, "little")),
    ],
)
def test_vel2_takes_the_right_wheel_from_its_low_byte(client: Client, packet: Packet) -> None:
    client.say(packet)
    client.wait(1.5)
    report = client.report()
    assert (report.left, report.right) == (100, 200)


@pytest.mark.parametrize(
    "packet",
    [
        make_wheels_command(left=-5, right=5),
        # as ARIA sends it: the magnitude of the 16 bits, with the type of a negative number
        Packet(Command.VEL2, bytes([0x1B]) + (0x10000 - 0xFB05).to_bytes(2, "little")),
    ],
)
def test_vel2_takes_negative_speeds_in_both_forms(client: Client, packet: Packet) -> None:
    client.say(packet)
    client.wait(1.5)
    report = client.report()
    assert (report.left, report.right) == (-100, 100)


def test_setv_limits_the_speed_and_top_limits_setv(client: Client) -> None:
    client.command(Command.SETV, 150)
    client.command(Command.VEL, 3000)
    client.wait_pulsing(2.0)
    assert client.speed == pytest.approx(0.15)
    client.command(Command.SETV, 30000)
    client.command(Command.VEL, 30000)
    client.wait_pulsing(10.0)
    assert client.speed == pytest.approx(1.5)


def test_setrv_limits_both_directions_and_setrvdir_one(client: Client) -> None:
    client.command(Command.SETRV, 20)
    client.command(Command.SETRVDIR, -10)
    client.command(Command.RVEL, 90)
    client.wait_pulsing(1.0)
    assert math.degrees(client.turning) == pytest.approx(20)
    client.command(Command.RVEL, -90)
    client.wait_pulsing(1.0)
    assert math.degrees(client.turning) == pytest.approx(-10)


def test_seta_sets_acceleration_by_a_positive_and_deceleration_by_a_negative_number(
    client: Client,
) -> None:
    client.command(Command.SETA, 100)
    client.command(Command.SETA, -600)
    client.command(Command.VEL, 300)
    client.wait(1.0)
    assert client.speed == pytest.approx(0.1, abs=2e-3)
    client.wait_pulsing(3.0)
    client.command(Command.STOP)
    client.wait(0.25)
    assert client.speed == pytest.approx(0.15, abs=5e-3)


def test_setra_sets_how_fast_turning_grows_and_falls(client: Client) -> None:
    client.command(Command.SETRA, 20)
    client.command(Command.SETRA, -200)
    client.command(Command.RVEL, 40)
    client.wait(1.0)
    assert math.degrees(client.turning) == pytest.approx(20, abs=0.2)
    client.command(Command.RVEL, 0)
    client.wait(0.2)
    assert client.turning == 0.0


def test_stop_keeps_the_motors_on_and_estop_stops_harder() -> None:
    ways = {}
    for command in (Command.STOP, Command.ESTOP, Command.QSTOP):
        client = connected(make_firmware())
        client.command(Command.VEL, 300)
        client.wait_pulsing(2.0)
        before = client.truth.x
        client.command(command)
        client.wait(2.0)
        assert client.speed == 0.0
        assert client.firmware.drive.motors
        ways[command] = client.truth.x - before
    # v² / 2a with 0.3 m/s² and 2 m/s²
    assert ways[Command.STOP] == pytest.approx(0.15, abs=3e-3)
    assert ways[Command.ESTOP] == ways[Command.QSTOP] == pytest.approx(0.0225, abs=2e-3)


def test_motion_commands_during_an_emergency_stop_are_ignored(client: Client) -> None:
    client.command(Command.VEL, 300)
    client.wait(1.0)
    client.command(Command.ESTOP)
    client.command(Command.VEL, 300)
    client.wait(1.0)
    assert client.speed == 0.0
    client.command(Command.VEL, 300)
    client.wait(1.0)
    assert client.speed > 0.2


def test_enable_0_stops_the_robot_and_clears_its_commands(client: Client) -> None:
    client.command(Command.VEL, 300)
    client.wait(1.0)
    client.command(Command.ENABLE, 0)
    client.wait(1.0)
    client.command(Command.ENABLE, 1)
    client.wait(1.0)
    assert client.speed == 0.0


def test_seto_takes_the_present_place_as_origin_with_and_without_its_argument(
    client: Client,
) -> None:
    for packet in (Packet(Command.SETO), Packet(Command.SETO, b"\x3b")):
        client.command(Command.MOVE, 200)
        client.wait_pulsing(3.0)
        assert client.report().x > 300
        client.say(packet)
        report = client.report()
        assert (report.x, report.y, report.heading) == (0, 0, 0)
    assert client.truth.x == pytest.approx(0.4, abs=1e-3)


def test_seto_leaves_the_commanded_heading_where_it_is(client: Client) -> None:
    client.command(Command.HEAD, 90)
    client.wait(1.0)
    client.command(Command.SETO)
    client.wait_pulsing(4.0)
    assert math.degrees(client.truth.heading) == pytest.approx(90, abs=0.2)


def test_sim_set_pose_moves_the_robot_and_not_its_odometry(client: Client) -> None:
    numbers = b"".join(n.to_bytes(4, "little", signed=True) for n in (-1500, 2500, -90))
    client.say(Packet(Command.SIM_SET_POSE, b"\0" + numbers))
    assert client.report().x == 0
    assert client.truth == Truth(-1.5, 2.5, math.radians(-90))
    client.command(Command.SIM_RESET)
    assert client.truth == Truth(0.0, 0.0, 0.0)


def test_config_reports_the_settings(client: Client) -> None:
    client.command(Command.SETV, 444)
    client.command(Command.SETRA, -33)
    client.wait(0.01)
    client.command(Command.CONFIG, 1)
    (packet,) = (p for p in client.wait(0.01) if p.kind == 0x20)
    told = Configuration.from_packet(packet)
    assert told.speed_max == 444
    assert told.turning_deceleration == 33
    assert told.watchdog_ms == 2000
    assert told.kinematics_delay is not None, "the packet is complete"


@settings(max_examples=25)
@given(st.lists(st.tuples(st.sampled_from(list(Command)), st.integers(-2000, 2000)), max_size=12))
def test_no_command_makes_the_robot_faster_than_its_top_or_jump(
    commands: list[tuple[Command, int]],
) -> None:
    client = connected(make_firmware())
    placing = (Command.SIM_RESET, Command.SIM_SET_POSE)
    for command, value in commands:
        if command in placing:
            continue
        before = client.truth
        client.command(command, value)
        client.wait(0.3)
        assert abs(client.speed) <= 1.5 + 1e-9
        assert abs(client.turning) <= math.radians(300) + 1e-9
        gone = math.hypot(client.truth.x - before.x, client.truth.y - before.y)
        assert gone <= 0.3 * 1.5 + 1e-6
