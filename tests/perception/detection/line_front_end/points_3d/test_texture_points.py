"""Texture points in space."""

import numpy as np

from facetlog.perception.detection.line_front_end.planes.texture_planes import texture_planes
from facetlog.perception.types import Pose
from tests.perception.detection.line_front_end.printed_disc import (
    printed_rig,
    rig_of,
    ring,
    true_height,
)


def test_points_lie_on_the_texture_within_their_covariance() -> None:
    texture = printed_rig().texture
    assert len(texture.points) > 100
    sd = np.sqrt(texture.covs[:, 2, 2])
    assert np.median(true_height(texture.points) / sd) < 1.0
    assert (true_height(texture.points) < 4 * sd).mean() > 0.95


def test_each_point_is_seen_by_three_views_and_more() -> None:
    texture = printed_rig().texture
    assert (texture.seen.sum(axis=1) >= 3).all()
    assert texture.seen.shape == (len(texture.points), len(printed_rig().views))


def test_cameras_that_hardly_move_propose_no_plane() -> None:
    start = ring(6, 60.0)[0]
    along = start.rotation[:, 0]
    rig = rig_of([Pose(start.rotation, start.centre + 1e-3 * k * along) for k in range(6)], [0] * 6)
    assert texture_planes(rig.texture, rig.pixel) == ()


def test_two_views_give_no_points() -> None:
    rig = rig_of(ring(6, 60.0)[:2], [0] * 2)
    assert not len(rig.texture.points)


def test_some_of_the_points_keep_their_views() -> None:
    texture = printed_rig().texture
    some = texture.take(np.array([4, 2]))
    np.testing.assert_array_equal(some.points[1], texture.points[2])
    np.testing.assert_array_equal(some.seen[0], texture.seen[4])
