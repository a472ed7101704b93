"""Laplacian edges inside the localised region, traced into chains of pixels.

Section 5.3 of the paper: "The Laplacian operator then is used to determine the edges of the
block ... the pixels on the edges are traced". An edge pixel is a zero crossing of the Laplacian
of the smoothed picture (Marr and Hildreth 1980) whose gradient stands out of the noise.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.picture_noise import noise_sd
from facetlog.perception.types import FloatArray, Image

__all__ = ["SMOOTHING_PX", "edge_pixels", "trace_chains"]

# Smoothing before the Laplacian, px: enough to make its zero crossings connected at the noise of
# ordinary cameras, and no wider than the pictures' own blur.
SMOOTHING_PX = 1.4
# A zero crossing is an edge where the gradient is this many times its own noise. A Rayleigh
# distributed gradient passes 5 sd once in 270,000 pixels.
GRADIENT_SIGNIFICANCE = 5.0
# An edge also has a step of a few grey levels, so that a noiseless picture's rounding is none.
LEAST_STEP_GREY = 4.0
# The edge lies within this distance of the thresholded region's border, px: the reach of the
# smoothing (2 sd) and a pixel of the threshold's own bias.
BAND_PX = 4

# Neighbours in the order of a walk: straight ones first, so that chains take no corner short cut.
_NEIGHBOURS = ((0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, -1), (-1, 1))


def edge_pixels(image: Image, mask: Image, sd_grey: float | None = None) -> NDArray[np.bool_]:
    """Zero crossings (H, W) of the Laplacian in and just round the mask, one pixel thin.

    `sd_grey` is the noise of the picture in grey levels; estimated if not given.
    """
    noise = noise_sd(image) if sd_grey is None else sd_grey
    found = np.zeros(image.shape, dtype=np.bool_)
    if not mask.any():
        return found
    # Only the window of the mask is worked on.
    u, v, w, h = cv2.boundingRect(mask)
    margin = BAND_PX + int(np.ceil(4 * SMOOTHING_PX))
    rows = slice(max(0, v - margin), min(image.shape[0], v + h + margin))
    columns = slice(max(0, u - margin), min(image.shape[1], u + w + margin))
    smooth = cv2.GaussianBlur(image[rows, columns].astype(np.float32), (0, 0), SMOOTHING_PX)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * BAND_PX + 1, 2 * BAND_PX + 1))
    near = cv2.dilate(mask[rows, columns], disc) > 0

    gradient_u = cv2.Sobel(smooth, cv2.CV_32F, 1, 0, scale=1.0 / 8.0)
    gradient_v = cv2.Sobel(smooth, cv2.CV_32F, 0, 1, scale=1.0 / 8.0)
    gradient = np.hypot(gradient_u, gradient_v)
    # White noise of sd s has gradients of sd s / (sqrt(8 pi) b²) after a Gaussian of b pixels;
    # a step of C grey levels has C / (sqrt(2 pi) b) (the pictures' own blur left out).
    gradient_sd = noise / (np.sqrt(8.0 * np.pi) * SMOOTHING_PX**2)
    weakest = max(
        GRADIENT_SIGNIFICANCE * gradient_sd, LEAST_STEP_GREY / (np.sqrt(2 * np.pi) * SMOOTHING_PX)
    )
    laplacian = cv2.Laplacian(smooth, cv2.CV_32F, ksize=1)
    positive = laplacian > 0
    crossing = np.zeros(smooth.shape, dtype=np.bool_)
    magnitude = np.abs(laplacian)
    # Of two neighbours of different sign the one nearer to zero is the edge pixel.
    across = positive[:, 1:] != positive[:, :-1]
    left = magnitude[:, :-1] <= magnitude[:, 1:]
    crossing[:, :-1] |= across & left
    crossing[:, 1:] |= across & ~left
    down = positive[1:] != positive[:-1]
    upper = magnitude[:-1] <= magnitude[1:]
    crossing[:-1] |= down & upper
    crossing[1:] |= down & ~upper
    found[rows, columns] = crossing & near & (gradient >= weakest)
    # The picture's own rim is no edge of a thing.
    found[[0, -1], :] = False
    found[:, [0, -1]] = False
    return found


def trace_chains(edges: NDArray[np.bool_], least_pixels: int) -> tuple[FloatArray, ...]:
    """Chains of neighbouring edge pixels (u, v), each (n, 2) with n >= `least_pixels`.

    A chain is walked from an end where there is one; where edges fork it goes on and the other
    branch becomes a chain of its own. A closed chain repeats its first pixel at its end.
    """
    count, labels = cv2.connectedComponents(edges.astype(np.uint8), connectivity=8)
    sizes = np.bincount(labels.ravel(), minlength=count)
    sizes[0] = 0
    kept = (sizes >= least_pixels)[labels]
    degree = cv2.boxFilter(
        kept.astype(np.uint8), -1, (3, 3), normalize=False, borderType=cv2.BORDER_CONSTANT
    )
    rows, columns = np.nonzero(kept)
    by_degree = np.argsort(degree[rows, columns], kind="stable")  # ends before middles
    left = set(zip(rows.tolist(), columns.tolist(), strict=True))
    chains = []
    starts = zip(rows[by_degree].tolist(), columns[by_degree].tolist(), strict=True)
    for start in starts:
        if start not in left:
            continue
        left.discard(start)
        forward = _walk(start, left)
        backward = _walk(start, left)
        chain = [*reversed(backward), start, *forward]
        if len(chain) < least_pixels:
            continue
        if max(abs(chain[0][0] - chain[-1][0]), abs(chain[0][1] - chain[-1][1])) <= 1:
            chain.append(chain[0])
        chains.append(np.array(chain, dtype=np.float64)[:, ::-1].copy())
    return tuple(chains)


def _walk(start: tuple[int, int], left: set[tuple[int, int]]) -> list[tuple[int, int]]:
    """Pixels from `start` on, taken out of `left`, until none is next to the last."""
    walked = []
    row, column = start
    while True:
        for down, right in _NEIGHBOURS:
            step = (row + down, column + right)
            if step in left:
                left.discard(step)
                walked.append(step)
                row, column = step
                break
        else:
            return walked
