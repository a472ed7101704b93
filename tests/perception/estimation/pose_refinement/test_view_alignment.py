"""Views brought to where their straight edges agree."""

from dataclasses import replace
from functools import cache

import numpy as np

from facetlog.perception.detection.edge_maps import edge_map
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import find_shown_lines
from facetlog.perception.detection.segments import detect_segments
from facetlog.perception.estimation.pose_refinement.view_alignment import align_views
from facetlog.perception.types import View
from facetlog.robot.rendering.views import add_pose_noise, views_of
from facetlog.robot.rendering.worlds import make_world
from facetlog.robot.tour import tour_camera, tour_poses


@cache
def tour() -> tuple[View, ...]:
    """Every second view of the tour of a block, in inches."""
    return views_of(make_world("block", 0), tour_poses()[::2], tour_camera())


def agreeing(views: tuple[View, ...]) -> tuple[View, ...]:
    maps = [edge_map(v.image) for v in views]
    segments = [detect_segments(v.image) for v in views]
    cloud, use = find_shown_lines(views, maps, segments)
    return align_views(views, maps, segments, cloud.segments, use) or views


def test_views_that_agree_stay_as_they_are() -> None:
    for view, found in zip(tour(), agreeing(tour()), strict=True):
        np.testing.assert_allclose(found.pose.centre, view.pose.centre, atol=1e-12)
        np.testing.assert_allclose(found.pose.rotation, view.pose.rotation, atol=1e-12)


def test_views_off_by_some_tenths_of_a_degree_come_to_agree() -> None:
    rng = np.random.default_rng(0)
    off = add_pose_noise(tour(), rng, position_sd=0.2, angle_sd=np.radians(0.3))
    found = agreeing(off)
    # Corners of the block, as the views before and after have them against the true ones.
    corners = np.array(make_world("block", 0).truth.solids[0].vertices)
    assert _spread_px(found, corners) < 0.5 * _spread_px(off, corners)


def test_pictures_that_show_nothing_leave_the_poses_as_they_are() -> None:
    grey = tuple(replace(v, image=np.full_like(v.image, 90)) for v in tour())
    for view, found in zip(grey, agreeing(grey), strict=True):
        np.testing.assert_allclose(found.pose.centre, view.pose.centre, atol=1e-12)


def _spread_px(views: tuple[View, ...], corners: np.ndarray) -> float:
    """Rms in px of true pixels about those of the points that fit them best at these poses."""
    total = 0.0
    for corner in corners:
        uv = np.array([_pixel(true, corner) for true in tour()])
        best = np.array(corner, dtype=np.float64)
        for _ in range(5):
            at = np.array([_pixel(v, best) for v in views])
            rows = [
                (np.array([_pixel(v, best + 1e-4 * axis) for v in views]) - at).ravel() / 1e-4
                for axis in np.eye(3)
            ]
            best = best + np.linalg.lstsq(np.array(rows).T, (uv - at).ravel(), rcond=None)[0]
        total += float(((uv - np.array([_pixel(v, best) for v in views])) ** 2).mean())
    return float(np.sqrt(total / len(corners)))


def _pixel(view: View, point: np.ndarray) -> np.ndarray:
    h = view.projection @ np.append(point, 1.0)
    return np.asarray(h[:2] / h[2])
