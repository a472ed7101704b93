"""Planes among exact segments."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import (
    PlaneHypothesis,
    plane_hypotheses,
)
from facetlog.robot.rendering.solids import cuboid
from facetlog.robot.rendering.views import random_similarity
from tests.perception.detection.line_front_end.ideal_lines import (
    PIXEL,
    SQUARE,
    exact_ends,
    placed,
    sides_of,
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
    frame = random_similarity(np.random.default_rng(seed), scale=scale, reach=2.0)
    moved = frame.scale * edges_of(BLOCK) @ frame.rotation.T + frame.shift
    planes = planes_of(moved, np.ones(12), PIXEL * scale)
    assert len(planes) == 6
    for plane in planes:
        away = moved[plane.lines] @ plane.normal - plane.distance
        assert np.abs(away).max() < 1e-9 * scale + 1e-12
        assert np.linalg.norm(plane.normal) == pytest.approx(1.0)


def test_noise_of_a_pixel_moves_no_plane_by_more() -> None:
    rng = np.random.default_rng(0)
    noisy = edges_of(BLOCK) + 0.5 * PIXEL * rng.normal(size=(12, 2, 3))
    planes = planes_of(noisy, np.ones(12), PIXEL)
    assert len(planes) == 6
    for plane in planes:
        assert np.abs(noisy[plane.lines] @ plane.normal - plane.distance).max() < 2 * PIXEL


def test_segments_that_do_not_meet_are_no_plane() -> None:
    apart = sides_of(placed(SQUARE, np.eye(3)))
    middle = apart.mean(axis=1, keepdims=True)
    short = middle + 0.2 * (apart - middle)
    assert planes_of(short, np.ones(4), PIXEL) == ()
