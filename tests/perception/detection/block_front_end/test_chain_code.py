import cv2
import numpy as np
import pytest

from facetlog.perception.detection.block_front_end.localise import (
    chain_length,
    freeman_chain,
    outer_outline,
    outline_shape,
)


def polygon(points: np.ndarray, size: int = 400) -> np.ndarray:
    mask = np.zeros((size, size), np.uint8)
    cv2.fillPoly(mask, [np.rint(points).astype(np.int32)], 255)
    return mask


def turned(points: np.ndarray, degrees: float, scale: float = 1.0) -> np.ndarray:
    c, s = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    return 200 + scale * points @ np.array([[c, s], [-s, c]])


SQUARE = np.array([[-60, -60], [60, -60], [60, 60], [-60, 60]], float)
HEXAGON = 80 * np.array([[np.cos(a), np.sin(a)] for a in np.arange(6) * np.pi / 3])


@pytest.mark.parametrize("degrees", [0, 22.5, 70])
def test_the_length_of_a_square_does_not_depend_on_its_turn(degrees):
    codes = freeman_chain(outer_outline(polygon(turned(SQUARE, degrees))))
    assert chain_length(codes) == pytest.approx(480, rel=0.03)


@pytest.mark.parametrize("degrees", [0, 17])
@pytest.mark.parametrize("scale", [0.5, 1.8])
def test_polygons_score_higher_than_discs_and_blots(degrees, scale):
    disc = np.zeros((400, 400), np.uint8)
    cv2.circle(disc, (200, 200), round(70 * scale), 255, cv2.FILLED)
    angles = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    radius = 60 * scale * (1 + 0.4 * np.sin(5 * angles))
    blot = polygon(200 + radius[:, None] * np.column_stack([np.cos(angles), np.sin(angles)]))
    square = outline_shape(outer_outline(polygon(turned(SQUARE, degrees, scale))))
    hexagon = outline_shape(outer_outline(polygon(turned(HEXAGON, degrees, scale))))
    worst = min(square.score, hexagon.score)
    assert worst > 0.6
    assert worst > outline_shape(outer_outline(disc)).score + 0.1
    assert worst > outline_shape(outer_outline(blot)).score + 0.1


def test_pixels_that_are_not_neighbours_are_no_chain():
    with pytest.raises(ValueError, match="neighbouring"):
        freeman_chain(np.array([[0, 0], [5, 0], [5, 5]]))
