"""From how many places lines of sight passed the cells of a lattice."""

import numpy as np

from facetlog.perception.scene import SightLines
from facetlog.perception.space.grid import Lattice
from facetlog.perception.space.thing_space import count_places_through

LATTICE = Lattice(1.0, np.eye(3), np.zeros(3), (10, 4, 3))
NOTHING = np.zeros(LATTICE.shape, dtype=np.bool_)


def line(origin: list[float], *ends: list[float]) -> SightLines:
    return SightLines(np.array(origin), np.array(ends))


def test_measured_surface_stops_a_line() -> None:
    full = NOTHING.copy()
    full[4, 1, 1] = True
    passed = count_places_through(LATTICE, [line([-5.0, 1.5, 1.5], [20.0, 1.5, 1.5])], full)
    assert passed[:, 1, 1].tolist() == [1, 1, 1, 1, 0, 0, 0, 0, 0, 0]


def test_a_line_may_begin_inside_and_end_at_its_own_place() -> None:
    inside = [4.5, 2.5, 1.5]
    passed = count_places_through(LATTICE, [line(inside, [4.5, 2.5, 20.0], inside)], NOTHING)
    assert passed[4, 2, :].tolist() == [0, 1, 1]
    assert passed.sum() == 2


def test_random_lines_pass_only_cells_that_they_cross() -> None:
    rng = np.random.default_rng(3)
    origin = np.array([-4.0, 7.0, 5.0])
    ends = rng.uniform([-2.0, -3.0, -3.0], [12.0, 6.0, 5.0], (200, 3))
    passed = count_places_through(LATTICE, [SightLines(origin, ends)], NOTHING) > 0
    crossed = np.zeros_like(passed)
    for end in ends:
        steps = np.linspace(origin, end, 4000)
        cells = np.floor(steps[((steps >= 0) & (steps < LATTICE.shape)).all(axis=1)]).astype(int)
        crossed[tuple(cells.T)] = True
    assert not (passed & ~crossed).any()
    assert passed.sum() > 0.7 * crossed.sum()
