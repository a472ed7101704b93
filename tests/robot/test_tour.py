"""The paper's tour and rings of cameras."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.perception.types import FloatArray
from facetlog.robot.tour import make_pose_looking_at, make_ring_poses, tour_poses

finite = st.floats(-100, 100)
points = st.tuples(finite, finite, finite).map(np.array)


def test_all_24_views_of_the_tour_look_at_the_block() -> None:
    target = np.array([23.2, 56.1, 28.5])
    for pose in tour_poses():
        towards = (target - pose.centre)[:2]
        ahead = pose.rotation[:2, 2]
        cos = towards @ ahead / np.linalg.norm(towards) / np.linalg.norm(ahead)
        assert np.rad2deg(np.arccos(cos)) < 17.2  # the spread of the printed pans
        assert np.rad2deg(np.arcsin(-pose.rotation[2, 2])) == pytest.approx(23.06)


@given(eye=points, aim=points)
def test_a_camera_looks_at_its_target_and_stands_upright(eye: FloatArray, aim: FloatArray) -> None:
    if np.hypot(*(aim - eye)[:2]) < 1e-3:
        return
    pose = make_pose_looking_at(eye, aim)
    x, y, z = (aim - pose.centre) @ pose.rotation
    assert z > 0
    assert abs(x) < 1e-6 * z + 1e-9
    assert abs(y) < 1e-6 * z + 1e-9
    assert pose.rotation[2, 0] == pytest.approx(0.0, abs=1e-9)  # right is level
    assert pose.rotation[2, 1] <= 1e-9  # down is down


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
def test_a_ring_stands_round_its_target_at_any_scale(scale: float) -> None:
    target = scale * np.array([1.0, 2.0, 0.5])
    poses = make_ring_poses(target, 3 * scale, (scale, 2 * scale), 8)
    offsets = np.array([p.centre - target for p in poses])
    assert np.linalg.norm(offsets[:, :2], axis=1) == pytest.approx(3 * scale)
    assert offsets[:, 2] == pytest.approx(scale * np.array([1, 2] * 4))
    assert offsets.mean(axis=0)[:2] == pytest.approx([0, 0], abs=1e-9 * scale)
