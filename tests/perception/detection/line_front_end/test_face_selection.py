"""Which outlines are faces: judged by rendered views, and against one another."""

from collections.abc import Sequence

import numpy as np
import pytest

from facetlog.perception.detection.line_front_end.candidate_faces import SelectedFace
from facetlog.perception.detection.line_front_end.evidence.photo_consistency import GreyLevels
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.evidence.see_through import LinesBehind
from facetlog.perception.detection.line_front_end.evidence.side_evidence import SideJudge
from facetlog.perception.detection.line_front_end.face_selection import select_faces
from facetlog.perception.detection.line_front_end.planes.ground_plane import find_ground
from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import (
    PlaneHypothesis,
    plane_hypotheses,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import LineCloud
from facetlog.perception.detection.line_front_end.segments_3d.line_extent import (
    find_covered_extents,
    measure_line_profiles,
)
from facetlog.perception.detection.view_graph import view_graph
from facetlog.perception.types import FloatArray
from tests.perception.detection.line_front_end.block_rig import Rig, block_rig
from tests.perception.detection.line_front_end.ideal_lines import exact_ends

UP = np.array([0.0, 0.0, 1.0])


def cloud(rig: Rig, segments: FloatArray) -> LineCloud:
    count = len(segments)
    ends = exact_ends(segments)
    return LineCloud(segments, ends, np.full(count, 8.0), np.zeros(count), rig.pixel)


def selected(
    rig: Rig,
    segments: FloatArray,
    up: FloatArray | None = UP,
    planes: Sequence[PlaneHypothesis] | None = None,
) -> tuple[SelectedFace, ...]:
    lines = cloud(rig, segments)
    found = planes or plane_hypotheses(lines.segments, lines.end_covs, lines.support, lines.pixel)
    graph = view_graph(rig.views)
    use = np.ones((len(segments), len(rig.views)), np.bool_)
    profiles = measure_line_profiles(segments, rig.views, rig.maps, use, graph.weight)
    sides = SideJudge(rig.views, rig.maps, graph.weight)
    score = sides.score(segments)
    ground = find_ground(found, lines, score, rig.views, graph.distance, up)
    photos = PhotometricViews(rig.views, GreyLevels(rig.views, rig.maps), graph.weight)
    behind = LinesBehind.of(lines, find_covered_extents(segments, profiles), photos, sides)
    faces, _ = select_faces(found, lines, score, rig.views, profiles, ground, photos, sides, behind)
    return faces


@pytest.mark.parametrize("up", [UP, None])
def test_the_five_faces_that_views_see_are_selected(up: FloatArray | None) -> None:
    rig = block_rig()
    faces = selected(rig, rig.edges, up)
    heights = sorted(float(f.corners[:, 2].mean()) for f in faces)
    np.testing.assert_allclose(heights, [3, 3, 3, 3, 6], atol=rig.pixel)
    assert all(f.support > 0.9 for f in faces)
    middle = rig.points.mean(axis=0)
    for face in faces:
        newell = np.cross(face.corners, np.roll(face.corners, -1, axis=0)).sum(axis=0)
        assert face.normal @ newell > 0
        assert face.normal @ (face.corners.mean(axis=0) - middle) > 0
        facing = [face.normal @ (v.pose.centre - face.corners[0]) > 0 for v in rig.views]
        assert not (face.shown & ~np.array(facing)).any()


def test_a_face_with_a_side_that_no_line_bounds_is_found_by_what_the_pictures_show() -> None:
    rig = block_rig()
    high = (rig.edges[:, :, 2] > 5.9).all(axis=1)
    kept = np.delete(rig.edges, np.nonzero(high)[0][0], axis=0)  # one side of the top is missing
    faces = selected(rig, kept)
    (found,) = (f for f in faces if f.corners[:, 2].min() > 5.5)
    area = 10.0 * 8.0
    ring = found.corners
    newell = np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0) / 2
    assert abs(np.linalg.norm(newell) - area) < 0.1 * area


def test_sides_without_upright_lines_reach_from_the_top_to_the_ground() -> None:
    rig = block_rig()
    level = np.ptp(rig.edges[:, :, 2], axis=1) < 0.1
    low = np.flatnonzero(level & (rig.edges[:, 0, 2] < 0.1))
    kept = rig.edges[[*np.flatnonzero(level & (rig.edges[:, 0, 2] > 5.9)), *low[:2]]]
    heights = sorted(float(f.corners[:, 2].mean()) for f in selected(rig, kept))
    np.testing.assert_allclose(heights, [3, 3, 3, 3, 6], atol=rig.pixel)


def test_the_selection_is_the_same_in_any_order_of_the_segments() -> None:
    rig = block_rig()
    one, other = selected(rig, rig.edges), selected(rig, rig.edges[::-1])
    assert len(one) == len(other)
    middles = np.array([f.corners.mean(axis=0) for f in other])
    for face in one:
        assert np.linalg.norm(middles - face.corners.mean(axis=0), axis=1).min() < rig.pixel
