"""Sides that are closed, open or hollow, known from how things are built."""

import numpy as np
import pytest
from numpy.typing import NDArray

from facetlog.perception.facts.levels.levels import (
    find_back,
    hollow,
    measure_closed_sides,
    open_from_two_sides,
)
from facetlog.perception.space.grid import Grid, Lattice

SIZE = 20


def grid(solid: NDArray[np.bool_]) -> Grid:
    nx, ny, nz = solid.shape
    return Grid(Lattice(1.0, np.eye(3), np.zeros(3), (nx, ny, nz)), solid, solid)


def empty() -> NDArray[np.bool_]:
    return np.zeros((SIZE, SIZE, SIZE), dtype=np.bool_)


def test_arms_leave_the_back_at_the_side_whose_opposite_is_open() -> None:
    plan = np.ones((SIZE, SIZE), dtype=np.bool_)
    tall = ~plan
    tall[:, -1] = True  # the back
    tall[:2, 4:] = tall[-2:, 4:] = True  # arms that end before the front
    sides = measure_closed_sides(plan, tall)
    assert sides == pytest.approx((0.8, 0.8, 0.2, 1.0))
    assert find_back(sides) == 3


def test_a_back_behind_its_seat_closes_the_seat_s_side() -> None:
    plan, tall = np.zeros((2, SIZE, SIZE), dtype=np.bool_)
    plan[:, :15] = True
    tall[:10, 18] = True
    assert measure_closed_sides(plan, tall)[3] == pytest.approx(0.5)
    assert measure_closed_sides(plan, tall)[2] == 0.0


@pytest.mark.parametrize(
    ("panels", "seen"),
    [((), 1.0), ((0,), 1.0), ((0, 1), 1.0), ((0, 2), 1.0), ((0, 1, 2), 0.0), ((0, 1, 2, 3), 0.0)],
)
def test_two_sides_without_panels_show_the_middle(panels: tuple[int, ...], seen: float) -> None:
    solid = empty()
    ends = (np.s_[0, :, :], np.s_[-1, :, :], np.s_[:, 0, :], np.s_[:, -1, :])
    for panel in panels:
        solid[ends[panel]] = True
    beside = 0.06 * len(panels)  # of a side the edges of panels beside it are taken
    assert open_from_two_sides(grid(solid), SIZE) == pytest.approx(seen, abs=beside)


def test_a_block_has_no_hollow_side_and_a_recess_makes_one() -> None:
    solid = ~empty()
    assert hollow(grid(solid), on_ground=True) == 0.0
    solid[:5, 2:18, 2:18] = False
    assert hollow(grid(solid), on_ground=True) == pytest.approx(0.8**2)
    solid = ~empty()
    solid[:1, 2:18, 2:18] = False  # no deeper than a panel's frame
    assert hollow(grid(solid), on_ground=True) == 0.0


def test_what_stands_on_the_ground_may_be_open_below() -> None:
    solid = ~empty()
    solid[1:-1, 1:-1, :8] = False
    assert hollow(grid(solid), on_ground=True) == 0.0
    assert hollow(grid(solid), on_ground=False) > 0.8
