"""The noise of a picture, from the picture alone."""

from dataclasses import dataclass

import cv2
import numpy as np

from facetlog.perception.types import Image

# A picture without noise (rendered, saturated) still has rounding, whose single steps are no edges.
MIN_NOISE_SD = 1.5


@dataclass(frozen=True, slots=True)
class Noise:
    """White noise of `sd` grey levels in a picture before it was enlarged `factor` times.

    Its users know how enlarging by cubics, 1, 2 or 4 times, changes it.
    """

    sd: float
    factor: int = 1


def noise_sd(image: Image) -> float:
    """Return the standard deviation of the picture's noise in grey levels; texture raises it
    little.

    The median of |N * image| with N the difference of two Laplacians, which no plane or straight
    edge along the grid answers to (Immerkær 1996; the median in place of the mean).
    """
    difference = np.array([[1.0, -2.0, 1.0], [-2.0, 4.0, -2.0], [1.0, -2.0, 1.0]])
    response = cv2.filter2D(image, cv2.CV_16S, difference)[1:-1, 1:-1]
    if not response.size:
        return 0.0
    # Whole numbers, at most 8 * 255: the median from their counts.
    count = cv2.calcHist([np.abs(response).view(np.uint16)], [0], None, [2041], [0, 2041])
    median = np.searchsorted(np.cumsum(count, dtype=np.int64), response.size // 2, side="right")
    # sd of the response is 6 sd of the noise; a Gaussian's median magnitude is .6745 sd.
    return float(median) / (6.0 * 0.6745)


def measure_working_noise(image: Image) -> Noise:
    """Return the noise that thresholds follow of a picture not enlarged, MIN_NOISE_SD at least."""
    return Noise(max(noise_sd(image), MIN_NOISE_SD))
