"""Planes among exact segments."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import (
    PlaneHypothesis,
    plane_basis,
    plane_hypotheses,
)
from facetlog.robot.rendering.solids import cuboid, pyramid
from facetlog.robot.rendering.views import random_similarity
from tests.perception.detection.line_front_end.block_rig import block_rig
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


def test_a_pyramid_has_five() -> None:
    planes = planes_of(edges_of(pyramid(2.0, 2.0, 2.0)), np.ones(8), PIXEL)
    assert sorted(len(p.lines) for p in planes)[:4] == [3, 3, 3, 3]
    assert max(len(p.lines) for p in planes) == 4


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


def test_the_order_of_the_segments_does_not_matter() -> None:
    order = np.random.default_rng(3).permutation(12)
    one = planes_of(edges_of(BLOCK), np.ones(12), PIXEL)
    other = planes_of(edges_of(BLOCK)[order], np.ones(12), PIXEL)
    assert normals(one) == normals(other)
    assert {frozenset(p.lines) for p in one} == {frozenset(order[p.lines]) for p in other}


def test_the_best_supported_comes_first() -> None:
    edges = edges_of(BLOCK)
    top = (edges[..., 2] == 1.0).all(axis=1)
    first = planes_of(edges, np.where(top, 5.0, 1.0), PIXEL)[0]
    assert sorted(first.lines) == np.nonzero(top)[0].tolist()


def test_noise_of_a_pixel_moves_no_plane_by_more() -> None:
    rng = np.random.default_rng(0)
    noisy = edges_of(BLOCK) + 0.5 * PIXEL * rng.normal(size=(12, 2, 3))
    planes = planes_of(noisy, np.ones(12), PIXEL)
    assert len(planes) == 6
    for plane in planes:
        assert np.abs(noisy[plane.lines] @ plane.normal - plane.distance).max() < 2 * PIXEL


def test_ends_known_badly_may_lie_further_off() -> None:
    edges = edges_of(BLOCK)
    top = np.nonzero((edges[..., 2] == 1.0).all(axis=1))[0]
    edges[top[0], :, 2] += 5 * PIXEL
    covs = exact_ends(edges)
    assert len(planes_of(edges, np.ones(12), PIXEL)) > 0
    sure = plane_hypotheses(edges, covs, np.ones(12), PIXEL)
    covs[top[0], :, 2, 2] = (3 * PIXEL) ** 2
    unsure = plane_hypotheses(edges, covs, np.ones(12), PIXEL)
    assert not any(set(top) <= set(p.lines) for p in sure)
    assert any(set(top) <= set(p.lines) for p in unsure)


def test_two_segments_that_meet_are_no_plane() -> None:
    assert planes_of(edges_of(BLOCK)[:2], np.ones(2), PIXEL) == ()


def test_segments_that_do_not_meet_are_no_plane() -> None:
    apart = sides_of(placed(SQUARE, np.eye(3)))
    middle = apart.mean(axis=1, keepdims=True)
    short = middle + 0.2 * (apart - middle)
    assert planes_of(short, np.ones(4), PIXEL) == ()


def test_parallel_segments_and_none_at_all_are_no_plane() -> None:
    beside = np.array([[[0.0, y, 0], [1, y, 0]] for y in range(5)])
    assert planes_of(beside, np.ones(5), PIXEL) == ()
    assert planes_of(np.zeros((0, 2, 3)), np.zeros(0), PIXEL) == ()


def test_the_edges_of_the_rendered_block_give_its_planes() -> None:
    rig = block_rig()
    planes = planes_of(rig.edges, np.ones(12), rig.pixel)
    assert sorted(len(p.lines) for p in planes) == [4] * 6


@given(st.lists(st.floats(-1, 1), min_size=3, max_size=3).filter(lambda n: np.hypot(*n[:2]) > 0.01))
def test_a_basis_spans_the_plane_across_its_normal(values: list[float]) -> None:
    normal = np.array(values) / np.linalg.norm(values)
    basis = plane_basis(normal)
    np.testing.assert_allclose(basis.T @ basis, np.eye(2), atol=1e-9)
    np.testing.assert_allclose(normal @ basis, 0.0, atol=1e-9)
