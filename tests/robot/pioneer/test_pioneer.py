"""The driver with its threads, against a scripted robot in real time."""

import logging
import os
import pty
import signal
import socket
import subprocess
import sys
import threading
import time
import tty
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from facetlog.errors import DeviceError, DeviceTimeout, InputError
from facetlog.robot.pioneer.guard import Cause, Problem
from facetlog.robot.pioneer.packets.commands import Command
from facetlog.robot.pioneer.packets.packet import Packet
from facetlog.robot.pioneer.packets.reports import Encoders, InputsOutputs
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
        assert robot.encoders() == Encoders(-70000, 123456)
        assert robot.inputs_outputs() == InputsOutputs(b"\x0f", b"\xf0", (512, 3))
        pose = robot.true_pose()
        assert (pose.x, pose.y) == (1.25, -0.5)
        assert robot.limits.speed == 0.3
        assert robot.baud is None


def test_a_robot_that_is_not_simulated_has_no_true_pose(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("facetlog.robot.pioneer.pioneer.ASK_EACH", 0.05)
    robot_without = ScriptedRobot()
    take = robot_without._take
    robot_without._take = lambda p, now: None if p.kind == 237 else take(p, now)  # type: ignore[method-assign]
    with (
        Pioneer.connect(ScriptedPort(robot_without)) as robot,
        pytest.raises(DeviceTimeout, match="simulator"),
    ):
        robot.true_pose()


def test_a_lease_runs_out_and_the_robot_stands() -> None:
    scripted = ScriptedRobot()
    with Pioneer.connect(ScriptedPort(scripted)) as robot:
        robot.enable_motors()
        keep_driving(robot, lambda: robot.state.speed > 0.25)
        robot.wait_for(lambda s: s.standing, PATIENCE)
        assert Cause.LEASE in [p.cause for p in robot.problems]


def test_a_thread_that_ends_with_its_lease_running_stops_the_robot() -> None:
    scripted = ScriptedRobot()
    with Pioneer.connect(ScriptedPort(scripted)) as robot:
        robot.enable_motors()
        driving = threading.Thread(target=lambda: robot.drive(0.3, 0.0))
        driving.start()
        driving.join()
        until(lambda: any("thread" in p.text for p in robot.problems))
        robot.wait_for(lambda s: s.standing, PATIENCE)


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
        robot.wait_for(lambda s: not s.bumped, PATIENCE)
        robot.clear_stop()
        keep_driving(robot, lambda: robot.state.speed > 0.1)


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
        assert robot.last_state.standing
        with pytest.raises(DeviceTimeout, match="link is lost"):
            robot.enable_motors()


def test_a_port_that_breaks_ends_the_session_and_closing_is_still_clean() -> None:
    port = ScriptedPort(ScriptedRobot())
    with Pioneer.connect(port) as robot:
        port.broken = DeviceError("the adapter was pulled out")
        with pytest.raises(DeviceError, match="pulled out"):
            robot.wait_for(lambda s: s.speed > 1.0, PATIENCE)
    assert port.closed


def test_a_wait_in_vain_is_a_time_out() -> None:
    with (
        Pioneer.connect(ScriptedPort(ScriptedRobot())) as robot,
        pytest.raises(DeviceTimeout, match="did not reach the awaited state"),
    ):
        robot.wait_for(lambda s: s.speed > 1.0, 0.3)


def test_motors_that_stay_off_are_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("facetlog.robot.pioneer.pioneer.ENABLE_TRIES", 1)
    with (
        Pioneer.connect(ScriptedPort(ScriptedRobot(enable_works=False))) as robot,
        pytest.raises(DeviceError, match="motors stay off"),
    ):
        robot.enable_motors()


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
        robot.disable_motors()
    assert scripted.configuration.speed_max == 750


def test_motors_are_not_switched_on_while_the_stop_button_is_pressed() -> None:
    scripted = ScriptedRobot(stop_button=True)
    with Pioneer.connect(ScriptedPort(scripted)) as robot:
        with pytest.raises(DeviceError, match="STOP button is pressed"):
            robot.enable_motors()
        assert ("ENABLE", 1) not in [(n, a) for _, n, a in scripted.commands]


def test_old_firmware_is_driven_at_once_after_its_motors_were_switched_on() -> None:
    scripted = ScriptedRobot(model="p2dx", reports_motors=False)
    with Pioneer.connect(ScriptedPort(scripted)) as robot:
        robot.enable_motors()
        robot.drive(0.1, 0.0)
        keep_driving(robot, lambda: robot.state.motors_on is True, 0.1)
        robot.disable_motors()
        assert scripted.motors is False


def test_an_unknown_model_is_an_error_that_names_the_way_out() -> None:
    scripted = ScriptedRobot(model="p3dx")
    scripted._synchronise = _with_names(scripted, b"Robby\0Pioneer\0patrolbot\0")  # type: ignore[method-assign]
    port = ScriptedPort(scripted)
    with pytest.raises(DeviceError, match=r"patrolbot.*model="):
        Pioneer.connect(port)
    assert port.closed
    with Pioneer.connect(ScriptedPort(scripted), model="p3at") as robot:
        assert robot.parameters.name == "p3at"
        assert robot.names.subclass == "patrolbot"


def _with_names(scripted: ScriptedRobot, names: bytes) -> Callable[..., None]:
    original = scripted._synchronise

    def synchronise(packet: object, now: float) -> None:
        said = scripted._out
        original(packet, now)  # type: ignore[arg-type]
        if b"scripted" in scripted._out:
            from facetlog.robot.pioneer.packets.packet import Packet

            scripted._out = said + Packet(2, names).to_bytes()

    return synchronise


def test_a_model_that_there_is_not_is_refused_before_anything_is_sent() -> None:
    port = ScriptedPort(ScriptedRobot())
    with pytest.raises(InputError, match="p3dx"):
        Pioneer.connect(port, model="r2d2")
    assert port.written == []


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


def test_many_threads_may_use_one_robot() -> None:
    scripted = ScriptedRobot()
    failures: list[Exception] = []
    with Pioneer.connect(ScriptedPort(scripted)) as robot:
        robot.enable_motors()

        def use(number: int) -> None:
            try:
                for _ in range(15):
                    robot.drive(0.05 * number, 0.0, 0.2)
                    assert robot.encoders().left == -70000
                    assert robot.state.at > 0
            except Exception as error:
                failures.append(error)

        threads = [threading.Thread(target=use, args=(n,)) for n in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert failures == []


CLIENT = """
import sys, time
from facetlog.robot.pioneer.limits import Limits
from facetlog.robot.pioneer.pioneer import Pioneer
robot = Pioneer.connect(sys.argv[1], limits=Limits(speed=0.3))
robot.enable_motors()
if sys.argv[2] == "block":
    with robot:
        while True:
            robot.drive(0.3, 0.0)
            time.sleep(0.05)
if sys.argv[2] == "exit":
    until = time.monotonic() + 20
    while robot.state.speed < 0.1 and time.monotonic() < until:
        robot.drive(0.3, 0.0)
        time.sleep(0.05)
    robot.drive(0.3, 0.0)
    sys.exit(0)
while True:
    robot.drive(0.3, 0.0)
    time.sleep(0.05)
"""


class Served(ABC):
    """The scripted robot behind a real line, for clients in processes of their own too."""

    def __init__(self) -> None:
        self.robot = ScriptedRobot(watchdog=1.0)
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._serve)
        self.address = self._listen()
        self._thread.start()

    def close(self) -> None:
        self._closing.set()
        self._thread.join()

    def _serve(self) -> None:
        while not self._closing.is_set():
            self.exchange()

    def exchange(self) -> None:
        """Hands on what the robot says, and what it is told."""
        try:
            self._send(self.robot.pending(time.monotonic()))
            self.robot.receive(self._receive(), time.monotonic())
        except OSError:
            self._hang_up()

    @abstractmethod
    def _listen(self) -> str: ...

    @abstractmethod
    def _send(self, data: bytes) -> None: ...

    @abstractmethod
    def _receive(self) -> bytes: ...

    @abstractmethod
    def _hang_up(self) -> None: ...


class ServedByTcp(Served):
    _client: socket.socket | None = None

    def _listen(self) -> str:
        self._listening = socket.create_server(("127.0.0.1", 0))
        self._listening.settimeout(0.01)
        return "tcp:{}:{}".format(*self._listening.getsockname())

    def _send(self, data: bytes) -> None:
        if self._client is None:
            self._client = self._listening.accept()[0]
            self._client.settimeout(0.005)
        self._client.sendall(data)

    def _receive(self) -> bytes:
        assert self._client is not None
        try:
            data = self._client.recv(4096)
        except TimeoutError:
            return b""
        if not data:
            raise ConnectionResetError
        return data

    def _hang_up(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None

    def close(self) -> None:
        super().close()
        self._hang_up()
        self._listening.close()


class ServedBySerialLine(Served):
    def _listen(self) -> str:
        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        return os.ttyname(self._slave)

    def _send(self, data: bytes) -> None:
        os.write(self._master, data)

    def _receive(self) -> bytes:
        time.sleep(0.005)
        try:
            return os.read(self._master, 4096)
        except BlockingIOError:
            return b""

    def _hang_up(self) -> None:
        raise AssertionError("the line is held open by the test")

    def close(self) -> None:
        super().close()
        os.close(self._master)
        os.close(self._slave)


@pytest.fixture
def served() -> Iterator[Served]:
    server = ServedByTcp()
    yield server
    server.close()


def client(address: str, what: str, tmp_path: Path) -> subprocess.Popen[bytes]:
    script = tmp_path / "client.py"
    script.write_text(CLIENT)
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    return subprocess.Popen([sys.executable, str(script), address, what], env=environment)


@pytest.mark.filterwarnings("ignore:This process:DeprecationWarning")
def test_a_fork_leaves_the_robot_to_its_parent(served: Served) -> None:
    with Pioneer.connect(served.address) as robot:
        robot.enable_motors()
        reading, writing = os.pipe()
        child = os.fork()
        if child == 0:
            try:
                robot.stop()
                robot.close()
                robot.drive(0.1, 0.0)
            except DeviceError as error:
                os.write(writing, str(error).encode())
            finally:
                os._exit(0)
        os.waitpid(child, 0)
        os.close(writing)
        with os.fdopen(reading) as said:
            assert "forked" in said.read()
        keep_driving(robot, lambda: robot.state.speed > 0.1)
        assert "CLOSE" not in [name for _, name, _ in served.robot.commands][3:]


@pytest.mark.slow
def test_a_robot_on_a_serial_line_is_driven_and_its_line_given_back() -> None:
    served = ServedBySerialLine()
    try:
        for _ in range(2):
            with Pioneer.connect(served.address) as robot:
                assert robot.baud == 9600
                robot.enable_motors()
                keep_driving(robot, lambda: robot.state.speed > 0.2)
            assert (served.robot.speed, served.robot.session) == (0.0, "waiting")
    finally:
        served.close()


@pytest.mark.slow
def test_a_killed_client_leaves_a_robot_that_stands_and_does_not_jump_at_the_next(
    served: Served, tmp_path: Path
) -> None:
    """kill -9 at full allowed speed: the process that owns the line stops it, and parts from it."""
    process = client(served.address, "drive", tmp_path)
    try:
        until(lambda: served.robot.speed > 0.29)
    finally:
        killed = time.monotonic()
        process.send_signal(signal.SIGKILL)
        process.wait()
    robot = served.robot
    until(lambda: robot.session == "waiting")
    assert (robot.speed, robot.motors) == (0.0, False)
    assert robot.stopped_at is not None
    assert robot.stopped_at - killed < robot.watchdog
    where = robot.x
    with Pioneer.connect(served.address) as next_client:
        next_client.wait_for(lambda s: s.standing, PATIENCE)
        at = next_client.state.at
        next_client.wait_for(lambda s: s.at > at + 0.5, PATIENCE)
        assert robot.x - where < 0.005


@pytest.mark.slow
def test_an_interpreter_that_ends_without_closing_stops_the_robot(
    served: Served, tmp_path: Path
) -> None:
    process = client(served.address, "exit", tmp_path)
    assert process.wait(60) == 0
    until(lambda: served.robot.session == "waiting")
    assert served.robot.speed == 0.0
    words = [(name, argument) for _, name, argument in served.robot.commands]
    assert words.index(("ENABLE", 0)) < len(words) - 1
    assert words[-1][0] == "CLOSE"


@pytest.mark.slow
def test_ctrl_c_stops_the_robot_and_closes_the_session(served: Served, tmp_path: Path) -> None:
    process = client(served.address, "block", tmp_path)
    try:
        until(lambda: served.robot.speed > 0.2)
    finally:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(60)
        finally:
            process.kill()
            process.wait()
    until(lambda: served.robot.session == "waiting")
    assert (served.robot.speed, served.robot.motors) == (0.0, False)
