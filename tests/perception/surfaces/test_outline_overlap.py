"""Outlines as arrays against shapely: what two share, what they hold, how far points are off."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.perception.surfaces.outline_overlap import (
    Outlines,
    find_convex_loops,
    measure_loop_distances,
)

seeds = st.integers(0, 2**32 - 1)
some = settings(max_examples=60)


def ngon(rng: np.random.Generator, count: int) -> np.ndarray:
    """A convex loop (count, 2) round somewhere near the origin."""
    turn = 2.0 * np.pi * (np.arange(count) + rng.uniform(0.1, 0.9, count)) / count
    radii = rng.uniform(0.5, 2.0, 2)
    return np.column_stack([np.cos(turn), np.sin(turn)]) * radii + rng.normal(size=2)


def padded(loops: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Loops as one array, shorter ones repeating their last corner, and their sizes."""
    longest = max(map(len, loops))
    table = [np.concatenate([loop, np.repeat(loop[-1:], longest - len(loop), 0)]) for loop in loops]
    return np.array(table), np.array([len(loop) for loop in loops])


def outlines(loops: list[np.ndarray]) -> Outlines:
    table, sizes = padded(loops)

    def rings_of(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        own = [loops[row] for row in rows]
        return np.concatenate(own), sizes[rows], np.arange(len(rows))

    return Outlines.of(table, sizes, np.ones(len(loops), np.bool_), rings_of)


def many(seed: int, count: int = 12) -> tuple[np.random.Generator, list[np.ndarray]]:
    rng = np.random.default_rng(seed)
    loops = [ngon(rng, int(rng.integers(3, 9))) for _ in range(count)]
    return rng, [loop[::-1] if rng.random() < 0.5 else loop for loop in loops]


@some
@given(seeds)
def test_shared_areas_are_those_of_shapely(seed: int) -> None:
    (_, first), (_, second) = many(seed), many(seed + 1)
    # The same outline, and one that shares a side, are where clipping is touchy.
    second[0], second[1] = first[0], first[1] + (first[1][1] - first[1][0])
    found = outlines(first).compute_shared_areas(outlines(second))
    wanted = [
        shapely.Polygon(a).intersection(shapely.Polygon(b)).area
        for a, b in zip(first, second, strict=True)
    ]
    assert found == pytest.approx(wanted, rel=1e-9, abs=1e-12)


def test_what_is_not_convex_shares_what_shapely_says() -> None:
    ell = np.array([[0.0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]])
    square = np.array([[0.5, 0.5], [2.0, 0.5], [2.0, 2.0], [0.5, 2.0]])
    both = outlines([ell, square])
    assert both.convex.tolist() == [False, True]
    assert both.areas.tolist() == [3.0, 2.25]
    assert both.compute_shared_areas(outlines([square, ell])) == pytest.approx([1.25, 1.25])


@some
@given(seeds)
def test_points_are_held_as_shapely_says(seed: int) -> None:
    rng, loops = many(seed)
    loops[0] = np.array([[0.0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]])  # not convex
    where = rng.normal(size=(len(loops), 20, 2)) * 1.5
    wanted = [
        shapely.intersects_xy(shapely.Polygon(a), b) for a, b in zip(loops, where, strict=True)
    ]
    assert (outlines(loops).hold(where) == wanted).all()


@some
@given(seeds)
def test_distances_from_convex_loops_are_those_of_shapely(seed: int) -> None:
    rng, _ = many(seed)
    loops = [ngon(rng, int(rng.integers(3, 9))) for _ in range(6)]
    where = rng.normal(size=(len(loops), 20, 2)) * 2.0
    outside, rim = measure_loop_distances(*padded(loops), where)
    dots = shapely.points(where)
    polygons = np.array([shapely.Polygon(loop) for loop in loops])[:, None]
    np.testing.assert_allclose(outside, shapely.distance(dots, polygons), atol=1e-12)
    np.testing.assert_allclose(rim, shapely.distance(dots, shapely.boundary(polygons)), atol=1e-12)


def test_only_loops_that_turn_left_once_round_are_convex() -> None:
    turn = 2.0 * np.pi * np.arange(5) / 5
    pentagon = np.column_stack([np.cos(turn), np.sin(turn)])
    dart = np.array([[0.0, 0.0], [2.0, 0.0], [0.5, 0.5], [0.0, 2.0], [-1.0, 1.0]])
    loops, sizes = padded([pentagon, pentagon[::-1], pentagon[[0, 2, 4, 1, 3]], dart, pentagon[:4]])
    assert find_convex_loops(loops, sizes).tolist() == [True, False, False, False, True]
