"""An image pyramid of a noisy picture: faint edges hidden by its noise show at coarser scales.

Halving averages noise away, but not the grain of a textured floor. Both are measured, so that in a
plain scene the faintest edges count, and in a textured one those that stand out from the texture.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.picture_noise import MIN_NOISE_SD, Noise
from facetlog.perception.types import Image

# Smoothing before the derivative, px: the usual compromise between noise and localisation.
GRADIENT_SIGMA = 1.0
# Standard deviation of the gradient for white noise of 1: that of a Gaussian derivative is
# 1 / (sqrt(8 π) s²), Sobel's own smoothing included.
GRADIENT_NOISE = float(1 / (np.sqrt(8 * np.pi) * (GRADIENT_SIGMA**2 + 0.5)))


@dataclass(frozen=True, eq=False, slots=True)
class Gradient:
    """A picture's gradient across and down, each (H, W) float32 in grey levels per px."""

    gx: NDArray[np.float32]
    gy: NDArray[np.float32]


def gradient(image: Image) -> Gradient:
    """Return the gradient of a grey picture, smoothed by GRADIENT_SIGMA."""
    smooth = cv2.GaussianBlur(image.astype(np.float32), (0, 0), GRADIENT_SIGMA)
    return Gradient(
        _float32(cv2.Sobel(smooth, cv2.CV_32F, 1, 0, ksize=3, scale=1 / 8)),
        _float32(cv2.Sobel(smooth, cv2.CV_32F, 0, 1, ksize=3, scale=1 / 8)),
    )


def _float32(picture: cv2.typing.MatLike) -> NDArray[np.float32]:
    return np.asarray(picture, dtype=np.float32)


# White noise of 1 in a picture enlarged by this factor (cubic) and then halved once, twice, three
# times by cv2.pyrDown: the sd of its pixels; and the sd of white noise with the same gradient
# noise. From the filters.
HALVED = {
    1: ((0.273, 0.455), (0.123, 0.219), (0.060, 0.109)),
    2: ((0.516, 0.926), (0.251, 0.444), (0.121, 0.216)),
    4: ((0.731, 1.643), (0.474, 0.892), (0.246, 0.441)),
}
# Median magnitude of a Gaussian, in sd.
MEDIAN_SD = 0.6745


@dataclass(frozen=True, eq=False, slots=True)
class CoarsePicture:
    """A picture each of whose px spans `factor` px of the full one, and its gradient.

    `noise` is the sd, in grey levels, of white noise with the same gradient noise; `grain` the same
    for the texture that the picture has beyond noise in most places.
    """

    image: Image
    factor: int
    slope: Gradient
    noise: float
    grain: float


def coarse_pictures(image: Image, noise: Noise) -> list[CoarsePicture]:
    """Return the picture halved, three times at most, until its noise is that of a clean one.

    Empty for a clean picture.
    """
    found: list[CoarsePicture] = []
    left = noise.sd
    for level, (of_pixels, of_gradient) in enumerate(HALVED[noise.factor]):
        if left <= MIN_NOISE_SD or min(image.shape) < 2:
            break
        image = np.asarray(cv2.pyrDown(image), dtype=np.uint8)
        slope = gradient(image)
        magnitude = float(np.median(np.abs(np.stack([slope.gx, slope.gy]))))
        everything = magnitude / MEDIAN_SD / GRADIENT_NOISE
        white = of_gradient * noise.sd
        grain = float(np.sqrt(max(everything**2 - white**2, 0.0)))
        found.append(CoarsePicture(image, 2 ** (level + 1), slope, white, grain))
        left = of_pixels * noise.sd
    return found
