"""Whether a picture is sharp and well exposed, judged against the other pictures of its tour.

How sharp a picture can be depends on what it shows, so no number is sharp by itself: the variances
of the two terms of the Laplacian, freed of what noise adds to them, are compared with those of the
tour's other pictures on a scale of logarithms. The terms are kept apart, since motion blurs in one
direction and leaves edges along it as they were.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np

from facetlog.perception.types import FloatArray, Image

__all__ = ["Quality", "faults_of", "quality_of"]

# Pixels: somewhat more than a picture's own blur, so that edges answer more than noise does
# (measured with 1, 1.5 and 2 on rendered tours with noise of 5 grey levels).
SMOOTHING_PX = 1.5
# Immerkær, Fast noise variance estimation (1996): a mask that steps and ramps of grey do not
# pass; the sum of its squares is 36. The median is not drawn away by corners and print.
NOISE_MASK = np.array([[1.0, -2.0, 1.0], [-2.0, 4.0, -2.0], [1.0, -2.0, 1.0]])
NOISE_GAIN = 6.0
MEDIAN_OF_NORMAL = 0.6745
# Share of the noise's part that may be left over: its sd is known to some percent.
NOISE_DOUBT = 0.05
# Others that a picture is compared with at least: from fewer the spread cannot be estimated.
LEAST_OTHERS = 3
# Standard deviations that a picture may be below the median of the others: one of 700 sharp
# pictures is retaken in vain if logarithms of sharpness are normal.
OUTLIER_SDS = 3.0
# Of the logarithm of sharpness, at least: the spread of a few pictures that are alike says too
# little. With 3 sd a picture must be less than half as sharp in one direction. Rendered tours
# have sds of .17 to .32 and none below .6; motion by 9 pixels leaves .16 to .49 (measured).
LEAST_SD = math.log(2.0) / OUTLIER_SDS
# Share of pixels at either end of the range: where a fifth of a picture has no shape left, the
# exposure is wrong rather than a lamp or a shadow in it.
CLIPPED_SHARE = 0.2
DARKEST, BRIGHTEST = 0, 255


@dataclass(frozen=True, slots=True)
class Quality:
    """Of one picture: sharpness `across` and `down` (squared grey levels), `clipped` a share."""

    across: float
    down: float
    clipped: float

    @property
    def sharpness(self) -> float:
        """Both directions in one figure, to compare two pictures of the same: their product."""
        return self.across * self.down


def quality_of(image: Image) -> Quality:
    """Sharpness and share of clipped pixels of a picture, grey (H, W) or colour (H, W, 3)."""
    grey = image if image.ndim == 2 else np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY))
    ends = np.count_nonzero(grey == DARKEST) + np.count_nonzero(grey == BRIGHTEST)
    across, down = _sharpness(grey.astype(np.float64))
    return Quality(across, down, ends / grey.size)


def _sharpness(grey: FloatArray) -> tuple[float, float]:
    """Variances of the second derivatives of the smoothed picture, less the part that is noise."""
    responses = _second_derivatives(grey)
    through = np.abs(cv2.filter2D(grey, cv2.CV_64F, NOISE_MASK))
    noise_sd = float(np.median(through)) / (MEDIAN_OF_NORMAL * NOISE_GAIN)
    of_noise = noise_sd**2 * _noise_energy()
    across, down = responses.var(axis=(1, 2)) - of_noise
    least = NOISE_DOUBT * of_noise + float(np.finfo(np.float64).tiny)
    return max(float(across), least), max(float(down), least)


def _second_derivatives(grey: FloatArray) -> FloatArray:
    """Across and down, (2, H, W): the two terms of the Laplacian."""
    smooth = cv2.GaussianBlur(grey, (0, 0), SMOOTHING_PX)
    terms = [cv2.Sobel(smooth, cv2.CV_64F, x, y, ksize=1) for x, y in ((2, 0), (0, 2))]
    return np.array(terms, dtype=np.float64)


@cache
def _noise_energy() -> float:
    """Variance of a response to white noise of variance 1: the response to a point, squared."""
    point = np.zeros((31, 31))
    point[15, 15] = 1.0
    return float((_second_derivatives(point)[0] ** 2).sum())


def faults_of(quality: Quality, others: Sequence[Quality]) -> tuple[str, ...]:
    """What is wrong with a picture, one phrase for each fault; `others` are of the same tour.

    Of fewer than three others nothing follows for its sharpness.
    """
    found = []
    if len(others) >= LEAST_OTHERS:
        logs = np.log([(other.across, other.down) for other in others])
        middle = np.median(logs, axis=0)
        spread = np.median(np.abs(logs - middle), axis=0) / MEDIAN_OF_NORMAL
        below = middle - np.log([quality.across, quality.down])
        if (below > OUTLIER_SDS * np.maximum(spread, LEAST_SD)).any():
            share = math.exp(-float(below.max()))
            found.append(f"blurred: {share:.0%} of the sharpness that the other pictures have")
    if quality.clipped > CLIPPED_SHARE:
        found.append(f"badly exposed: {quality.clipped:.0%} of it is black or white")
    return tuple(found)
