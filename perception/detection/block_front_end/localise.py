"""Where the object is: the largest white region, or the best shaped one of several.

Section 5.3 of the paper: "the white largest region corresponds to the block. Had there been a
number of large white regions, then ... the entire image is partitioned into equal sized blocks
and the blocks containing 80% or more white region is considered as the desired sub-block. Then
the connected sub-blocks are identified and the location of the desired object is detected
through shape analysis by the chain-code technique."
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.block_front_end.chain_code import outer_outline, outline_shape
from facetlog.perception.types import Image

__all__ = ["Localisation", "localise"]

# The paper's share of white in a sub-block.
WHITE_SHARE = 0.80
# A second region counts as large from this share of the largest one's area on; the paper's
# "noisy white region ... being small enough compared to the large sized white block" is below.
LARGE_SHARE = 0.25
# Sub-blocks along the picture's shorter side: fine enough that a thing of a tenth of the picture
# covers several, coarse enough that specks and threads of white fill none.
SUB_BLOCKS = 40
LEAST_BLOCK_PX = 4
# A smaller region has no traceable sides: four sides of eight pixels each.
LEAST_AREA_PX = 64
# White that fills more of the picture than this has no ground around it to stand out from.
MOST_PICTURE_SHARE = 0.95

LARGEST_REGION, SUB_BLOCK_SHAPE = "largest region", "sub-blocks by shape"


@dataclass(frozen=True, eq=False, slots=True)
class Localisation:
    """Where the object is in one picture: mask (H, W) of 0 and 255, and its area in pixels.

    Falsy where no object was found; `reason` says why, or which way it was found.
    """

    mask: Image
    area_px: int
    reason: str

    def __bool__(self) -> bool:
        return self.area_px > 0


def _nothing(binary: Image, reason: str) -> Localisation:
    return Localisation(np.zeros_like(binary), 0, reason)


def _filled(mask: Image) -> Image:
    """The mask with its holes filled (a dark print or a highlight does not cut the object)."""
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    filled = np.zeros_like(mask)
    cv2.drawContours(filled, outlines, -1, 255, thickness=cv2.FILLED)
    return filled


def _sub_block_groups(binary: Image) -> tuple[NDArray[np.int32], int, int]:
    """Labels of the joined sub-blocks (rows, columns), number of groups, side of a sub-block."""
    height, width = binary.shape
    side = max(LEAST_BLOCK_PX, min(height, width) // SUB_BLOCKS)
    rows, columns = height // side, width // side
    cut = binary[: rows * side, : columns * side] > 0
    white = cut.reshape(rows, side, columns, side).mean(axis=(1, 3))
    kept = (white >= WHITE_SHARE).astype(np.uint8)
    count, labels = cv2.connectedComponents(kept, connectivity=4)
    return labels.astype(np.int32), count - 1, side


def _by_shape(binary: Image, smallest: float) -> Localisation:
    """The group of sub-blocks whose white region has the best shape and a fair size."""
    labels, count, side = _sub_block_groups(binary)
    best, best_score = _nothing(binary, "no sub-block is white enough"), 0.0
    for group in range(1, count + 1):
        blocks = (labels == group).astype(np.uint8)
        window = np.zeros_like(binary)
        grown = cv2.resize(blocks, None, fx=side, fy=side, interpolation=cv2.INTER_NEAREST)
        window[: grown.shape[0], : grown.shape[1]] = grown
        # The rim of the region fills no sub-block; it is the white within two blocks of one.
        reach = np.ones((4 * side + 1, 4 * side + 1), dtype=np.uint8)
        near = np.where(cv2.dilate(window, reach) > 0, binary, np.uint8(0))
        mask = _largest(_filled(near))
        area = int(np.count_nonzero(mask))
        if area < max(smallest, LEAST_AREA_PX):
            continue
        score = outline_shape(outer_outline(mask)).score * np.sqrt(area)
        if score > best_score:
            best, best_score = Localisation(mask, area, SUB_BLOCK_SHAPE), score
    return best


def _largest(mask: Image) -> Image:
    """The largest connected region of the mask alone."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    if len(stats) < 2:
        return np.zeros_like(mask)
    largest = 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))
    return np.where(labels == largest, np.uint8(255), np.uint8(0))


def localise(binary: Image) -> Localisation:
    """The object's region in a picture of 0 and 255, holes filled; falsy with a reason if none.

    The largest white region where it is the only large one; otherwise the joined sub-blocks of at
    least 80 % white whose outline is most compact, polygonal and straight (weighted by the root
    of the area, so that a fair piece beats a perfect speck).

    >>> picture = np.zeros((40, 60), dtype=np.uint8)
    >>> picture[10:30, 20:45] = 255
    >>> localise(picture).area_px
    500
    """
    _, labels, stats, _ = cv2.connectedComponentsWithStats(binary, connectivity=8)
    areas = stats[1:, cv2.CC_STAT_AREA]
    if not len(areas):
        return _nothing(binary, "nothing is as bright as the threshold")
    largest = int(areas.max())
    if largest < LEAST_AREA_PX:
        return _nothing(binary, f"the largest bright region has only {largest} pixels")
    if largest > MOST_PICTURE_SHARE * binary.size:
        return _nothing(binary, "nearly the whole picture is bright")
    if np.count_nonzero(areas >= LARGE_SHARE * largest) > 1:
        found = _by_shape(binary, LARGE_SHARE * largest)
        if found:
            return found
    mask = np.where(labels == 1 + int(np.argmax(areas)), np.uint8(255), np.uint8(0))
    mask = _filled(mask)
    return Localisation(mask, int(np.count_nonzero(mask)), LARGEST_REGION)
