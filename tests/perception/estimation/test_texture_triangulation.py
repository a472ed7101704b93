"""Texture points triangulated from features."""

import numpy as np

from facetlog.perception.detection.line_front_end.points_3d.texture_points import triangulated
from facetlog.perception.types import Camera, View
from facetlog.robot.tour import ring_poses

CAMERA = Camera(640, 480, 600.0, 600.0, 319.5, 239.5)
BLANK = np.zeros((480, 640), np.uint8)
VIEWS = tuple(
    View(str(k), BLANK, CAMERA, pose)
    for k, pose in enumerate(ring_poses([0.0, 0.0, 0.0], 3.0, (1.0, 1.4), 8))
)
SD = 0.5


def test_points_and_their_covariances_are_those_of_the_world() -> None:
    rng = np.random.default_rng(0)
    points = rng.uniform(-0.4, 0.4, (200, 3))
    h = np.array([v.projection[:, :3] @ points.T + v.projection[:, 3:] for v in VIEWS])
    uv = (h[:, :2] / h[:, 2:]).transpose(2, 0, 1) + SD * rng.normal(size=(200, 8, 2))
    seen = rng.random((200, 8)) < 0.7
    seen[:, :3] = True
    found = triangulated(VIEWS, uv, SD, seen)
    assert len(found.points) > 190
    apart = np.linalg.norm(found.points[:, None] - points, axis=-1)
    truth = points[apart.argmin(axis=1)]
    off = found.points - truth
    chi2 = np.einsum("ni,nij,nj->n", off, np.linalg.inv(found.covs), off)
    assert 2.5 < chi2.mean() < 3.6
    assert (found.seen.sum(axis=1) >= 3).all()


def test_what_two_views_see_or_none_agree_on_is_no_point() -> None:
    rng = np.random.default_rng(1)
    uv = rng.uniform(100, 400, (50, 8, 2))
    two = np.zeros((50, 8), np.bool_)
    two[:, :2] = True
    assert not len(triangulated(VIEWS, uv, SD, two).points)
    assert not len(triangulated(VIEWS, uv, SD, np.ones((50, 8), np.bool_)).points)
