"""What sonars met, in clusters: legs of one table are one, things apart are two."""

import numpy as np
import pytest

from facetlog.exploring.echoes import clusters, within
from facetlog.exploring.floor_ways import Lattice

LATTICE = Lattice.of_area((0.0, 0.0, 6.0, 4.0), 0.1)
GAP = 1.2


def _echoes(*places: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    echoed = np.zeros(LATTICE.shape, np.bool_)
    for place in places:
        echoed[LATTICE.cell(place)] = True
    return echoed, 10.0 * echoed.astype(np.float32)


def test_the_legs_of_a_table_are_one_place_round_its_middle() -> None:
    legs = [(1.05, 1.05), (2.05, 1.05), (1.05, 1.75), (2.05, 1.75)]
    (found,) = clusters(*_echoes(*legs), LATTICE, GAP)
    assert found.middle == pytest.approx([1.55, 1.4])
    assert found.reach == pytest.approx(np.hypot(0.5, 0.35), abs=0.1)


def test_things_that_are_farther_apart_are_two() -> None:
    assert len(list(clusters(*_echoes((1.05, 1.05), (2.65, 1.05)), LATTICE, GAP))) == 2


def test_what_is_too_large_is_cut_at_its_widest_gap_and_a_wall_in_its_middle() -> None:
    (row,) = clusters(*_echoes((1.05, 1.05), (1.25, 1.05), (2.35, 1.15)), LATTICE, GAP)
    one, other = row.halves()
    assert sorted(one.places[:, 0].tolist()) == pytest.approx([1.05, 1.25])
    assert other.middle == pytest.approx([2.35, 1.15])
    (wall,) = clusters(*_echoes(*((2.05, 0.05 + k / 10) for k in range(30))), LATTICE, GAP)
    assert sorted(len(half.places) for half in wall.halves()) == [15, 15]


def test_the_place_that_is_said_of_a_cluster_is_where_something_echoes() -> None:
    corners = [(1.05, 1.05), (2.05, 1.05), (1.05, 2.05)]
    (found,) = clusters(*_echoes(*corners), LATTICE, GAP)
    assert found.nearest.tolist() in [pytest.approx(corner) for corner in corners]


def test_a_single_echo_is_none_yet() -> None:
    echoed, hits = _echoes((1.05, 1.05))
    assert list(clusters(echoed, hits / 10.0, LATTICE, GAP)) == []
    assert list(clusters(np.zeros_like(echoed), hits, LATTICE, GAP)) == []


def test_cells_within_a_distance_are_found_and_none_of_none() -> None:
    echoed, _ = _echoes((3.05, 2.05))
    near = within(echoed, 0.5, LATTICE.side)
    assert near.sum() * 0.01 == pytest.approx(np.pi * 0.25, rel=0.1)
    assert not within(np.zeros_like(echoed), 0.5, LATTICE.side).any()
