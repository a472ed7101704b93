"""Whether a picture is sharp and well exposed.

Pictures of one tour show different things, plain floor among them, and no measure of contrast
compares those. What they have in common is how wide their edges are: the gradient of an edge falls
when the picture is smoothed further, whatever its contrast, and the less the wider the edge is
already. Both directions are kept apart, since motion blurs in one direction and leaves edges along
it as they were. A picture without edges says nothing.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.types import Image

# Pixels: smoothing before the two gradients that are compared. The finer passes little more than a
# picture's own blur, the coarser still finds an edge that motion has spread over 30 pixels.
FINE_PX, COARSE_PX = 1.0, 3.0
# Of Sobel's mask, which smooths by half a pixel squared itself.
OF_MASK_PX2 = 0.5
# What is stronger than so many standard deviations of the noise of the coarser gradient is an edge:
# of a million pixels of noise none is.
EDGE_SDS = 8.0
# Coarse standard deviations from an edge within which nearly all of its gradient lies.
BESIDE_EDGE_SDS = 2
# Immerkær, Fast noise variance estimation (1996): a mask that steps and ramps of grey do not
# pass; the sum of its squares is 36. The median is not drawn away by corners and print.
NOISE_MASK = np.array([[1.0, -2.0, 1.0], [-2.0, 4.0, -2.0], [1.0, -2.0, 1.0]], dtype=np.float32)
NOISE_GAIN = 6.0
MEDIAN_OF_NORMAL = 0.6745
# Grey levels: what rounding to whole ones adds is noise too.
ROUNDING_SD = 12.0**-0.5
# Others that a picture is compared with at least: from fewer the spread cannot be estimated.
LEAST_OTHERS = 3
# Standard deviations that a picture may be more blurred than the median of the others: one of 700
# sharp pictures is retaken in vain if their variances are normal.
OUTLIER_SDS = 3.0
# A motion by fewer pixels is let pass: by so much sharp pictures differ for what they show. Of 338
# views of rendered areas none is off by more than a motion by 3.4 px is, and 9 px are found in all.
LEAST_MOTION_PX = 4.0
# Share of pixels at either end of the range: where a fifth of a picture has no shape left, the
# exposure is wrong rather than a lamp or a shadow in it.
CLIPPED_SHARE = 0.2
DARKEST, BRIGHTEST = 0, 255


@dataclass(frozen=True, slots=True)
class Quality:
    """The quality of one picture: the blur of its edges `across` and `down`, as standard deviations
    in pixels, None where it has no edges in that direction; `clipped` is a share of its pixels.
    """

    across: float | None
    down: float | None
    clipped: float

    @property
    def blur(self) -> float:
        """Both directions in one figure, to compare two pictures of the same, px; infinite where
        there is no edge left.
        """
        known = [each for each in (self.across, self.down) if each is not None]
        return float(np.hypot.reduce(known)) if known else float("inf")


def measure_quality(image: Image) -> Quality:
    """Return blur and share of clipped pixels of a picture, grey (H, W) or colour (H, W, 3)."""
    grey = image if image.ndim == 2 else np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY))
    ends = np.count_nonzero(grey == DARKEST) + np.count_nonzero(grey == BRIGHTEST)
    across, down = _blur(grey.astype(np.float32))
    return Quality(across, down, ends / grey.size)


def _blur(grey: NDArray[np.float32]) -> tuple[float | None, float | None]:
    """Return standard deviations of the blur of its edges across and down, px.

    Over an edge of height C, blurred by b, the square of the gradient behind a smoothing by s sums
    up to C² / (2 sqrt(π (s² + b²))): the ratio r of two such sums, less what noise adds to them,
    gives b² = (s₂² - r² s₁²) / (r² - 1).
    """
    noise = max(_estimate_noise_sd(grey), ROUNDING_SD)
    fine, coarse = _compute_gradients(grey, FINE_PX), _compute_gradients(grey, COARSE_PX)
    least = EDGE_SDS * noise * _compute_noise_gain(COARSE_PX)
    size = 2 * round(BESIDE_EDGE_SDS * COARSE_PX) + 1
    found: list[float | None] = []
    for axis in (0, 1):
        own = np.abs(coarse[axis])
        edges = (own > least) & (own > np.abs(coarse[1 - axis]))
        if not edges.any():
            found.append(None)
            continue
        near = cv2.dilate(edges.astype(np.uint8), np.ones((size, size), np.uint8)) > 0
        sums = [
            float(np.sum(gradient[axis][near] ** 2, dtype=np.float64))
            - np.count_nonzero(near) * (noise * _compute_noise_gain(smoothing)) ** 2
            for gradient, smoothing in ((fine, FINE_PX), (coarse, COARSE_PX))
        ]
        found.append(_measure_blur_px(sums[0] / sums[1]))
    return found[0], found[1]


def _measure_blur_px(ratio: float) -> float:
    """Return the blur of edges whose fine gradients sum up to so many times the coarse ones."""
    s1, s2 = FINE_PX**2 + OF_MASK_PX2, COARSE_PX**2 + OF_MASK_PX2
    # Of what is finer than an edge, as print, the ratio is larger; without end it is 1.
    r2 = min(max(ratio, 1.0 + float(np.finfo(np.float32).eps)) ** 2, s2 / s1)
    return float(np.sqrt((s2 - r2 * s1) / (r2 - 1.0)))


def _compute_gradients(grey: NDArray[np.float32], smoothing: float) -> NDArray[np.float32]:
    """Return across and down, (2, H, W), in grey levels per pixel."""
    smooth = cv2.GaussianBlur(grey, (0, 0), smoothing)
    return np.array(
        [cv2.Sobel(smooth, cv2.CV_32F, x, y, ksize=3, scale=1 / 8) for x, y in ((1, 0), (0, 1))]
    )


def _estimate_noise_sd(grey: NDArray[np.float32]) -> float:
    through = np.abs(cv2.filter2D(grey, cv2.CV_32F, NOISE_MASK))
    return float(np.median(through)) / (MEDIAN_OF_NORMAL * NOISE_GAIN)


@cache
def _compute_noise_gain(smoothing: float) -> float:
    """Return standard deviation of a gradient of white noise of standard deviation 1: the root
    of the sum of the squares of the response to a point."""
    half = 6 * round(COARSE_PX)
    point = np.zeros((2 * half + 1, 2 * half + 1), np.float32)
    point[half, half] = 1.0
    return float(np.linalg.norm(_compute_gradients(point, smoothing)[0]))


def faults_of(quality: Quality, others: Sequence[Quality]) -> tuple[str, ...]:
    """Return the faults of a picture, empty if there are none; `others` are of the same tour.

    Of fewer than three others with edges in a direction nothing follows for its blur.
    """
    found = []
    directions = (
        ("across", quality.across, [other.across for other in others]),
        ("down", quality.down, [other.down for other in others]),
    )
    beyond = []
    for name, blur, theirs in directions:
        limits = _find_usual_and_limit(theirs)
        if blur is None or limits is None or blur**2 <= limits[1]:
            continue
        said = f"blurred {name} by {blur:.1f} px, the other pictures by {limits[0]:.1f}"
        beyond.append((blur**2 / limits[1], said))
    if beyond:
        # Edges at a slant are blurred both ways by either motion.
        found.append(max(beyond)[1])
    if quality.clipped > CLIPPED_SHARE:
        found.append(f"badly exposed: {quality.clipped:.0%} of it is black or white")
    return tuple(found)


def _find_usual_and_limit(blurs: Sequence[float | None]) -> tuple[float, float] | None:
    """Return the usual one of pictures' blurs (px), and the largest variance (px²) that passes.

    None of too few.
    """
    known = np.array([blur for blur in blurs if blur is not None]) ** 2
    if len(known) < LEAST_OTHERS:
        return None
    middle = float(np.median(known))
    spread = float(np.median(np.abs(known - middle))) / MEDIAN_OF_NORMAL
    # A motion at constant speed has the variance of what is even over its length.
    return middle**0.5, middle + max(OUTLIER_SDS * spread, LEAST_MOTION_PX**2 / 12.0)
