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


def test_cameras_that_hardly_move_propose_no_plane() -> None:
    start = ring(6, 60.0)[0]
    along = start.rotation[:, 0]
    rig = rig_of([Pose(start.rotation, start.centre + 1e-3 * k * along) for k in range(6)], [0] * 6)
    assert texture_planes(rig.texture, rig.pixel) == ()
