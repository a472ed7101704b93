"""A robot, a head and a camera in simulated time: kinematics, errors of odometry, and faults."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from facetlog.errors import DeviceTimeout
from facetlog.perception.types import FloatArray, Image
from facetlog.robot.camera.source import Frame
from facetlog.robot.head.head import HeadLimits, HeadState
from facetlog.robot.pioneer.state import SonarRange
from facetlog.robot.pose2 import Pose2

SONY = HeadLimits(
    math.radians(-100),
    math.radians(100),
    math.radians(-25),
    math.radians(25),
    math.radians(1 / 8.8),
    math.radians(1 / 12),
    1023,
)
STEP, REPORT = 0.02, 0.1
ORIGIN = Pose2()


@dataclass(frozen=True)
class FakeState:
    at: float = 100.0
    pose: Pose2 = ORIGIN
    covariance: FloatArray = field(default_factory=lambda: np.diag([1e-4, 1e-4, 1e-4]))
    speed: float = 0.0
    turning: float = 0.0
    motors_on: bool | None = True
    stop_button: bool | None = False
    stalled: tuple[bool, bool] = (False, False)
    front_bumpers: tuple[bool, ...] = (False,) * 5
    rear_bumpers: tuple[bool, ...] = (False,) * 5
    sonars: tuple[SonarRange, ...] = ()


class FakeRobot:
    """Moves as it is told as long as the lease holds; `odometry` are its errors of way and turn.

    `wall` (x, y, radius) in the true frame stops it and presses a bumper. `held` makes its wheels
    slip from that time on.
    """

    ACCELERATION, TURN_ACCELERATION = 0.3, math.radians(100)

    def __init__(
        self,
        true: Pose2 = ORIGIN,
        *,
        odometry: tuple[float, float] = (0.0, 0.0),
        wall: tuple[float, float, float] | None = None,
        held: float = math.inf,
    ) -> None:
        self.true, self.errors, self.wall, self.held = true, odometry, wall, held
        self.state = FakeState()
        self.true_path = [true]
        self.stops = 0
        self.halted: str | None = None
        self.faults: list[Callable[[FakeState], FakeState]] = []
        self._wanted, self._until = (0.0, 0.0), 0.0

    def drive(self, speed: float, turning: float, lease: float = 0.3) -> None:
        self._wanted, self._until = (speed, turning), self.state.at + lease

    def stop(self) -> None:
        self._wanted = (0.0, 0.0)
        self.stops += 1

    def wait_for(self, condition: Callable[[FakeState], bool], timeout: float) -> FakeState:
        end = self.state.at + timeout
        while not condition(self.state):
            if self.state.at >= end:
                raise DeviceTimeout("nothing came")
            self.advance(REPORT)
        return self.state

    def advance(self, seconds: float) -> None:
        state = self.state
        speed, turning, at = state.speed, state.turning, state.at
        believed = state.pose
        hit = False
        for _ in range(round(seconds / STEP)):
            at += STEP
            told = self._wanted if at <= self._until else (0.0, 0.0)
            speed += max(-1.0, min(1.0, (told[0] - speed) / (self.ACCELERATION * STEP))) * (
                self.ACCELERATION * STEP
            )
            turning += max(
                -1.0, min(1.0, (told[1] - turning) / (self.TURN_ACCELERATION * STEP))
            ) * (self.TURN_ACCELERATION * STEP)
            if at >= self.held:
                speed = turning = 0.0
            step = Pose2(speed * STEP, 0.0, turning * STEP)
            true = self.true.compose(step)
            if self.wall and math.dist((true.x, true.y), self.wall[:2]) < self.wall[2]:
                hit, speed = True, 0.0
            else:
                self.true = true
            way, turn = self.errors
            believed = believed.compose(Pose2(step.x * (1 + way), 0.0, step.heading * (1 + turn)))
        self.true_path.append(self.true)
        self.state = replace(
            state,
            at=at,
            pose=believed,
            speed=speed,
            turning=turning,
            front_bumpers=(False, False, hit, False, False),
        )
        for fault in self.faults:
            self.state = fault(self.state)


class FakeHead:
    """Stands where it is told to, in steps of the Sony's, at the robot's time."""

    limits = SONY

    def __init__(self, robot: FakeRobot) -> None:
        self.robot = robot
        self.state = HeadState(0.0, 0.0, 0, 0.0)
        self.looks: list[tuple[float, float]] = []

    def start(self) -> None:
        pass

    def look(
        self,
        pan: float,
        tilt: float,
        timeout: float = 10.0,  # noqa: ARG002
    ) -> HeadState:
        self.limits.check(pan, tilt)
        self.looks.append((pan, tilt))
        self.robot.advance(0.3)
        steps = self.limits.pan_step, self.limits.tilt_step
        turned = (round(a / s) * s for a, s in zip((pan, tilt), steps, strict=True))
        self.state = HeadState(*turned, 0, self.robot.state.at)
        return self.state

    def where(self) -> HeadState:
        return self.state

    def stop(self) -> None:
        pass

    def close(self) -> None:
        pass


class FakeCamera:
    """A picture for each shot by a function of robot and head; exposed when the shot is asked."""

    def __init__(
        self, robot: FakeRobot, head: FakeHead, picture: Callable[[Pose2, HeadState], Image]
    ) -> None:
        self.robot, self.head, self.picture = robot, head, picture
        self.shots: list[float] = []

    def shot(self, after: float, timeout: float) -> Frame:  # noqa: ARG002
        self.robot.advance(max(after - self.robot.state.at, 0.0) + REPORT)
        self.shots.append(after)
        return Frame(self.picture(self.robot.true, self.head.state), self.robot.state.at)

    def close(self) -> None:
        pass
