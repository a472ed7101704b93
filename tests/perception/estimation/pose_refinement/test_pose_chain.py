"""Twists of drifting poses: what a step adds is the same wherever it is looked at from."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from facetlog.perception.estimation.pose_refinement.pose_chain import moved, pose_chain
from facetlog.perception.types import Pose
from facetlog.robot.rendering.views import add_drift
from tests.rendered import tour

ABOUT = np.array([1.0, -2.0, 0.5])


@given(st.lists(st.floats(-0.5, 0.5), min_size=6, max_size=6), st.integers(0, 99))
def test_a_twist_moves_camera_and_world_point_alike(twist: list[float], seed: int) -> None:
    rng = np.random.default_rng(seed)
    pose = Pose(Rotation.random(random_state=rng).as_matrix(), rng.normal(size=3))
    there = moved(pose, np.array(twist), ABOUT)
    seen = pose.rotation.T @ (ABOUT - pose.centre)
    # The point `about` only shifts; seen from the camera it stays where it was.
    assert there.rotation @ seen + there.centre == pytest.approx(ABOUT + twist[3:], abs=1e-9)


def test_what_a_step_adds_does_not_depend_on_the_drift_before_it() -> None:
    views = tour("block")[:6]
    _, covs = add_drift(views, np.random.default_rng(0), turn_sd=0.01, way_sd=0.02)
    poses = [view.pose for view in views]
    chain = pose_chain(poses, covs, ABOUT, 40.0)
    before = np.array(covs)
    # A drift that all poses share, about one place of the world, adds nothing to any step.
    shared = np.array([[0.02**2 if i == j == 5 else 0.0 for j in range(6)] for i in range(6)])
    for cov, pose in zip(before, poses, strict=True):
        r = pose.centre - ABOUT
        carried = np.eye(6)
        carried[:3, 3:] = np.array([[0, r[2], -r[1]], [-r[2], 0, r[0]], [r[1], -r[0], 0]])
        cov += carried @ shared @ carried.T
    again = pose_chain(poses, before, ABOUT, 40.0)
    assert again.covs[1:] == pytest.approx(chain.covs[1:], rel=1e-6, abs=1e-12)
    assert again.covs[0][2, 2] == pytest.approx(chain.covs[0][2, 2] + 0.02**2)


def test_where_odometry_began_anew_both_drifts_are_in_the_step() -> None:
    views = tour("block")[:8]
    _, first = add_drift(views[:4], np.random.default_rng(0), turn_sd=0.01, way_sd=0.02)
    _, second = add_drift(views[3:], np.random.default_rng(1), turn_sd=0.01, way_sd=0.02)
    poses = [view.pose for view in views]
    chain = pose_chain(poses, np.concatenate([first, second[1:]]), ABOUT, 40.0)
    apart = pose_chain(poses[:4], first, ABOUT, 40.0)
    of_turns = chain.covs[1:][:, 2, 2]
    assert of_turns[3] == pytest.approx(3 * 0.01**2 + 0.01**2 + apart.covs[0][2, 2], rel=0.1)
    assert of_turns[4] == pytest.approx(of_turns[0])


def test_steps_have_the_covariance_of_many_drawn_drifts() -> None:
    views = tour("block")[:5]
    _, covs = add_drift(views, np.random.default_rng(0), turn_sd=0.01, way_sd=0.02)
    chain = pose_chain([view.pose for view in views], covs, ABOUT, 40.0)
    drawn = []
    for seed in range(400):
        off, _ = add_drift(views, np.random.default_rng(seed), turn_sd=0.01, way_sd=0.02)
        drawn.append([_twist(a.pose, b.pose) for a, b in zip(views, off, strict=True)])
    steps = np.diff(np.array(drawn), axis=1)
    of_heading = steps[:, :, 2].std(axis=0)
    assert of_heading == pytest.approx(np.sqrt(chain.covs[1:][:, 2, 2]), rel=0.5)
    # The views' own errors come on top.
    assert (of_heading <= np.sqrt(chain.covs[1:][:, 2, 2])).all()
    for axis in (3, 4):
        assert (steps[:, :, axis].std(axis=0) <= 1.1 * np.sqrt(chain.covs[1:][:, axis, axis])).all()


def _twist(true: Pose, off: Pose) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    turn = off.rotation @ true.rotation.T
    shift = off.centre - ABOUT - turn @ (true.centre - ABOUT)
    return np.concatenate([Rotation.from_matrix(turn).as_rotvec(), shift])
