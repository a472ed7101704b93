"""Ways round circles, and the order of stops."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import LineString, Point

from facetlog.robot.collecting.route import (
    Circle,
    route_length,
    short_order,
    shortest_route,
)

PLACES = st.tuples(st.floats(-3, 3), st.floats(-3, 3))


def test_the_way_to_the_far_side_is_two_tangents_and_an_arc() -> None:
    way = shortest_route((-2.0, 0.0), (2.0, 0.0), (Circle(0.0, 0.0, 1.0),))
    assert way is not None
    # Two tangents of length sqrt(3), and the third of a half circle between them.
    exact = 2 * math.sqrt(3) + math.pi / 3
    assert route_length(way) == pytest.approx(exact, rel=0.003)


@given(PLACES, PLACES, st.floats(0.1, 1.0))
@settings(max_examples=60)
def test_no_way_enters_a_circle_or_is_longer_than_round_it(
    start: tuple[float, float], end: tuple[float, float], radius: float
) -> None:
    circle = Circle(0.2, -0.1, radius)
    way = shortest_route(start, end, (circle,))
    assert way is not None
    assert (way[0], way[-1]) == (start, end)
    kept = min(radius, circle.distance(start), circle.distance(end))
    # The polygon's sides cut 0.22 % off the radius.
    line = LineString(way) if start != end else Point(start)
    assert line.distance(Point(0.2, -0.1)) >= kept * 0.9975 - 1e-6
    assert route_length(way) <= math.dist(start, end) * (math.pi / 2 + 0.01) + 1e-6


def test_places_that_no_way_leads_to_come_last_in_the_short_order() -> None:
    angles = np.linspace(0, 2 * np.pi, 6, endpoint=False)
    fence = tuple(Circle(float(np.cos(a)), float(np.sin(a)), 0.6) for a in angles)
    places = [(0.0, 0.0), (0.1, 0.0), (4.0, 0.0), (3.0, 0.0)]
    assert short_order((2.0, 0.0), places, fence)[:2] == (3, 2)


@given(st.lists(PLACES, min_size=1, max_size=7))
@settings(max_examples=30)
def test_a_short_order_has_every_place_once_and_is_no_longer_than_as_given(
    places: list[tuple[float, float]],
) -> None:
    order = short_order((0.0, 0.0), places)
    assert sorted(order) == list(range(len(places)))


def test_a_short_order_of_a_shuffled_ring_goes_once_round() -> None:
    angles = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    ring = [(float(np.cos(a)), float(np.sin(a))) for a in angles]
    shuffled = np.random.default_rng(1).permutation(16).tolist()
    circles = (Circle(0.0, 0.0, 0.8),)
    order = short_order((1.05, -0.05), [ring[i] for i in shuffled], circles)
    visited = [shuffled[i] for i in order]
    steps = [(b - a) % 16 for a, b in pairwise(visited)]
    assert set(steps) in ({1}, {15})
