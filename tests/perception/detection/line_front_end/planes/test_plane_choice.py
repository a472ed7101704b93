"""Planes among exact segments, and which of them to search."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.planes.plane_choice import (
    OPEN_SLOPE,
    choose_planes,
    plane_cov,
)
from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import (
    PlaneHypothesis,
    plane_hypotheses,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import LineCloud
from facetlog.perception.types import FloatArray
from facetlog.robot.rendering.solids import cuboid
from facetlog.robot.rendering.views import draw_similarity
from tests.perception.detection.line_front_end.ideal_lines import (
    PIXEL,
    exact_ends,
)

BLOCK = cuboid(3.0, 2.0, 1.0)


def planes_of(segments, support, pixel: float) -> tuple[PlaneHypothesis, ...]:
    return plane_hypotheses(segments, exact_ends(segments), support, pixel)


def edges_of(solid):
    return solid.vertices[np.array(solid.edges)]


def normals(planes) -> set[tuple[float, ...]]:
    """Planes by their normals, each turned the same way."""
    named = set()
    for plane in planes:
        largest = np.argmax(np.abs(plane.normal))
        normal = plane.normal * np.sign(plane.normal[largest])
        distance = plane.distance * np.sign(plane.normal[largest])
        named.add(tuple(np.round([*normal, distance], 6) + 0.0))
    return named


def test_a_block_has_six_planes_of_four_edges() -> None:
    planes = planes_of(edges_of(BLOCK), np.ones(12), PIXEL)
    assert normals(planes) == {
        (1, 0, 0, 1.5), (1, 0, 0, -1.5), (0, 1, 0, 1), (0, 1, 0, -1), (0, 0, 1, 0), (0, 0, 1, 1)
    }  # fmt: skip
    assert all(len(p.lines) == 4 for p in planes)


@settings(max_examples=20)
@given(st.integers(0, 10_000), st.sampled_from([1e-3, 1.0, 1e3]))
def test_planes_turn_and_grow_with_the_world(seed: int, scale: float) -> None:
    frame = draw_similarity(np.random.default_rng(seed), scale=scale, reach=2.0)
    moved = frame.scale * edges_of(BLOCK) @ frame.rotation.T + frame.shift
    planes = planes_of(moved, np.ones(12), PIXEL * scale)
    assert len(planes) == 6
    for plane in planes:
        away = moved[plane.lines] @ plane.normal - plane.distance
        assert np.abs(away).max() < 1e-9 * scale + 1e-12
        assert np.linalg.norm(plane.normal) == pytest.approx(1.0)


UP = np.array([0.0, 0.0, 1.0])
CORNERS = np.array([[0.0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
RIM = np.stack([CORNERS, np.roll(CORNERS, -1, axis=0)], axis=1)


def cloud(segments: FloatArray) -> LineCloud:
    count = len(segments)
    return LineCloud(segments, exact_ends(segments), np.ones(count), np.zeros(count), PIXEL)


def level(height: float, lines: int) -> PlaneHypothesis:
    return PlaneHypothesis(UP, height, np.arange(lines))


def surface(plane: PlaneHypothesis) -> NDArray[np.bool_]:
    return np.ones((2, len(plane.lines)), np.bool_)


def test_a_plane_that_is_there_twice_is_taken_once() -> None:
    tilted = PlaneHypothesis(np.array([0.0, np.sin(0.01), np.cos(0.01)]), 1.0, np.arange(3))
    (only,) = choose_planes((level(1.0, 4), tilted), cloud(RIM), np.full(4, 9.0), None, surface, 1)
    assert only.bound == 36.0
    assert only.sides == (1.0, -1.0)
    assert len(only.plane.lines) == 4


def test_planes_through_the_same_lines_score_less_and_less() -> None:
    # Twelve planes round one line, each with a short line of its own.
    axis = np.array([[[0.0, 0, 0], [0, 0, 1]]])
    turns = np.linspace(0, np.pi, 12, endpoint=False)
    own = np.array([[[0.5 * np.cos(t), 0.5 * np.sin(t), 0.2]] * 2 for t in turns])
    own[:, 1, 2] = 0.3
    planes = [
        PlaneHypothesis(np.array([-np.sin(t), np.cos(t), 0.0]), 0.0, np.array([0, k + 1]))
        for k, t in enumerate(turns)
    ]
    score = np.array([100.0, *np.full(12, 5.0)])
    lines = cloud(np.concatenate([axis, own]))
    chosen = choose_planes(planes, lines, score, None, surface, 16.0)
    assert 3 <= len(chosen) <= 5
    np.testing.assert_allclose([c.bound for c in chosen], 105.0)


def test_lines_speak_only_for_a_plane_that_is_a_surface_beside_them() -> None:
    def from_above_at_two(plane: PlaneHypothesis) -> NDArray[np.bool_]:
        return np.array([[True, True, False, False], [False] * 4])

    score = np.full(4, 10.0)
    (plane,) = choose_planes((level(1.0, 4),), cloud(RIM), score, None, from_above_at_two, 16.0)
    assert plane.bound == 20.0
    assert plane.sides == (1.0,)
    assert not choose_planes((level(1.0, 4),), cloud(RIM), score, None, from_above_at_two, 25.0)


def test_a_plane_is_known_near_its_lines_and_hardly_far_from_them() -> None:
    near, far = np.array([[0.5, 0.5, 1.0]]), np.array([[9.0, 0.5, 1.0]])
    four, one = level(1.0, 4), PlaneHypothesis(UP, 1.0, np.array([0]))
    lines = cloud(RIM)

    def sds(plane: PlaneHypothesis, points: FloatArray, slope: float = OPEN_SLOPE) -> FloatArray:
        return np.sqrt(np.diagonal(plane_cov(plane, lines, points, slope)))

    assert sds(four, near)[0] < PIXEL
    assert sds(four, far)[0] > 5 * sds(four, near)[0]
    assert sds(one, CORNERS)[2] > 3 * sds(four, CORNERS)[2]
    assert sds(one, CORNERS, OPEN_SLOPE / 10)[2] < sds(one, CORNERS)[2] / 3
    none = PlaneHypothesis(UP, 1.0, np.zeros(0, np.intp))
    assert np.isfinite(sds(none, CORNERS)).all()


def test_corners_near_together_share_the_error_of_a_plane() -> None:
    # A board's rim of two lines, ten pixels wide: it may be shifted, and is hardly tilted.
    rim = np.array([[[0.0, 0, 1], [1, 0, 1]], [[0.0, 0.1, 1], [1, 0.1, 1]]])
    slope = np.tan(np.radians(0.5))
    cov = plane_cov(level(1.0, 2), cloud(rim), rim.reshape(-1, 3), slope)
    sds = np.sqrt(np.diagonal(cov))
    across = np.sqrt(cov[0, 0] + cov[2, 2] - 2 * cov[0, 2])
    assert (sds > 0.3 * PIXEL).all()
    assert across < 1.01 * slope * 0.1 < 0.2 * sds.min()
