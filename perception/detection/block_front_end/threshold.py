"""Binary pictures: the paper's fixed threshold, and thresholds chosen by the histogram.

Section 5.3 of the paper: pixels below the threshold become 0, those at or above it 255; "a
threshold of around 150 can isolate" the white block.
"""

import cv2
import numpy as np

from facetlog.perception.types import FloatArray, Image

__all__ = [
    "BLACK",
    "PAPER_THRESHOLD",
    "WHITE",
    "binary_picture",
    "grey_histogram",
    "otsu_threshold",
    "valley_threshold",
]

# Section 5.3: the threshold of figure 9(b), grey levels of 255.
PAPER_THRESHOLD = 150
BLACK, WHITE = 0, 255

GREY_LEVELS = 256
# The histogram is smoothed until it has two peaks only; more passes than this and it has one.
# (Prewitt and Mendelsohn 1966 smooth by threes; 10,000 passes are a Gaussian of some 80 levels.)
MOST_SMOOTHING_PASSES = 10_000


def binary_picture(image: Image, threshold: int = PAPER_THRESHOLD) -> Image:
    """The picture in 0 and 255: 0 below the threshold, 255 at or above it (section 5.3).

    >>> binary_picture(np.array([[149, 150, 151]], dtype=np.uint8)).tolist()
    [[0, 255, 255]]
    """
    return np.where(image >= threshold, np.uint8(WHITE), np.uint8(BLACK))


def grey_histogram(image: Image, mask: Image | None = None) -> FloatArray:
    """Number of pixels of each grey level, (256,), of the whole picture or where mask is not 0."""
    counts = cv2.calcHist([image], [0], mask, [GREY_LEVELS], [0, GREY_LEVELS])
    return counts.ravel().astype(np.float64)  # (256, 1) or (256,), as OpenCV's version has it


def otsu_threshold(image: Image) -> int:
    """The threshold that parts the histogram into two classes of least variance (Otsu 1979).

    It is the first grey level of the bright class, so it fits `binary_picture`.
    """
    last_dark, _ = cv2.threshold(image, 0, WHITE, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    return int(last_dark) + 1


def valley_threshold(image: Image) -> int | None:
    """The lowest level between the two peaks of the smoothed histogram; None if it has but one.

    Prewitt and Mendelsohn 1966: average over three levels until two peaks are left.
    """
    counts = grey_histogram(image)
    kernel = np.full(3, 1.0 / 3.0)
    for _ in range(MOST_SMOOTHING_PASSES):
        padded = np.concatenate([[-1.0], counts, [-1.0]])
        rises = np.diff(padded)
        steps = np.flatnonzero(rises)  # a flat top counts once, at its first level
        signs = np.sign(rises[steps])
        tops = steps[:-1][(signs[:-1] > 0) & (signs[1:] < 0)]
        if len(tops) < 2:
            return None
        if len(tops) == 2:
            return int(tops[0] + np.argmin(counts[tops[0] : tops[1] + 1]))
        counts = np.convolve(counts, kernel, mode="same")
    return None
