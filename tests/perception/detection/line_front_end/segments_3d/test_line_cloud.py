"""3-D segments: candidates of two pictures, and those of rendered scenes."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.perception.detection.edge_maps import edge_map
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import (
    MIN_OVERLAP,
    LineCloud,
    propose_segments,
    reconstruct_lines,
)
from facetlog.perception.detection.segments import detect_segments
from facetlog.perception.detection.view_graph import view_graph
from facetlog.perception.types import FloatArray, Pose, View
from facetlog.robot.rendering.views import draw_similarity, shuffled
from facetlog.robot.rendering.worlds import make_world
from facetlog.robot.tour import make_pose_looking_at
from tests.perception.detection.drawings import project, view
from tests.rendered import get_solid_truth, list_visible_faces, tour, true_edges

LEFT = view(pose=make_pose_looking_at([-2.0, -8.0, 1.0], [0.0, 0.0, 0.0]))
RIGHT = view(pose=make_pose_looking_at([2.0, -8.0, 2.0], [0.0, 0.0, 0.0]))
# Two cameras side by side that look along z, for cases read off by eye.
BESIDE = view(pose=Pose(np.eye(3), np.array([1.0, 0.0, 0.0])))
VIEWS = (LEFT, RIGHT)
COORDINATE = st.floats(-1.0, 1.0)
POINT = st.tuples(COORDINATE, COORDINATE, COORDINATE).map(np.array)


def seen(by: View, segment: FloatArray) -> FloatArray:
    return project(by, segment).reshape(1, 4)


def plane_sine(segment: FloatArray) -> float:
    """Sine of the angle between the planes through the segment and either pinhole."""
    normals = [np.cross(segment[0] - v.pose.centre, segment[1] - v.pose.centre) for v in VIEWS]
    a, b = (n / np.linalg.norm(n) for n in normals)
    return float(np.linalg.norm(np.cross(a, b)))


@settings(max_examples=60)
@given(POINT, POINT)
def test_the_segment_that_both_show_is_found(start: FloatArray, end: FloatArray) -> None:
    segment = np.array([start, end])
    if np.linalg.norm(end - start) < 0.1 or plane_sine(segment) < 0.05:
        return
    found, made_of = propose_segments(LEFT, seen(LEFT, segment), RIGHT, seen(RIGHT, segment))
    assert made_of.tolist() == [[0, 0]]
    np.testing.assert_allclose(found[0], segment, atol=1e-6)


@pytest.mark.parametrize(("overlap", "count"), [(MIN_OVERLAP - 0.05, 0), (MIN_OVERLAP + 0.05, 1)])
def test_parts_must_overlap_enough(overlap: float, count: int) -> None:
    # Upright segments at depth 2: 100 px in either picture.
    left = np.array([[180.0, 20.0, 180.0, 120.0]])
    low = 120.0 - 100.0 * overlap
    right = np.array([[30.0, low, 30.0, low + 100.0]])
    found, made_of = propose_segments(view(), left, BESIDE, right)
    assert len(found) == len(made_of) == count


def lines_of(views: tuple[View, ...]) -> LineCloud:
    maps = [edge_map(v.image) for v in views]
    segments = [detect_segments(v.image) for v in views]
    return reconstruct_lines(views, maps, segments, view_graph(views))


@cache
def block_lines() -> LineCloud:
    return lines_of(tour("block"))


def seen_edges() -> FloatArray:
    """True edges (n, 2, 3) of the block that some view sees."""
    solid = get_solid_truth(make_world("block"))
    faces = {f for v in tour("block") for f in list_visible_faces(solid, v)}
    corners = [set(solid.faces[f]) for f in faces]
    shown = [any(set(e) <= face for face in corners) for e in solid.edges]
    return true_edges(solid)[np.array(shown)]


def found_share(edge: FloatArray, segments: FloatArray, tolerance: float) -> float:
    """Share of an edge (2, 3) that lies within `tolerance` of some segment (n, 2, 3)."""
    places = edge[0] + np.linspace(0.02, 0.98, 49)[:, None] * (edge[1] - edge[0])
    start = segments[:, 0]
    along = segments[:, 1] - start
    t = ((places[:, None] - start) * along).sum(-1) / (along**2).sum(-1)
    nearest = start + np.clip(t, 0, 1)[..., None] * along
    away = np.linalg.norm(places[:, None] - nearest, axis=-1)
    return float((away.min(axis=1) < tolerance).mean())


def test_every_edge_seen_of_a_block_is_found_whole() -> None:
    shares = [found_share(e, block_lines().segments, 0.1) for e in seen_edges()]
    assert len(shares) == 12
    assert min(shares) > 0.9


def test_the_same_lines_are_found_in_another_frame() -> None:
    frame = draw_similarity(np.random.default_rng(5), scale=1000.0, reach=1e4)
    moved = lines_of(tuple(frame.view(v) for v in tour("block")))
    assert moved.pixel == pytest.approx(1000 * block_lines().pixel, rel=1e-6)
    edges = frame.scale * seen_edges() @ frame.rotation.T + frame.shift
    assert min(found_share(e, moved.segments, 0.1 * frame.scale) for e in edges) > 0.9


def test_wrong_poses_leave_few_lines_and_none_of_them_well_supported() -> None:
    views = shuffled(tour("block"), np.random.default_rng(0))
    cloud = lines_of(views)
    assert cloud.support.sum() < 0.2 * block_lines().support.sum()


def test_two_views_support_no_line() -> None:
    # Two planes through two pinholes always meet: only a third view can confirm it.
    assert not len(lines_of(tour("block")[:2]).segments)
