"""Undistorted pictures are what a pinhole would have taken."""

from collections.abc import Callable

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.errors import CalibrationError
from facetlog.perception.reading.lens import Distortion, Lens
from facetlog.perception.types import Camera, FloatArray

CAMERA = Camera(320, 240, 260.0, 255.0, 163.0, 118.0)

RAYS = np.array([[x, y, 1.0] for x in (-0.35, 0.0, 0.3) for y in (-0.25, 0.0, 0.25)])


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


def _opencv(coefficients: list[float]) -> FloatArray:
    seen = cv2.projectPoints(RAYS, np.zeros(3), np.zeros(3), CAMERA.matrix, np.array(coefficients))
    return np.asarray(seen[0], dtype=np.float64).reshape(-1, 2)


def _opencv_fisheye(coefficients: list[float]) -> FloatArray:
    none = np.zeros(3)
    seen, _ = cv2.fisheye.projectPoints(
        RAYS[:, None], none, none, CAMERA.matrix, np.array(coefficients)
    )
    return np.asarray(seen, dtype=np.float64).reshape(-1, 2)


def _in_pixels(x: FloatArray, y: FloatArray) -> FloatArray:
    return np.stack([CAMERA.fx * x + CAMERA.cx, CAMERA.fy * y + CAMERA.cy], axis=-1)


def _fov(omega: float) -> FloatArray:
    """By Devernay and Faugeras: the radius is atan(2 r tan(ω / 2)) / ω."""
    r = np.hypot(RAYS[:, 0], RAYS[:, 1])
    angle = np.arctan2(RAYS[:, 1], RAYS[:, 0])
    radius = np.arctan(2 * r * np.tan(omega / 2)) / omega
    return _in_pixels(radius * np.cos(angle), radius * np.sin(angle))


def _thin_prism_fisheye(k: list[float], p: list[float], s: list[float]) -> FloatArray:
    """By COLMAP's models.h, written out: all terms of the ray's angle laid off along its way."""
    theta = np.arctan(np.hypot(RAYS[:, 0], RAYS[:, 1]))
    angle = np.arctan2(RAYS[:, 1], RAYS[:, 0])
    u, v = theta * np.cos(angle), theta * np.sin(angle)
    radial = sum(c * theta ** (2 * n) for n, c in enumerate(k, start=1))
    du = u * radial + 2 * p[0] * u * v + p[1] * (theta**2 + 2 * u**2) + s[0] * theta**2
    dv = v * radial + 2 * p[1] * u * v + p[0] * (theta**2 + 2 * v**2) + s[1] * theta**2
    return _in_pixels(u + du, v + dv)


def _radial_first(k: list[float], p: list[float], s: list[float]) -> FloatArray:
    """By Project Aria's Fisheye624: the radial terms first, the others of what they make."""
    theta = np.arctan(np.hypot(RAYS[:, 0], RAYS[:, 1]))
    angle = np.arctan2(RAYS[:, 1], RAYS[:, 0])
    far = theta + sum(c * theta ** (2 * n + 1) for n, c in enumerate(k, start=1))
    x, y = far * np.cos(angle), far * np.sin(angle)
    xd = x + p[0] * (2 * x**2 + far**2) + 2 * p[1] * x * y + s[0] * far**2 + s[1] * far**4
    yd = y + p[1] * (2 * y**2 + far**2) + 2 * p[0] * x * y + s[2] * far**2 + s[3] * far**4
    return _in_pixels(xd, yd)


def _where(undistorted: Callable[[FloatArray], FloatArray]) -> FloatArray:
    """Where radii lie whose undistorted ones are given by a formula, by a table of it."""
    table = np.linspace(0, 1, 100_001)
    r = np.hypot(RAYS[:, 0], RAYS[:, 1])
    angle = np.arctan2(RAYS[:, 1], RAYS[:, 0])
    radius = np.interp(r, undistorted(table), table)
    return _in_pixels(radius * np.cos(angle), radius * np.sin(angle))


def _unified(alpha: float, beta: float) -> FloatArray:
    """By Khomutenko, Garcia and Martinet: x over alpha sqrt(beta r² + z²) + (1 - alpha) z."""
    x, y, z = RAYS.T
    depth = alpha * np.sqrt(beta * (x * x + y * y) + z * z) + (1 - alpha) * z
    return _in_pixels(x / depth, y / depth)


POLYNOMIAL, FISHEYE = Distortion.POLYNOMIAL, Distortion.FISHEYE
LENSES = {
    "polynomial": (
        Lens(CAMERA, POLYNOMIAL, (0.12, -0.05, 0.01, 0.0), (0.002, -0.001)),
        _opencv([0.12, -0.05, 0.002, -0.001, 0.01]),
    ),
    "fisheye": (
        Lens(CAMERA, FISHEYE, (0.05, -0.02, 0.003, 0.0005)),
        _opencv_fisheye([0.05, -0.02, 0.003, 0.0005]),
    ),
    "rational": (
        Lens(CAMERA, POLYNOMIAL, (0.3, -0.1, 0.02, 0), (0.002, -0.001), (0.2, -0.05, 0.01)),
        _opencv([0.3, -0.1, 0.002, -0.001, 0.02, 0.2, -0.05, 0.01]),
    ),
    "wide angle": (Lens(CAMERA, Distortion.FOV, projection=(0.9,)), _fov(0.9)),
    "tele": (Lens(CAMERA, Distortion.FOV, projection=(1e-3,)), _fov(1e-3)),
    "thin prism": (
        Lens(CAMERA, FISHEYE, (0.05, -0.02, 0.01, 0.003), (0.01, -0.02), prism=(0.02, 0, -0.03, 0)),
        _thin_prism_fisheye([0.05, -0.02, 0.01, 0.003], [0.01, -0.02], [0.02, -0.03]),
    ),
    "radial first": (
        Lens(
            *(CAMERA, Distortion.FISHEYE_RADIAL_FIRST, (0.3, -0.2, 0.1, 0.05, -0.3, 0.2)),
            tangential=(0.01, -0.02),
            prism=(0.02, 0.05, -0.03, -0.06),
        ),
        _radial_first([0.3, -0.2, 0.1, 0.05, -0.3, 0.2], [-0.02, 0.01], [0.02, 0.05, -0.03, -0.06]),
    ),
    "division, barrel": (
        Lens(CAMERA, Distortion.DIVISION, projection=(-0.3,)),
        _where(lambda d: d / (1 - 0.3 * d * d)),
    ),
    "division, cushion": (
        Lens(CAMERA, Distortion.DIVISION, projection=(0.1,)),
        _where(lambda d: d / (1 + 0.1 * d * d)),
    ),
    "unified": (Lens(CAMERA, Distortion.UNIFIED, projection=(0.6, 1.2)), _unified(0.6, 1.2)),
    "inverse, barrel": (
        Lens(CAMERA, Distortion.INVERSE, projection=(0.3,)),
        _where(lambda d: d * (1 + 0.3 * d * d)),
    ),
    "inverse, cushion": (
        Lens(CAMERA, Distortion.INVERSE, projection=(-0.1,)),
        _where(lambda d: d * (1 - 0.1 * d * d)),
    ),
}


@pytest.mark.parametrize(("lens", "seen"), LENSES.values(), ids=LENSES)
def test_lenses_are_undone_as_opencv_or_written_formulae_have_them(
    lens: Lens, seen: FloatArray
) -> None:
    picture = lens.undistort(_spots(seen))
    for ray in RAYS:
        expected = (lens.pinhole.matrix @ ray)[:2]
        np.testing.assert_allclose(_spot_near(picture, expected), expected, atol=0.1)


@settings(max_examples=60)
@given(st.floats(-0.15, 0.3), st.floats(-0.05, 0.1))
def test_every_pixel_comes_from_within_the_picture(k1: float, k2: float) -> None:
    lens = Lens(CAMERA, Distortion.POLYNOMIAL, (k1, k2, 0.0, 0.0))
    assert lens.pinhole.fx >= CAMERA.fx
    # A black rim would show: the picture is white all over.
    white = np.full((CAMERA.height, CAMERA.width), 255, dtype=np.uint8)
    assert lens.undistort(white).min() == 255


def test_coefficients_that_fold_the_picture_are_refused() -> None:
    with pytest.raises(CalibrationError, match="folds"):
        _ = Lens(CAMERA, Distortion.POLYNOMIAL, (-50.0, 0.0, 0.0, 0.0)).pinhole
    for distortion, k in ((Distortion.DIVISION, 50.0), (Distortion.INVERSE, -50.0)):
        with pytest.raises(CalibrationError, match="folds"):
            _ = Lens(CAMERA, distortion, projection=(k,)).pinhole
