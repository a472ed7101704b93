"""Choices that do not hang on rounding."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.perception.estimation.pose_noise import GROUPS, view_groups
from facetlog.perception.stable_order import (
    TIE,
    at_least,
    choose_farthest_points,
    descending,
    largest,
    ranks,
)
from facetlog.perception.types import FloatArray

# Rounding as of a few operations, and far below TIE.
NOISE = 1e-12


def ring(count: int) -> FloatArray:
    angle = 2 * np.pi * np.arange(count) / count
    return np.column_stack([np.cos(angle), np.sin(angle), np.zeros(count)])


def apart(points: FloatArray) -> FloatArray:
    return np.linalg.norm(points[:, None] - points[None], axis=-1)


def gaps(chosen: list[int], count: int) -> list[int]:
    """Steps from each chosen one to the next round the ring."""
    places = sorted(chosen)
    return [(b - a) % count for a, b in zip(places, places[1:] + places[:1], strict=True)]


@given(st.lists(st.integers(-5, 5), max_size=30), st.integers(0, 1000))
def test_noise_far_below_the_scale_changes_no_rank(values: list[int], seed: int) -> None:
    exact = np.array([*values, 5.0])  # the scale
    noise = NOISE * np.random.default_rng(seed).uniform(-1, 1, len(exact))
    wanted = np.unique(exact, return_inverse=True)[1]
    assert ranks(exact + noise).tolist() == wanted.tolist()
    assert ranks(1e6 * (exact + noise)).tolist() == wanted.tolist()


def test_equal_ones_keep_their_order_and_further_keys_decide_before() -> None:
    assert descending(np.array([1.0, 2.0, 1.0 + 1e-15, 2.0])).tolist() == [1, 3, 0, 2]
    assert largest(np.array([1.0, 1.0 + 1e-15, 1.0]), np.array([0.0, 1.0, 2.0])) == 2


def test_a_limit_is_reached_but_for_rounding() -> None:
    reached = at_least(np.array([3.0, 3.0 - 1e-15, 3.0 - 1e3 * TIE]), 3.0)
    assert reached.tolist() == [True, True, False]


@pytest.mark.parametrize("count", [17, 20, 24, 25, 28, 36, 48, 64])
def test_a_ring_is_divided_evenly(count: int) -> None:
    for seed in range(5):
        noise = NOISE * np.random.default_rng(seed).uniform(-1, 1, (count, 3))
        chosen = choose_farthest_points(apart(ring(count) + noise), 16)
        assert chosen == choose_farthest_points(apart(ring(count)), 16)
        assert len(set(chosen)) == 16
        assert max(gaps(chosen, count)) <= np.ceil(count / 8)
        first_eight = gaps(chosen[:8], count)
        assert max(first_eight) <= np.ceil(count / 4)


def test_copies_are_not_chosen_twice() -> None:
    copied = np.repeat(ring(5), 4, axis=0)
    assert len(choose_farthest_points(apart(copied), 16)) == 5
    assert choose_farthest_points(np.zeros((3, 3)), 2) == [0]


@pytest.mark.parametrize("count", [3, 12, 24, 30])
def test_groups_of_a_ring_do_not_hang_on_rounding(count: int) -> None:
    exact = view_groups(ring(count))
    assert len(set(exact.tolist())) == min(count, GROUPS)
    for seed in range(5):
        noise = NOISE * np.random.default_rng(seed).uniform(-1, 1, (count, 3))
        np.testing.assert_array_equal(view_groups(ring(count) + noise), exact)
