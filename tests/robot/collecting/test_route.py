"""Ways round circles, and the order of stops."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import LineString, Point

from facetlog.robot.collecting.route import (
    Circle,
    find_shortest_route,
    measure_route,
)

PLACES = st.tuples(st.floats(-3, 3), st.floats(-3, 3))


def test_the_way_to_the_far_side_is_two_tangents_and_an_arc() -> None:
    way = find_shortest_route((-2.0, 0.0), (2.0, 0.0), (Circle(0.0, 0.0, 1.0),))
    assert way is not None
    # Two tangents of length sqrt(3), and the third of a half circle between them.
    exact = 2 * math.sqrt(3) + math.pi / 3
    assert measure_route(way) == pytest.approx(exact, rel=0.003)


@given(PLACES, PLACES, st.floats(0.1, 1.0))
@settings(max_examples=60)
def test_no_way_enters_a_circle_or_is_longer_than_round_it(
    start: tuple[float, float], end: tuple[float, float], radius: float
) -> None:
    circle = Circle(0.2, -0.1, radius)
    way = find_shortest_route(start, end, (circle,))
    assert way is not None
    assert (way[0], way[-1]) == (start, end)
    kept = min(radius, circle.distance(start), circle.distance(end))
    # The polygon's sides cut 0.22 % off the radius.
    line = LineString(way) if start != end else Point(start)
    assert line.distance(Point(0.2, -0.1)) >= kept * 0.9975 - 1e-6
    assert measure_route(way) <= math.dist(start, end) * (math.pi / 2 + 0.01) + 1e-6


def test_of_two_circles_neither_is_entered() -> None:
    circles = (Circle(0.0, 0.0, 0.5), Circle(1.5, 0.3, 0.6))
    way = find_shortest_route((-1.0, 0.0), (3.0, 0.2), circles)
    assert way is not None
    for circle in circles:
        middle = Point(circle.x, circle.y)
        assert LineString(way).distance(middle) >= circle.radius * 0.997
