"""Clouds that go all round things, and views of them from one side."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.perception.shapes.clouds.all_sides import covers_all_sides, least_hidden
from facetlog.perception.types import FloatArray
from tests.perception.shapes.sampled_shapes import box_points, sphere_points, turned

NOISE = 0.005
SIZE = (0.7, 0.5, 0.5)
COUNT = 6000


def spacing(area: float) -> float:
    return float(np.sqrt(area / COUNT))


BOX_SPACING = spacing(2.0 * (0.7 * 0.5 + 0.7 * 0.5 + 0.5 * 0.5))


def seen_from(points: FloatArray, eye: FloatArray, radius: float) -> FloatArray:
    """The points of a sphere about the origin that can be seen from a place."""
    distance = float(np.linalg.norm(eye))
    return points[points @ eye / distance >= radius**2 / distance]


@settings(max_examples=5)
@given(st.integers(0, 2**31), st.sampled_from([1e-3, 1.0, 1e3]))
def test_samples_all_over_a_box_go_all_round_in_any_frame_and_unit(seed: int, unit: float) -> None:
    points = unit * turned(box_points(SIZE, COUNT, noise=NOISE), seed)
    assert covers_all_sides(points, noise=unit * NOISE, spacing=unit * BOX_SPACING)


@settings(max_examples=5)
@given(st.integers(0, 2**31))
def test_three_sides_of_a_box_lie_open_to_who_looks_at_their_corner(seed: int) -> None:
    points = turned(box_points(SIZE, COUNT, noise=NOISE, sides=("+x", "+y", "+z")), seed)
    assert not covers_all_sides(points, noise=NOISE, spacing=BOX_SPACING)


@pytest.mark.parametrize("distance", [2.0, 4.0, 20.0])
def test_half_of_a_sphere_seen_from_a_place_lies_open(distance: float) -> None:
    points = sphere_points(1.0, 2 * COUNT, 0.0)
    view = seen_from(points, np.array([0.3, -0.5, 0.8]) * distance, 1.0)
    assert not covers_all_sides(view, noise=NOISE, spacing=spacing(2.0 * np.pi))
    assert covers_all_sides(points, noise=NOISE, spacing=spacing(2.0 * np.pi))


def test_box_with_a_side_missing_goes_round_as_holes_are_allowed() -> None:
    sides = ("-x", "+x", "-y", "+y", "-z")
    points = box_points(SIZE, COUNT, noise=NOISE, sides=sides)
    assert covers_all_sides(points, noise=NOISE, spacing=BOX_SPACING)


def test_a_sheet_hides_nothing_and_a_box_its_smallest_side_at_least() -> None:
    sheet = box_points(SIZE, COUNT, noise=NOISE, sides=("+z",))
    assert least_hidden(sheet, noise=NOISE, spacing=BOX_SPACING) == 0.0
    box = box_points(SIZE, COUNT, noise=NOISE)
    # looked at head-on, when its other sides are seen at their edges
    smallest = 0.5 * 0.5 / (2.0 * (0.7 * 0.5 + 0.7 * 0.5 + 0.5 * 0.5))
    assert least_hidden(box, noise=NOISE, spacing=BOX_SPACING) == pytest.approx(smallest, rel=0.25)


def test_a_thin_top_on_thin_legs_goes_all_round_though_it_hides_little() -> None:
    top = box_points((1.0, 0.6, 0.0), 16_000, noise=NOISE, sides=("+z",))
    legs = [
        box_points((0.01, 0.01, 0.3), 100, seed=k, noise=NOISE) + np.array([x, y, -0.3])
        for k, (x, y) in enumerate([(0.1, 0.1), (0.9, 0.1), (0.1, 0.5), (0.9, 0.5)])
    ]
    table = turned(np.concatenate([top, *legs]))
    apart = float(np.sqrt(0.6 / 16_000))
    assert least_hidden(table, noise=NOISE, spacing=apart) == pytest.approx(0.02, abs=0.01)
    assert covers_all_sides(table, noise=NOISE, spacing=apart)
