"""The plane of the ground, and up where nobody states it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.perception.detection.line_front_end.planes.ground_plane import Ground, find_ground
from facetlog.perception.detection.line_front_end.planes.level_direction import (
    held_up,
    level_direction,
)
from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import (
    PlaneHypothesis,
    plane_hypotheses,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import LineCloud
from facetlog.perception.surfaces.reconstruct import reconstruct
from facetlog.perception.types import FloatArray, Pose, View
from facetlog.robot.rendering.views import draw_similarity
from facetlog.robot.tour import make_ring_poses, tour_camera
from tests.perception.detection.drawings import view
from tests.perception.detection.line_front_end.ideal_lines import exact_ends
from tests.rendered import tour

PIXEL = 0.01
DISTANCE = 4.2
UP = np.array([0.0, 0.0, 1.0])
VIEWS = [view(pose=p) for p in make_ring_poses([0.0, 0.0, 0.3], 4.0, (1.0, 2.0), 8)]


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
    ring = LEVEL.extend_to_ground(side, out / np.linalg.norm(out))
    np.testing.assert_array_equal(ring[:2], side)
    np.testing.assert_allclose(ring[2:, 2], 0.0, atol=1e-9)
    # It lies in the plane, and goes down square to the level side.
    np.testing.assert_allclose((ring - side[0]) @ out, 0.0, atol=1e-9)
    np.testing.assert_allclose((ring[3] - ring[0]) @ along, 0.0, atol=1e-9)
    np.testing.assert_allclose((ring[2] - ring[1]) @ along, 0.0, atol=1e-9)


UP = np.array([0.0, 0.0, 1.0])


def read_views_from(elevation: float, rolled: float = 0.0) -> tuple[View, ...]:
    """Twelve blank views from a ring that high above the horizon, rolled about their axes."""
    c, s = np.cos(np.deg2rad(rolled)), np.sin(np.deg2rad(rolled))
    roll = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    poses = make_ring_poses([0.0, 0.0, 0.0], 30.0, (elevation,), 12)
    blank = np.zeros((480, 640), np.uint8)
    return tuple(
        View(f"{k}.png", blank, tour_camera(), Pose(pose.rotation @ roll, pose.centre))
        for k, pose in enumerate(poses)
    )


def lines(directions: FloatArray) -> FloatArray:
    """Segments (n, 2, 3) of length one along directions (n, 3), anywhere."""
    starts = np.random.default_rng(0).uniform(-1.0, 1.0, directions.shape)
    return np.stack([starts, starts + directions], axis=1)


def level_and_upright(count: int) -> FloatArray:
    turns = np.random.default_rng(1).uniform(0.0, np.pi, count)
    level = np.column_stack([np.cos(turns), np.sin(turns), np.zeros(count)])
    return np.concatenate([level, np.tile(UP, (count // 3, 1))])


def degrees_off(up: FloatArray | None) -> float:
    assert up is not None
    return float(np.degrees(np.arccos(np.clip(up @ UP, -1.0, 1.0))))


def test_up_is_square_to_what_is_level_and_along_what_is_upright() -> None:
    ways = level_and_upright(12)
    ways += np.random.default_rng(2).normal(scale=0.003, size=ways.shape)
    found = level_direction(lines(ways), np.ones(len(ways)), read_views_from(30.0))
    assert degrees_off(found) < 0.3


def test_lines_in_all_directions_tell_nothing() -> None:
    ways = np.random.default_rng(3).normal(size=(200, 3))
    assert level_direction(lines(ways), np.ones(200), read_views_from(30.0)) is None
    assert level_direction(np.zeros((0, 2, 3)), np.zeros(0), read_views_from(30.0)) is None


@pytest.mark.parametrize("rolled", [90.0, 180.0])
def test_cameras_that_were_not_held_upright_tell_nothing_above_the_ground(rolled: float) -> None:
    ways = level_and_upright(12)
    views = read_views_from(20.0, rolled)
    found = level_direction(lines(ways), np.ones(len(ways)), views)
    assert found is None or float(found @ UP) < -0.9
    assert not held_up(views, UP)


@pytest.mark.parametrize("rolled", [0.0, 30.0])
def test_the_grounds_normal_is_up_if_the_cameras_were_held_so(rolled: float) -> None:
    views = read_views_from(20.0, rolled)
    assert held_up(views, UP)
    assert not held_up(views, np.array([1.0, 0.0, 0.0]))  # a wall


@pytest.mark.parametrize("world", ["wedge", "stool"])
@pytest.mark.slow
def test_a_scene_in_any_frame_has_the_up_of_its_ground(world: str) -> None:
    frame = draw_similarity(np.random.default_rng(5))
    scene = reconstruct([frame.view(view) for view in tour(world)[::2]], name=world)
    assert scene.up is not None
    assert float(scene.up @ (frame.rotation @ UP)) > np.cos(np.deg2rad(1.0))
    assert any(said.startswith("up is not stated: it is that of the") for said in scene.warnings)
