"""Hulls and least rectangles of many sets of points, each as it is alone."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from facetlog.perception.surfaces.convex_hulls import Hulls, least_rectangle, least_rectangles

seeds = st.integers(0, 2**32 - 1)
some = settings(max_examples=40)


def sets(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (r, k, 2) of which some are there (r, k): scattered ones, and convex loops."""
    rng = np.random.default_rng(seed)
    flat, there = rng.normal(size=(8, 12, 2)), rng.random((8, 12)) < 0.7
    there[:, :3] = True
    turn = 2.0 * np.pi * np.arange(6) / 6
    flat[:4, :6] = np.column_stack([np.cos(turn), np.sin(turn)]) * rng.uniform(0.5, 2.0, (4, 1, 2))
    there[:4] = np.arange(12) < 6
    return flat, there


def slacks(count: int, slack: float) -> np.ndarray | None:
    return np.full(count, slack) if slack else None


@pytest.mark.parametrize("slack", [0.0, 1e-9])
@some
@given(seeds)
def test_hulls_are_those_of_each_row_alone(slack: float, seed: int) -> None:
    flat, there = sets(seed)
    hulls = Hulls(flat, there, slack=slacks(len(flat), slack))
    for row, (points, own) in enumerate(zip(flat, there, strict=True)):
        wanted = np.flatnonzero(own)[ConvexHull(points[own]).vertices]
        wanted = np.roll(wanted, -int(points[wanted, 0].argmin()))
        assert hulls.places[row, : hulls.sizes[row]].tolist() == wanted.tolist()
        assert (hulls.places[row, hulls.sizes[row] :] == wanted[-1]).all()


@some
@given(seeds)
def test_loops_that_are_known_to_be_convex_are_their_own_hulls(seed: int) -> None:
    flat, there = sets(seed)
    turn = 2.0 * np.pi * np.arange(6) / 6
    flat[:4, :6] = np.column_stack([2.0 * np.cos(turn), np.sin(turn)])
    found, told = Hulls(flat, there), Hulls(flat, there, np.arange(8) < 4)
    np.testing.assert_array_equal(told.of(flat), found.of(flat))


@pytest.mark.parametrize("slack", [0.0, 1e-9])
def test_points_in_a_row_and_points_alone_have_hulls(slack: float) -> None:
    flat = np.array([[[2.0, 0.0], [0.0, 0.0], [1.0, 0.0]], [[3.0, 4.0], [0.0, 0.0], [0.0, 0.0]]])
    there = np.array([[True, True, True], [True, False, False]])
    hulls = Hulls(flat, there, slack=slacks(len(flat), slack))
    assert hulls.places[0, : hulls.sizes[0]].tolist() == [1, 0]
    assert hulls.places[1, : hulls.sizes[1]].tolist() == [0]


def test_corners_nearer_than_the_slack_to_their_neighbours_line_are_left_out() -> None:
    flat = np.array([[[0.0, 0.0], [1.0, -1e-7], [2.0, 0.0], [2.0, 2.0], [1.0, 1.0], [0.0, 2.0]]])
    there = np.ones((1, 6), np.bool_)
    assert Hulls(flat, there, slack=slacks(1, 1e-6)).places[0, :4].tolist() == [0, 2, 3, 5]
    assert Hulls(flat, there, slack=slacks(1, 1e-8)).places[0, :5].tolist() == [0, 1, 2, 3, 5]


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


@pytest.mark.parametrize("seed", range(5))
def test_corners_that_are_one_but_for_rounding_turn_no_rectangle(seed: int) -> None:
    # The corners of a table's top and the feet below them, seen from above.
    rng = np.random.default_rng(seed)
    angle, scale = rng.uniform(0.0, np.pi), 10.0 ** rng.uniform(-3, 3)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    corners = np.array([[0.0, 0.0], [1.2, 0.0], [1.2, 0.8], [0.0, 0.8]]) @ turn.T
    twice = scale * np.concatenate([corners, corners + rng.uniform(-1e-15, 1e-15, (4, 2))])
    _, length, width = least_rectangle(twice)
    assert [length, width] == pytest.approx([1.2 * scale, 0.8 * scale], rel=1e-9)
