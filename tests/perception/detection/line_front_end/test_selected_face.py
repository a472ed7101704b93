"""Where a selected face may have neighbours."""

import numpy as np

from facetlog.perception.detection.line_front_end.selected_face import SelectedFace

UP = np.array([0.0, 0.0, 1.0])
SQUARE = np.array([[0.0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]])
NONE = np.zeros((0, 3))


def test_each_side_of_the_outline_and_of_a_hole_may_have_a_neighbour() -> None:
    hole = 1.0 + SQUARE[::-1] / 2.0
    face = SelectedFace(SQUARE, UP, np.ones(3, np.bool_), 1.0, NONE, holes=(hole,))
    assert face.long_sides.shape == (8, 2, 3)


def test_a_curve_has_no_neighbours_and_a_short_hole_has_beside_long_sides() -> None:
    turn = 2 * np.pi * np.arange(40) / 40
    circle = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    face = SelectedFace(circle, UP, np.ones(3, np.bool_), 1.0, NONE, holes=(SQUARE[::-1] / 100,))
    np.testing.assert_allclose(np.ptp(face.long_sides, axis=(0, 1)).max(), 0.04)
    assert len(face.long_sides) == 4
