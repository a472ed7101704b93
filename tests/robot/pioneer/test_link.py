"""The threads between port and mind, where something in them fails that should not."""

import logging
import threading
import time
from collections.abc import Iterator

import pytest

from facetlog.errors import DeviceError
from facetlog.robot.pioneer.control import Control
from facetlog.robot.pioneer.pioneer import Pioneer
from tests.robot.pioneer.scripted import ScriptedPort, ScriptedRobot

pytestmark = pytest.mark.usefixtures("quick")


@pytest.fixture
def scripted() -> ScriptedRobot:
    return ScriptedRobot()


@pytest.fixture
def robot(scripted: ScriptedRobot, caplog: pytest.LogCaptureFixture) -> Iterator[Pioneer]:
    caplog.set_level(logging.CRITICAL + 1, "facetlog.robot.pioneer.link")
    with Pioneer.connect(ScriptedPort(scripted)) as robot:
        robot.enable_motors()
        deadline = time.monotonic() + 20.0
        while robot.state.speed < 0.2:
            assert time.monotonic() < deadline, "the robot does not drive"
            robot.drive(0.3, 0.0)
            time.sleep(0.02)
        yield robot
    assert not [t for t in threading.enumerate() if t.name.startswith("pioneer")]


def stands(scripted: ScriptedRobot) -> None:
    deadline = time.monotonic() + 20
    while scripted.speed != 0.0:
        assert time.monotonic() < deadline, "the robot drives on"
        time.sleep(0.01)


@pytest.mark.parametrize("method", ["take", "advance"])
@pytest.mark.slow
def test_a_failure_in_either_thread_stops_the_robot_and_ends_the_session(
    robot: Pioneer, scripted: ScriptedRobot, monkeypatch: pytest.MonkeyPatch, method: str
) -> None:
    def fail(_self: Control, _argument: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(Control, method, fail)
    with pytest.raises(DeviceError, match="robot's line failed"):
        robot.wait_for(lambda s: s.speed > 10.0, 20.0)
    stands(scripted)


@pytest.mark.slow
def test_zeros_do_not_wait_for_a_slow_question(robot: Pioneer, scripted: ScriptedRobot) -> None:
    """A device on the AUX port that never answers holds up nothing."""
    waiting = threading.Thread(target=lambda: _in_vain(robot))
    waiting.start()
    robot.stop()
    stands(scripted)
    assert waiting.is_alive()
    waiting.join()


def _in_vain(robot: Pioneer) -> None:
    with pytest.raises(DeviceError):
        robot.aux().receive(6, 2.0)
