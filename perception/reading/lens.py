"""Lens distortion models and undistortion, so that all later steps see a pinhole camera."""

from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property

import cv2
import numpy as np

from facetlog.errors import CalibrationError
from facetlog.perception.types import Camera, FloatArray, Image

__all__ = ["Distortion", "Lens"]

# Beyond this factor most of the picture would be cropped: such coefficients are a mistake.
MAX_ZOOM = 3.0
ZOOM_STEPS = 24  # bisection to 1e-7 of the focal length, far below a pixel
RIM_SAMPLES = 129  # per side of the picture; its rim bends smoothly
RADIUS_SAMPLES = 257
# Rows undistorted at a time: keeps the coordinates of a 4000-pixel row block near 8 MB.
BLOCK_ROWS = 256


class Distortion(StrEnum):
    """How a lens bends rays: not at all, by OpenCV's polynomial, or by its fisheye polynomial."""

    NONE = "none"
    POLYNOMIAL = "polynomial"
    FISHEYE = "fisheye"


@dataclass(frozen=True)
class Lens:
    """The camera that took a picture: pinhole intrinsics and distortion.

    `radial` is (k1, k2, k3, k4), `tangential` (p1, p2), as nerfstudio and OpenCV define them,
    save that k4 is the factor of r⁸ (nerfstudio), not of OpenCV's denominator.
    """

    camera: Camera
    distortion: Distortion = Distortion.NONE
    radial: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    tangential: tuple[float, float] = (0.0, 0.0)

    @property
    def is_pinhole(self) -> bool:
        """Whether rays pass unbent."""
        if self.distortion is Distortion.POLYNOMIAL:
            return not any((*self.radial, *self.tangential))
        return self.distortion is Distortion.NONE

    @cached_property
    def pinhole(self) -> Camera:
        """The camera of the undistorted picture: same size and centre, focal length ≥ the lens's.

        The focal length is the least one at which every pixel comes from within the picture, since
        a black rim would be mistaken for edges of the scene. Raises CalibrationError where there is
        none: then the coefficients fold the picture over itself.
        """
        if self.is_pinhole:
            return self.camera
        low, high = 1.0, MAX_ZOOM
        if self._covered(low):
            return self.camera
        if not self._covered(high):
            raise CalibrationError(
                f"the lens distortion {(*self.radial, *self.tangential)} folds the picture over "
                "itself: check the coefficients and the camera model"
            )
        for _ in range(ZOOM_STEPS):
            middle = (low + high) / 2
            low, high = (low, middle) if self._covered(middle) else (middle, high)
        return self.camera.zoomed(high)

    def undistort(self, image: Image) -> Image:
        """The picture that `pinhole` would have taken, (H, W) uint8; bicubic interpolation.

        A picture that was reduced stays so: then it is what `pinhole` resized would have taken.
        """
        if self.is_pinhole:
            return image
        height, width = image.shape
        camera = self.pinhole.resized(width, height)
        lens = replace(self, camera=self.camera.resized(width, height))
        result = np.empty_like(image)
        columns = np.arange(camera.width, dtype=np.float64)
        for top in range(0, camera.height, BLOCK_ROWS):
            rows = np.arange(top, min(top + BLOCK_ROWS, camera.height), dtype=np.float64)
            grid = np.stack(np.meshgrid(columns, rows), axis=-1)
            source = lens._distorted(grid, camera).astype(np.float32)
            map_u, map_v = (
                np.ascontiguousarray(source[..., 0]),
                np.ascontiguousarray(source[..., 1]),
            )
            result[top : top + BLOCK_ROWS] = cv2.remap(
                image, map_u, map_v, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE
            )
        return result

    def _distorted(self, pixels: FloatArray, pinhole: Camera) -> FloatArray:
        """Where the lens puts what a pinhole sees at pixels (..., 2): pixels (..., 2)."""
        c = self.camera
        x = (pixels[..., 0] - pinhole.cx) / pinhole.fx
        y = (pixels[..., 1] - pinhole.cy) / pinhole.fy
        r2 = x * x + y * y
        gain = self._radial_gain(np.sqrt(r2))
        p1, p2 = self.tangential
        # OpenCV, camera calibration: x'' = x' g + 2 p1 x' y' + p2 (r² + 2 x'²), and so for y.
        xd = x * gain + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
        yd = y * gain + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
        return np.stack([c.fx * xd + c.cx, c.fy * yd + c.cy], axis=-1)

    def _radial_gain(self, r: FloatArray) -> FloatArray:
        """Distorted radius over undistorted radius r (tangent of the angle to the axis)."""
        k1, k2, k3, k4 = self.radial
        fisheye = self.distortion is Distortion.FISHEYE
        # OpenCV fisheye: θd = θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸) with θ = atan r.
        angle = np.arctan(r) if fisheye else r
        s = angle * angle
        gain = 1 + s * (k1 + s * (k2 + s * (k3 + s * k4)))
        if fisheye:
            gain = gain * np.divide(angle, r, out=np.ones_like(r), where=r > 0)
        return np.asarray(gain, dtype=np.float64)

    def _covered(self, zoom: float) -> bool:
        """Whether at this zoom all pixels come from within the picture, and from one place each."""
        camera = self.camera.zoomed(zoom)
        right, bottom = camera.width - 1.0, camera.height - 1.0
        u, v = np.linspace(0, right, RIM_SAMPLES), np.linspace(0, bottom, RIM_SAMPLES)
        rim = np.concatenate(
            [
                np.column_stack([u, np.zeros_like(u)]),
                np.column_stack([u, np.full_like(u, bottom)]),
                np.column_stack([np.zeros_like(v), v]),
                np.column_stack([np.full_like(v, right), v]),
            ]
        )
        with np.errstate(over="ignore", invalid="ignore"):
            source = self._distorted(rim, camera)
            offset = (rim - [camera.cx, camera.cy]) / [camera.fx, camera.fy]
            radii = np.linspace(0, np.sqrt((offset**2).sum(axis=1).max()), RADIUS_SAMPLES)
            growing = np.diff(radii * self._radial_gain(radii)) > 0
            # Half a pixel outside the rim's pixel centres is still on the rim's pixels.
            inside = (source >= -0.5) & (source <= [right + 0.5, bottom + 0.5])
        return bool(inside.all() and growing.all())
