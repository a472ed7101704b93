"""Ways over known floor: as short as the cells allow, and never over one that is not open."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.exploring.floor_ways import FloorWays, Lattice
from facetlog.robot.collecting.route import route_length

LATTICE = Lattice.of_area((-1.0, -1.0, 4.0, 3.0), 0.1)


def _ways(open_: np.ndarray, here: tuple[float, float] = (0.0, 0.0)) -> FloorWays:
    return FloorWays(LATTICE, open_, open_, here)


def _all() -> np.ndarray:
    return np.ones(LATTICE.shape, np.bool_)


def _wall(left: float, right: float, low: float, high: float) -> np.ndarray:
    x, y = np.moveaxis(LATTICE.middles, -1, 0)
    return (x > left) & (x < right) & (y > low) & (y < high)


def test_an_area_has_cells_of_one_side_from_its_lowest_corner() -> None:
    assert LATTICE.shape == (30, 40)
    assert LATTICE.middles[0, 0] == pytest.approx([-0.95, -0.95])
    assert LATTICE.cell((-0.99, 1.99)) == (29, 0)
    assert not LATTICE.holds(LATTICE.cell((-1.01, 0.0)))


def test_over_open_floor_a_way_is_straight() -> None:
    assert _ways(_all()).route_to((2.5, 1.3)) == ((0.0, 0.0), (2.5, 1.3))


def test_a_way_goes_round_a_wall_and_none_leads_through_a_closed_one() -> None:
    around = _ways(_all() & ~_wall(1.0, 1.3, -1.0, 1.0)).route_to((2.0, 0.0))
    assert around is not None
    assert route_length(around) > 2 * math.hypot(1.0, 1.0)
    closed = _ways(_all() & ~_wall(1.0, 1.3, -1.0, 2.0))
    assert closed.route_to((2.0, 0.0)) is None
    assert math.isinf(closed.length_to((2.0, 0.0)))


def test_no_way_leads_out_of_the_area_or_begins_outside() -> None:
    assert _ways(_all()).route_to((3.5, 0.0)) is None
    assert _ways(_all(), (-5.0, 0.0)).route_to((0.0, 0.0)) is None


def test_a_way_does_not_slip_between_two_corners() -> None:
    open_ = np.zeros(LATTICE.shape, np.bool_)
    open_[10, 10] = open_[11, 11] = True
    here, there = (tuple(LATTICE.middles[k, k].tolist()) for k in (10, 11))
    assert _ways(open_, here).route_to(there) is None


def test_from_a_place_that_is_not_open_it_leaves_the_shortest_way_it_fits_through() -> None:
    open_ = _all() & ~_wall(-0.5, 1.5, -0.5, 0.5)
    # To the left it is nearest, but there it does not fit.
    bare = _all() & ~_wall(-0.5, -0.2, -1.0, 1.0)
    ways = FloorWays(LATTICE, open_, bare, (0.0, 0.0))
    route = ways.route_to((-0.8, 0.0))
    assert route is not None
    assert min(x for x, y in route[:-1] if abs(y) < 0.5) > -0.3
    assert FloorWays(LATTICE, open_, open_, (0.0, 0.0)).route_to((-0.8, 0.0)) is None


def test_it_leaves_by_the_way_it_came_and_where_that_leads_to_nothing_as_from_any_place() -> None:
    open_ = _all() & ~_wall(-0.5, 1.5, -0.5, 0.5)
    came = _wall(-0.05, 0.25, -0.65, 0.05)
    # A narrow place: by the way it came alone.
    route = FloorWays(LATTICE, open_, came, (0.1, 0.0), came).route_to((-0.8, 0.0))
    assert route is not None
    # It began there, and what it came by ends within what is not open.
    began = _wall(-0.05, 0.25, -0.05, 0.15)
    ways = FloorWays(LATTICE, open_, _all(), (0.1, 0.0), began)
    assert ways.route_to((-0.8, 0.0)) is not None
    assert FloorWays(LATTICE, open_, began, (0.1, 0.0), began).route_to((-0.8, 0.0)) is None


def test_where_something_was_found_beside_it_it_goes_back_and_not_on() -> None:
    # It drove along x from -0.8 to 0; the cell in which it stands now is not open any more.
    open_ = _all() & ~_wall(-0.5, 0.6, -1.0, 2.0)
    driven = _wall(-0.9, 0.1, -0.15, 0.15)
    ways = FloorWays(LATTICE, open_, _all(), (0.0, 0.0), open_ & driven, driven)
    assert ways.route_to((-0.8, 0.0)) is not None
    assert ways.route_to((0.8, 0.0)) is None


@given(st.integers(0, 2**32 - 1), st.floats(-0.9, 2.9), st.floats(-0.9, 1.9))
def test_every_place_of_a_way_is_open(seed: int, x: float, y: float) -> None:
    open_ = np.random.default_rng(seed).uniform(size=LATTICE.shape) > 0.15
    here = 0.05, 0.05
    open_[LATTICE.cell(here)] = True
    route = _ways(open_, here).route_to((x, y))
    if route is None:
        return
    assert (route[0], route[-1]) == (here, (x, y))
    for one, other in pairwise(route):
        for share in np.linspace(0.0, 1.0, 2 + round(math.dist(one, other) / 0.05)):
            x, y = (np.array(one) + share * (np.array(other) - np.array(one))).tolist()
            # A corner may be cut by a quarter of a cell.
            beside = [(x + dx, y + dy) for dx in (-0.026, 0.026) for dy in (-0.026, 0.026)]
            assert any(
                open_[LATTICE.cell(each)] for each in beside if LATTICE.holds(LATTICE.cell(each))
            )
