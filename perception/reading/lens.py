"""Lens distortion models and undistortion, so that all later steps see a pinhole camera."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property

import numpy as np

from facetlog.errors import CalibrationError
from facetlog.perception.types import Camera, FloatArray, Image

# Beyond this factor most of the picture would be cropped: such coefficients are a mistake.
MAX_ZOOM = 3.0
ZOOM_STEPS = 24  # bisection to 1e-7 of the focal length, far below a pixel
RIM_SAMPLES = 129  # per side of the picture; its rim bends smoothly
RADIUS_SAMPLES = 257
# Rows undistorted at a time: keeps the coordinates of a 4000-pixel row block near 8 MB.
BLOCK_ROWS = 256


class Distortion(StrEnum):
    """How a lens takes the tangent r of a ray's angle to the axis to a radius in the picture.

    Not at all; as it is, then by polynomials; by the angle, then by polynomials, and those of both
    directions of the point before the radial ones or after them; by the FOV model's arctangent; by
    the division model; by the enhanced unified camera model; or by the inverse of a polynomial.
    """

    NONE = "none"
    POLYNOMIAL = "polynomial"
    FISHEYE = "fisheye"
    FISHEYE_RADIAL_FIRST = "fisheye, radial first"
    FOV = "fov"
    DIVISION = "division"
    UNIFIED = "unified"
    INVERSE = "inverse"


FISHEYES = (Distortion.FISHEYE, Distortion.FISHEYE_RADIAL_FIRST)
# COLMAP's camera models in the order of their numbers: distortion, and names of their parameters,
# OpenCV's where it has them. The first is the focal length. nerfstudio has the same names. What
# comes after these, EQUIRECTANGULAR, is no perspective picture.
CAMERA_MODELS = {
    "SIMPLE_PINHOLE": (Distortion.NONE, "f cx cy"),
    "PINHOLE": (Distortion.NONE, "fx fy cx cy"),
    "SIMPLE_RADIAL": (Distortion.POLYNOMIAL, "f cx cy k1"),
    "RADIAL": (Distortion.POLYNOMIAL, "f cx cy k1 k2"),
    "OPENCV": (Distortion.POLYNOMIAL, "fx fy cx cy k1 k2 p1 p2"),
    "OPENCV_FISHEYE": (Distortion.FISHEYE, "fx fy cx cy k1 k2 k3 k4"),
    "FULL_OPENCV": (Distortion.POLYNOMIAL, "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6"),
    "FOV": (Distortion.FOV, "fx fy cx cy omega"),
    "SIMPLE_RADIAL_FISHEYE": (Distortion.FISHEYE, "f cx cy k1"),
    "RADIAL_FISHEYE": (Distortion.FISHEYE, "f cx cy k1 k2"),
    "THIN_PRISM_FISHEYE": (Distortion.FISHEYE, "fx fy cx cy k1 k2 p1 p2 k3 k4 sx1 sy1"),
    "RAD_TAN_THIN_PRISM_FISHEYE": (
        Distortion.FISHEYE_RADIAL_FIRST,
        "fx fy cx cy k1 k2 k3 k4 k5 k6 p2 p1 sx1 sx2 sy1 sy2",  # there k0 to k5, p0, p1, s0 to s3
    ),
    "SIMPLE_DIVISION": (Distortion.DIVISION, "f cx cy k"),
    "DIVISION": (Distortion.DIVISION, "fx fy cx cy k"),
    "SIMPLE_FISHEYE": (Distortion.FISHEYE, "f cx cy"),
    "FISHEYE": (Distortion.FISHEYE, "fx fy cx cy"),
    "EUCM": (Distortion.UNIFIED, "fx fy cx cy alpha beta"),
}


@dataclass(frozen=True)
class Lens:
    """The camera that took a picture: pinhole intrinsics and distortion.

    `radial` is (k1, k2, k3, k4), or k5 and k6 too, `tangential` (p1, p2), as nerfstudio and OpenCV
    define them, save that k4 to k6 are the factors of r⁸ to r¹² (nerfstudio), not of OpenCV's
    denominator. `rational` is that denominator, OpenCV's (k4, k5, k6); `prism` is (sx1, sx2, sy1,
    sy2), of a thin prism. `projection` is of the models without polynomials: the FOV model's angle
    in radians, the factor k of the division model and of the inverse, (alpha, beta) of the unified.
    """

    camera: Camera
    distortion: Distortion = Distortion.NONE
    radial: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)
    tangential: tuple[float, float] = (0.0, 0.0)
    rational: tuple[float, float, float] = (0.0, 0.0, 0.0)
    prism: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    projection: tuple[float, ...] = ()

    @property
    def coefficients(self) -> tuple[float, ...]:
        """All numbers that bend rays."""
        return (*self.radial, *self.tangential, *self.rational, *self.prism, *self.projection)

    @property
    def is_pinhole(self) -> bool:
        """Whether rays pass unbent."""
        if self.distortion in FISHEYES:
            return False
        return self.distortion is Distortion.NONE or not any(self.coefficients)

    @cached_property
    def pinhole(self) -> Camera:
        """The camera of the undistorted picture: same size and centre, focal length ≥ the lens's.

        The focal length is the least one at which every pixel comes from within the picture, since
        a black rim would be mistaken for edges of the scene. Raise CalibrationError where there is
        none: then the coefficients fold the picture over itself.
        """
        if self.is_pinhole:
            return self.camera
        low, high = 1.0, MAX_ZOOM
        if self._covered(low):
            return self.camera
        if not self._covered(high):
            raise CalibrationError(
                f"the lens distortion {self.coefficients} folds the picture over "
                "itself: check the coefficients and the camera model"
            )
        for _ in range(ZOOM_STEPS):
            middle = (low + high) / 2
            low, high = (low, middle) if self._covered(middle) else (middle, high)
        return self.camera.zoomed(high)

    def undistort(self, image: Image) -> Image:
        """Return the picture that `pinhole` would have taken, (H, W) uint8; bicubic interpolation.

        A picture that was reduced stays so: then it is what `pinhole` resized would have taken.
        """
        if self.is_pinhole:
            return image
        import cv2  # loaded only now: COLMAP's clouds need the names of lenses alone

        height, width = image.shape
        camera = self.pinhole.resized(width, height)
        lens = replace(self, camera=self.camera.resized(width, height))
        result = np.empty_like(image)
        columns = np.arange(camera.width, dtype=np.float64)
        for top in range(0, camera.height, BLOCK_ROWS):
            rows = np.arange(top, min(top + BLOCK_ROWS, camera.height), dtype=np.float64)
            grid = np.stack(np.meshgrid(columns, rows), axis=-1)
            source = lens._distort_pixels(grid, camera).astype(np.float32)
            map_u, map_v = (np.ascontiguousarray(source[..., k]) for k in (0, 1))
            result[top : top + BLOCK_ROWS] = cv2.remap(
                image, map_u, map_v, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE
            )
        return result

    def _distort_pixels(self, pixels: FloatArray, pinhole: Camera) -> FloatArray:
        """Return where the lens puts what a pinhole sees at pixels (..., 2): pixels (..., 2)."""
        c = self.camera
        x = (pixels[..., 0] - pinhole.cx) / pinhole.fx
        y = (pixels[..., 1] - pinhole.cy) / pinhole.fy
        scale = self._projected(np.hypot(x, y))
        x, y = x * scale, y * scale
        s = x * x + y * y
        gain = self.compute_radial_gain(s)
        xr, yr = x * gain, y * gain
        if self.distortion is Distortion.FISHEYE_RADIAL_FIRST:
            x, y = xr, yr
            s = x * x + y * y
        p1, p2 = self.tangential
        sx1, sx2, sy1, sy2 = self.prism
        # OpenCV, camera calibration: x'' = x' g + 2 p1 x' y' + p2 (s + 2 x'²) + sx1 s + sx2 s²,
        # with s = r², and so for y; of a fisheye with a thin prism (COLMAP) the same of x θ/r, with
        # s = θ², or all but the first term of x g θ/r (Fisheye624 of Project Aria).
        xd = xr + 2 * p1 * x * y + p2 * (s + 2 * x * x) + s * (sx1 + sx2 * s)
        yd = yr + p1 * (s + 2 * y * y) + 2 * p2 * x * y + s * (sy1 + sy2 * s)
        return np.stack([c.fx * xd + c.cx, c.fy * yd + c.cy], axis=-1)

    def _projected(self, r: FloatArray) -> FloatArray:
        """Return the radius over r (tangent of the angle to the axis), before polynomials."""
        if self.distortion in FISHEYES:  # θ = atan r
            radius, on_axis = np.arctan(r), 1.0
        elif not any(self.projection):
            return np.ones_like(r)
        elif self.distortion is Distortion.FOV:
            # Devernay and Faugeras 2001, eq. 13: atan(2 r tan(ω/2)) / ω.
            (omega,) = self.projection
            bent = 2 * np.tan(omega / 2)
            radius, on_axis = np.arctan(bent * r) / omega, bent / omega
        elif self.distortion is Distortion.DIVISION:
            # Fitzgibbon 2001: r = d / (1 + k d²), solved for d.
            (k,) = self.projection
            return np.asarray(2 / (1 + np.sqrt(1 - 4 * k * r * r)))
        elif self.distortion is Distortion.UNIFIED:
            # Khomutenko et al. 2016, eq. 8: d = r / (α √(β r² + 1) + 1 - α).
            alpha, beta = self.projection
            return np.asarray(1 / (alpha * np.sqrt(beta * r * r + 1) + 1 - alpha))
        else:
            radius, on_axis = _invert_cubic_distortion(r, *self.projection), 1.0
        return np.divide(radius, r, out=np.full_like(r, on_axis), where=r > 0)

    def compute_radial_gain(self, s: FloatArray) -> FloatArray:
        """Return the distorted over the undistorted radius whose square is s: a ratio of
        polynomials.
        """
        return _evaluate_series(self.radial, s) / _evaluate_series(self.rational, s)

    def _covered(self, zoom: float) -> bool:
        """Return whether at this zoom all pixels come from within the picture, and from one place
        each.
        """
        camera = self.camera.zoomed(zoom)
        right, bottom = camera.width - 1.0, camera.height - 1.0
        u, v = np.linspace(0, right, RIM_SAMPLES), np.linspace(0, bottom, RIM_SAMPLES)
        across = [np.column_stack([u, np.full_like(u, y)]) for y in (0.0, bottom)]
        down = [np.column_stack([np.full_like(v, x), v]) for x in (0.0, right)]
        rim = np.concatenate([*across, *down])
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            source = self._distort_pixels(rim, camera)
            offset = (rim - [camera.cx, camera.cy]) / [camera.fx, camera.fy]
            radii = np.linspace(0, np.sqrt((offset**2).sum(axis=1).max()), RADIUS_SAMPLES)
            straight = radii * self._projected(radii)
            growing = np.diff(straight * self.compute_radial_gain(straight**2)) > 0
            # Half a pixel outside the rim's pixel centres is still on the rim's pixels.
            inside = (source >= -0.5) & (source <= [right + 0.5, bottom + 0.5])
        return bool(inside.all() and growing.all())


def _evaluate_series(coefficients: Sequence[float], s: FloatArray) -> FloatArray:
    """Return 1 + c₁ s + c₂ s² + …"""
    total: FloatArray = np.zeros_like(s)
    for coefficient in reversed(coefficients):
        total = s * (coefficient + total)
    return 1 + total


def _invert_cubic_distortion(r: FloatArray, k: float) -> FloatArray:
    """Return the d of r = d (1 + k d²), of three the one next to r (Viète); nan where there is
    none.
    """
    size = np.sqrt(3 * abs(k))
    if k > 0:
        return np.asarray(2 / size * np.sinh(np.arcsinh(1.5 * size * r) / 3))
    return np.asarray(2 / size * np.sin(np.arcsin(1.5 * size * r) / 3))
