"""A robot without a clock in a room: driven, heard and seen by the code that drives a real one.

Wheels, odometry, sonars and contacts are those of the simulated robot (robot/simulator), its head
stands where it is told to at once, and its camera renders what is to be seen from where it truly
is. Seconds pass only when somebody waits for a report.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from benchmarks.robot.robot_report import report_of
from benchmarks.robot.rooms import Room
from facetlog.errors import DeviceTimeout
from facetlog.perception.types import Image, Pose
from facetlog.robot.camera.freshness import Frame
from facetlog.robot.head.head import HeadLimits, HeadState
from facetlog.robot.head.sony_models import EVI_D30
from facetlog.robot.mount.kinematics import Gaze, camera_pose
from facetlog.robot.mount.mount import Mount
from facetlog.robot.pioneer.parameters import parameters_of
from facetlog.robot.pioneer.state import RobotState, StateMaker
from facetlog.robot.pose2 import Pose2
from facetlog.robot.rendering.views import views_of
from facetlog.robot.rendering.worlds import INCH
from facetlog.robot.simulator.body.dynamics import STEP, Body, MotionErrors, Truth
from facetlog.robot.simulator.body.obstacles import Obstacles
from facetlog.robot.simulator.body.sonar import Sonars
from facetlog.robot.simulator.firmware.drive import Drive
from facetlog.robot.simulator.firmware.generations import default_configuration
from facetlog.robot.tour import tour_camera

__all__ = ["HEIGHT", "KIND", "RoomCamera", "RoomHead", "RoomRobot"]

KIND = parameters_of("p3dx")
HEIGHT = 0.24
"""Of the robot without its mast, m: what is lower is in its way, and its sonars see it."""
REPORT = 0.1
# Seconds until a head has turned, and a picture has come.
TURNED, CAME = 0.3, 0.1


class RoomRobot:
    """Drives in a room; `path` is where its middle truly was at each report."""

    def __init__(self, room: Room, start: Pose2, errors: MotionErrors, seed: int) -> None:
        solids = tuple(replace(t.solid, vertices=INCH * t.solid.vertices) for t in room.things)
        obstacles = Obstacles.of(solids, radius=KIND.radius, height=HEIGHT)
        begun = Truth(start.x, start.y, start.heading)
        body = Body(
            2 / KIND.turning_per_speed,
            begun,
            errors,
            surroundings=obstacles,
            rng=np.random.default_rng([seed, 1]),
        )
        configuration = default_configuration(KIND, "room")
        self._drive = Drive(KIND, configuration, body, begun)
        self._drive.enable(True)
        self._sonars = Sonars(KIND, obstacles, (configuration.sonar_cycle or 0) / 1e3)
        self._sonars.switch(True, 0.0)
        self._maker = StateMaker(KIND, configuration)
        self._now, self._until = 0.0, 0.0
        self.halted: str | None = None
        self.path: list[Pose2] = [start]
        self.touched = False
        """Whether it touched something that is as low as it is."""
        self.state: RobotState = self._reported()

    @property
    def true(self) -> Pose2:
        """Where it truly is."""
        truth = self._drive.body.truth
        return Pose2(truth.x, truth.y, truth.heading)

    def drive(self, speed: float, turning: float, lease: float = 0.3) -> None:
        """Moves for as long as the lease."""
        self._drive.servo.drive(speed)
        self._drive.servo.rotate(turning)
        self._until = self._now + lease

    def stop(self) -> None:
        """Stops."""
        self._drive.servo.stop()

    def wait_for(self, condition: Callable[..., bool], timeout: float) -> RobotState:
        """The first state of which the condition is true; DeviceTimeout if none is."""
        end = self._now + timeout
        while not condition(self.state):
            if self._now >= end:
                raise DeviceTimeout("nothing came")
            self.advance(REPORT)
        return self.state

    def advance(self, seconds: float) -> None:
        """Lets time pass, and reports at its end."""
        for _ in range(round(seconds / STEP)):
            self._now += STEP
            if self._now > self._until:
                self._drive.servo.stop()
            self._drive.step(self._now, held=False)
            self.touched |= self._drive.body.blocked
        self.path.append(self.true)
        self.state = self._reported()

    def _reported(self) -> RobotState:
        counted, body = self._drive.odometry, self._drive.body
        sonar = self._sonars.readings(self._now, body.truth)
        report = report_of(KIND, counted, body.speed, body.turning, sonar)
        return self._maker.state(report, self._now)[0]


class RoomHead:
    """Stands where it is told to, in steps of the Sony's."""

    limits: HeadLimits = EVI_D30.limits

    def __init__(self, robot: RoomRobot) -> None:
        self._robot = robot
        self.state = HeadState(0.0, 0.0, 0, 0.0)

    def start(self) -> None:
        """Nothing is to be done."""

    def look(
        self,
        pan: float,
        tilt: float,
        zoom: int | None = None,
        timeout: float = 10.0,  # noqa: ARG002
    ) -> HeadState:
        """Turns there."""
        self.limits.check(pan, tilt, zoom)
        self._robot.advance(TURNED)
        steps = self.limits.pan_step, self.limits.tilt_step
        turned = [round(a / s) * s for a, s in zip((pan, tilt), steps, strict=True)]
        self.state = HeadState(turned[0], turned[1], 0, self._robot.state.at)
        return self.state

    def where(self) -> HeadState:
        """Where it stands."""
        return self.state

    def stop(self) -> None:
        """It stands."""

    def close(self) -> None:
        """Nothing is to be done."""


class RoomCamera:
    """A picture of the room from where robot and head truly are; its noise follows from `seed`."""

    def __init__(
        self, room: Room, robot: RoomRobot, head: RoomHead, mount: Mount, seed: int, noise: float
    ) -> None:
        self._room, self._robot, self._head, self._mount = room, robot, head, mount
        self._seed, self._noise, self._shots = seed, noise, 0

    def shot(self, after: float, timeout: float) -> Frame:  # noqa: ARG002
        """The picture at a time, or a little later."""
        self._robot.advance(max(after - self._robot.state.at, 0.0) + CAME)
        return Frame(self._picture(), self._robot.state.at)

    def _picture(self) -> Image:
        head = self._head.state
        pose = camera_pose(self._robot.true, self._mount, Gaze(head.pan, head.tilt))
        small = Pose(pose.rotation, pose.centre / INCH)
        self._shots += 1
        seed = 1000 * self._seed + self._shots
        (view,) = views_of(
            self._room.world, [small], tour_camera(), seed=seed, noise_sd=self._noise
        )
        return view.image

    def close(self) -> None:
        """Nothing is to be done."""
