"""Where a level board may lie between two upright faces."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from facetlog.perception.detection.line_front_end.planes.board_places import (
    BoardPlaces,
    board_places,
)
from facetlog.perception.flat_faces import vector_area
from facetlog.perception.types import FloatArray

UP = np.array([0.0, 0.0, 1.0])
PIXEL, LEAST = 0.01, 0.1


@dataclass(frozen=True)
class Panel:
    corners: FloatArray
    normal: FloatArray


def panel(x: float, depth: float = 0.4, height: float = 1.0, facing: float = 1.0) -> Panel:
    """Across the first axis at x, from the ground up and from the second axis on."""
    ring = np.array([[x, 0, 0], [x, depth, 0], [x, depth, height], [x, 0, height]])
    return Panel(ring if facing > 0 else ring[::-1].copy(), np.array([facing, 0.0, 0.0]))


def between(*panels: Panel) -> BoardPlaces:
    return board_places(panels, UP, PIXEL, LEAST)


def test_a_board_may_lie_at_each_height_of_both_from_the_front_to_the_rear() -> None:
    places = between(panel(0.0), panel(0.8))
    heights = places.rings[:, :, 2]
    assert np.ptp(heights, axis=1).max() == pytest.approx(0.0, abs=1e-12)
    assert heights[:, 0] == pytest.approx(np.arange(PIXEL / 2, 1.0, PIXEL))
    assert np.abs(places.rings[..., 0]).max() == pytest.approx(0.8)
    areas = np.array([vector_area(ring) for ring in places.rings])
    assert areas == pytest.approx(np.broadcast_to([0.0, 0.0, 0.32], areas.shape))


def test_the_free_sides_go_from_face_to_face() -> None:
    sides = between(panel(0.0), panel(0.8)).free_sides
    assert np.ptp(sides[..., 0], axis=2) == pytest.approx(0.8)
    assert np.ptp(sides[..., 1], axis=2) == pytest.approx(0.0)
    assert sorted(sides[0, :, 0, 1]) == pytest.approx([0.0, 0.4])


def test_it_is_as_high_and_as_deep_as_both_faces_are() -> None:
    places = between(panel(0.0, depth=0.4, height=0.5), panel(0.8, depth=0.3, height=1.0))
    assert places.rings[..., 2].max() == pytest.approx(0.5, abs=PIXEL)
    assert places.rings[..., 1].max() == pytest.approx(0.3)


@pytest.mark.parametrize(
    "other",
    [
        panel(0.05),  # the other side of the same board
        Panel(
            panel(0.8).corners + np.array([0.0, 0.35, 0.0]), np.array([1.0, 0.0, 0.0])
        ),  # hardly opposite
        Panel(panel(0.8).corners[:, [1, 0, 2]], np.array([0.0, 1.0, 0.0])),  # across it
        Panel(panel(0.8).corners[:, [2, 1, 0]], UP),  # level
        panel(0.8, depth=0.05),  # too narrow for a board
    ],
    ids=["near", "beside", "across", "level", "narrow"],
)
def test_there_is_no_place_where_two_faces_do_not_stand_opposite(other: Panel) -> None:
    assert not len(between(panel(0.0), other).rings)


def test_two_sides_of_one_panel_make_no_places_of_their_own() -> None:
    one = between(panel(0.0), panel(0.8))
    both = between(panel(0.0), panel(0.02, facing=-1.0), panel(0.8), panel(0.78, facing=-1.0))
    assert len(both.rings) == len(one.rings)
    three = between(panel(0.0), panel(0.8), panel(1.6))
    assert len(np.unique(three.pair)) == 3


def test_places_turn_with_the_faces() -> None:
    turned = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()
    panels = [panel(0.0), panel(0.8)]
    moved = [Panel(p.corners @ turned.T, turned @ p.normal) for p in panels]
    places = board_places(moved, turned @ UP, PIXEL, LEAST)
    assert places.rings == pytest.approx(between(*panels).rings @ turned.T)


def test_no_face_has_no_places() -> None:
    assert between().rings.shape == (0, 4, 3)
