"""Driving along a way with the driver's own mind and a robot, in simulated time."""

from collections.abc import Callable

import pytest

from facetlog.errors import DeviceError, DeviceTimeout
from facetlog.robot.collecting.drive import MobileBase
from facetlog.robot.collecting.steering import Pace
from facetlog.robot.pioneer.guard import Problem
from facetlog.robot.pioneer.state import RobotState
from facetlog.robot.pose2 import Pose2
from tests.robot.pioneer.drives import Drive


class HeldUp:
    """A driver as ways need it, whose program gets no time for 5 s once it is at `x`."""

    def __init__(self, x: float, *, in_vain: bool) -> None:
        self.run, self._x, self._done = Drive(), x, False
        self._in_vain = in_vain
        """Whether the wait in which it was held up is over by then."""

    @property
    def state(self) -> RobotState:
        return self.run.state

    @property
    def halted(self) -> Problem | None:
        return self.run.control.halted

    def drive(self, speed: float, turning: float, lease: float = 0.3) -> tuple[float, float]:
        return self.run.control.drive(speed, turning, lease, self.run.now)

    def stop(self) -> None:
        self.run.control.stop()

    def wait_for(self, condition: Callable[..., bool], timeout: float) -> RobotState:
        if self.state.pose.x > self._x and not self._done:
            self.run.hang(5.0)
            self._done = True
            if self._in_vain:
                raise DeviceTimeout("waited 3.0 s for the robot, in vain")
        self.run.run(timeout, until=lambda: condition(self.state))
        if not condition(self.state):
            raise DeviceTimeout("nothing came")
        return self.state


@pytest.mark.parametrize("in_vain", [False, True])
def test_a_program_that_was_held_up_ends_the_drive_with_one_line_and_the_robot_stands(
    in_vain: bool,
) -> None:
    robot = HeldUp(0.3, in_vain=in_vain)
    base = MobileBase(robot, Pose2(), pace=Pace())
    with pytest.raises(DeviceError) as ended:
        base.follow(((0.0, 0.0), (3.0, 0.0)))
    said = str(ended.value)
    assert said.startswith("the program was held up for 5.")
    assert said.endswith("then go on with --resume")
    assert "clear_stop" not in said
    robot.run.run(1.0)
    assert robot.state.standing
    assert robot.state.pose.x < 1.0  # 2 s to the watchdog's stop at 0.2 m/s, then no further
