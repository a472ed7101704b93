"""The process that owns a line: real sockets, and drivers that hang, die and lose their line."""

import os
import pty
import signal
import socket
import subprocess
import sys
import termios
import threading
import time
import tty
from collections.abc import Iterator

import pytest

from facetlog.errors import DeviceError, DeviceTimeout, InputError
from facetlog.robot.pioneer.line.dead_man import NotStoppedError
from facetlog.robot.pioneer.line.process import LineProcess

PATIENCE = 20.0
OUTPUT_SPEED = 5  # its place in what tcgetattr gives
STOP, OFF, BYE = b"<stop>", b"<off>", b"<bye>"
DRIVER = """
import sys, time
from facetlog.robot.pioneer.line.dead_man import NotStoppedError
from facetlog.robot.pioneer.line.process import LineProcess
line = LineProcess(sys.argv[1])
line.part([b"<off>", b"<bye>"])
line.hold(time.monotonic() + float(sys.argv[2]), b"<stop>")
line.write(b"<go>")
time.sleep(1000)
"""


class Robot:
    """The other end of the line."""

    def __init__(self) -> None:
        self._listening = socket.create_server(("127.0.0.1", 0))
        self._listening.settimeout(PATIENCE)
        self.address = "tcp:{}:{}".format(*self._listening.getsockname())
        self.client: socket.socket | None = None

    def accept(self) -> None:
        self.hang_up()
        self.client, _ = self._listening.accept()
        self.client.settimeout(PATIENCE)

    def hears(self, wanted: bytes) -> bytes:
        """What comes until it ends with what is wanted."""
        assert self.client is not None
        heard = b""
        while not heard.endswith(wanted):
            piece = self.client.recv(100)
            assert piece, f"hung up after {heard!r}"
            heard += piece
        return heard

    def hears_nothing_more(self) -> bool:
        assert self.client is not None
        return self.client.recv(100) == b""

    def hang_up(self) -> None:
        if self.client is not None:
            self.client.close()
            self.client = None

    def close(self) -> None:
        self.hang_up()
        self._listening.close()


@pytest.fixture
def robot() -> Iterator[Robot]:
    robot = Robot()
    yield robot
    robot.close()


@pytest.fixture
def line(robot: Robot) -> Iterator[LineProcess]:
    line = LineProcess(robot.address)
    robot.accept()
    yield line
    line.close()


@pytest.fixture
def driver(robot: Robot, request: pytest.FixtureRequest) -> Iterator[subprocess.Popen[bytes]]:
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    arguments = [sys.executable, "-c", DRIVER, robot.address, str(request.param)]
    process = subprocess.Popen(arguments, env=environment)
    robot.accept()
    robot.hears(b"<go>")
    yield process
    process.kill()
    process.wait()


def read_exactly(line: LineProcess, count: int) -> bytes:
    data, deadline = b"", time.monotonic() + PATIENCE
    while len(data) < count and time.monotonic() < deadline:
        data += line.read(0.2)
    return data


def raised(line: LineProcess) -> DeviceError:
    """What is said of a line that is lost."""
    with pytest.raises(DeviceError) as caught:
        read_exactly(line, 10)
    return caught.value


def test_bytes_go_both_ways_and_the_line_is_given_back(robot: Robot, line: LineProcess) -> None:
    assert (line.address, line.has_baud) == (robot.address, False)
    line.write(b"\xfa\xfb\x03")
    assert robot.hears(b"\x03") == b"\xfa\xfb\x03"
    assert robot.client is not None
    robot.client.sendall(bytes(range(256)) * 40)
    assert read_exactly(line, 256 * 40) == bytes(range(256)) * 40
    assert line.read(0.0) == b""
    line.set_baud(38400)
    line.close()
    assert robot.hears_nothing_more()
    line.close()


def test_what_cannot_be_opened_is_refused_as_a_port_of_this_process_would() -> None:
    with pytest.raises(InputError, match="no address of a robot"):
        LineProcess("nowhere")
    with pytest.raises(InputError, match="no baud rate"):
        LineProcess("tcp:localhost:8101", 9600)
    with pytest.raises(DeviceError, match="no such port"):
        LineProcess("/dev/nothing-of-that-name")


def test_a_lease_that_is_not_renewed_ends_in_stops_and_what_comes_late_is_dropped(
    robot: Robot, line: LineProcess
) -> None:
    now = time.monotonic()
    line.hold(now + 0.3, STOP)
    line.write(b"<go>")
    robot.hears(b"<go>" + STOP)
    assert time.monotonic() >= now + 0.3
    line.hold(now + 0.2, STOP)  # a time that has passed
    line.write(b"<stale>")
    line.hold(time.monotonic() + PATIENCE, STOP)
    line.write(b"<on>")
    assert b"<stale>" not in robot.hears(b"<on>")
    line.release()


@pytest.mark.slow
def test_a_closed_connection_is_opened_again_to_stop_the_robot(
    robot: Robot, line: LineProcess
) -> None:
    line.part([OFF, BYE])
    line.hold(time.monotonic() + PATIENCE, STOP)
    line.write(b"<go>")
    robot.hears(b"<go>")
    robot.accept()
    assert robot.hears(OFF + BYE).startswith(STOP)
    assert "opened again to stop the robot" in str(raised(line))
    assert robot.hears_nothing_more()


@pytest.mark.slow
def test_a_robot_whose_line_cannot_be_opened_again_was_not_stopped(
    robot: Robot, line: LineProcess
) -> None:
    line.hold(time.monotonic() + PATIENCE, STOP)
    line.write(b"<go>")
    robot.hears(b"<go>")
    robot.close()
    fault = raised(line)
    assert isinstance(fault, NotStoppedError)
    assert "not stopped" in str(fault)


def test_of_a_robot_that_stands_a_closed_connection_stays_closed(
    robot: Robot, line: LineProcess
) -> None:
    line.hold(time.monotonic() + PATIENCE, STOP)
    line.write(b"<zero>")
    line.release()
    robot.hears(b"<zero>")
    robot.hang_up()
    assert "opened again" not in str(raised(line))


@pytest.mark.parametrize("driver", [PATIENCE], indirect=True)
@pytest.mark.slow
def test_a_driver_that_is_killed_is_followed_by_stops_and_the_end_of_the_session(
    robot: Robot, driver: subprocess.Popen[bytes]
) -> None:
    driver.kill()
    heard = robot.hears(OFF + BYE).removesuffix(OFF + BYE)
    assert heard.count(STOP) > 1
    assert heard == STOP * heard.count(STOP)
    assert robot.hears_nothing_more()


@pytest.mark.slow
def test_a_driver_that_dies_while_a_fork_of_it_lives_is_missed_all_the_same(
    robot: Robot,
) -> None:
    """The fork keeps the socket open; the owner sees that its parent is another."""
    forking = DRIVER.replace("time.sleep(1000)", "import os; os.fork() and os._exit(0)\ninput()")
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    arguments = [sys.executable, "-c", forking, robot.address, str(PATIENCE)]
    with subprocess.Popen(arguments, env=environment, stdin=subprocess.PIPE) as process:
        robot.accept()
        robot.hears(BYE)
        assert process.stdin is not None  # closed now: the fork ends


def test_a_serial_line_changes_its_rate_and_is_locked() -> None:
    master, slave = pty.openpty()
    tty.setraw(slave)
    path = os.ttyname(slave)
    line = LineProcess(path, 9600)
    try:
        assert line.has_baud
        line.set_baud(38400)
        assert termios.tcgetattr(slave)[OUTPUT_SPEED] == termios.B38400
        with pytest.raises(DeviceError, match="another program has this port"):
            LineProcess(path)
    finally:
        line.close()
        os.close(master)
        os.close(slave)


def test_signals_that_end_programs_do_not_end_the_owner(robot: Robot, line: LineProcess) -> None:
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGTSTP):
        os.kill(line.process, number)
    line.write(b"<still here>")
    robot.hears(b"<still here>")


@pytest.mark.slow
def test_where_the_owner_is_killed_its_driver_stops_the_robot(
    robot: Robot, line: LineProcess
) -> None:
    line.part([OFF, BYE])
    line.hold(time.monotonic() + PATIENCE, STOP)
    line.write(b"<go>")
    robot.hears(b"<go>")
    os.kill(line.process, signal.SIGKILL)
    said: list[DeviceError] = []
    driver = threading.Thread(target=lambda: said.append(raised(line)))
    driver.start()
    robot.accept()
    heard = robot.hears(OFF + BYE).removesuffix(OFF + BYE)
    assert heard == STOP * heard.count(STOP) != b""
    driver.join(PATIENCE)
    assert "the robot was stopped over the line opened again" in str(said[0])
    assert "the robot was stopped" in str(raised(line))


def test_where_the_line_is_gone_with_its_owner_it_is_said_that_the_robot_was_not_stopped(
    robot: Robot, line: LineProcess
) -> None:
    line.hold(time.monotonic() + PATIENCE, STOP)
    line.write(b"<go>")
    robot.hears(b"<go>")
    # Stopped, it cannot say itself that the line was closed before it is killed.
    os.kill(line.process, signal.SIGSTOP)
    robot.close()
    os.kill(line.process, signal.SIGKILL)
    assert "the robot was not stopped" in str(raised(line))


def write_for_ever(line: LineProcess) -> None:
    while True:
        line.write(b"x" * 1000)


def test_an_owner_that_is_suspended_holds_up_nobody_for_ever(
    robot: Robot, line: LineProcess
) -> None:
    os.kill(line.process, signal.SIGSTOP)
    try:
        with pytest.raises(DeviceTimeout, match="takes no bytes"):
            write_for_ever(line)
    finally:
        os.kill(line.process, signal.SIGCONT)


def test_the_owner_needs_none_of_the_large_libraries() -> None:
    """It starts before a robot is connected, and stays small."""
    code = (
        "import sys, facetlog.robot.pioneer.line.owner\n"
        "print([m for m in ('numpy', 'cv2', 'scipy', 'typer', 'pydantic') if m in sys.modules])"
    )
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("driver", [0.3], indirect=True)
@pytest.mark.slow
def test_a_driver_that_is_suspended_and_then_killed_leaves_a_robot_that_stands(
    robot: Robot, driver: subprocess.Popen[bytes]
) -> None:
    driver.send_signal(signal.SIGSTOP)
    robot.hears(STOP)
    driver.kill()
    robot.hears(OFF + BYE)
