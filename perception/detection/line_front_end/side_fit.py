"""Straight sides fitted to the edges of each view: at working size, then in the stored picture.

A picture that was kept reduced is read again at full size, and along each side the gradient across
it is measured in its own pixels: averaged over the part of the side that one reading stands for, so
that all pixels count and faint sides are found in the noise of a large picture, too.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.edge_maps import EdgeMap
from facetlog.perception.detection.line_front_end.segments_3d.line_refine import (
    STEP_PX,
    peak,
    read_edges,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_support import project_points
from facetlog.perception.types import FloatArray, Image, View

# Readings along a side; the ends are left out, where other edges interfere.
SAMPLES = 32
CLEAR_OF_ENDS = 0.05
SEARCH_PX = 3.0
# A side counts in a view when this share of its readings is found.
MIN_READ = 0.6
# Robust scale of a side's readings, px, and the least sd of one reading (interpolation).
ROBUST_PX = 0.5
MIN_READING_SD_PX = 0.05
# Neighbouring readings share pixels: noise smoothed by a Gaussian of s = sqrt(1 + 0.5) px, the
# gradient's, counts as one independent reading for each 2 sqrt(pi) s px along the edge.
INDEPENDENT_PX = 4.3
# Half the width searched in a stored picture, in px of the reduced one: many times the error of a
# fit there, and little enough to stay at the same edge.
STORED_SEARCH_PX = 0.75


@dataclass(frozen=True, eq=False, slots=True)
class SideFits:
    """Offsets of n sides in a view from their projection.

    `offset` (n, 2) px at start and end along unit `normal` (n, 2), `variance` (n, 2) of these in
    px²; `good` (n,) says which sides were found.
    """

    normal: FloatArray
    offset: FloatArray
    variance: FloatArray
    good: NDArray[np.bool_]

    def part(self, first: int, last: int) -> "SideFits":
        """Return the fits of some of the sides."""
        p = slice(first, last)
        return SideFits(self.normal[p], self.offset[p], self.variance[p], self.good[p])


def fit_sides(
    sides: FloatArray, visible: NDArray[np.bool_], views: Sequence[View], maps: Sequence[EdgeMap]
) -> tuple[SideFits, ...]:
    """Return sides (n, 2, 3) fitted in each view that shows them, `visible` (n, V)."""
    return tuple(
        _in_view(sides, visible[:, k], view, edges)
        for k, (view, edges) in enumerate(zip(views, maps, strict=True))
    )


def _in_view(sides: FloatArray, visible: NDArray[np.bool_], view: View, edges: EdgeMap) -> SideFits:
    uv, _ = project_points(view.projection, sides)
    share = _shares(SAMPLES)[:, None]
    at = sides[:, :1] + share * (sides[:, 1:] - sides[:, :1])
    read = read_edges(view, edges, at, SEARCH_PX)
    span = uv[:, 1] - uv[:, 0]
    length = np.maximum(np.hypot(span[:, 0], span[:, 1]), 1e-9)
    x = np.einsum("nmk,nk->nm", read.uv - uv[:, :1], span) / (length**2)[:, None]
    fits = _fitted(x, read.offset, read.normal, length)
    good = fits.good & visible & read.visible.all(axis=1)
    fits = SideFits(fits.normal, fits.offset, fits.variance, good)
    if view.stored is not None and good.any():
        _fit_stored(fits, uv, view, view.stored.read())
    return fits


def _shares(count: int) -> FloatArray:
    shares: FloatArray = CLEAR_OF_ENDS + (1 - 2 * CLEAR_OF_ENDS) * (np.arange(count) + 0.5) / count
    return shares


def _fitted(x: FloatArray, offset: FloatArray, normal: FloatArray, length: FloatArray) -> SideFits:
    # Straight lines through readings `offset` (n, m), NaN where there is none, at shares `x` (n, m)
    # of sides of so many px: robust least squares for the offsets at both ends.
    design = np.stack([1 - x, x], axis=-1)  # (n, m, 2)
    found = np.isfinite(offset)
    e = np.where(found, offset, 0.0)
    good = found.mean(axis=1) >= MIN_READ
    centre = np.zeros((len(x), 2))
    information = np.broadcast_to(np.eye(2), (len(x), 2, 2))
    residual = e
    for _ in range(4):
        w = found / (1.0 + (residual / ROBUST_PX) ** 2)
        information = np.einsum("nm,nma,nmb->nab", w, design, design) + 1e-9 * np.eye(2)
        centre = np.linalg.solve(information, np.einsum("nm,nma,nm->na", w, design, e)[..., None])[
            ..., 0
        ]
        residual = e - np.einsum("nma,na->nm", design, centre)
    spread = np.where(found, np.abs(residual), np.nan)
    sd = np.full(len(x), np.inf)
    sd[good] = 1.4826 * np.nanmedian(spread[good], axis=1)
    shared = np.maximum(1.0, SAMPLES * INDEPENDENT_PX / length)
    variance = np.maximum(sd, MIN_READING_SD_PX) ** 2 * shared
    cov = np.linalg.inv(information) * np.where(good, variance, 1.0)[:, None, None]
    return SideFits(normal, centre, np.diagonal(cov, axis1=1, axis2=2).copy(), good)


def _fit_stored(fits: SideFits, uv: FloatArray, view: View, image: Image) -> None:
    # Refits the good ones, in place; where the stored picture shows no edge, they stay.
    factor = view.enlargement
    chosen = np.nonzero(fits.good)[0]
    placed = uv[chosen] + fits.offset[chosen, :, None] * fits.normal[chosen, None]
    ends = (placed + 0.5) * factor - 0.5
    for k, (start, end) in zip(chosen.tolist(), ends, strict=True):
        span = end - start
        length = float(np.hypot(*span))
        across = np.array([-span[1], span[0]]) / length
        offset = _read_stored(image, start, end, across, STORED_SEARCH_PX * float(factor.max()))
        again = _fitted(_shares(SAMPLES)[None], offset[None], across[None], np.array([length]))
        if not again.good[0]:
            continue
        moved = again.offset[0, :, None] * across / factor
        fits.offset[k] += moved @ fits.normal[k]
        fits.variance[k] = again.variance[0] * ((across / factor) @ fits.normal[k]) ** 2


def _read_stored(
    image: Image, start: FloatArray, end: FloatArray, across: FloatArray, search_px: float
) -> FloatArray:
    # Offsets (SAMPLES,) of the edge from the line between two pixels, NaN where there is none.
    length = float(np.hypot(*(end - start)))
    each = max(round((1 - 2 * CLEAR_OF_ENDS) * length / SAMPLES), 1)
    rim = 4 * round(1 / STEP_PX)  # what smoothing reaches beyond the places that are looked at
    steps = round(search_px / STEP_PX) + round(1 / STEP_PX)
    reach = STEP_PX * np.arange(-steps - rim, steps + rim + 1, dtype=np.float64)
    along = start + _shares(SAMPLES * each)[:, None] * (end - start)
    at: NDArray[np.float32] = (along[:, None] + reach[:, None] * across).astype(np.float32)
    u, v = (np.ascontiguousarray(at[..., k]) for k in (0, 1))
    strip = cv2.remap(image, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    mean = strip.reshape(SAMPLES, each, -1).mean(axis=1)
    smooth = cv2.GaussianBlur(mean, (0, 0), sigmaX=1 / STEP_PX, sigmaY=1e-9)
    slope: FloatArray = np.abs(np.gradient(np.asarray(smooth, np.float64), STEP_PX, axis=1))
    offset, height = peak(slope[:, rim:-rim], reach[rim:-rim])
    return np.where(height > 0, offset, np.nan)
