"""A picture's gradient, and its noise for a given noise of the pixels."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.types import Image

__all__ = ["GRADIENT_NOISE", "GRADIENT_SIGMA", "Gradient", "gradient"]

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
    """The gradient of a grey picture, smoothed by GRADIENT_SIGMA."""
    smooth = cv2.GaussianBlur(image.astype(np.float32), (0, 0), GRADIENT_SIGMA)
    return Gradient(
        _float32(cv2.Sobel(smooth, cv2.CV_32F, 1, 0, ksize=3, scale=1 / 8)),
        _float32(cv2.Sobel(smooth, cv2.CV_32F, 0, 1, ksize=3, scale=1 / 8)),
    )


def _float32(picture: cv2.typing.MatLike) -> NDArray[np.float32]:
    return np.asarray(picture, dtype=np.float32)
