"""Step 2 of the paper's algorithm: threshold a picture and locate the object in it (section 5.3).

Pixels below the threshold become 0, those at or above it 255; "a threshold of around 150 can
isolate" the white block. "The white largest region corresponds to the block. Had there been a
number of large white regions, then ... the entire image is partitioned into equal sized blocks
and the blocks containing 80% or more white region is considered as the desired sub-block. Then
the connected sub-blocks are identified and the location of the desired object is detected
through shape analysis by the chain-code technique."

"One vertex has been lost in image 9(b), but this can be avoided if region growing technique was
employed for segmentation. But region growing is highly time-consuming": growing by a second, lower
threshold in the window round the region costs little, and adds the faces in the shade.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.types import Image

# Section 5.3: the threshold of figure 9(b), grey levels of 255.
PAPER_THRESHOLD = 150
GREY_LEVELS = 256
# The histogram is smoothed until it has two peaks only; more passes than this and it has one.
# (Prewitt and Mendelsohn 1966 smooth by threes; 10,000 passes are a Gaussian of some 80 levels.)
MOST_SMOOTHING_PASSES = 10_000

# The code of the step (du, dv), at [dv + 1, du + 1]; v runs down. Code k is the step at 45° k from
# the picture's right, counter-clockwise as seen (Freeman 1961).
STEP_CODES = np.array([[3, 2, 1], [4, -1, 0], [5, 6, 7]], dtype=np.int8)
STEPS = np.array([[1, 0], [1, -1], [0, -1], [-1, -1], [-1, 0], [-1, 1], [0, 1], [1, 1]])
# Length of a digital curve: even steps, odd steps, changes of code; the coefficients without
# bias for straight lines of random direction (Vossepoel and Smeulders 1982).
EVEN_STEP, ODD_STEP, CODE_CHANGE = 0.980, 1.406, -0.091
# A digital straight line is at worst this much longer than its chord: 1 / cos(22.5°).
LONGEST_LINE = 1.082
# A side is a stretch of outline that turns less than the paper's 30 degrees in all.
SIDE_TURN = np.deg2rad(30.0)
# The direction at a pixel is taken over this share of the outline (at least MIN_SUPPORT steps:
# four steps resolve 14 degrees on the grid).
SUPPORT_SHARE = 0.02
MIN_SUPPORT = 4
# A side is at least this share of the outline; a polygon of six sides, as a block shows, has
# sides well above it, while a disc is cut into twelve stretches of 1/12 = .083 each.
LEAST_SIDE_SHARE = 0.1

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

# The window of growing reaches this share of the region's larger side beyond it on each side: a
# face in the shade is at most about as large as the one in the light.
WINDOW_SHARE = 0.75
# A grown region that is much less the outline of one flat-faced thing has run into the ground.
LEAST_SHAPE_SHARE = 0.9
# Smoothing before the lower threshold, px: the noise of a face must not leave holes in its rim.
SMOOTHING_PX = 1.0


@dataclass(frozen=True, eq=False, slots=True)
class Localisation:
    """The object's mask (H, W) of 0 and 255 in one picture, and its area in pixels.

    Falsy where no object was found, with the reason.
    """

    mask: Image
    area_px: int
    reason: str = ""

    def __bool__(self) -> bool:
        return self.area_px > 0


def threshold_picture(image: Image, threshold: int = PAPER_THRESHOLD) -> Image:
    """Return the picture in 0 and 255: 0 below the threshold, 255 at or above it (section 5.3).

    >>> threshold_picture(np.array([[149, 150, 151]], dtype=np.uint8)).tolist()
    [[0, 255, 255]]
    """
    return np.where(image >= threshold, np.uint8(255), np.uint8(0))


def find_otsu_threshold(image: Image) -> int:
    """Return the threshold that separates the histogram into two classes of least variance.

    It is the first grey level of the bright class, so it fits `threshold_picture` (Otsu 1979).
    """
    last_dark, _ = cv2.threshold(image, 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    return int(last_dark) + 1


def find_valley_threshold(image: Image) -> int | None:
    """Return the lowest level between the two peaks of the smoothed histogram; None if it has one.

    Prewitt and Mendelsohn 1966: average over three levels until two peaks are left.
    """
    counts = np.bincount(image.ravel(), minlength=GREY_LEVELS).astype(np.float64)
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


def outline_score(mask: Image) -> float:
    """Score the mask's longest outline in [0, 1] as that of one flat-faced thing, by chain code.

    The product of compactness (4 pi area / perimeter²: 1 for a disc, .785 for a square),
    polygonality (share of the outline in straight stretches of some length) and straightness
    (chord over arc, mean over those stretches). All are invariant to scale, place and (up to the
    grid) rotation. 0 below eight pixels.
    """
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    outline = max(outlines, key=len, default=np.zeros((0, 1, 2), np.int32))[:, 0]
    count = len(outline)
    if count < 2 * MIN_SUPPORT:
        return 0.0
    steps = np.roll(outline, -1, axis=0) - outline
    codes: NDArray[np.int8] = STEP_CODES[steps[:, 1] + 1, steps[:, 0] + 1]
    odd = int((codes % 2).sum())
    changes = int((codes != np.roll(codes, 1)).sum())
    perimeter = EVEN_STEP * (count - odd) + ODD_STEP * odd + CODE_CHANGE * changes
    # The area through the middles of the pixels; the half pixel round it is Pick's.
    compactness = min(1.0, 4.0 * np.pi * cv2.contourArea(outline) / perimeter**2)
    support = max(MIN_SUPPORT, round(SUPPORT_SHARE * count))
    on_sides, chord_over_arc = 0.0, 0.0
    for begin, end in _find_straight_stretches(codes, support):
        # The directions look `support` steps ahead, so a side reaches that much further.
        stretch = codes[np.arange(begin, end + support) % count]
        share = (end - begin) / count
        if share >= LEAST_SIDE_SHARE:
            arc = float(np.hypot(*STEPS[stretch].T).sum())
            chord = float(np.hypot(*STEPS[stretch].sum(axis=0)))
            on_sides += share
            chord_over_arc += share * min(1.0, LONGEST_LINE * chord / arc)
    straightness = chord_over_arc / on_sides if on_sides else 0.0
    return compactness * min(1.0, on_sides) * straightness


def _find_straight_stretches(codes: NDArray[np.int8], support: int) -> list[tuple[int, int]]:
    """Return the stretches [start, end) of a closed chain that turn less than SIDE_TURN."""
    count = len(codes)
    closed = STEPS[np.concatenate([codes, codes[:support]])].astype(np.float64)
    sums = np.cumsum(np.concatenate([np.zeros((1, 2)), closed]), axis=0)
    chords = sums[support : support + count] - sums[:count]
    directions = np.unwrap(np.arctan2(-chords[:, 1], chords[:, 0]))
    # Start where the outline turns most, i.e. at a corner, not amid a side.
    start = int(np.argmax(np.abs(np.diff(directions, append=directions[0]))))
    turned = np.unwrap(np.roll(directions, -start - 1))
    sides = []
    begin, low, high = 0, turned[0], turned[0]
    for i, direction in enumerate(turned):
        low, high = min(low, direction), max(high, direction)
        if high - low > SIDE_TURN:
            sides.append((begin, i))
            begin, low, high = i, direction, direction
    sides.append((begin, count))
    return [((a + start + 1) % count, (a + start + 1) % count + b - a) for a, b in sides]


def localise(binary: Image) -> Localisation:
    """Find the object's region in a picture of 0 and 255, holes filled; falsy if there is none.

    The largest white region where it is the only large one; otherwise the joined sub-blocks of at
    least 80 % white whose outline is most compact, polygonal and straight (weighted by the root
    of the area, so that a fair piece beats a perfect speck).

    >>> picture = np.zeros((40, 60), dtype=np.uint8)
    >>> picture[10:30, 20:45] = 255
    >>> localise(picture).area_px
    500
    """

    def none(reason: str) -> Localisation:
        return Localisation(np.zeros_like(binary), 0, reason)

    _, _, stats, _ = cv2.connectedComponentsWithStats(binary, connectivity=8)
    areas = stats[1:, cv2.CC_STAT_AREA]
    if not len(areas):
        return none("nothing is as bright as the threshold")
    largest = int(areas.max())
    if largest < LEAST_AREA_PX:
        return none(f"the largest bright region has only {largest} pixels")
    if largest > MOST_PICTURE_SHARE * binary.size:
        return none("nearly the whole picture is bright")
    mask = None
    if np.count_nonzero(areas >= LARGE_SHARE * largest) > 1:
        mask = _find_best_shape(binary, LARGE_SHARE * largest)
    if mask is None:
        mask = _fill_holes(_keep_largest_region(binary))
    return Localisation(mask, int(np.count_nonzero(mask)))


def _find_best_shape(binary: Image, smallest: float) -> Image | None:
    """Return the white region of best shape and a fair size round joined white sub-blocks."""
    height, width = binary.shape
    side = max(LEAST_BLOCK_PX, min(height, width) // SUB_BLOCKS)
    rows, columns = height // side, width // side
    cut = binary[: rows * side, : columns * side] > 0
    white = cut.reshape(rows, side, columns, side).mean(axis=(1, 3))
    count, labels = cv2.connectedComponents((white >= WHITE_SHARE).astype(np.uint8), connectivity=4)
    best, best_score = None, 0.0
    for group in range(1, count):
        window = np.zeros_like(binary)
        grown = np.kron((labels == group).astype(np.uint8), np.ones((side, side), np.uint8))
        window[: grown.shape[0], : grown.shape[1]] = grown
        # The rim of the region fills no sub-block; it is the white within two blocks of one.
        reach = np.ones((4 * side + 1, 4 * side + 1), dtype=np.uint8)
        near = np.where(cv2.dilate(window, reach) > 0, binary, np.uint8(0))
        mask = _keep_largest_region(_fill_holes(near))
        area = int(np.count_nonzero(mask))
        if area < max(smallest, LEAST_AREA_PX):
            continue
        score = outline_score(mask) * np.sqrt(area)
        if score > best_score:
            best, best_score = mask, score
    return best


def _fill_holes(mask: Image) -> Image:
    # A dark print or a highlight does not cut the object.
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    filled = np.zeros_like(mask)
    cv2.drawContours(filled, outlines, -1, 255, thickness=cv2.FILLED)
    return filled


def _keep_largest_region(mask: Image) -> Image:
    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    if len(stats) < 2:
        return np.zeros_like(mask)
    largest = 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))
    return np.where(labels == largest, np.uint8(255), np.uint8(0))


def grow_region(image: Image, found: Localisation, threshold: int) -> Localisation:
    """Grow the region to all that is brighter than the ground around and touches it.

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
    lower = find_otsu_threshold(window.astype(np.uint8))
    if lower >= threshold:
        return found
    seed = found.mask[rows, columns] > 0
    brighter = ((window >= lower) | seed).astype(np.uint8)
    _, labels = cv2.connectedComponents(brighter, connectivity=4)
    # The region that most of the seed lies in; its specks across a gap of noise are left.
    grown = labels == int(np.bincount(labels[seed]).argmax())
    leaves_window = (
        (rows.start > 0 and grown[0].any())
        or (rows.stop < image.shape[0] and grown[-1].any())
        or (columns.start > 0 and grown[:, 0].any())
        or (columns.stop < image.shape[1] and grown[:, -1].any())
    )
    if leaves_window:
        return found
    mask = np.zeros_like(found.mask)
    mask[rows, columns] = _fill_holes(grown.astype(np.uint8))
    if outline_score(mask) < LEAST_SHAPE_SHARE * outline_score(found.mask):
        return found
    return Localisation(mask, int(np.count_nonzero(mask)))
