"""A robot without a clock goes by its odometry; its views are explored as those of a real one."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from benchmarks.robot.accuracy_explore import explored, lead_of, random_views
from benchmarks.robot.explored_world import KEEP_OUT, ExploredWorld, OdometryRobot
from facetlog.robot.collecting.steering import Pace
from facetlog.robot.pose2 import Pose2
from facetlog.robot.rendering.solids import cuboid, placed
from facetlog.robot.rendering.world import World
from facetlog.robot.rendering.worlds import INCH
from facetlog.robot.simulator.body import MotionErrors

SQUARE = ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0))
# Wheels that go a twentieth further than they count, on a track that is as much wider.
SLIP = MotionErrors(left=0.05, right=0.05, track=0.05, slip=0.002, encoder=0.001)


def test_without_errors_it_is_where_it_believes_to_be() -> None:
    robot = OdometryRobot(Pose2(0.0, 0.0, 0.3), MotionErrors(), 1, Pace())
    robot.go(SQUARE, 1.0)
    off = robot.here.between(robot.true)
    # Odometry is reported in whole millimetres and 4096 parts of a turn.
    assert math.hypot(off.x, off.y) < 0.005
    assert abs(off.heading) < 0.002
    assert robot.true.heading == pytest.approx(1.0, abs=0.01)
    assert robot.driven == pytest.approx(6.0, abs=0.02)


def test_a_robot_whose_wheels_slip_is_where_its_covariance_says() -> None:
    for seed in range(3):
        robot = OdometryRobot(Pose2(), MotionErrors.usual(skids=False), seed, Pace())
        robot.go(SQUARE, 0.0)
        off = np.array([robot.true.x - robot.here.x, robot.true.y - robot.here.y])
        assert 0.002 < np.linalg.norm(off) < 0.2
        assert off @ np.linalg.solve(robot.covariance[:2, :2], off) < chi2.ppf(0.999, 2)


@pytest.mark.slow
def test_views_of_a_ring_show_the_target_and_keep_out() -> None:
    drive = ExploredWorld("block", 3)
    for candidate in drive.ring(3):
        drive.take(candidate)
    assert drive.nearest > KEEP_OUT
    assert len(drive.world.solids) == 6
    for view in drive.views:
        to_target = view.pose.rotation.T @ (drive.around.target - view.pose.centre)
        assert abs(to_target[0] / to_target[2]) < 0.05
        assert view.pose_cov is not None
        assert np.linalg.eigvalsh(view.pose_cov).min() > 0
    again = ExploredWorld("block", 3)
    for candidate in again.ring(3):
        again.take(candidate)
    for one, other in zip(drive.views, again.views, strict=True):
        assert (one.image == other.image).all()


def test_views_by_chance_begin_as_the_explored_ones_do() -> None:
    drive = random_views("block", 3, 3)
    places = [view.pose.centre - drive.around.target for view in drive.views]
    angles = sorted(math.degrees(math.atan2(y, x)) for x, y, _ in places)
    gaps = np.diff([*angles, angles[0] + 360.0])
    assert sorted(gaps)[:2] == pytest.approx([22.5, 22.5], abs=2.0)


class Interrupted(ExploredWorld):
    """A world in which something happens before its fourth view, and is over after that if
    `for_one` view alone.
    """

    def __init__(self, seed: int, happens: World | None = None, *, for_one: bool = False) -> None:
        super().__init__("block", seed)
        self.happens, self.for_one, self._before = happens, for_one, self.world

    def take(self, candidate: object) -> None:
        number = len(self.views) + 1
        if self.happens is not None and number >= 4:
            self.world = self._before if self.for_one and number > 4 else self.happens
        super().take(candidate)  # type: ignore[arg-type]


def _with_person(world: World, drive: ExploredWorld) -> World:
    """Somebody stands behind the block, as the first views look."""
    x, y = drive.around.target[:2] / INCH / drive.scale
    step = (drive.robot.true.x / INCH - x, drive.robot.true.y / INCH - y)
    share = -14.0 / math.hypot(*step)
    person = placed(
        cuboid(18.0, 10.0, 66.0, name="person"), x + share * step[0], y + share * step[1]
    )
    return replace(world, solids=(*world.solids, person))


@pytest.mark.slow
@pytest.mark.parametrize("what", ["slip", "moved", "person"])
def test_what_happens_meanwhile_does_not_end_it_on_a_wrong_name(what: str) -> None:
    drive: ExploredWorld
    if what == "slip":
        drive = ExploredWorld("block", 1, slips=SLIP)
    else:
        drive = Interrupted(1)
        block, *others = drive.world.solids
        moved = replace(drive.world, solids=(block.moved(np.eye(3), [4.0, 2.0, 0.0]), *others))
        drive.happens = moved if what == "moved" else _with_person(drive.world, drive)
        drive.for_one = what == "person"
    finished = explored(drive)
    assert finished.reason
    assert 3 <= len(drive.views) <= 24
    assert drive.nearest > KEEP_OUT
    assert lead_of(drive) in {"box", ""}
