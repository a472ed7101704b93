"""Views in groups by what they look at."""

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.mapping.visit import view_groups
from facetlog.perception.types import Pose
from facetlog.robot.tour import make_pose_looking_at

THINGS = ([0.0, 0.0, 0.4], [2.4, 0.2, 0.2], [1.0, 3.0, 0.3])


def _ring(target: list[float], count: int, first: float = 0.0) -> list[Pose]:
    angles = [first + math.tau * k / count for k in range(count)]
    places = [[target[0] + 1.8 * math.cos(a), target[1] + 1.8 * math.sin(a), 1.45] for a in angles]
    return [make_pose_looking_at(place, target) for place in places]


@given(st.integers(0, 1000))
@settings(max_examples=25)
def test_odometry_that_drifts_does_not_mix_them(seed: int) -> None:
    rng = np.random.default_rng(seed)
    poses = [
        Pose(pose.rotation, pose.centre + rng.normal(0.0, 0.03, 3) * [1, 1, 0])
        for target in THINGS
        for pose in _ring(target, 8)
    ]
    assert view_groups(poses) == tuple(tuple(range(8 * k, 8 * k + 8)) for k in range(3))


def test_who_comes_back_to_a_thing_goes_on_with_its_group() -> None:
    poses = [*_ring(THINGS[0], 5), *_ring(THINGS[2], 5), *_ring(THINGS[0], 4, 0.5)]
    assert view_groups(poses) == ((0, 1, 2, 3, 4, 10, 11, 12, 13), (5, 6, 7, 8, 9))


def test_views_that_look_at_nothing_together_are_one_group() -> None:
    """A robot that turns on the spot, and one that looks ahead on its way."""
    spot = [
        make_pose_looking_at([0, 0, 1], [math.cos(a), math.sin(a), 0.5])
        for a in np.arange(0, 6, 0.5)
    ]
    ahead = [make_pose_looking_at([x, 0, 1], [x + 2, 0, 0]) for x in np.arange(0, 5, 0.5)]
    assert view_groups(spot) == (tuple(range(len(spot))),)
    assert view_groups(ahead) == (tuple(range(len(ahead))),)
    assert view_groups([]) == ()
