"""Motion: what each command makes of the robot, in simulated time."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.robot.pioneer.packets.commands import Command
from facetlog.robot.pioneer.packets.reports import Configuration
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


@pytest.mark.parametrize("turning", [20, -20])
def test_rvel_turns_counter_clockwise_if_positive(client: Client, turning: int) -> None:
    client.command(Command.RVEL, turning)
    client.wait(1.0)
    assert math.degrees(client.turning) == pytest.approx(turning)
    # 0.2 s of acceleration at 100 degrees/s², then 0.8 s
    assert math.degrees(client.truth.heading) == pytest.approx(0.9 * turning, abs=0.2)


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


def test_stop_keeps_the_motors_on_and_estop_stops_harder() -> None:
    ways = {}
    for command in (Command.STOP, Command.ESTOP):
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
    assert ways[Command.ESTOP] == pytest.approx(0.0225, abs=2e-3)


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
    for command, value in commands:
        before = client.truth
        client.command(command, value)
        client.wait(0.3)
        assert abs(client.speed) <= 1.5 + 1e-9
        assert abs(client.turning) <= math.radians(300) + 1e-9
        gone = math.hypot(client.truth.x - before.x, client.truth.y - before.y)
        assert gone <= 0.3 * 1.5 + 1e-6
