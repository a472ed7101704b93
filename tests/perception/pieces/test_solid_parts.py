"""Cells into solid parts: boards, bars and blocks as a person would name them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from facetlog.perception.pieces.pieces import is_convex, join_convex_parts, solid_parts

Cells = NDArray[np.bool_]
TURNS = [(0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1)]


def boxes(shape: tuple[int, int, int], *corners: tuple[tuple[int, int], ...]) -> Cells:
    """Boxes of cells, each from and to along x, y and z."""
    cells = np.zeros(shape, dtype=np.bool_)
    for (x0, x1), (y0, y1), (z0, z1) in corners:
        cells[x0:x1, y0:y1, z0:z1] = True
    return cells


def table(top: int = 2) -> Cells:
    legs = [((x, x + 2), (y, y + 2), (0, 24)) for x in (1, 37) for y in (1, 21)]
    return boxes((40, 24, 24 + top), *legs, ((0, 40), (0, 24), (24, 24 + top)))


def sizes(parts: NDArray[np.intp]) -> list[int]:
    return np.bincount(parts.ravel())[1:].tolist()


@pytest.mark.parametrize("turn", TURNS)
def test_a_top_and_four_legs_are_five_parts_whichever_way_it_lies(
    turn: tuple[int, int, int],
) -> None:
    cells = table().transpose(turn)
    assert sizes(solid_parts(cells)) == [40 * 24 * 2, *[2 * 2 * 24] * 4]


def test_a_slope_in_steps_of_cells_is_one_part() -> None:
    x, _, z = np.indices((40, 20, 20))
    cells = z < 20 - x // 2
    assert is_convex(cells)
    assert sizes(solid_parts(cells)) == [int(cells.sum())]


def test_two_halves_of_a_block_are_joined_and_two_arms_of_an_angle_are_not() -> None:
    parts = np.zeros((20, 6, 20), dtype=np.intp)
    parts[:10, :, :6], parts[10:, :, :6] = 1, 2
    assert sizes(join_convex_parts(parts)) == [20 * 6 * 6]
    parts[:6, :, 6:] = 3
    assert sorted(size for size in sizes(join_convex_parts(parts)) if size) == [
        6 * 6 * 14,
        20 * 6 * 6,
    ]


cuboids = st.tuples(*[st.tuples(st.integers(0, 14), st.integers(1, 10))] * 3)


@settings(max_examples=60)
@given(some=st.lists(cuboids, min_size=1, max_size=6))
@pytest.mark.slow
def test_parts_divide_what_is_solid_the_largest_first(
    some: list[tuple[tuple[int, int], ...]],
) -> None:
    ends = [tuple((low, low + size) for low, size in one) for one in some]
    cells = boxes((24, 24, 24), *ends)
    parts = solid_parts(cells)
    assert np.array_equal(parts > 0, cells)
    found = sizes(parts)
    assert found == sorted(found, reverse=True)
    assert min(found) > 0
