"""Does one see through an outline, or is what seems to be behind it texture on it?"""

from collections.abc import Sequence

import cv2
import numpy as np

from facetlog.perception.detection.edge_maps import edge_map
from facetlog.perception.detection.line_front_end.evidence.photo_consistency import GreyLevels
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.evidence.see_through import LinesBehind
from facetlog.perception.detection.line_front_end.evidence.side_evidence import SideJudge
from facetlog.perception.detection.line_front_end.segments_3d.line_support import project_points
from facetlog.perception.types import FloatArray, View
from facetlog.robot.tour import make_ring_poses
from tests.perception.detection.line_front_end.block_rig import CAMERA, DISTANCE

UP = np.array([0.0, 0.0, 1.0])
PIXEL = DISTANCE / CAMERA.fx
# The outline, at height 0, and a line so far behind it that views see it at different places.
SQUARE = np.array([[-6.0, -6.0, 0.0], [6.0, -6.0, 0.0], [6.0, 6.0, 0.0], [-6.0, 6.0, 0.0]])
BEHIND = np.array([[-2.0, -1.0, -3.0], [2.0, 1.0, -3.0]])
POSES = make_ring_poses(np.zeros(3), DISTANCE / 1.4, (DISTANCE / 1.4,), 10)


def drawn(lines: Sequence[FloatArray]) -> tuple[View, ...]:
    """Views of lines (2, 3) in black on white."""
    views = []
    for pose in POSES:
        view = View("drawn", np.full((240, 320), 200, np.uint8), CAMERA, pose)
        for line in lines:
            (a, b), _ = project_points(view.projection, line)
            cv2.line(view.image, np.rint(a).astype(int), np.rint(b).astype(int), 40, 2)
        views.append(view)
    return tuple(views)


def pixel_incidence(centre: FloatArray) -> FloatArray:
    """Where in the outline's plane a view sees the line behind."""
    t = centre[2] / (centre[2] - BEHIND[:, 2:])
    return np.asarray(centre + t * (BEHIND - centre))


def seen_through(
    views: Sequence[View],
    *,
    holes: Sequence[FloatArray] = (),
    behind: Sequence[FloatArray] = (BEHIND,),
) -> bool:
    everyone = np.arange(len(views))
    return lines_behind(views, behind).seen_through(SQUARE, UP, everyone, holes)


def lines_behind(views: Sequence[View], behind: Sequence[FloatArray]) -> LinesBehind:
    maps, weight = [edge_map(v.image) for v in views], np.ones(len(views))
    photos = PhotometricViews(views, GreyLevels(views, maps), weight)
    exact = 1e-6 * np.tile(np.eye(3), (len(behind), 1, 1))
    sides = SideJudge(views, maps, weight)
    return LinesBehind(photos, sides, np.array(behind), exact, PIXEL)


def test_one_sees_through_where_the_views_see_a_line_behind() -> None:
    assert seen_through(drawn([BEHIND]))


def test_a_line_that_no_view_sees_is_hidden_by_a_surface() -> None:
    assert not seen_through(drawn([]))


def test_what_is_seen_through_a_hole_says_nothing() -> None:
    hole = SQUARE[::-1] * np.array([0.9, 0.9, 1.0])
    assert not seen_through(drawn([BEHIND]), holes=[hole])


def test_texture_that_all_views_see_makes_no_line_behind() -> None:
    # Grain: in each view one of its lines is where the line behind would be.
    grain = [pixel_incidence(pose.centre) for pose in POSES]
    assert not seen_through(drawn(grain))
