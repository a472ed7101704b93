"""Set operations on polygons that GEOS refuses: bow-ties, slivers, sides that all but coincide."""

import re
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import facetlog.perception
from facetlog.perception.line_drawing import LineDrawing
from facetlog.perception.polygons import (
    find_difference,
    find_intersection,
    find_symmetric_difference,
    find_union,
    make_polygon,
    make_valid,
    triangulate,
)
from facetlog.perception.types import FloatArray

BOW_TIE = np.array([[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]])
SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])

# Few places: corners repeat, sides overlap and cross; a shift of 1e-16 to 1e-3.
# Of loops that cross and differ by less than a double holds, GEOS's overlays do not add up.
PLACES = st.integers(-3, 3).map(float) | st.floats(-3.0, 3.0)
SHIFTS = st.integers(3, 14).map(lambda digits: 10.0**-digits)
SIZES = st.sampled_from([1e-9, 1e-3, 1.0, 1e3, 1e9])


@st.composite
def loops(draw: st.DrawFn) -> tuple[FloatArray, FloatArray]:
    """Two loops (k, 2), the second the first with its corners moved by very little, or another."""
    count = draw(st.integers(3, 9))
    one = draw(arrays(np.float64, (count, 2), elements=PLACES))
    moves = draw(arrays(np.float64, (count, 2), elements=st.integers(-99, 99))) / 99.0
    size = draw(SIZES)
    return one * size, (one + draw(SHIFTS) * moves) * size


@given(loops())
def test_no_loops_end_an_operation(pair: tuple[FloatArray, FloatArray]) -> None:
    one, other = (shapely.Polygon(loop) for loop in pair)
    extent = float(np.ptp(np.concatenate(pair), axis=0).max(initial=0.0))
    whole, both = find_union([one, other]).area, find_intersection(one, other).area
    apart = find_symmetric_difference(one, other).area
    assert whole == pytest.approx(both + apart, abs=1e-6 * extent**2)
    assert find_difference(one, other).area <= make_valid(one).area + 1e-6 * extent**2
    filled = shapely.area(shapely.polygons(triangulate(one))).sum()
    assert filled == pytest.approx(make_polygon(pair[0]).area, abs=1e-6 * extent**2)


@given(st.lists(loops(), max_size=4), SIZES)
def test_arrays_are_the_same_as_one_by_one(
    pairs: list[tuple[FloatArray, FloatArray]], size: float
) -> None:
    one = np.array([shapely.Polygon(a) for a, _ in pairs], dtype=np.object_)
    other = np.array([shapely.Polygon(b * size) for _, b in pairs], dtype=np.object_)
    singly = [find_intersection(make_valid(a), b).area for a, b in zip(one, other, strict=True)]
    together = shapely.area(find_intersection(make_valid(one), other))
    extents = [np.abs([a, b * size]).max(initial=0.0) for a, b in pairs]
    assert (np.abs(together - singly) <= 1e-6 * np.square(extents)).all()


def test_what_a_crossed_loop_goes_round_stays() -> None:
    assert make_polygon(BOW_TIE).area == 0.5
    assert find_intersection(shapely.Polygon(BOW_TIE), shapely.Polygon(SQUARE)).area == 0.5
    slit = np.concatenate([4.0 * SQUARE, [[0.0, 0.0]], (1.0 + SQUARE)[[0, 3, 2, 1, 0]]])
    assert make_polygon(slit).area == pytest.approx(15.0)
    assert make_polygon(np.array([[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]])).is_empty


@given(
    arrays(np.float64, (8, 2), elements=PLACES),
    st.lists(st.tuples(st.integers(0, 7), st.integers(0, 7)), max_size=16),
)
def test_a_drawing_of_lines_that_cross_has_a_contour(
    points: FloatArray, pairs: list[tuple[int, int]]
) -> None:
    lines = sorted({(min(a, b), max(a, b)) for a, b in pairs if a != b})
    drawing = LineDrawing.between(points, np.array(lines, dtype=np.intp))
    assert {frozenset(line) for line in drawing.contour()} <= {frozenset(line) for line in lines}


FAILING = re.compile(
    r"shapely\.(intersection|difference|symmetric_difference|union|union_all|coverage_union_all"
    r"|make_valid|constrained_delaunay_triangles|delaunay_triangles|set_precision|build_area)\b"
    r"|GEOSException|\.buffer\(0(\.0)?\)"
)


def test_perception_calls_what_may_fail_in_one_place() -> None:
    (folder,) = facetlog.perception.__path__
    calls = {
        path.name
        for path in Path(folder).rglob("*.py")
        if FAILING.search(path.read_text(encoding="utf-8"))
    }
    assert calls == {"polygons.py"}
