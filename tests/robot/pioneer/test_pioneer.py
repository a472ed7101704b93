"""The driver with its threads, against a scripted robot in real time."""

import logging
import os
import threading
import time
from collections.abc import Callable, Iterator

import pytest

from facetlog.errors import DeviceError, DeviceTimeout
from facetlog.robot.pioneer.guard import Cause, Problem
from facetlog.robot.pioneer.packets.commands import Command
from facetlog.robot.pioneer.packets.packet import Packet
from facetlog.robot.pioneer.pioneer import Pioneer
from tests.robot.pioneer.scripted import ScriptedPort, ScriptedRobot

pytestmark = pytest.mark.usefixtures("quick")
PATIENCE = 20.0  # seconds a loaded machine gets for what takes one


@pytest.fixture(autouse=True)
def no_thread_is_left() -> Iterator[None]:
    before = set(threading.enumerate())
    yield
    left = [t for t in threading.enumerate() if t not in before]
    assert not left, f"threads are left over: {left}"


@pytest.fixture(autouse=True)
def quiet_log(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.CRITICAL, "facetlog.robot.pioneer.link")


def until(condition: Callable[[], bool], seconds: float = PATIENCE) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "in vain"
        time.sleep(0.01)


def keep_driving(
    robot: Pioneer, enough: Callable[[], bool], speed: float = 0.3, turning: float = 0.0
) -> None:
    deadline = time.monotonic() + PATIENCE
    while not enough():
        assert time.monotonic() < deadline, "in vain"
        if robot.halted is not None and robot.halted.cause is Cause.HELD_UP:
            robot.clear_stop()  # a busy machine gave the program no time
        robot.drive(speed, turning)
        time.sleep(0.05)


def test_a_robot_is_connected_driven_and_left_standing_with_its_motors_off() -> None:
    scripted = ScriptedRobot()
    port = ScriptedPort(scripted)
    with Pioneer.connect(port) as robot:
        assert robot.names.subclass == robot.parameters.name == "p3dx"
        assert robot.configuration is not None
        assert robot.state.motors_on is False
        robot.enable_motors()
        assert robot.state.motors_on is True
        keep_driving(robot, lambda: robot.state.pose.x > 0.05)
        robot.stop()
        state = robot.wait_for(lambda s: s.standing, PATIENCE)
        assert state.pose.x == pytest.approx(scripted.x, abs=0.001)
        assert robot.halted is None or robot.halted.cause is Cause.HELD_UP
        # A busy machine may not have given the program its turn in time.
        assert {p.cause for p in robot.problems} <= {Cause.LEASE, Cause.QUIET, Cause.HELD_UP}
    assert port.closed
    assert (scripted.session, scripted.motors, scripted.speed) == ("waiting", False, 0.0)
    words = [name for _, name, _ in scripted.commands]
    assert words.index("STOP") == words.index("OPEN", 3) + 1
    assert words[-1] == "CLOSE"


def test_every_request_is_answered() -> None:
    with Pioneer.connect(ScriptedPort(ScriptedRobot(x=1.25, y=-0.5))) as robot:
        pose = robot.ask_true_pose()
        assert (pose.x, pose.y) == (1.25, -0.5)
        assert robot.limits.speed == 0.3
        assert robot.baud is None


def test_a_thread_that_ends_with_its_lease_running_stops_the_robot() -> None:
    scripted = ScriptedRobot()
    with Pioneer.connect(ScriptedPort(scripted)) as robot:
        robot.enable_motors()
        driving = threading.Thread(target=lambda: robot.drive(0.3, 0.0))
        driving.start()
        driving.join()
        until(lambda: any("thread" in p.text for p in robot.problems))
        robot.wait_for(lambda s: s.standing, PATIENCE)


def test_a_callback_that_fails_is_a_problem_and_nothing_more() -> None:
    scripted = ScriptedRobot()

    def fail(problem: Problem) -> None:
        raise RuntimeError("no")

    with Pioneer.connect(ScriptedPort(scripted)) as robot:
        robot.on_problem(fail)
        scripted.stall = (True, False)
        until(lambda: Cause.CALLBACK in [p.cause for p in robot.problems])
        scripted.stall = (False, False)
        robot.wait_for(lambda s: not any(s.stalled), PATIENCE)


@pytest.mark.slow
def test_waiters_wake_up_when_the_link_is_lost() -> None:
    scripted = ScriptedRobot()
    with Pioneer.connect(ScriptedPort(scripted)) as robot:
        scripted.frozen = True
        with pytest.raises(DeviceTimeout, match="link is lost"):
            robot.wait_for(lambda s: s.speed > 1.0, PATIENCE)
        with pytest.raises(DeviceTimeout, match="link is lost"):
            _ = robot.state
        with pytest.raises(DeviceTimeout, match="link is lost"):
            robot.enable_motors()


def test_a_port_that_breaks_ends_the_session_and_closing_is_still_clean() -> None:
    port = ScriptedPort(ScriptedRobot())
    with Pioneer.connect(port) as robot:
        port.broken = DeviceError("the adapter was pulled out")
        with pytest.raises(DeviceError, match="pulled out"):
            robot.wait_for(lambda s: s.speed > 1.0, PATIENCE)
    assert port.closed


def test_motors_that_stay_off_are_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("facetlog.robot.pioneer.pioneer.ENABLE_TRIES", 1)
    with (
        Pioneer.connect(ScriptedPort(ScriptedRobot(enable_works=False))) as robot,
        pytest.raises(DeviceError, match="motors stay off"),
    ):
        robot.enable_motors()


def test_motors_are_not_switched_on_while_the_stop_button_is_pressed() -> None:
    scripted = ScriptedRobot(stop_button=True)
    with Pioneer.connect(ScriptedPort(scripted)) as robot:
        with pytest.raises(DeviceError, match="STOP button is pressed"):
            robot.enable_motors()
        assert ("ENABLE", 1) not in [(n, a) for _, n, a in scripted.commands]


def test_a_closed_robot_says_so_and_closing_again_does_no_harm() -> None:
    robot = Pioneer.connect(ScriptedPort(ScriptedRobot()))
    robot.close()
    robot.close()
    robot.stop()
    robot.emergency_stop()
    for use in (
        robot.enable_motors,
        robot.clear_stop,
        lambda: robot.drive(0.1, 0.0),
        lambda: robot.state,
        lambda: robot.aux(),
    ):
        with pytest.raises(DeviceError, match="closed"):
            use()


@pytest.mark.filterwarnings("ignore:This process:DeprecationWarning")
def test_a_fork_leaves_the_robot_to_its_parent() -> None:
    port = ScriptedPort(ScriptedRobot())
    with Pioneer.connect(port) as robot:
        child = os.fork()
        if child == 0:
            before = len(port.written)
            robot.stop()
            robot.close()
            try:
                robot.drive(0.1, 0.0)
            except DeviceError as error:
                os._exit(0 if "forked" in str(error) and len(port.written) == before else 1)
            os._exit(2)
        assert os.waitpid(child, 0)[1] == 0


def test_a_lease_runs_out_and_the_robot_stands() -> None:
    scripted = ScriptedRobot()
    with Pioneer.connect(ScriptedPort(scripted)) as robot:
        robot.enable_motors()
        keep_driving(robot, lambda: robot.state.speed > 0.25)
        robot.wait_for(lambda s: s.standing, PATIENCE)
        assert Cause.LEASE in [p.cause for p in robot.problems]


def test_an_exception_in_the_block_stops_the_robot_and_comes_through() -> None:
    scripted = ScriptedRobot()
    port = ScriptedPort(scripted)

    def interrupted() -> None:
        with Pioneer.connect(port) as robot:
            robot.enable_motors()
            keep_driving(robot, lambda: robot.state.speed > 0.2)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert (scripted.speed, scripted.motors, port.closed) == (0.0, False, True)


def test_a_bumper_stops_the_robot_and_the_callback_is_reported() -> None:
    scripted = ScriptedRobot()
    told: list[Problem] = []
    with Pioneer.connect(ScriptedPort(scripted)) as robot:
        robot.on_problem(told.append)
        robot.enable_motors()
        keep_driving(robot, lambda: robot.state.speed > 0.2)
        scripted.front_bumpers = 1
        with pytest.raises(DeviceError, match="bumper pressed"):
            keep_driving(robot, lambda: False)
        until(lambda: Cause.BUMPER in [p.cause for p in told])
        robot.wait_for(lambda s: s.standing, PATIENCE)
        assert robot.halted is not None
        assert robot.halted.cause is Cause.BUMPER
        scripted.front_bumpers = 0
        robot.wait_for(lambda s: not any(s.front_bumpers), PATIENCE)
        robot.clear_stop()
        keep_driving(robot, lambda: robot.state.speed > 0.1)


def test_settings_go_out_one_by_one_and_again_where_they_did_not_arrive() -> None:
    scripted = ScriptedRobot()
    take = scripted._take
    lost: list[float] = []

    def forgetful(packet: Packet, now: float) -> None:
        if packet.kind == Command.SETRV and not lost:
            lost.append(now)
        else:
            take(packet, now)

    scripted._take = forgetful  # type: ignore[method-assign]
    port = ScriptedPort(scripted)
    with Pioneer.connect(port) as robot:
        robot.enable_motors()
        assert lost
        assert scripted.configuration is not None
        assert scripted.configuration.turning_max == 30
        names = scripted.names()
        assert [names.count(name) for name in ("SETV", "SETRV", "SETA", "SETRA")] == [1] * 4
        times = [at for at, name, _ in scripted.commands if name in ("SETV", "SETA", "SETRA")]
        assert max(times) - min(times) > 0.1  # 0.05 s each; the machine may be late for the first
    assert scripted.configuration.speed_max == 750
