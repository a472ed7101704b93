"""Straight segments of one picture (LSD, Grompone von Gioi et al. 2012), noise-normalised."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.coarse_pictures import CoarsePicture, coarse_pictures
from facetlog.perception.detection.picture_noise import Noise, measure_working_noise
from facetlog.perception.types import FloatArray, Image

# Shorter segments have no usable direction; as a share of the picture's diagonal.
MIN_LENGTH = 0.025
# LSD's `quant`, the error of a grey level that its gradient threshold allows for, over the noise:
# its default of 2 levels is made for pictures with noise of about 2.
QUANT_PER_NOISE = 1.0
# Its gradient's noise in a picture that was enlarged so many times, over that in one that was not.
ENLARGED = {1: 1.0, 2: 1.5, 4: 1.3}
# The same over the noise that halving leaves: 3 sd of LSD's gradient are enough there, for LSD
# needs many such pixels in line. Its threshold is `quant` over the sine of 22.5°, and its gradient
# has .23 of the noise of CoarsePicture.
QUANT_PER_COARSE_NOISE = 0.25
# A segment this near to those of finer scales, in px of its own scale, is a duplicate of them.
NEAR_PX = 3.0
SAMPLES = 12


def detect_segments(
    image: Image, noise: Noise | None = None, coarser: Sequence[CoarsePicture] | None = None
) -> FloatArray:
    """Return segments (n, 4) as u0, v0, u1, v1 in px, longest first; all of some length.

    LSD's gradient threshold follows the picture's noise, so that faint edges of a clean picture
    are found and the noise of a poor one is not; fainter ones of a noisy picture are found at
    coarser scales, which callers that have them pass as `coarser`. `noise` is for pictures whose
    noise cannot be estimated from their own pixels (working_size.py).
    """
    if noise is None:
        noise = measure_working_noise(image)
    fine = QUANT_PER_NOISE * ENLARGED[noise.factor] * noise.sd
    segments = _detected(image, fine)
    if coarser is None:
        coarser = coarse_pictures(image, noise)
    if not coarser:
        half = np.asarray(cv2.pyrDown(image), dtype=np.uint8)
        segments = np.vstack([segments, 2.0 * _detected(half, fine)])
    for coarse in coarser:
        quant = float(np.hypot(QUANT_PER_COARSE_NOISE * coarse.noise, coarse.grain))
        # Pixel k of a picture halved n times sits at pixel 2ⁿ k of the whole one.
        new = coarse.factor * _detected(coarse.image, min(fine, quant))
        shown = _shown(new, segments, NEAR_PX * coarse.factor, image.shape)
        segments = np.vstack([segments, new[~shown]])
    length = np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1])
    order = np.argsort(-length, kind="stable")
    return segments[order[length[order] >= MIN_LENGTH * float(np.hypot(*image.shape))]]


def _detected(image: Image, quant: float) -> FloatArray:
    lines = cv2.createLineSegmentDetector(cv2.LSD_REFINE_STD, quant=quant).detect(image)[0]
    # OpenCV has None for no lines.
    return np.zeros((0, 4)) if lines is None else lines.reshape(-1, 4).astype(np.float64)


def _shown(
    segments: FloatArray, known: FloatArray, near: float, shape: tuple[int, ...]
) -> NDArray[np.bool_]:
    # Which of the segments (n, 4) lie mostly beside known ones, nearer than so many px.
    beside = np.zeros(shape, dtype=np.uint8)
    for u0, v0, u1, v1 in np.rint(known).astype(int).tolist():
        cv2.line(beside, (u0, v0), (u1, v1), 1, 2 * round(near) + 1)
    t = (np.arange(SAMPLES) + 0.5)[:, None] / SAMPLES
    along = segments[:, None, :2] + t * (segments[:, None, 2:] - segments[:, None, :2])
    column, row = np.clip(np.rint(along), 0, np.array(shape[::-1]) - 1).astype(np.intp).T
    return np.asarray(beside[row, column].mean(axis=0) > 0.5)
