import cv2
import numpy as np

from facetlog.perception.detection.block_front_end.localise import (
    binary_picture,
    grow_region,
    localise,
)


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
    found = localise(binary_picture(picture))
    grown = grow_region(picture, found, 150)
    assert abs(found.area_px - 80 * 70) < 60
    assert abs(grown.area_px - 80 * 120) < 400


def test_a_region_does_not_grow_into_its_ground():
    picture = shaded(60)
    found = localise(binary_picture(picture))
    assert abs(grow_region(picture, found, 150).area_px - found.area_px) < 400
