"""Two pictures of a known 3-D segment allow that segment."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.perception.detection.line_front_end.segments_3d.line_candidates import (
    MIN_OVERLAP,
    candidate_segments,
)
from facetlog.perception.types import FloatArray, Pose, View
from facetlog.robot.tour import looking_at
from tests.perception.detection.drawings import project, view

LEFT = view(pose=looking_at([-2.0, -8.0, 1.0], [0.0, 0.0, 0.0]))
RIGHT = view(pose=looking_at([2.0, -8.0, 2.0], [0.0, 0.0, 0.0]))
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
    found, made_of = candidate_segments(LEFT, seen(LEFT, segment), RIGHT, seen(RIGHT, segment))
    assert made_of.tolist() == [[0, 0]]
    np.testing.assert_allclose(found[0], segment, atol=1e-6)


def test_parts_seen_in_one_view_each_are_joined() -> None:
    start, end = np.array([-0.5, 0.2, -0.9]), np.array([0.4, 0.1, 0.8])

    def part(low: float, high: float) -> FloatArray:
        return start + np.array([[low], [high]]) * (end - start)

    found, _ = candidate_segments(LEFT, seen(LEFT, part(0, 0.7)), RIGHT, seen(RIGHT, part(0.2, 1)))
    np.testing.assert_allclose(found[0], [start, end], atol=1e-9)


@pytest.mark.parametrize(("overlap", "count"), [(MIN_OVERLAP - 0.05, 0), (MIN_OVERLAP + 0.05, 1)])
def test_parts_must_overlap_enough(overlap: float, count: int) -> None:
    # Upright segments at depth 2: 100 px in either picture.
    left = np.array([[180.0, 20.0, 180.0, 120.0]])
    low = 120.0 - 100.0 * overlap
    right = np.array([[30.0, low, 30.0, low + 100.0]])
    found, made_of = candidate_segments(view(), left, BESIDE, right)
    assert len(found) == len(made_of) == count


def test_a_segment_in_the_epipolar_plane_has_no_depth() -> None:
    # Level segments in pictures side by side: both planes are one.
    segment = np.array([[0.2, 0.1, 3.0], [0.9, 0.1, 3.0]])
    views = (view(), BESIDE)
    found, made_of = candidate_segments(
        views[0], seen(views[0], segment), views[1], seen(views[1], segment)
    )
    assert found.shape == (0, 2, 3)
    assert made_of.shape == (0, 2)
