"""A robot without a clock before a world with clutter: driven by odometry, seen from where it is.

Its wheels slip as those of the simulated robot do, so where it stands is not where it believes to
stand; poses and their covariances are those that a collection would write. Models of furniture are
looked at by a robot as small as they are: `scale` is how many times larger both would be.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from benchmarks.robot.robot_report import make_motion_report
from facetlog.perception.estimation.pose_refinement.refine_poses import correct_poses
from facetlog.perception.reading.read_views import ViewSet
from facetlog.perception.types import FloatArray, Pose, PoseErrors, View
from facetlog.robot.camera.checks import Quality
from facetlog.robot.collecting.next_stop import Around, place_sd
from facetlog.robot.collecting.plan import Reach
from facetlog.robot.collecting.record import Taken
from facetlog.robot.collecting.ring_views import Candidate
from facetlog.robot.collecting.route import Circle, Route, find_shortest_route
from facetlog.robot.collecting.session import pose_covariance_at
from facetlog.robot.collecting.steering import Pace
from facetlog.robot.head.sony_models import EVI_D30
from facetlog.robot.mount.kinematics import Gaze, camera_pose, find_gaze
from facetlog.robot.mount.mount import DEFAULT_MOUNT, LENGTHS, PARAMETERS, Mount
from facetlog.robot.pioneer.parameters import find_parameters
from facetlog.robot.pioneer.state import Odometry
from facetlog.robot.pose2 import Pose2, wrapped
from facetlog.robot.rendering.views import views_of
from facetlog.robot.rendering.world import World
from facetlog.robot.rendering.worlds import (
    BLOCK_CENTRE,
    INCH,
    WORLDS,
    add_clutter,
    make_world,
    place_in_world,
)
from facetlog.robot.simulator.body import STEP, Body, MotionErrors
from facetlog.robot.tour import tour_camera

KEEP_OUT = 0.75
"""How near the robot may come, m: the inner ring is then as far off as the paper's tour."""
# The planner's clearance, and what is kept free besides, m: as in a collection.
CLEARANCE, KEPT_FREE = 0.03, 0.05
# Where the robot starts, from the target, m; the height that is aimed at: a block's middle, m.
STARTS, AIM = (1.2, 2.0), 0.08
# Reports of a robot come ten a second.
STEPS_OF_REPORT = round(0.1 / STEP)
ROBOT = find_parameters("p3dx")


class OdometryRobot:
    """Goes along routes by what its wheels count; `path` is where its middle truly was.

    `start` is where it truly stands at first, and knows that it does.
    """

    def __init__(self, start: Pose2, errors: MotionErrors, seed: int, pace: Pace) -> None:
        self._start, self._pace = start, pace
        track = 2 / ROBOT.turning_per_speed
        rng = np.random.default_rng([seed, 1])
        self._body = Body(track, start, errors, rng=rng)
        self._counted, self._time = Pose2(), 0.0
        self._odometry = Odometry(ROBOT)
        self._report()
        self.path: list[tuple[float, float]] = [(start.x, start.y)]
        self.driven = 0.0
        """Metres, as it counts."""

    @property
    def true(self) -> Pose2:
        """Where it stands."""
        truth = self._body.truth
        return Pose2(truth.x, truth.y, truth.heading)

    @property
    def here(self) -> Pose2:
        """Where it believes to stand."""
        return self._start.compose(self._odometry.pose)

    @property
    def covariance(self) -> FloatArray:
        """Covariance (3, 3) of that place, in the world."""
        c, s = math.cos(self._start.heading), math.sin(self._start.heading)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        return np.asarray(turn @ self._odometry.covariance @ turn.T)

    def go(self, route: Route, heading: float) -> None:
        """Drive along a route, then turn to a heading."""
        for _, there in pairwise(route):
            here = self.here
            way = math.dist((here.x, here.y), there)
            if way > ROBOT.distance:
                self._turn(math.atan2(there[1] - here.y, there[0] - here.x))
                self._move(self._pace.speed, 0.0, way / self._pace.speed)
                self.driven += way
        self._turn(heading)

    def _turn(self, heading: float) -> None:
        turn = wrapped(heading - self.here.heading)
        self._move(0.0, math.copysign(self._pace.turning, turn), abs(turn) / self._pace.turning)

    def _move(self, speed: float, turning: float, seconds: float) -> None:
        self._body.speed, self._body.turning = speed, turning
        for step in range(round(seconds / STEP)):
            way, turned = self._body.step()
            self._counted = self._counted.compose(Pose2(way, 0.0, turned))
            self._time += STEP
            if (step + 1) % STEPS_OF_REPORT == 0:
                self._report()
                self.path.append((self.true.x, self.true.y))
        self._body.speed = self._body.turning = 0.0
        self._report()
        self.path.append((self.true.x, self.true.y))

    def _report(self) -> None:
        body = self._body
        report = make_motion_report(ROBOT, self._counted, body.speed, body.turning)
        self._odometry.update(report, self._time)


class ExploredWorld:
    """A world with clutter, its robot, and the views it took; `slips` is how its wheels do."""

    def __init__(
        self, name: str, seed: int, *, clutter: bool = True, slips: MotionErrors | None = None
    ) -> None:
        self.name, self.seed = name, seed
        self.world: World = (
            place_in_world(name, add_clutter(WORLDS[name]), seed)
            if clutter
            else make_world(name, seed)
        )
        self.scale = self.world.model_scale
        self._target = np.array([*(INCH * np.array(BLOCK_CENTRE)), AIM])
        rng = np.random.default_rng(seed)
        angle, heading = rng.uniform(-np.pi, np.pi, 2)
        start = float(rng.uniform(*STARTS))
        x, y = self._target[:2] + start * np.array([math.cos(angle), math.sin(angle)])
        errors = MotionErrors.usual(skids=False) if slips is None else slips
        self.robot = OdometryRobot(Pose2(float(x), float(y), float(heading)), errors, seed, Pace())
        self._first = float(angle)
        closed = KEEP_OUT + ROBOT.radius + CLEARANCE
        self._reach = self._reach_of(DEFAULT_MOUNT, closed)
        self._ring = closed - CLEARANCE + KEPT_FREE
        self.taken: list[Taken] = []
        self.views: list[View] = []

    def _reach_of(self, mount: Mount, closed: float) -> Reach:
        circle = Circle(float(self._target[0]), float(self._target[1]), closed)
        return Reach(mount, EVI_D30.limits, tour_camera(), (circle,))

    @property
    def nearest(self) -> float:
        """How near the robot's rim came to the target, m."""
        return min(math.dist(at, self._target[:2]) for at in self.robot.path) - ROBOT.radius

    @property
    def around(self) -> Around:
        """What can be taken from where the robot believes to be, as large as the things are."""
        return self._around(self._first)

    def ring(self, count: int) -> Iterator[Candidate]:
        """Yield views all round, evenly; each is found when the one before it was taken."""
        for k in range(count):
            turned = self._around(self._first + math.tau * k / count)
            yield turned.candidates(k + 1)[0]

    def _around(self, first: float) -> Around:
        scale, small = self.scale, self.robot.here
        margin = place_sd(self.robot.covariance)
        values = [
            value * scale if part in LENGTHS else value
            for part, value in zip(PARAMETERS, DEFAULT_MOUNT.values, strict=True)
        ]
        reach = self._reach_of(DEFAULT_MOUNT.replace_values(tuple(values)), 0.0)
        (circle,) = self._reach.closed
        closed = Circle(scale * circle.x, scale * circle.y, scale * circle.radius)
        around = Around(
            scale * self._target,
            scale * self._ring,
            first,
            replace(reach, closed=(closed,)),
            Pace(speed=scale * Pace().speed),
            Pose2(scale * small.x, scale * small.y, small.heading),
        )
        return around.enlarge_keep_out(scale * margin)

    def take(self, candidate: Candidate) -> None:
        """Go there, look at the target and take the view."""
        wanted, robot = candidate.stop.robot, self.robot
        end = wanted.x / self.scale, wanted.y / self.scale
        margin = place_sd(robot.covariance)
        closed = tuple(circle.grown(margin) for circle in self._reach.closed)
        route = find_shortest_route((robot.here.x, robot.here.y), end, closed)
        if route is None:
            raise ValueError(f"{self.name}-{self.seed}: a view that was offered cannot be reached")
        robot.go(route, wanted.heading)
        gaze = self._stepped(find_gaze(robot.here, DEFAULT_MOUNT, self._target))
        true = camera_pose(robot.true, DEFAULT_MOUNT, gaze)
        in_inches = Pose(true.rotation, true.centre / INCH)
        # The noise of a view follows from its place among all.
        seed = 1000 * self.seed + len(self.taken)
        (view,) = views_of(self.world, [in_inches], tour_camera(), seed=seed)
        believed = camera_pose(robot.here, DEFAULT_MOUNT, gaze)
        cov = pose_covariance_at(robot.here, robot.covariance, self._reach, gaze)
        cov[:3] *= self.scale
        cov[:, :3] *= self.scale
        pose = Pose(believed.rotation, believed.centre * self.scale)
        name = candidate.stop.view.name
        self.views.append(replace(view, name=name, pose=pose, pose_cov=cov))
        self.taken.append(_taken(candidate, pose, cov))

    def _stepped(self, gaze: Gaze) -> Gaze:
        limits, found = EVI_D30.limits, self._reach.within(gaze)
        steps = limits.pan_step, limits.tilt_step
        pan, tilt = (
            round(angle / step) * step
            for angle, step in zip((found.pan, found.tilt), steps, strict=True)
        )
        return Gaze(pan, tilt)

    def view_set(self, count: int) -> ViewSet:
        """Return the first views as large as the things, with the poses corrected by the
        pictures.
        """
        views = tuple(self.views[:count])
        covs = np.array([view.pose_cov for view in views])
        plain = ViewSet(
            f"{self.name}-{self.seed}",
            views,
            up=np.array([0.0, 0.0, 1.0]),
            metric=True,
            pose_errors=PoseErrors(tuple(view.pose for view in views), covs),
        )
        return correct_poses(plain)


def _taken(candidate: Candidate, pose: Pose, cov: FloatArray) -> Taken:
    stop, good = candidate.stop, Quality(1.0, 1.0, 0.0)
    robot = stop.robot
    return Taken(stop.number, stop.view.name, pose, cov, robot, robot, 0.0, 0.0, 0, 0.0, good, ())
