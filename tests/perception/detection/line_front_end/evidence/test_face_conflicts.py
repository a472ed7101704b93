"""Faces that cannot both be."""

import numpy as np
import pytest

from facetlog.perception.detection.line_front_end.evidence.face_conflicts import (
    back_to_back,
    blocked,
    overlap,
)

UP = np.array([0.0, 0.0, 1.0])
SQUARE = np.array([[0.0, 0, 0], [10, 0, 0], [10, 10, 0], [0, 10, 0]])


def test_a_face_hides_what_lies_behind_it_and_not_its_own_plane() -> None:
    centres = np.array([[5.0, 5.0, 30.0]])
    inside = SQUARE.mean(axis=0, keepdims=True)
    assert blocked(SQUARE, UP, inside - 3.0 * UP, centres, 0.1).all()
    assert not blocked(SQUARE, UP, inside, centres, 0.1).any()
    assert not blocked(SQUARE, UP, inside + 3.0 * UP, centres, 0.1).any()


@pytest.mark.parametrize(
    ("move", "both"),
    [([0, 0, 0], False), ([9.5, 0, 0], True), ([5, 0, 0], False), ([5, 0, 2], True)],
)
def test_two_faces_share_no_part_of_one_plane(move: list[float], both: bool) -> None:
    other = SQUARE + np.array(move, dtype=float)
    assert overlap(other, UP, SQUARE, UP, 1.0) is not both


def test_a_small_face_on_a_large_one_is_an_overlap_and_a_steep_one_is_none() -> None:
    small = 0.2 * SQUARE + np.array([4.0, 4.0, 0.0])
    assert overlap(small, UP, SQUARE, UP, 1.0)
    steep = small[:, [2, 1, 0]] + np.array([5.0, 0.0, 0.0])
    assert not overlap(steep, np.array([1.0, 0.0, 0.0]), SQUARE, UP, 1.0)


@pytest.mark.parametrize(("above", "both"), [(-0.9, True), (0.0, True), (0.9, False)])
def test_of_the_two_sides_of_a_board_neither_is_before_the_other(above: float, both: bool) -> None:
    lower = SQUARE[::-1] + above * UP
    assert overlap(lower, -UP, SQUARE, UP, 1.0)
    assert back_to_back(lower, -UP, SQUARE, UP, 0.3) is both
    assert back_to_back(SQUARE, UP, lower, -UP, 0.3) is both
    assert not back_to_back(lower[::-1], UP, SQUARE, UP, 0.3)
