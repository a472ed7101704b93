"""A noisy picture at coarser scales: faint edges that its noise hides show there.

Halving averages noise away, but not what a textured floor shows everywhere: its grain. Both are
measured, so that of a plain scene the faintest edges count, and of a textured one those that
stand out from the texture.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from facetlog.perception.detection.gradients import GRADIENT_NOISE, Gradient, gradient
from facetlog.perception.detection.picture_noise import MIN_NOISE_SD, Noise
from facetlog.perception.types import Image

__all__ = ["CoarsePicture", "coarse_pictures"]

# What white noise of 1 is in a picture enlarged so many times (cubic) and then halved once, twice,
# three times by cv2.pyrDown: the sd of its pixels; and the sd of white noise whose gradient is as
# noisy as there. From the filters.
HALVED = {
    1: ((0.273, 0.455), (0.123, 0.219), (0.060, 0.109)),
    2: ((0.516, 0.926), (0.251, 0.444), (0.121, 0.216)),
    4: ((0.731, 1.643), (0.474, 0.892), (0.246, 0.441)),
}
# Median magnitude of a Gaussian, in sd.
MEDIAN_SD = 0.6745


@dataclass(frozen=True, eq=False, slots=True)
class CoarsePicture:
    """A picture of which each px spans `factor` px of the whole one, and its gradient.

    `noise` is the sd, in grey levels, of white noise whose gradient is what noise leaves here;
    `grain` the same of what the picture shows beyond noise in most places.
    """

    image: Image
    factor: int
    slope: Gradient
    noise: float
    grain: float


def coarse_pictures(image: Image, noise: Noise) -> list[CoarsePicture]:
    """The picture halved, three times at most, until its noise is a clean one's.

    None of a clean picture.
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
