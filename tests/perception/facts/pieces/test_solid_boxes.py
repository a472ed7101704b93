"""Relations `beside` and `inside` of boxes whose places are known."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from facetlog.perception.facts.all_facts import fact_rows
from facetlog.perception.facts.pieces.solid_boxes import (
    SolidBox,
    beside,
    inside,
    iter_known_insets,
    iter_known_overlaps,
    iter_known_relations,
)
from facetlog.perception.surfaces.exact_solids.builders import build
from tests.perception.pieces.test_openings import DEPTH, HEIGHT, LINTEL, POST, POSTS, Box, of_boxes

UP = np.array([0.0, 0.0, 1.0])
CELL = 0.02
NONE = np.zeros((3, 2))

extents = st.tuples(*(st.floats(0.05, 1.0),) * 3)
places = st.tuples(*(st.floats(-1.0, 1.0),) * 3)
turns = st.integers(0, 10**6).map(lambda seed: Rotation.random(random_state=seed).as_matrix())


def box(middle: tuple[float, ...], size: tuple[float, ...]) -> SolidBox:
    return SolidBox(np.array(middle), np.eye(3), np.array(size) / 2.0, CELL, NONE)


boxes = st.builds(box, places, extents)


def turned(one: SolidBox, by: np.ndarray) -> SolidBox:
    return replace(one, middle=by @ one.middle, axes=one.axes @ by.T)


@given(boxes, st.floats(0.3, 0.89), turns)
def test_what_is_smaller_about_the_same_middle_is_inside(
    outer: SolidBox, share: float, turn: np.ndarray
) -> None:
    both = [turned(each, turn) for each in (replace(outer, half=share * outer.half), outer)]
    assert inside(both).tolist() == [[True, True], [False, True]]


@given(boxes, extents, st.floats(0.0, 1.0), st.sampled_from([(1, 0, 0), (0, 1, 0), (-1, 0, 0)]))
def test_what_stands_on_one_floor_without_meeting_is_beside_and_not_inside(
    one: SolidBox, size: tuple[float, ...], gap: float, way: tuple[int, ...]
) -> None:
    half = np.array(size) / 2.0
    half[2] = one.half[2]
    middle = one.middle + np.array(way) * (one.half + half + gap)
    both = [one, replace(one, middle=middle, half=half)]
    assert beside(both, UP)[0, 1]
    assert beside(both, UP)[1, 0]
    assert not inside(both)[0, 1]


@given(boxes, st.floats(0.0, 0.5), turns)
def test_what_is_half_sunk_in_is_beside_and_what_is_all_within_is_not(
    one: SolidBox, sunk: float, turn: np.ndarray
) -> None:
    way = np.array([2.0 * (1.0 - sunk) * one.half[0], 0.0, 0.0])
    taller = one.half + np.array([0.0, 0.1, 0.1])
    outer = replace(one, half=taller)
    for middle, is_beside in ((one.middle + way, True), (one.middle, False)):
        both = [turned(each, turn) for each in (replace(one, middle=middle), outer)]
        assert beside(both, turn @ UP)[0, 1] == is_beside
        assert beside(both, turn @ UP)[1, 0] == is_beside


@given(boxes, st.floats(0.0, 0.5), turns)
def test_what_leans_over_another_is_not_beside_it(
    one: SolidBox, low: float, turn: np.ndarray
) -> None:
    above = replace(one, middle=one.middle + np.array([0.0, 0.0, 2.0 * one.half[2] + low]))
    both = [turned(each, turn) for each in (one, above)]
    assert not beside(both, turn @ UP)[0, 1]


def test_what_may_reach_on_in_unseen_space_is_beside_or_inside_nothing_for_certain() -> None:
    post, other = box((0.0, 0.0, 0.5), (0.1, 0.1, 1.0)), box((0.5, 0.0, 0.5), (0.1, 0.1, 1.0))
    room = box((0.0, 0.0, 0.5), (2.0, 2.0, 2.0))
    known = set(iter_known_relations([post, other, room], UP))
    assert {("beside", 0, 1, True), ("beside", 1, 0, True), ("inside", 0, 2, True)} <= known
    assert len(known) == 12
    towards = replace(post, reaches=np.array([[0.0, 2.0], [0.0, 0.0], [0.0, 0.0]]))
    open_ = set(iter_known_relations([towards, other, room], UP))
    assert open_ < known
    assert {(name, *sorted(two)) for name, *two, _ in known - open_} == {
        ("beside", 0, 1),
        ("beside", 0, 2),  # half of it may be out of the room
        ("inside", 0, 1),  # the other may lie within it, as far as it may reach
        ("inside", 0, 2),
    }


def test_a_lamp_hangs_inside_a_gate_between_posts_that_stand_beside_each_other() -> None:
    lamp: Box = ((0.5, 0.0, 0.9), (0.7, DEPTH, 1.1))
    cord: Box = ((0.58, 0.03, 1.1), (0.64, 0.07, HEIGHT - POST))
    scene = of_boxes(*POSTS, LINTEL, lamp, cord)
    rows = fact_rows(scene, {"inside", "beside", "piece_heights"})
    low = {name: round(each, 1) for name, each, _, _ in rows["piece_heights"]}
    within = {(low[a], b) for a, b, known in rows["inside"] if known == "yes"}
    assert within == {(0.9, "o1"), (1.1, "o1")}
    beside_ = {(a, b) for a, b, known in rows["beside"] if known == "yes"}
    posts = [name for name, each in low.items() if each == 0.0]
    assert {tuple(posts), (posts[0], "o1"), (posts[1], "o1")} <= beside_


def _board(x: float, z: float, *, unseen: bool = False) -> SolidBox:
    """A level board of 1 by 1 m, which may go on past its left side."""
    reaches = np.zeros((3, 2))
    reaches[0, 0] = 10.0 * unseen
    half = np.array([0.5, 0.5, 0.01])
    return SolidBox(np.array([x, 0.0, z]), np.eye(3), half, 1e-4, reaches)


@pytest.mark.parametrize(("x", "share"), [(0.0, 1.0), (0.75, 0.25), (1.0, 0.0), (3.0, 0.0)])
def test_boards_of_any_heights_overlap_by_a_share_of_their_plans(x: float, share: float) -> None:
    found = {
        (i, j): s for i, j, s, _ in iter_known_overlaps([_board(0.0, 0.7), _board(x, 0.4)], UP)
    }
    assert found == {(0, 1): pytest.approx(share, abs=1e-3), (1, 0): pytest.approx(share, abs=1e-3)}
    assert not list(iter_known_overlaps([_board(0.0, 0.7), _board(x, 0.4)], None))


def test_an_overlap_is_known_as_far_as_the_ends_of_both_are() -> None:
    sds = []
    for cell in (0.01, 0.02):
        boxes = [replace(_board(x, 0.4 + x), cell=cell) for x in (0.0, 0.75)]
        sds.append(next(sd for *_, sd in iter_known_overlaps(boxes, UP)))
    # Two ends of the overlap along x, less what the width of a metre grows by alike.
    assert sds[0] == pytest.approx(1.5 * 0.01 / math.sqrt(12.0), rel=0.1)
    assert sds[1] == pytest.approx(2.0 * sds[0], rel=0.1)


margins = st.floats(-0.2, 0.2)


@given(boxes, st.lists(margins, min_size=4, max_size=4), turns, st.floats(0.0, 1.0))
def test_what_is_set_back_is_so_by_the_least_of_its_four_margins(
    outer: SolidBox, given_margins: list[float], turn: np.ndarray, rise: float
) -> None:
    scaled = np.array(given_margins) * outer.half.min()
    low = outer.middle - outer.half + (scaled[0], scaled[1], 0.0)
    high = outer.middle + outer.half - (scaled[2], scaled[3], 0.0)
    inner = replace(outer, middle=(low + high) / 2.0 + rise * UP, half=(high - low) / 2.0)
    both = [turned(each, turn) for each in (inner, outer)]
    found = {pair[:2]: pair[2:4] for pair in iter_known_insets(both, turn @ UP)}
    corner = max(scaled[[0, 2]].min(), scaled[[1, 3]].min())
    assert found[0, 1] == pytest.approx((scaled.min(), corner), abs=1e-6)
    assert list(iter_known_insets(both, None)) == []


def test_the_legs_of_a_table_are_set_back() -> None:
    scene = build("table", {"length": 1.2, "width": 0.8, "leg": 0.06})
    rows = fact_rows(scene, {"piece_inset", "carries"})
    insets = {(p, q): (value, corner, sd) for p, q, value, corner, sd in rows["piece_inset"]}
    assert len(rows["carries"]) == 4
    for leg, top in rows["carries"]:
        value, corner, sd = insets[leg, top]
        assert (value, corner) == pytest.approx((0.04, 0.04), abs=3 * sd)
        assert insets[top, leg][0] < -0.5


def test_what_may_reach_on_into_unseen_space_has_no_known_inset() -> None:
    outer = box((0.0, 0.0, 0.0), (1.0, 1.0, 0.1))
    inner = box((0.0, 0.0, -0.2), (0.6, 0.6, 0.1))
    hidden = replace(inner, reaches=np.array([[0.0, 0.3], [0.0, 0.0], [0.0, 0.0]]))
    assert (0, 1) in {(one, other) for one, other, *_ in iter_known_insets([inner, outer], UP)}
    assert (0, 1) not in {pair[:2] for pair in iter_known_insets([hidden, outer], UP)}
