"""Hulls and least rectangles of many sets of points, each as it is alone."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from facetlog.perception.surfaces.convex_hulls import (
    Hulls,
    find_least_rectangle,
    find_least_rectangles,
)

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


@pytest.mark.parametrize("slack", [0.0, 1e-9])
@some
@given(seeds)
def test_hulls_are_those_of_each_row_alone(slack: float, seed: int) -> None:
    flat, there = sets(seed)
    hulls = Hulls(flat, there, slack=slack or None)
    for row, (points, own) in enumerate(zip(flat, there, strict=True)):
        wanted = np.flatnonzero(own)[ConvexHull(points[own]).vertices]
        wanted = np.roll(wanted, -int(points[wanted, 0].argmin()))
        assert hulls.places[row, : hulls.sizes[row]].tolist() == wanted.tolist()
        assert (hulls.places[row, hulls.sizes[row] :] == wanted[-1]).all()


@pytest.mark.parametrize("slack", [0.0, 1e-9])
def test_points_in_a_row_and_points_alone_have_hulls(slack: float) -> None:
    flat = np.array([[[2.0, 0.0], [0.0, 0.0], [1.0, 0.0]], [[3.0, 4.0], [0.0, 0.0], [0.0, 0.0]]])
    there = np.array([[True, True, True], [True, False, False]])
    hulls = Hulls(flat, there, slack=slack or None)
    assert hulls.places[0, : hulls.sizes[0]].tolist() == [1, 0]
    assert hulls.places[1, : hulls.sizes[1]].tolist() == [0]


def test_corners_nearer_than_the_slack_to_their_neighbours_line_are_left_out() -> None:
    flat = np.array([[[0.0, 0.0], [1.0, -1e-7], [2.0, 0.0], [2.0, 2.0], [1.0, 1.0], [0.0, 2.0]]])
    there = np.ones((1, 6), np.bool_)
    assert Hulls(flat, there, slack=1e-6).places[0, :4].tolist() == [0, 2, 3, 5]
    assert Hulls(flat, there, slack=1e-8).places[0, :5].tolist() == [0, 1, 2, 3, 5]


@some
@given(seeds)
def test_least_rectangles_are_those_of_each_row_alone(seed: int) -> None:
    flat, there = sets(seed)
    directions, lengths, widths = find_least_rectangles(flat, there)
    for row, (points, own) in enumerate(zip(flat, there, strict=True)):
        direction, length, width = find_least_rectangle(points[own])
        np.testing.assert_allclose(directions[row], direction, atol=1e-12)
        np.testing.assert_allclose([lengths[row], widths[row]], [length, width], rtol=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_corners_that_are_one_but_for_rounding_turn_no_rectangle(seed: int) -> None:
    # The corners of a table's top and the feet below them, seen from above.
    rng = np.random.default_rng(seed)
    angle, scale = rng.uniform(0.0, np.pi), 10.0 ** rng.uniform(-3, 3)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    corners = np.array([[0.0, 0.0], [1.2, 0.0], [1.2, 0.8], [0.0, 0.8]]) @ turn.T
    twice = scale * np.concatenate([corners, corners + rng.uniform(-1e-15, 1e-15, (4, 2))])
    _, length, width = find_least_rectangle(twice)
    assert [length, width] == pytest.approx([1.2 * scale, 0.8 * scale], rel=1e-9)


def test_hulls_agree_however_many_points_there_are() -> None:
    rng = np.random.default_rng(3)
    points = rng.standard_normal((39, 2))
    inner = 0.01 * rng.standard_normal((60, 2)) + points.mean(axis=0)
    flat = np.stack([np.vstack([points, inner])] * 2)
    hulls = Hulls(flat, np.arange(99) < np.array([[39], [99]]))
    few, many = (set(places.tolist()) for places in hulls.places)
    assert few == many
