"""Things of a scene in the world, and what the robot's own pose leaves open of them."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from facetlog.kb.explaining.verdict import Recognition
from facetlog.mapping.placed_thing import place_things, pose_covariance_at
from facetlog.perception.types import Pose
from tests.mapping.rooms import SD, box_at


def test_a_box_has_its_place_heading_and_size() -> None:
    (thing,) = place_things(box_at(1.0, -2.0, 0.5), Recognition("scene", ()), "monday")
    assert thing.source == ("monday", "t1")
    assert thing.pose == pytest.approx([1.0, -2.0, 0.5], abs=1e-6)
    assert [each.value for each in thing.lengths] == pytest.approx([0.4, 0.3, 0.2], abs=1e-6)
    assert thing.lengths[2].sd == pytest.approx(SD)
    assert np.array_equal(thing.cov, thing.box.cov[:3, :3])
    assert thing.plan.area == pytest.approx(0.12)
    assert len(thing.triangles) >= 12


def test_an_error_of_the_robots_pose_moves_the_thing_as_a_whole() -> None:
    """As many views as were drawn with that covariance put the thing elsewhere."""
    rng = np.random.default_rng(2)
    place = np.array([1.5, 0.4, 0.2])
    pose = Pose(np.eye(3), np.array([0.0, 0.0, 0.7]))
    root = rng.normal(size=(6, 6)) * [0.01, 0.01, 0.002, 0.004, 0.004, 0.02]
    cov = root @ root.T
    draws = rng.multivariate_normal(np.zeros(6), cov, 20_000)
    turned = Rotation.from_rotvec(draws[:, 3:])
    places = pose.centre + draws[:, :3] + turned.apply(place - pose.centre)
    found = np.cov(np.column_stack([places[:, :2], draws[:, 5]]).T)
    expected = pose_covariance_at(place, [pose], cov[None])
    assert found == pytest.approx(expected, rel=0.1, abs=0.05 * expected.max())
