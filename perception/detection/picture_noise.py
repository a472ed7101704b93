"""The noise of a picture, from the picture alone."""

import cv2
import numpy as np

from facetlog.perception.types import Image

__all__ = ["noise_sd"]


def noise_sd(image: Image) -> float:
    """Standard deviation of the picture's noise in grey levels; texture raises it little.

    The median of |N * image| with N the difference of two Laplacians, which no plane or straight
    edge along the grid answers to (Immerkær 1996; the median in place of the mean).
    """
    difference = np.array([[1.0, -2.0, 1.0], [-2.0, 4.0, -2.0], [1.0, -2.0, 1.0]])
    response = np.abs(cv2.filter2D(image, cv2.CV_32F, difference)[1:-1, 1:-1]).ravel()
    if not response.size:
        return 0.0
    # sd of the response is 6 sd of the noise; a Gaussian's median magnitude is .6745 sd.
    half = response.size // 2
    return float(np.partition(response, half)[half]) / (6.0 * 0.6745)
