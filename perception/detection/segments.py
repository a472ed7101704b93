"""Straight segments of one picture (LSD, Grompone von Gioi et al. 2012), noise-normalised."""

import cv2
import numpy as np

from facetlog.perception.detection.edge_maps import working_noise
from facetlog.perception.types import FloatArray, Image

__all__ = ["detect_segments"]

# Shorter segments have no usable direction; as a share of the picture's diagonal.
MIN_LENGTH = 0.025
# LSD's `quant`, the error of a grey level that its gradient threshold allows for, over the noise:
# its default of 2 levels is made for pictures with noise of about 2.
QUANT_PER_NOISE = 1.0


def detect_segments(image: Image, noise: float | None = None) -> FloatArray:
    """Segments (n, 4) as u0, v0, u1, v1 in px, longest first; all of some length.

    LSD's gradient threshold follows the picture's noise, so that faint edges of a clean picture
    are found and the noise of a poor one is not. `noise`, in grey levels, is for pictures whose own
    pixels do not tell it (working_size.py).
    """
    quant = QUANT_PER_NOISE * (working_noise(image) if noise is None else noise)
    detector = cv2.createLineSegmentDetector(cv2.LSD_REFINE_STD, quant=quant)
    found: list[FloatArray] = []
    for picture, factor in ((image, 1.0), (cv2.pyrDown(image), 2.0)):
        lines = detector.detect(picture)[0]
        if lines is not None:
            # Pixel k of the half picture sits at pixel 2k of the whole one.
            found.append(lines.reshape(-1, 4).astype(np.float64) * factor)
    if not found:
        return np.zeros((0, 4))
    segments = np.vstack(found)
    length = np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1])
    order = np.argsort(-length, kind="stable")
    return segments[order[length[order] >= MIN_LENGTH * float(np.hypot(*image.shape))]]
