"""Freeman chain codes of closed outlines, and shape descriptors computed from them.

Code k is the step at 45° k from the picture's right, counter-clockwise as seen (0 right, 2 up,
4 left, 6 down): Freeman 1961. All descriptors are invariant to scale, place and (up to the grid)
rotation.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.types import FloatArray, Image

__all__ = ["OutlineShape", "chain_length", "freeman_chain", "outer_outline", "outline_shape"]

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
