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

from facetlog.perception.types import FloatArray, Image

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


# The code of the step (du, dv), at [dv + 1, du + 1]; v runs down.
STEP_CODES = np.array([[3, 2, 1], [4, -1, 0], [5, 6, 7]], dtype=np.int8)
STEPS = np.array([[1, 0], [1, -1], [0, -1], [-1, -1], [-1, 0], [-1, 1], [0, 1], [1, 1]])

# Length of a digital curve: even steps, odd steps, changes of code; the coefficients without
# bias for straight lines of random direction (Vossepoel and Smeulders 1982).
EVEN_STEP, ODD_STEP, CODE_CHANGE = 0.980, 1.406, -0.091

# A side is a stretch of outline that turns less than the paper's 30 degrees in all.
SIDE_TURN = np.deg2rad(30.0)
# The direction at a pixel is taken over this share of the outline (at least MIN_SUPPORT steps:
# four steps resolve 14 degrees on the grid).
SUPPORT_SHARE = 0.02
MIN_SUPPORT = 4
# A side is at least this share of the outline; a polygon of six sides, as a block shows, has
# sides well above it, while a disc is cut into twelve stretches of 1/12 = .083 each.
LEAST_SIDE_SHARE = 0.1


@dataclass(frozen=True, slots=True)
class OutlineShape:
    """Shape descriptors of a closed outline, each in [0, 1].

    compactness: 4 pi area / perimeter², 1 for a disc, .785 for a square.
    polygonality: share of the outline in sides, i.e. in straight stretches of some length.
    straightness: chord over arc, mean over those sides.
    """

    compactness: float
    polygonality: float
    straightness: float
    histogram: tuple[float, ...]

    @property
    def score(self) -> float:
        """A score for the outline of one flat-faced thing: the product of the descriptors."""
        return self.compactness * self.polygonality * self.straightness


def outer_outline(mask: Image) -> NDArray[np.int64]:
    """The longest outer outline of a mask as a closed 8-connected loop of pixels (u, v), (n, 2)."""
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not outlines:
        return np.zeros((0, 2), dtype=np.int64)
    return max(outlines, key=len)[:, 0, :].astype(np.int64)


def freeman_chain(outline: NDArray[np.int64]) -> NDArray[np.int8]:
    """Freeman codes (n,) of a closed loop of 8-connected pixels (u, v), (n, 2).

    >>> freeman_chain(np.array([[0, 0], [0, 1], [1, 1], [1, 0]])).tolist()
    [6, 0, 2, 4]
    """
    if len(outline) < 2:
        return np.zeros(0, dtype=np.int8)
    steps = np.roll(outline, -1, axis=0) - outline
    if np.abs(steps).max() != 1 or not np.abs(steps).max(axis=1).all():
        raise ValueError("the outline is not a chain of neighbouring pixels")
    codes: NDArray[np.int8] = STEP_CODES[steps[:, 1] + 1, steps[:, 0] + 1]
    return codes


def chain_length(codes: NDArray[np.int8]) -> float:
    """Length of the digital curve in pixels, without bias for straight stretches."""
    odd = int((codes % 2).sum())
    changes = int((codes != np.roll(codes, 1)).sum())
    return EVEN_STEP * (len(codes) - odd) + ODD_STEP * odd + CODE_CHANGE * changes


def _directions(codes: NDArray[np.int8], support: int) -> FloatArray:
    """Direction (radians, unwrapped) of the outline at each step, over `support` steps."""
    steps = STEPS[codes].astype(np.float64)
    closed = np.concatenate([steps, steps[:support]])
    sums = np.cumsum(np.concatenate([np.zeros((1, 2)), closed]), axis=0)
    chords = sums[support : support + len(codes)] - sums[: len(codes)]
    return np.unwrap(np.arctan2(-chords[:, 1], chords[:, 0]))


def _sides(directions: FloatArray) -> list[tuple[int, int]]:
    """Stretches [start, end) of the closed loop that turn less than SIDE_TURN, greedily."""
    count = len(directions)
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


def outline_shape(outline: NDArray[np.int64]) -> OutlineShape:
    """Shape of a closed outline, from its Freeman chain code; all 0 below eight pixels."""
    if len(outline) < 2 * MIN_SUPPORT:
        return OutlineShape(0.0, 0.0, 0.0, (0.0,) * 8)
    codes = freeman_chain(outline)
    perimeter = chain_length(codes)
    u, v = outline[:, 0].astype(np.float64), outline[:, 1].astype(np.float64)
    # Shoelace formula through the middles of the pixels; the half pixel round it is Pick's.
    area = 0.5 * abs(float(u @ np.roll(v, -1) - v @ np.roll(u, -1)))
    compactness = min(1.0, 4.0 * np.pi * area / perimeter**2)
    support = max(MIN_SUPPORT, round(SUPPORT_SHARE * len(codes)))
    count, on_sides, chord_over_arc = len(codes), 0.0, 0.0
    for begin, end in _sides(_directions(codes, support)):
        # The directions look `support` steps ahead, so a side reaches that much further.
        stretch = codes[np.arange(begin, end + support) % count]
        arc = float(np.hypot(*STEPS[stretch].T).sum())
        share = (end - begin) / count
        if share >= LEAST_SIDE_SHARE:
            chord = float(np.hypot(*STEPS[stretch].sum(axis=0)))
            on_sides += share
            # A digital straight line is at worst 1/cos(22.5°) = 1.082 longer than its chord.
            chord_over_arc += share * min(1.0, 1.082 * chord / arc)
    histogram = np.bincount(codes, minlength=8) / count
    return OutlineShape(
        compactness,
        min(1.0, on_sides),
        chord_over_arc / on_sides if on_sides else 0.0,
        tuple(float(share) for share in histogram),
    )


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


# The window reaches this share of the region's larger side beyond it on each side: a face in the
# shade is at most about as large as the one in the light.
WINDOW_SHARE = 0.75
# A grown region that is much less the outline of one flat-faced thing has run into the ground.
LEAST_SHAPE_SHARE = 0.9
# Smoothing before the lower threshold, px: the noise of a face must not leave holes in its rim.
WINDOW_SMOOTHING_PX = 1.0

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
    window = cv2.GaussianBlur(image[rows, columns], (0, 0), WINDOW_SMOOTHING_PX)
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
