"""Closed outlines among exact lines."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.perception.detection.line_front_end.outlines.outline_search import (
    MIN_SIDE_PX,
    find_outlines,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import LineCloud
from facetlog.robot.rendering.views import draw_similarity
from tests.perception.detection.line_front_end.ideal_lines import (
    HEXAGON,
    L_SHAPE,
    PENTAGON,
    PIXEL,
    SQUARE,
    TRIANGLE,
    exact_ends,
    exact_profiles,
    placed,
    plane_of,
    same_ring,
    sides_of,
)

SHAPES = {
    "square": SQUARE,
    "triangle": TRIANGLE,
    "pentagon": PENTAGON,
    "hexagon": HEXAGON,
    "L": L_SHAPE,
}


def outlines_of(corners, segments=None, covered=None, pixel=PIXEL):
    segments = sides_of(corners) if segments is None else segments
    plane = plane_of(corners, len(segments))
    return find_outlines(plane, cloud(segments, pixel), exact_profiles(segments, covered))


def cloud(segments, pixel=PIXEL):
    count = len(segments)
    return LineCloud(segments, exact_ends(segments), np.ones(count), np.zeros(count), pixel)


@pytest.mark.parametrize("shape", SHAPES)
@settings(max_examples=8)
@given(seed=st.integers(0, 10_000), scale=st.sampled_from([1e-3, 1.0, 1e3]))
def test_the_outline_of_exact_sides_comes_first(shape: str, seed: int, scale: float) -> None:
    rotation = draw_similarity(np.random.default_rng(seed)).rotation
    corners = placed(SHAPES[shape], rotation, scale)
    best = outlines_of(corners, pixel=PIXEL * scale)[0]
    assert same_ring(best.corners, corners, 1e-6 * scale)
    assert sorted(best.lines) == list(range(len(corners)))
    np.testing.assert_allclose(best.coverage, 1.0, atol=1e-6)


def test_a_printed_line_does_not_halve_a_face() -> None:
    corners = placed(SQUARE, np.eye(3))
    texture_line = placed(np.array([[0.0, 0.5], [1.0, 0.5]]), np.eye(3))
    best = outlines_of(corners, np.concatenate([sides_of(corners), texture_line[None]]))[0]
    assert same_ring(best.corners, corners)


def test_slivers_are_rejected() -> None:
    thin = SQUARE * [1.0, 0.9 * MIN_SIDE_PX * PIXEL]
    assert outlines_of(placed(thin, np.eye(3))) == ()
    assert len(outlines_of(placed(SQUARE * [1.0, 1.3 * MIN_SIDE_PX * PIXEL], np.eye(3)))) == 1
    # A long flat triangle has no short side, and yet no width.
    assert outlines_of(placed(np.array([[0.0, 0], [2, 0], [1, 0.08]]), np.eye(3))) == ()


def test_crossing_sides_are_no_outline() -> None:
    bow_tie = placed(SQUARE[[0, 2, 1, 3]], np.eye(3))
    segments = sides_of(bow_tie)
    plane = plane_of(placed(SQUARE, np.eye(3)), 4)
    found = find_outlines(plane, cloud(segments), exact_profiles(segments))
    assert all(len(o.lines) == 3 for o in found)  # its two triangles at most
