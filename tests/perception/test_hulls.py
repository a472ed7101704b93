"""Hulls and least rectangles of many sets of points, each as it is alone."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.perception.flat_faces import hull_indices
from facetlog.perception.hulls import Hulls, least_rectangle, least_rectangles

seeds = st.integers(0, 2**32 - 1)
some = settings(max_examples=40, deadline=None)


def sets(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (r, k, 2) of which some are there (r, k): scattered ones, and convex loops."""
    rng = np.random.default_rng(seed)
    flat, there = rng.normal(size=(8, 12, 2)), rng.random((8, 12)) < 0.7
    there[:, :3] = True
    turn = 2.0 * np.pi * np.arange(6) / 6
    flat[:4, :6] = np.column_stack([np.cos(turn), np.sin(turn)]) * rng.uniform(0.5, 2.0, (4, 1, 2))
    there[:4] = np.arange(12) < 6
    return flat, there


@some
@given(seeds)
def test_hulls_are_those_of_each_row_alone(seed: int) -> None:
    flat, there = sets(seed)
    hulls = Hulls(flat, there)
    for row, (points, own) in enumerate(zip(flat, there, strict=True)):
        places = np.flatnonzero(own)
        wanted = places[hull_indices(points[own])].tolist()
        assert hulls.places[row, : hulls.sizes[row]].tolist() == wanted


@some
@given(seeds)
def test_least_rectangles_are_those_of_each_row_alone(seed: int) -> None:
    flat, there = sets(seed)
    directions, lengths, widths = least_rectangles(flat, there)
    for row, (points, own) in enumerate(zip(flat, there, strict=True)):
        direction, length, width = least_rectangle(points[own])
        np.testing.assert_allclose(directions[row], direction, atol=1e-12)
        np.testing.assert_allclose([lengths[row], widths[row]], [length, width], rtol=1e-12)


def test_a_round_outline_beside_a_quad_has_its_own_rectangle() -> None:
    turn = 2.0 * np.pi * np.arange(100) / 100
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    quad = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [0.0, 1.0]])
    flat, there = np.zeros((2, 100, 2)), np.ones((2, 100), np.bool_)
    flat[0], flat[1, :4], there[1, 4:] = circle, quad, False
    _, lengths, widths = least_rectangles(flat, there)
    np.testing.assert_allclose(lengths, [2.0, 3.0], rtol=2e-3)
    np.testing.assert_allclose(widths, [2.0, 1.0], rtol=2e-3)
