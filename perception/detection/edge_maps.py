"""Edges of a picture and their directions: gradients and an oriented edge mask."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.coarse_pictures import (
    GRADIENT_NOISE,
    CoarsePicture,
    Gradient,
    coarse_pictures,
    gradient,
)
from facetlog.perception.detection.picture_noise import Noise, measure_working_noise
from facetlog.perception.types import FloatArray, Image

# One bit of a uint16 for each 11.25° of orientation: as fine as a short segment is known.
ORIENTATION_BINS = 16
# The bits of each orientation and of both beside it.
NEAR_BINS = np.array(
    [
        sum(1 << (k + beside) % ORIENTATION_BINS for beside in (-1, 0, 1))
        for k in range(ORIENTATION_BINS)
    ],
    dtype=np.uint16,
)
# Hysteresis thresholds in standard deviations of the gradient's own noise.
LOW_SD, HIGH_SD = 3.0, 5.0
# Gradient noise of a picture enlarged by this factor (cubic) over that of one not enlarged, for the
# same white noise before. From the filters.
ENLARGED = {1: 1.0, 2: 1.75, 4: 1.78}


@dataclass(frozen=True, eq=False, slots=True)
class EdgeMap(Gradient):
    """A gradient with its noise, and the oriented mask (H, W) of the edges in it.

    Bit k of a mask pixel is set if an edge within `reach_px` runs in the direction
    [k, k + 1) · 180° / 16 (direction of the edge, not of its gradient). Of an edge that only a
    coarser scale shows half a pixel of that scale counts, if that is more.
    """

    gradient_noise: float
    mask: NDArray[np.uint16]
    reach_px: float


def edge_map(
    image: Image,
    reach_px: float | None = None,
    own_noise: Noise | None = None,
    coarser: Sequence[CoarsePicture] | None = None,
) -> EdgeMap:
    """Return gradients and oriented edge mask of one grey picture.

    The mask's edges are dilated by `reach_px`, or by the usual effect of pose errors. The noise is
    estimated from the picture if `own_noise` is None. In a noisy picture edges that only its
    coarser scales show are added; callers that have these scales already pass them as `coarser`.
    """
    slope = gradient(image)
    white = measure_working_noise(image) if own_noise is None else own_noise
    noise = ENLARGED[white.factor] * white.sd
    reach = max(2.0, 0.0025 * float(np.hypot(*image.shape))) if reach_px is None else reach_px
    sparse = {reach: _find_oriented_edges(slope, noise)}
    for coarse in coarse_pictures(image, white) if coarser is None else coarser:
        unrest = float(np.hypot(coarse.noise, coarse.grain))
        # Pixel k of a picture reduced by f stands at f k, and for half of what lies between two.
        faint = sparse.setdefault(max(reach, coarse.factor / 2), np.zeros(image.shape, np.uint16))
        faint[:: coarse.factor, :: coarse.factor] |= _find_oriented_edges(coarse.slope, unrest)
    mask = np.bitwise_or.reduce([_widened(edges, far) for far, edges in sparse.items()])
    return EdgeMap(slope.gx, slope.gy, noise * GRADIENT_NOISE, mask, reach)


def _find_oriented_edges(slope: Gradient, noise: float) -> NDArray[np.uint16]:
    # The bit of its direction at each pixel of an edge.
    # Canny needs 16-bit integers: 8 for each sd of the gradient's noise are exact enough.
    unit, limit = np.float32(8.0 / (noise * GRADIENT_NOISE)), np.float32(32767.0 / 1.5)
    dx = np.clip(slope.gx * unit, -limit, limit).astype(np.int16)
    dy = np.clip(slope.gy * unit, -limit, limit).astype(np.int16)
    edges = cv2.Canny(dx, dy, LOW_SD * 8.0, HIGH_SD * 8.0, L2gradient=True) > 0
    rows, cols = np.nonzero(edges)
    # The edge runs at right angles to its gradient.
    direction = np.arctan2(slope.gx[rows, cols], -slope.gy[rows, cols]) % np.pi
    bins = np.minimum((direction * (ORIENTATION_BINS / np.pi)).astype(int), ORIENTATION_BINS - 1)
    sparse = np.zeros(edges.shape, np.uint16)
    sparse[rows, cols] = np.uint16(1) << bins.astype(np.uint16)
    return sparse


def _widened(sparse: NDArray[np.uint16], reach: float) -> NDArray[np.uint16]:
    size = 2 * round(reach) + 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    mask = np.zeros_like(sparse)
    # A dilation of all bits at once: the picture, moved to each place of the disc.
    for down, across in np.argwhere(disc) - size // 2:
        into, of = _shifted(down, mask.shape[0]), _shifted(-down, mask.shape[0])
        beside, at = _shifted(across, mask.shape[1]), _shifted(-across, mask.shape[1])
        mask[into, beside] |= sparse[of, at]
    return mask


def _shifted(by: int, length: int) -> slice:
    # The part of 0 ... length that remains inside when moved by so much.
    return slice(max(by, 0), length + min(by, 0))


def encode_direction(direction: FloatArray) -> NDArray[np.uint16]:
    """Return mask bits that an edge running at `direction` (radians, any shape) may have set.

    Its own bin and both neighbours: an orientation is known to about one bin.
    """
    k = np.floor(direction % np.pi * (ORIENTATION_BINS / np.pi)).astype(np.intp)
    return NEAR_BINS[k % ORIENTATION_BINS]
