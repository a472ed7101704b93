"""Whether pictures of a thing on a mat suffice, and what to add: in words to act on."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from facetlog.perception.types import FloatArray

if TYPE_CHECKING:
    from facetlog.perception.reading.mat.mat_poses import PlacedPicture

ENOUGH_PICTURES = 12
WIDEST_GAP_DEG = 90.0
"""Widest gap between neighbouring directions: a side of a thing is then seen from two."""
# Heights of cameras above the mat's plane as seen from its middle, in degrees: lower hardly a
# corner of the mat is seen, higher none of the thing's sides.
LOW_DEG, HIGH_DEG = 20.0, 65.0
LEAST_SPREAD_DEG = 10.0
"""Least spread of these heights: with less, tops or sides are all seen at one slant."""
LEAST_SQUARE_PX = 20.0
"""A module of a marker has then three pixels, of a picture at an angle two."""
FEW_CORNERS = 0.2
"""Share of the mat's corners below which most of it is hidden, or outside of the picture."""
# Directions round the mat by who stands before its words: angles from x to y.
SIDES = (
    "the right",
    "the far right corner",
    "the far side, across from the words",
    "the far left corner",
    "the left",
    "the near left corner",
    "the near side, where the words are",
    "the near right corner",
)


def advice(pictures: "Sequence[PlacedPicture]") -> tuple[str, ...]:
    """Return what to add to pictures of a mat, a line each; nothing where they suffice."""
    return tuple(_iter_advice(pictures))


def _iter_advice(pictures: "Sequence[PlacedPicture]") -> Iterator[str]:
    missing = ENOUGH_PICTURES - len(pictures)
    if missing > 0:
        yield (
            f"too few: {len(pictures)} can be used, take {missing} more "
            f"({ENOUGH_PICTURES} to 30 are good)"
        )
    places = np.array([p.placed.pose.centre for p in pictures])
    yield from (f"from one side only: take some from {side}" for side in _unseen_sides(places))
    heights = np.degrees(np.arctan2(places[:, 2], np.hypot(places[:, 0], places[:, 1])))
    if np.median(heights) < LOW_DEG:
        yield "too flat: hold the camera higher, and look down on the thing more"
    elif np.median(heights) > HIGH_DEG:
        yield "too steep: hold the camera lower, so that the thing's sides are seen"
    elif len(heights) > 1 and np.ptp(heights) < LEAST_SPREAD_DEG:
        yield "all from one height: take some from higher up, and some from lower down"
    yield from _iter_advice_of_pictures(pictures)


def _unseen_sides(places: FloatArray) -> Iterator[str]:
    """Yield the middles of the gaps between directions (n, 3) that are too wide."""
    angles = np.sort(np.degrees(np.arctan2(places[:, 1], places[:, 0])) % 360.0)
    gaps = np.diff(np.append(angles, angles[0] + 360.0))
    for start, gap in zip(angles, gaps, strict=True):
        if gap > WIDEST_GAP_DEG:
            # As many places between as make the gap narrow enough.
            between = int(np.ceil(gap / WIDEST_GAP_DEG)) - 1
            for k in range(1, between + 1):
                middle = start + gap * k / (between + 1)
                yield SIDES[round(middle / 45.0) % len(SIDES)]


def _iter_advice_of_pictures(pictures: "Sequence[PlacedPicture]") -> Iterator[str]:
    far = [p for p in pictures if p.picture.seen.square_px < LEAST_SQUARE_PX]
    if 2 * len(far) > len(pictures):
        yield f"too far: in {len(far)} pictures the mat is small; go nearer, or take larger ones"
    hidden = [p for p in pictures if _compute_seen_share(p) < FEW_CORNERS]
    if 2 * len(hidden) > len(pictures):
        yield (
            f"the mat is hidden: in {len(hidden)} pictures little of it is seen; "
            "use larger paper, or a smaller thing"
        )


def _compute_seen_share(picture: "PlacedPicture") -> float:
    mat = picture.picture.seen.mat
    return len(picture.picture.seen.numbers) / ((mat.columns - 1) * (mat.rows - 1))
