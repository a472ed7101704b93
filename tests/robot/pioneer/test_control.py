"""The driver's mind in simulated time: leases, watchdog, everything that stops the robot."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.errors import DeviceError, DeviceTimeout
from facetlog.robot.pioneer.control import LONGEST_LEASE, Control
from facetlog.robot.pioneer.guard import Cause
from facetlog.robot.pioneer.limits import Limits
from facetlog.robot.pioneer.packets.packet import Packet, Received
from facetlog.robot.pioneer.parameters import MODELS
from tests.robot.pioneer.drives import Drive, list_speeds_sent, way
from tests.robot.pioneer.scripted import CONFIGURATION, ScriptedRobot

STAND = 0.6  # seconds after the caller's death, of the issue


def causes(drive: Drive) -> list[Cause]:
    return [problem.cause for problem in drive.control.problems]


def moving(drive: Drive | None = None, speed: float = 0.3, turning: float = 0.0) -> Drive:
    drive = drive or Drive()
    drive.run(2.0, (speed, turning))
    assert drive.state.speed == pytest.approx(speed, abs=0.005)
    return drive


def test_speeds_are_repeated_several_times_a_second_and_no_more_often_than_p2os_takes() -> None:
    drive = moving()
    since = drive.now
    drive.run(3.0, (0.3, 0.0))
    times = [at for at, packet in drive.sent if at >= since]
    assert 10 <= len(times) / 3.0 <= 20  # one command in 50 ms
    gaps = [b - a for a, b in pairwise(times)]
    assert max(gaps) < 0.21


def test_a_robot_stands_within_the_limit_after_the_last_renewal() -> None:
    drive = moving()
    died = drive.now  # at most 0.1 s after the program's last word
    drive.run(2.0)
    assert drive.robot.stopped_at is not None
    assert drive.robot.stopped_at - died < STAND
    assert list_speeds_sent(drive, died)[-2:] == [("VEL", 0), ("RVEL", 0)]
    assert causes(drive) == [Cause.LEASE]
    drive.run(1.0, (0.1, 0.0))  # the lease is no offence
    assert drive.state.speed > 0


def test_a_robot_is_stopped_at_once_when_the_thread_that_drives_has_ended() -> None:
    drive = moving()
    alive = True
    drive.control.drive(0.3, 0.0, LONGEST_LEASE, drive.now, lambda: alive)
    drive.run(0.05)
    alive = False
    died = drive.now
    drive.run(0.05)
    assert ("VEL", 0) in list_speeds_sent(drive, died)
    drive.run(1.0)
    assert "thread" in drive.control.problems[-1].text
    assert drive.robot.stopped_at is not None
    assert drive.robot.stopped_at - died < 0.35


def test_a_robot_that_brakes_badly_is_stopped_the_hard_way() -> None:
    weak = replace(CONFIGURATION, acceleration_top=200)
    drive = moving(Drive(ScriptedRobot(configuration=weak)))
    died = drive.now
    drive.run(1.0)
    assert "ESTOP" in drive.names(died)
    assert drive.robot.stopped_at is not None
    assert drive.robot.stopped_at - died < STAND


def test_zeros_are_sent_until_the_robot_is_seen_to_stand_and_then_only_pulses() -> None:
    drive = moving()
    drive.control.stop()
    drive.run(1.5)
    since = drive.now
    drive.run(3.0)
    assert set(drive.names(since)) == {"PULSE"}
    assert 5 <= len(drive.names(since)) <= 7


def test_an_emergency_stop_is_hard_and_holds_until_it_is_cleared() -> None:
    drive = moving()
    since = drive.now
    drive.control.emergency_stop(drive.now)
    drive.run(0.2)
    assert drive.names(since)[:3] == ["ESTOP", "VEL 0", "RVEL 0"]
    assert drive.robot.speed == 0
    with pytest.raises(DeviceError, match=r"program called.*clear_stop"):
        drive.control.drive(0.1, 0.0, 0.3, drive.now)
    drive.control.clear_stop()
    drive.run(1.0, (0.1, 0.0))
    assert drive.state.speed == pytest.approx(0.1, abs=0.01)


def test_the_first_packets_after_a_gap_are_zeros_never_a_pulse() -> None:
    """The watchdog has stopped the robot: any packet lets it go on as it was told last."""
    drive = moving()
    drive.hang(3.0)
    assert drive.robot.speed == 0
    since, where = drive.now, way(drive.robot)
    drive.tick()
    assert drive.names(since) == ["VEL 0", "RVEL 0"]
    drive.run(1.0)
    assert way(drive.robot) - where < 0.005
    assert Cause.HELD_UP in causes(drive)


def test_a_program_that_is_held_up_while_the_robot_stands_has_lost_nothing() -> None:
    drive = Drive()
    drive.hang(5.0)
    drive.run(0.5)
    assert drive.control.halted is None
    assert Cause.HELD_UP not in causes(drive)


def test_no_reports_for_half_a_second_stop_the_robot_and_their_return_lets_it_go_on() -> None:
    drive = moving()
    drive.silent = True
    since = drive.now
    drive.run(1.0, (0.3, 0.0))
    assert drive.robot.speed == 0
    assert drive.robot.stopped_at is not None
    assert drive.robot.stopped_at - since < 0.6 + 0.3
    assert causes(drive) == [Cause.QUIET]
    drive.silent = False
    drive.run(2.0, (0.3, 0.0))
    assert causes(drive) == [Cause.QUIET, Cause.REPORTS_AGAIN]
    assert "no report came of the robot" in str(drive.control.problems[-1])
    assert drive.state.speed == pytest.approx(0.3, abs=0.01)
    assert drive.state.pose.x == pytest.approx(drive.robot.x, abs=0.04)


def test_no_reports_for_two_seconds_end_the_session() -> None:
    drive = moving()
    drive.silent = True
    drive.run(2.2)
    with pytest.raises(DeviceTimeout, match=r"link is lost.* after 2 s .* up to 0\.6 m on"):
        drive.control.drive(0.1, 0.0, 0.3, drive.now)
    drive.silent = False
    drive.run(1.0)
    with pytest.raises(DeviceTimeout, match="link is lost"):
        drive.control.check()
    assert drive.robot.speed == 0


def test_damaged_reports_alone_end_the_session_later() -> None:
    """They stop the robot as none do, but a noisy line may get better."""
    drive = moving()
    drive.damage = 0.5
    drive.run(8.0)
    assert drive.robot.speed == 0
    drive.control.check()
    drive.run(4.0)
    with pytest.raises(DeviceTimeout, match="damaged; check cable and baud rate"):
        drive.control.check()


@pytest.mark.parametrize(
    ("change", "cause", "text"),
    [
        ({"stall": (True, False)}, Cause.STALL, "left wheel"),
        ({"stall": (True, True)}, Cause.STALL, "left and right wheel"),
        ({"front_bumpers": 0b00100}, Cause.BUMPER, "front 3"),
        ({"stop_button": True}, Cause.STOP_BUTTON, "pull it out"),
        ({"motors": False}, Cause.MOTORS_OFF, "enable_motors"),
    ],
)
def test_what_the_robot_reports_stops_it_and_is_said(
    change: dict[str, object], cause: Cause, text: str
) -> None:
    drive = moving()
    for name, value in change.items():
        setattr(drive.robot, name, value)
    since = drive.now
    drive.run(0.6)
    assert causes(drive)[0] is cause
    assert text in drive.control.problems[0].text
    assert list_speeds_sent(drive, since)[-2:] == [("VEL", 0), ("RVEL", 0)]
    assert drive.robot.speed == 0
    with pytest.raises(DeviceError, match="clear_stop"):
        drive.control.drive(-0.1, 0.0, 0.3, drive.now)


def test_a_problem_that_goes_on_is_said_once() -> None:
    drive = moving()
    drive.robot.front_bumpers = 1
    drive.robot.stall = (True, True)
    drive.run(3.0)
    assert causes(drive) == [Cause.BUMPER, Cause.STALL]


def test_a_bumped_robot_may_be_driven_away_from_the_bumper_only() -> None:
    drive = moving()
    drive.robot.front_bumpers = 1
    drive.run(1.0)
    drive.control.clear_stop()
    with pytest.raises(DeviceError, match="front bumper is pressed: drive backward"):
        drive.control.drive(0.1, 0.0, 0.3, drive.now)
    drive.run(1.0, (-0.1, 0.0))
    assert drive.state.speed < -0.05


def test_a_low_battery_stops_the_robot_but_a_dip_does_not() -> None:
    drive = moving()
    drive.robot.battery = 105
    drive.run(0.5, (0.3, 0.0))
    drive.robot.battery = 125
    drive.run(1.0, (0.3, 0.0))
    assert causes(drive) == []
    drive.robot.battery = 105
    drive.run(1.5)
    assert Cause.LOW_BATTERY in causes(drive)
    drive.control.clear_stop()
    with pytest.raises(DeviceError, match=r"10\.5 V, limit 11\.0 V"):
        drive.control.drive(0.1, 0.0, 0.3, drive.now)


def test_motors_are_off_until_they_are_switched_on() -> None:
    drive = Drive(enabled=False)
    assert drive.state.motors_on is False
    with pytest.raises(DeviceError, match=r"press the MOTORS button or call enable_motors"):
        drive.control.drive(0.1, 0.0, 0.3, drive.now)
    assert not any(name.startswith("ENABLE") for name in drive.names())


def test_motors_are_not_switched_on_again_by_the_driver() -> None:
    drive = moving()
    drive.robot.motors = False
    since = drive.now
    drive.run(5.0)
    assert not any(name.startswith("ENABLE") for name in drive.names(since))


def old_robot(**changes: object) -> Drive:
    return Drive(
        ScriptedRobot(model="p2dx", reports_motors=False, **changes)  # type: ignore[arg-type]
    )


def test_old_firmware_does_not_report_its_motors_but_its_behaviour_shows_them() -> None:
    """There the flags are a servo's pulse width; here 1500, which would say STOP button."""
    drive = old_robot()
    assert drive.state.motors_on is None
    assert drive.state.stop_button is None
    drive.run(1.0, (0.2, 0.0))
    assert drive.state.motors_on is True
    assert drive.control.problems == ()


def test_a_robot_that_does_not_move_is_said_to_have_its_motors_off() -> None:
    drive = old_robot(enable_works=False)
    with pytest.raises(DeviceError, match="commanded to move for"):
        drive.run(4.0, (0.2, 0.0))
    assert causes(drive) == [Cause.NOT_MOVING]
    assert "MOTORS button" in drive.control.problems[0].text
    drive.run(0.2)
    assert drive.state.motors_on is False


def test_the_robot_itself_is_given_the_limits() -> None:
    drive = Drive(limits=Limits(speed=0.2))
    for name in ("BUMPSTALL 3", "SETV 200", "SETRV 30", "SETA -1200", "SETRA -120"):
        assert name in drive.names()
    assert drive.robot.deceleration == 1.2


@pytest.mark.parametrize(
    ("front", "rear", "expected"), [(5, 5, ["BUMPSTALL 3"]), (5, 0, ["BUMPSTALL 1"]), (0, 0, [])]
)
def test_only_bumpers_that_there_are_stall_the_wheels(
    front: int, rear: int, expected: list[str]
) -> None:
    robot = ScriptedRobot(
        configuration=replace(CONFIGURATION, front_bumpers=front, rear_bumpers=rear)
    )
    assert [name for name in Drive(robot).names() if name.startswith("BUMPSTALL")] == expected


def test_the_robots_own_settings_are_given_back() -> None:
    names = [(packet.kind, packet.payload) for packet in Drive().control.parting()]
    assert len(names) == 4
    assert names[0] == (6, b"\x3b\xee\x02")  # SETV 750


@pytest.mark.parametrize("lease", [0.0, -1.0, 0.4, 1.0, math.nan])
def test_a_lease_is_short(lease: float) -> None:
    with pytest.raises(ValueError, match="lease"):
        Drive().control.drive(0.1, 0.0, lease, 50.0)


@pytest.mark.parametrize("speed", [math.nan, math.inf])
def test_what_is_no_speed_is_refused_and_nothing_is_sent(speed: float) -> None:
    drive = Drive()
    with pytest.raises(ValueError, match="cannot drive"):
        drive.control.drive(speed, 0.0, 0.3, drive.now)


@given(
    st.lists(st.tuples(st.integers(0, 0xFD), st.binary(max_size=120)), max_size=30),
    st.sampled_from(["p2dx", "p3dx", "pion1m"]),
)
def test_no_packets_whatever_is_in_them_upset_the_driver(
    packets: list[tuple[int, bytes]], model: str
) -> None:
    control, now = Control(0.0, MODELS[model], CONFIGURATION), 0.0
    for kind, payload in packets:
        now += 0.1
        control.take(Received(Packet(0x32 if kind % 2 else kind, payload), now))
        control.looked(now)
        assert all(packet.to_bytes() for packet in control.advance(now))
    if control.state is not None:
        assert math.isfinite(control.state.pose.x)
        assert np.isfinite(control.state.covariance).all()


def test_a_caller_that_hangs_right_after_the_longest_lease_leaves_a_robot_that_stands() -> None:
    drive = moving()
    hung = drive.now
    drive.control.drive(0.3, 0.0, LONGEST_LEASE, hung)
    drive.run(1.5)
    assert drive.robot.stopped_at is not None
    assert drive.robot.stopped_at - hung < STAND


def test_a_program_that_was_held_up_while_driving_drives_on_only_after_clear_stop() -> None:
    drive = moving()
    drive.hang(5.0)
    drive.run(1.0)
    assert drive.control.halted in drive.control.problems
    with pytest.raises(DeviceError, match=r"held up for 5\.\d s while the robot.*clear_stop"):
        drive.control.drive(0.1, 0.0, 0.3, drive.now)
    drive.control.clear_stop()
    drive.run(1.0, (0.1, 0.0))
    assert drive.state.speed == pytest.approx(0.1, abs=0.01)


def test_zeros_go_before_anything_that_somebody_else_sends_after_a_gap() -> None:
    drive = moving()
    drive.hang(3.0)
    since, where = drive.now, way(drive.robot)
    drive.send(Packet(42, b"\x2b\x01\x81"))
    assert drive.names(since) == ["VEL 0", "RVEL 0", "TTY2 81"]
    drive.run(1.0)
    assert way(drive.robot) - where < 0.005


def test_a_shorter_watchdog_of_the_robot_makes_for_shorter_gaps() -> None:
    robot = ScriptedRobot(configuration=replace(CONFIGURATION, watchdog_ms=600), watchdog=0.6)
    drive = moving(Drive(robot))
    drive.hang(0.5)
    since = drive.now
    drive.tick()
    assert drive.names(since) == ["VEL 0", "RVEL 0"]


def test_a_cut_line_leaves_a_robot_that_stands_and_does_not_jump_when_it_is_mended() -> None:
    drive = moving()
    drive.cut = True
    drive.run(4.0)
    assert drive.robot.speed == 0  # by its watchdog
    where = way(drive.robot)
    drive.cut = False
    drive.run(2.0)
    assert way(drive.robot) - where < 0.005


def test_a_reset_of_the_controller_ends_the_session() -> None:
    drive = moving()
    drive.control.take(Received(Packet(0xFF), drive.now))
    with pytest.raises(DeviceError, match="reset"):
        drive.control.drive(0.1, 0.0, 0.3, drive.now)
    assert causes(drive) == [Cause.RESET]


def test_motors_of_old_firmware_that_go_off_on_the_way_are_said_once() -> None:
    drive = old_robot()
    drive.run(1.0, (0.2, 0.0))
    drive.robot.motors = False
    with pytest.raises(DeviceError, match="commanded to move for"):
        drive.run(4.0, (0.2, 0.0))
    drive.run(1.0)
    assert causes(drive) == [Cause.NOT_MOVING]


def test_speeds_are_within_the_limits_and_keep_their_curve() -> None:
    drive = Drive()
    assert drive.control.drive(2.0, 1.0, 0.3, drive.now) == pytest.approx((0.3, 0.15))
    assert drive.control.drive(0.0, -9.0, 0.3, drive.now) == pytest.approx((0.0, -math.radians(30)))


@pytest.mark.slow
@pytest.mark.parametrize("damage", [0.01, 0.05])
def test_damage_and_gaps_cost_the_pose_nothing_but_the_rounding_of_the_encoders(
    damage: float,
) -> None:
    """Bytes damaged both ways, and half a second of no line at all every three seconds.

    Of 5 % damage a report of 31 bytes survives in one case of five.
    """
    drive = Drive(damage=damage)
    for i in range(6000):
        drive.cut = i % 300 >= 250
        if i % 10 == 0:
            drive.control.clear_stop()
            drive.control.drive(0.25, 0.2, 0.3, drive.now)
        drive.tick()
    drive.cut = False
    drive.run(2.0)
    drive.damage = 0.0  # for the last word: a false report may pass for whole, until the next
    drive.run(0.5)
    assert drive.robot.speed == drive.robot.turning == 0
    assert drive.control.lost is None
    pose, robot = drive.state.pose, drive.robot
    # The encoders' own error: a unit of rounding for both ends.
    assert math.hypot(pose.x - robot.x, pose.y - robot.y) < 0.485e-3
    assert abs(math.remainder(pose.heading - robot.heading, math.tau)) < math.tau / 4096
    doubted = [p for p in drive.control.problems if p.cause is Cause.ODOMETRY]
    assert not doubted
