"""Undistorted pictures are what a pinhole would have taken."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.errors import CalibrationError
from facetlog.perception.reading.lens import Distortion, Lens
from facetlog.perception.types import Camera, FloatArray

CAMERA = Camera(320, 240, 260.0, 255.0, 163.0, 118.0)


def _spots(pixels: FloatArray) -> np.ndarray[tuple[int, int], np.dtype[np.uint8]]:
    """A picture with a soft spot at each pixel."""
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    total = sum(np.exp(-((u - x) ** 2 + (v - y) ** 2) / 8) for x, y in pixels)
    return np.asarray(20 + 200 * np.minimum(total, 1), dtype=np.uint8)


def _spot_near(
    image: np.ndarray[tuple[int, int], np.dtype[np.uint8]], at: FloatArray
) -> FloatArray:
    u, v = np.rint(at).astype(int)
    window = image[v - 7 : v + 8, u - 7 : u + 8].astype(float) - 20
    y, x = np.mgrid[v - 7 : v + 8, u - 7 : u + 8]
    return np.array([(window * x).sum(), (window * y).sum()]) / window.sum()


@pytest.mark.parametrize("fisheye", [False, True])
def test_opencvs_projection_lands_where_the_pinhole_sees_it(fisheye: bool) -> None:
    points = np.array([[x, y, 1.0] for x in (-0.35, 0.0, 0.3) for y in (-0.25, 0.0, 0.25)])
    if fisheye:
        coefficients = np.array([0.05, -0.02, 0.003, 0.0005])
        seen = cv2.fisheye.projectPoints(
            points[:, None], np.zeros(3), np.zeros(3), CAMERA.matrix, coefficients
        )[0]
        k1, k2, k3, k4 = coefficients
        lens = Lens(CAMERA, Distortion.FISHEYE, (k1, k2, k3, k4))
    else:
        k1, k2, p1, p2, k3 = coefficients = np.array([0.12, -0.05, 0.002, -0.001, 0.01])
        seen = cv2.projectPoints(points, np.zeros(3), np.zeros(3), CAMERA.matrix, coefficients)[0]
        lens = Lens(CAMERA, Distortion.POLYNOMIAL, (k1, k2, k3, 0.0), (p1, p2))
    picture = lens.undistort(_spots(np.asarray(seen, dtype=np.float64).reshape(-1, 2)))
    pinhole = lens.pinhole
    for point in points:
        expected = (pinhole.matrix @ point)[:2]
        np.testing.assert_allclose(_spot_near(picture, expected), expected, atol=0.1)


@settings(max_examples=60, deadline=None)
@given(st.floats(-0.15, 0.3), st.floats(-0.05, 0.1))
def test_every_pixel_comes_from_within_the_picture(k1: float, k2: float) -> None:
    lens = Lens(CAMERA, Distortion.POLYNOMIAL, (k1, k2, 0.0, 0.0))
    assert lens.pinhole.fx >= CAMERA.fx
    # A black rim would show: the picture is white all over.
    white = np.full((CAMERA.height, CAMERA.width), 255, dtype=np.uint8)
    assert lens.undistort(white).min() == 255


def test_a_pinhole_leaves_the_picture_alone() -> None:
    image = np.zeros((CAMERA.height, CAMERA.width), dtype=np.uint8)
    assert Lens(CAMERA).undistort(image) is image
    assert Lens(CAMERA, Distortion.POLYNOMIAL).pinhole is CAMERA


def test_coefficients_that_fold_the_picture_are_refused() -> None:
    with pytest.raises(CalibrationError, match="folds"):
        _ = Lens(CAMERA, Distortion.POLYNOMIAL, (-50.0, 0.0, 0.0, 0.0)).pinhole
