"""Which plane is the ground."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from facetlog.perception.detection.line_front_end.planes.ground_plane import Ground, find_ground
from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import (
    PlaneHypothesis,
    plane_hypotheses,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import LineCloud
from facetlog.perception.types import FloatArray
from facetlog.robot.tour import ring_poses
from tests.perception.detection.drawings import view
from tests.perception.detection.line_front_end.ideal_lines import exact_ends

PIXEL = 0.01
DISTANCE = 4.2
UP = np.array([0.0, 0.0, 1.0])
VIEWS = [view(pose=p) for p in ring_poses([0.0, 0.0, 0.3], 4.0, (1.0, 2.0), 8)]


def grid(height: float, reach: float) -> FloatArray:
    """Level segments of a pattern (n, 2, 3)."""
    at = np.linspace(-reach, reach, 5)
    across = [[[-reach, y, height], [reach, y, height]] for y in at]
    along = [[[x, -reach, height], [x, reach, height]] for x in at]
    return np.array(across + along)


def cloud(*parts: FloatArray) -> LineCloud:
    segments = np.concatenate(parts)
    count = len(segments)
    return LineCloud(segments, exact_ends(segments), np.full(count, 8.0), np.zeros(count), PIXEL)


def planes(lines: LineCloud) -> tuple[PlaneHypothesis, ...]:
    return plane_hypotheses(lines.segments, lines.end_covs, lines.support, lines.pixel)


def equal(lines: LineCloud) -> FloatArray:
    """Every line as likely as every other."""
    return np.ones(len(lines.segments))


def test_a_tiled_floor_is_the_ground_and_a_table_top_above_it_is_not() -> None:
    lines = cloud(grid(0.0, 2.0), grid(0.7, 0.4))
    for up in (UP, None):
        ground = find_ground(planes(lines), lines, equal(lines), VIEWS, DISTANCE, up)
        assert ground is not None
        assert abs(ground.height) < 1e-6
        assert ground.normal @ UP > 0.999
        assert ground.holds(lines.segments[0]).all()
        assert not ground.holds(lines.segments[-1]).any()


def test_without_lines_on_it_the_ground_is_where_the_lowest_segments_end() -> None:
    upright = np.array([[[x, 0.0, 0.02], [x, 0.0, 0.7]] for x in (-0.4, 0.4)])
    lines = cloud(grid(0.7, 0.4), upright, np.array([[[-0.4, 0, 0.02], [0.4, 0, 0.02]]]))
    ground = find_ground(planes(lines), lines, equal(lines), VIEWS, DISTANCE, UP)
    assert ground is not None
    np.testing.assert_allclose(ground.height, 0.02, atol=1e-6)


def test_the_rim_of_a_seat_is_not_the_ground_of_thin_legs() -> None:
    legs = np.array([[[x, 0.0, 0.0], [x, 0.0, 0.7]] for x in (-0.4, 0.4)])
    lines = cloud(grid(0.7, 0.4), legs)
    score = np.array([100.0] * 10 + [50.0, 50.0])
    ground = find_ground(planes(lines), lines, score, VIEWS, DISTANCE, UP)
    assert ground is not None
    np.testing.assert_allclose(ground.height, 0.0, atol=1e-6)


def test_where_up_is_not_known_and_everything_is_above_no_plane_there_is_no_ground() -> None:
    lines = cloud(grid(0.7, 0.4), np.array([[[0.4, 0.4, 0.7], [0.4, 0.4, 0.0]]] * 3))
    assert find_ground((), lines, equal(lines), VIEWS, DISTANCE, None) is None
    assert find_ground(planes(lines), lines, equal(lines), VIEWS, DISTANCE, None) is None


LEVEL = Ground(UP, 0.0, 0.05, np.array([[0.0, -3.0, 2.0], [3.0, 0.0, 2.0]]), 3.6)


@given(st.floats(-0.5, 1.5), st.floats(0.0, 6.3))
def test_what_lies_below_the_ground_is_cut_off(height: float, turn: float) -> None:
    upright = np.array([[0.0, 0, -0.5], [1.0, 0, -0.5], [1.0, 0, 0.5], [0.0, 0, 0.5]])
    c, s = np.cos(turn), np.sin(turn)
    corners = upright @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) + height * UP
    cut = LEVEL.clipped(corners)
    if height - 0.5 >= -LEVEL.margin:
        np.testing.assert_array_equal(cut, corners)
        return
    assert (LEVEL.above(cut) >= -1e-9).all()
    left = max(height + 0.5, 0.0)
    area = np.linalg.norm(np.cross(cut, np.roll(cut, -1, axis=0)).sum(axis=0)) / 2
    np.testing.assert_allclose(area, left, atol=1e-9)


@given(st.floats(0.2, 3.0), st.floats(0.0, 6.3), st.floats(-1.0, 1.0))
def test_a_plane_goes_down_from_a_side_to_the_ground(h: float, turn: float, lean: float) -> None:
    along = np.array([np.cos(turn), np.sin(turn), 0.0])
    out = np.array([-np.sin(turn), np.cos(turn), lean])
    side = np.array([along, 3 * along]) + h * UP
    ring = LEVEL.down_from(side, out / np.linalg.norm(out))
    np.testing.assert_array_equal(ring[:2], side)
    np.testing.assert_allclose(ring[2:, 2], 0.0, atol=1e-9)
    # It lies in the plane, and goes down square to the level side.
    np.testing.assert_allclose((ring - side[0]) @ out, 0.0, atol=1e-9)
    np.testing.assert_allclose((ring[3] - ring[0]) @ along, 0.0, atol=1e-9)
    np.testing.assert_allclose((ring[2] - ring[1]) @ along, 0.0, atol=1e-9)
