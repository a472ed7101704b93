"""Straight segments of one picture (LSD, Grompone von Gioi et al. 2012), noise-normalised."""

import cv2
import numpy as np

from facetlog.perception.line_front_end.edge_maps import noise_sd
from facetlog.perception.types import FloatArray, Image

__all__ = ["detect_segments"]

# Shorter segments have no usable direction; as a share of the picture's diagonal.
MIN_LENGTH = 0.025
# LSD's gradient threshold is made for noise of about this many grey levels.
LSD_NOISE = 2.0
# Gain is limited: in a noise-free picture rounding would become texture.
MAX_GAIN = 4.0


def detect_segments(image: Image) -> FloatArray:
    """Segments (n, 4) as u0, v0, u1, v1 in px, longest first.

    LSD has a fixed gradient threshold; the picture is scaled to the noise it was made for, so
    that faint edges of a clean picture are found and the noise of a poor one is not.
    """
    gain = float(np.clip(LSD_NOISE / noise_sd(image), 0.25, MAX_GAIN))
    scaled = image.astype(np.float64) * gain
    found: list[FloatArray] = []
    detector = cv2.createLineSegmentDetector(cv2.LSD_REFINE_STD)
    # LSD takes 8 bits: a gain above 1 wraps bright areas, so work on a high-pass picture.
    low = cv2.GaussianBlur(scaled, (0, 0), 0.02 * float(np.hypot(*image.shape)))
    flat = np.clip(scaled - low + 128.0, 0, 255).astype(np.uint8)
    half = cv2.pyrDown(flat)
    for picture, factor in ((flat, 1.0), (half, 2.0)):
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
