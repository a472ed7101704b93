"""Where a picture has edges, and which way they run: gradients and an oriented edge mask."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.picture_noise import noise_sd
from facetlog.perception.types import FloatArray, Image

__all__ = [
    "GRADIENT_SIGMA",
    "ORIENTATION_BINS",
    "EdgeMap",
    "Gradient",
    "direction_bits",
    "edge_map",
    "gradient",
    "working_noise",
]

# One bit of a uint16 for each 11.25° of orientation: as fine as a short segment is known.
ORIENTATION_BINS = 16
# Smoothing before the derivative, px: the usual compromise between noise and localisation.
GRADIENT_SIGMA = 1.0
# Hysteresis thresholds in standard deviations of the gradient's own noise.
LOW_SD, HIGH_SD = 3.0, 5.0
# A picture without noise (rendered, saturated) still has rounding, whose single steps are no edges.
MIN_NOISE_SD = 1.5


@dataclass(frozen=True, eq=False, slots=True)
class Gradient:
    """A picture's gradient across and down, each (H, W) float32 in grey levels per px."""

    gx: NDArray[np.float32]
    gy: NDArray[np.float32]


@dataclass(frozen=True, eq=False, slots=True)
class EdgeMap(Gradient):
    """A gradient with its noise, and the oriented mask (H, W) of the edges in it.

    Bit k of a mask pixel is set if an edge within `reach_px` runs in the direction
    [k, k + 1) · 180° / 16 (direction of the edge, not of its gradient).
    """

    gradient_noise: float
    mask: NDArray[np.uint16]
    reach_px: float


def working_noise(image: Image) -> float:
    """The picture's noise in grey levels that thresholds follow, MIN_NOISE_SD at least."""
    return max(noise_sd(image), MIN_NOISE_SD)


def gradient(image: Image) -> Gradient:
    """The gradient of a grey picture, smoothed by GRADIENT_SIGMA."""
    smooth = cv2.GaussianBlur(image.astype(np.float32), (0, 0), GRADIENT_SIGMA)
    return Gradient(
        _float32(cv2.Sobel(smooth, cv2.CV_32F, 1, 0, ksize=3, scale=1 / 8)),
        _float32(cv2.Sobel(smooth, cv2.CV_32F, 0, 1, ksize=3, scale=1 / 8)),
    )


def edge_map(image: Image, reach_px: float | None = None) -> EdgeMap:
    """Gradients and oriented edge mask of one grey picture.

    The mask's edges reach so far, or as far as right poses may leave them off.
    """
    slope = gradient(image)
    gx, gy = slope.gx, slope.gy
    # Noise of a Gaussian derivative: sd = sigma / (sqrt(8 π) s²), Sobel's own smoothing included.
    s2 = GRADIENT_SIGMA**2 + 0.5
    noise = working_noise(image) / (np.sqrt(8 * np.pi) * s2)
    # Canny wants 16-bit integers: 256 levels to each noise sd / 8 keep the ratio exact enough.
    unit, limit = np.float32(8.0 / noise), np.float32(32767.0 / 1.5)
    dx = np.clip(gx * unit, -limit, limit).astype(np.int16)
    dy = np.clip(gy * unit, -limit, limit).astype(np.int16)
    edges = cv2.Canny(dx, dy, LOW_SD * 8.0, HIGH_SD * 8.0, L2gradient=True) > 0

    reach = max(2.0, 0.0025 * float(np.hypot(*image.shape))) if reach_px is None else reach_px
    return EdgeMap(gx, gy, float(noise), _oriented_mask(edges, gx, gy, reach), reach)


def _float32(picture: cv2.typing.MatLike) -> NDArray[np.float32]:
    return np.asarray(picture, dtype=np.float32)


def _oriented_mask(
    edges: NDArray[np.bool_], gx: NDArray[np.float32], gy: NDArray[np.float32], reach: float
) -> NDArray[np.uint16]:
    rows, cols = np.nonzero(edges)
    # The edge runs at right angles to its gradient.
    direction = np.arctan2(gx[rows, cols], -gy[rows, cols]) % np.pi
    bins = np.minimum((direction * (ORIENTATION_BINS / np.pi)).astype(int), ORIENTATION_BINS - 1)
    size = 2 * round(reach) + 1
    sparse = np.zeros(edges.shape, np.uint16)
    sparse[rows, cols] = np.uint16(1) << bins.astype(np.uint16)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    mask = np.zeros(edges.shape, np.uint16)
    # A dilation of all bits at once: the picture, moved to each place of the disc.
    for down, across in np.argwhere(disc) - size // 2:
        into, of = _shifted(down, edges.shape[0]), _shifted(-down, edges.shape[0])
        beside, at = _shifted(across, edges.shape[1]), _shifted(-across, edges.shape[1])
        mask[into, beside] |= sparse[of, at]
    return mask


def _shifted(by: int, length: int) -> slice:
    # What is left of 0 ... length where all is moved by so much.
    return slice(max(by, 0), length + min(by, 0))


def direction_bits(direction: FloatArray) -> NDArray[np.uint16]:
    """Mask bits that an edge running at `direction` (radians, any shape) may have set.

    Its own bin and both neighbours: an orientation is known to about one bin.
    """
    k = np.floor((direction % np.pi) * (ORIENTATION_BINS / np.pi)).astype(int) % ORIENTATION_BINS
    one = np.uint16(1)
    near = [(k + d) % ORIENTATION_BINS for d in (-1, 0, 1)]
    bits = np.zeros(k.shape, np.uint16)
    for bin_index in near:
        bits |= one << bin_index.astype(np.uint16)
    return bits
