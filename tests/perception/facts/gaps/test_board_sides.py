"""The two sides of a board belong to one thing, whatever edges between them were not found."""

import pytest

from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids.polyhedra import polyhedron, together
from tests.perception.facts.scene_values import faces_of_things, on_ground


def leaf(x: float, way: int, low: float = 0.0, side: float = 0.0) -> Scene:
    """An upright rectangle at x that looks along the x axis (way 1) or against it (-1)."""
    corners = [(x, side, low), (x, side + 0.4, low), (x, side + 0.4, 0.9), (x, side, 0.9)]
    return polyhedron(corners[::way], [(0, 1, 2, 3)])


def test_two_sides_of_a_board_are_one_thing() -> None:
    assert faces_of_things(on_ground(together(leaf(0.0, -1), leaf(0.04, 1)))) == [(0, 1)]


@pytest.mark.parametrize(
    "other",
    [
        leaf(0.3, 1),  # too far behind for a board
        leaf(0.04, -1),  # looks the same way
        leaf(-0.04, 1),  # they look at each other
        leaf(0.04, 1, side=0.3),  # mostly beside it
    ],
)
def test_others_are_two(other: Scene) -> None:
    assert faces_of_things(on_ground(together(leaf(0.0, -1), other))) == [(0,), (1,)]


def test_a_seat_belongs_to_what_holds_the_front_of_its_back() -> None:
    # The front ends above the ground and is carried by the seat, the rear goes down to it.
    seat = [(0.0, 0.0, 0.4), (0.4, 0.0, 0.4), (0.4, 0.4, 0.4), (0.0, 0.4, 0.4)]
    leg = [(0.35, 0.1, 0.0), (0.35, 0.3, 0.0), (0.35, 0.3, 0.38), (0.35, 0.1, 0.38)]
    stool = polyhedron([*seat, *leg], [(0, 1, 2, 3), (4, 5, 6, 7)])
    chair = together(stool, leaf(0.0, 1, 0.41), leaf(-0.03, -1))
    assert faces_of_things(on_ground(chair)) == [(0, 1, 2, 3)]
