"""Texture points in space, triangulated from features, and the surface that they show."""

import numpy as np

from facetlog.perception.detection.line_front_end.evidence.texture_correlation import (
    MIN_CORRELATION,
    find_surface_between,
    texture_correlation,
)
from facetlog.perception.detection.line_front_end.planes.texture_planes import texture_planes
from facetlog.perception.detection.line_front_end.points_3d.texture_points import triangulated
from facetlog.perception.types import Camera, FloatArray, Pose, View
from facetlog.robot.tour import make_ring_poses
from tests.perception.detection.line_front_end.printed_disc import (
    HEIGHT,
    RADIUS,
    PrintedRig,
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


CAMERA = Camera(640, 480, 600.0, 600.0, 319.5, 239.5)
BLANK = np.zeros((480, 640), np.uint8)
VIEWS = tuple(
    View(str(k), BLANK, CAMERA, pose)
    for k, pose in enumerate(make_ring_poses([0.0, 0.0, 0.0], 3.0, (1.0, 1.4), 8))
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


UP = np.array([0.0, 0.0, 1.0])


def inside(count: int, height: float = HEIGHT) -> FloatArray:
    rng = np.random.default_rng(0)
    return np.column_stack([rng.uniform(-0.5, 0.5, (count, 2)) * RADIUS, np.full(count, height)])


def likeness(rig: PrintedRig, points: FloatArray) -> FloatArray:
    return texture_correlation(rig.views, np.arange(len(rig.views)), points, UP, rig.pixel)


def test_texture_correlates_on_its_plane() -> None:
    assert (likeness(printed_rig(), inside(40)) > 0.8).all()


def test_different_textures_do_not_correlate() -> None:
    rig = rig_of(ring(6, 60.0), range(6))
    assert (likeness(rig, inside(40)) < MIN_CORRELATION).all()


def test_texture_is_surface_as_seen_from_above_only() -> None:
    rig = printed_rig()
    front, back = find_surface_between(rig.photos, rig.views, rig.pixel, UP, inside(40))
    assert front.mean() > 0.9
    assert not back.any()
