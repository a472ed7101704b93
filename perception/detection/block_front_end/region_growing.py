"""Faces in the shade: the localised region grown to the object's border.

Section 5.3 of the paper: "one vertex has been lost in image 9(b), but this can be avoided if
region growing technique was employed for segmentation. But region growing is highly
time-consuming". Growing by a second, lower threshold in the window round the region costs little.
"""

import cv2
import numpy as np

from facetlog.perception.detection.block_front_end.chain_code import outer_outline, outline_shape
from facetlog.perception.detection.block_front_end.localise import Localisation
from facetlog.perception.detection.block_front_end.threshold import otsu_threshold
from facetlog.perception.types import Image

__all__ = ["grow_region"]

# The window reaches this share of the region's larger side beyond it on each side: a face in the
# shade is at most about as large as the one in the light.
WINDOW_SHARE = 0.75
# A grown region that is much less the outline of one flat-faced thing has run into the ground.
LEAST_SHAPE_SHARE = 0.9
# Smoothing before the lower threshold, px: the noise of a face must not leave holes in its rim.
SMOOTHING_PX = 1.0

GROWN = "grown into the shade"


def grow_region(image: Image, found: Localisation, threshold: int) -> Localisation:
    """The region grown to all that is brighter than the ground around and touches it.

    The ground's threshold is Otsu's in the window round the region. The region stays as it is
    where that threshold is no lower than `threshold`, where what grows leaves the window, or
    where its outline becomes a worse shape by chain code.
    """
    if not found:
        return found
    u, v, width, height = cv2.boundingRect(found.mask)
    margin = int(np.ceil(WINDOW_SHARE * max(width, height)))
    rows = slice(max(0, v - margin), min(image.shape[0], v + height + margin))
    columns = slice(max(0, u - margin), min(image.shape[1], u + width + margin))
    window = cv2.GaussianBlur(image[rows, columns], (0, 0), SMOOTHING_PX)
    lower = otsu_threshold(window.astype(np.uint8))
    if lower >= threshold:
        return found
    seed = found.mask[rows, columns] > 0
    brighter = ((window >= lower) | seed).astype(np.uint8)
    _, labels = cv2.connectedComponents(brighter, connectivity=4)
    # The region that most of the seed lies in; its specks across a gap of noise are left.
    grown = labels == int(np.bincount(labels[seed]).argmax())
    if _leaves(grown, rows, columns, image.shape):
        return found
    mask = np.zeros_like(found.mask)
    outlines, _ = cv2.findContours(grown.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    cv2.drawContours(mask[rows, columns], outlines, -1, 255, thickness=cv2.FILLED)
    before = outline_shape(outer_outline(found.mask)).score
    if outline_shape(outer_outline(mask)).score < LEAST_SHAPE_SHARE * before:
        return found
    return Localisation(mask, int(np.count_nonzero(mask)), f"{found.reason}, {GROWN}")


def _leaves(
    grown: np.ndarray[tuple[int, ...], np.dtype[np.bool_]],
    rows: slice,
    columns: slice,
    shape: tuple[int, ...],
) -> bool:
    """Whether the region reaches a side of the window that is not the picture's own rim."""
    return bool(
        (rows.start > 0 and grown[0].any())
        or (rows.stop < shape[0] and grown[-1].any())
        or (columns.start > 0 and grown[:, 0].any())
        or (columns.stop < shape[1] and grown[:, -1].any())
    )
