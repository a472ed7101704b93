"""Thresholds, the shape of outlines by chain code, the object and its faces in the shade."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from facetlog.perception.detection.block_front_end.localise import (
    PAPER_THRESHOLD,
    find_otsu_threshold,
    find_valley_threshold,
    grow_region,
    localise,
    outline_score,
    threshold_picture,
)

pictures = hnp.arrays(np.uint8, hnp.array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=12))


def two_greys(dark: float, bright: float) -> np.ndarray:
    rng = np.random.default_rng(0)
    picture = rng.normal(dark, 5, (120, 160))
    picture[30:70, 40:90] = rng.normal(bright, 5, (40, 50))
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)


@given(pictures, st.integers(0, 255))
def test_at_the_threshold_is_white_and_below_it_black(picture, threshold):
    binary = threshold_picture(picture, threshold)
    assert ((binary == 255) == (picture >= threshold)).all()
    assert set(np.unique(binary)) <= {0, 255}


def test_the_papers_threshold_is_the_default():
    assert PAPER_THRESHOLD == 150
    assert (threshold_picture(np.array([[149, 150]], np.uint8)) == [[0, 255]]).all()


@pytest.mark.parametrize("choose", [find_otsu_threshold, find_valley_threshold])
@pytest.mark.parametrize(("dark", "bright"), [(20, 90), (150, 220)])
def test_a_chosen_threshold_parts_two_greys(choose, dark, bright):
    picture = two_greys(dark, bright)
    binary = threshold_picture(picture, choose(picture))
    truth = np.zeros(picture.shape, dtype=bool)
    truth[30:70, 40:90] = True
    assert ((binary > 0) == truth).mean() > 0.99


def polygon(points: np.ndarray, size: int = 400) -> np.ndarray:
    mask = np.zeros((size, size), np.uint8)
    cv2.fillPoly(mask, [np.rint(points).astype(np.int32)], 255)
    return mask


def turned(points: np.ndarray, degrees: float, scale: float = 1.0) -> np.ndarray:
    c, s = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    return 200 + scale * points @ np.array([[c, s], [-s, c]])


SQUARE = np.array([[-60, -60], [60, -60], [60, 60], [-60, 60]], float)
HEXAGON = 80 * np.array([[np.cos(a), np.sin(a)] for a in np.arange(6) * np.pi / 3])


@pytest.mark.parametrize("degrees", [0, 17])
@pytest.mark.parametrize("scale", [0.5, 1.8])
def test_polygons_score_higher_than_discs_and_blots(degrees, scale):
    disc = np.zeros((400, 400), np.uint8)
    cv2.circle(disc, (200, 200), round(70 * scale), 255, cv2.FILLED)
    angles = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    radius = 60 * scale * (1 + 0.4 * np.sin(5 * angles))
    blot = polygon(200 + radius[:, None] * np.column_stack([np.cos(angles), np.sin(angles)]))
    worst = min(outline_score(polygon(turned(s, degrees, scale))) for s in (SQUARE, HEXAGON))
    assert worst > 0.6
    assert worst > outline_score(disc) + 0.1
    assert worst > outline_score(blot) + 0.1
    assert outline_score(np.zeros((9, 9), np.uint8)) == 0.0


def black(height: int = 240, width: int = 320) -> np.ndarray:
    return np.zeros((height, width), np.uint8)


def test_the_largest_white_region_is_the_object():
    picture = black()
    picture[60:140, 90:200] = 255
    picture[10:16, 10:20] = 255
    found = localise(picture)
    assert found
    assert found.area_px == 80 * 110
    assert found.mask[12, 12] == 0


def test_nothing_bright_is_a_reason_not_an_object():
    found = localise(black())
    assert not found
    assert "bright" in found.reason


def test_of_two_large_bright_regions_the_better_shape_is_the_object():
    picture = black()
    picture[60:140, 30:130] = 255
    angles = np.linspace(0, 2 * np.pi, 300, endpoint=False)
    radius = 55 * (1 + 0.45 * np.sin(7 * angles))
    blot = [230, 110] + radius[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    cv2.fillPoly(picture, [np.rint(blot).astype(np.int32)], 255)
    found = localise(picture)
    assert found
    assert found.mask[100, 80] == 255
    assert found.mask[110, 230] == 0
    assert abs(found.area_px - 8000) < 400


def test_the_window_scheme_ignores_a_thin_bridge_and_threads():
    picture = black()
    picture[60:140, 30:130] = 255
    picture[::6, 160:320] = 255
    picture[:, 160:163] = 255
    found = localise(picture)
    assert found
    assert found.mask[100, 80] == 255
    assert found.mask[100, 250] == 0


def test_holes_belong_to_the_object():
    picture = black()
    picture[60:140, 90:200] = 255
    picture[90:100, 120:150] = 0
    assert localise(picture).area_px == 80 * 110


def shaded(dark: int) -> np.ndarray:
    rng = np.random.default_rng(0)
    picture = rng.normal(60, 4, (240, 320))
    picture[60:140, 90:160] = rng.normal(200, 4, (80, 70))
    picture[60:140, 160:210] = rng.normal(dark, 4, (80, 50))
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)


def test_a_face_below_the_threshold_is_grown_into():
    picture = shaded(130)
    found = localise(threshold_picture(picture))
    grown = grow_region(picture, found, 150)
    assert abs(found.area_px - 80 * 70) < 60
    assert abs(grown.area_px - 80 * 120) < 400


def test_a_region_does_not_grow_into_its_ground():
    picture = shaded(60)
    found = localise(threshold_picture(picture))
    assert abs(grow_region(picture, found, 150).area_px - found.area_px) < 400
