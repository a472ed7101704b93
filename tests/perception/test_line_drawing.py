"""Junctions are of the type that a reader would call them, whichever way the picture is turned."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.perception.line_drawing import Junction, LineDrawing, classify_junction, sort_rays

SD = np.deg2rad(0.3)
NAMED = {
    Junction.END: (30,),
    Junction.STRAIGHT: (20, 200),
    Junction.L: (20, 150),
    Junction.FORK: (90, 210, 330),
    Junction.ARROW: (40, 90, 140),
    Junction.T: (0, 70, 180),
    Junction.K: (0, 40, 120, 180),
    Junction.X: (0, 60, 180, 290),
    Junction.PEAK: (20, 50, 80, 160),
    Junction.MULTI: (0, 80, 170, 275),
}


def of(degrees: tuple[float, ...], sd: float = SD) -> Junction:
    return classify_junction(np.deg2rad(degrees), np.full(len(degrees), sd))


@pytest.mark.parametrize("kind", Junction)
def test_each_type_is_told_from_its_directions(kind: Junction) -> None:
    assert of(NAMED[kind]) is kind


@given(
    st.sampled_from(list(Junction)),
    st.floats(-720, 720),
    st.booleans(),
    st.randoms(use_true_random=False),
)
def test_turned_mirrored_and_counted_otherwise_a_junction_is_the_same(
    kind: Junction, turn: float, mirrored: bool, random: object
) -> None:
    degrees = [(-d if mirrored else d) + turn for d in NAMED[kind]]
    random.shuffle(degrees)  # type: ignore[attr-defined]
    assert of(tuple(degrees)) is kind


@pytest.mark.parametrize(("off", "kind"), [(0.5, Junction.T), (3.0, Junction.FORK)])
def test_a_bar_is_straight_within_what_its_lines_are_known_to(off: float, kind: Junction) -> None:
    assert of((0, 90, 180 + off)) is kind
    # lines that are known ten times worse may be one line
    assert of((0, 90, 180 + off), 10 * SD) is Junction.T
    assert of((0, 90, 180 - off)) is (Junction.T if off < 1 else Junction.ARROW)


@given(st.lists(st.floats(-10, 10), min_size=1, max_size=6))
def test_gaps_go_round_once_and_the_widest_is_last(angles: list[float]) -> None:
    order, gaps = sort_rays(np.array(angles))
    assert sorted(order.tolist()) == list(range(len(angles)))
    assert gaps.sum() == pytest.approx(2 * np.pi)
    assert gaps[-1] == pytest.approx(gaps.max(), abs=1e-5)


@given(st.floats(-1e-12, 1e-12))
def test_of_equal_gaps_rounding_decides_nothing(off: float) -> None:
    # two lines that cross, and three evenly spread
    for degrees in ([10.0, 60.0, 190.0, 240.0], [80.0, 200.0, 320.0]):
        order, _ = sort_rays(np.deg2rad(degrees) + np.eye(len(degrees))[0] * off)
        assert order.tolist() == sort_rays(np.deg2rad(degrees))[0].tolist()


POINTS = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0], [2.0, 2.0], [9.0, 9.0]])


def test_lines_stand_counter_clockwise_as_one_sees_them() -> None:
    # From the upper left corner to the right, down, and slantwise between them; v runs down.
    drawing = LineDrawing.between(POINTS, np.array([[0, 1], [0, 3], [4, 0]]))
    rays = drawing.rays[0]
    assert rays is not None
    assert rays.far.tolist() == [3, 4, 1]
    assert rays.line.tolist() == [1, 2, 0]
    assert rays.type is Junction.ARROW
    assert drawing.rays[5] is None


def test_the_contour_goes_round_all_and_leaves_lines_within_out() -> None:
    lines = np.array([[0, 1], [2, 1], [2, 3], [0, 3], [4, 0], [4, 2], [2, 5]])
    contour = LineDrawing.between(POINTS, lines).contour()
    assert contour == ((0, 1), (1, 2), (2, 3), (3, 0))


def test_what_encloses_nothing_has_no_contour() -> None:
    nothing = np.zeros((0, 2), dtype=np.intp)
    assert LineDrawing.between(POINTS, np.array([[0, 1], [1, 2]])).contour() == ()
    assert LineDrawing.between(POINTS, nothing).contour() == ()


@pytest.mark.parametrize("lines", [[[0, 1], [1, 0]], [[2, 2]]])
def test_doubled_lines_and_loops_are_refused(lines: list[list[int]]) -> None:
    with pytest.raises(ValueError, match="no two lines the same"):
        LineDrawing.between(POINTS, np.array(lines))
