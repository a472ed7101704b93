"""Photo-consistency: a log-likelihood ratio that the pictures show one surface at given points.

A point of a surface has one brightness: the views that see it agree, up to noise, a change of
light and the error of its place. A point in the air has the brightness of whatever lies behind it,
which differs between views. How likely a level is by chance follows from each picture's own
levels, so that a plain background proves nothing and a rare level much.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.coarse_pictures import GRADIENT_SIGMA, Gradient
from facetlog.perception.detection.picture_noise import Noise, measure_working_noise
from facetlog.perception.types import FloatArray, Image, View

# Probability that a view does not see the surface though it faces it: it is occluded.
HIDDEN = 0.3
# Light changes with the view by this share of the level: gloss, vignetting, exposure.
LIGHT_SHARE = 0.02
# Error in px of where a point of a surface is looked up: to a whole px, before its plane is fitted.
PLACE_PX = 0.5
# Share of the chance density that is even over all levels: no level is impossible.
EVEN_SHARE = 0.1
# Penalty for the surface's own level, a free parameter: chosen among some twenty that differ.
FREE_LEVEL = float(np.log(20.0))
# Levels tried are those of so many views: of a surface that half of them show 1 in 250 is missed.
TRIED_VIEWS = 8
# A view agrees when its level is within this many standard deviations.
AGREES_SDS = 3.0
# With noise of twice the change of light at a middle grey, single pixels of a few views are still
# evidence enough.
NOISE_BORNE = 2 * LIGHT_SHARE * 128
# A Gaussian of so many px divides the noise of pixels by 2 √π times as much; of fewer px than
# LEAST_SIGMA it hardly averages.
AVERAGING, LEAST_SIGMA = float(2 * np.sqrt(np.pi)), 0.5
BLOCK = 512

_Number = TypeVar("_Number", np.uint8, np.float32)


@dataclass(frozen=True, eq=False, slots=True)
class Levels:
    """Grey levels (V, ...) float32 of points in V views, their standard deviations, and the density
    of such a level by chance; a level is NaN where the view does not see the point.
    """

    level: NDArray[np.float32]
    sd: NDArray[np.float32]
    chance: NDArray[np.float32]

    def where(self, clear: NDArray[np.bool_]) -> "Levels":
        """Return the levels of those points (V, ...) only that are clear."""
        level = np.where(clear, self.level, np.float32(np.nan))
        return Levels(level, self.sd, self.chance)


@dataclass(frozen=True, eq=False, slots=True)
class Agreement:
    """`ratio` (...): log-likelihood ratio of a surface against chance; `agrees` (V, ...); `level`
    (...) of the surface: the mean of those that agree.
    """

    ratio: FloatArray
    agrees: NDArray[np.bool_]
    level: NDArray[np.float32]


class GreyLevels:
    """The pictures of a set of views, to be sampled at any points.

    `exposure` (V,) is the factor by which each view is brighter than usual; levels are divided by
    it, None means equal exposures. `noises` are for pictures whose noise cannot be estimated from
    their own pixels, as of enlarged ones (working_size.py).
    """

    def __init__(
        self,
        views: Sequence[View],
        gradients: Sequence[Gradient],
        exposure: FloatArray | None = None,
        noises: Sequence[Noise] | None = None,
    ) -> None:
        own = noises or [measure_working_noise(view.image) for view in views]
        smooth = [_averaged(view.image, noise) for view, noise in zip(views, own, strict=True)]
        even = np.ones(len(views)) if exposure is None else exposure
        self._exposure = even.astype(np.float32)
        self.noise = np.array([noise for _, noise in smooth], dtype=np.float32)
        sds = [
            _compute_sds(image, slope, noise) / by
            for (image, noise), slope, by in zip(smooth, gradients, self._exposure, strict=True)
        ]
        self._chance = np.array(
            [_density(*each) * by for each, by in zip(smooth, self._exposure, strict=True)]
        )
        # All pictures pixel by pixel, and where each begins: one look-up for all views.
        self._widths = np.array([sd.shape[1] for sd in sds])
        self._begins = np.cumsum([0, *(sd.size for sd in sds)])
        self._grey = np.concatenate([image.ravel() for image, _ in smooth])
        self._sd = np.concatenate([sd.ravel() for sd in sds])

    def read(
        self, views: NDArray[np.intp], uv: NDArray[np.floating], seen: NDArray[np.bool_]
    ) -> Levels:
        """Return levels at pixels (2, v, ...) of the chosen views (v,), where `seen` (v, ...)."""
        by_view = (-1, *[1] * (seen.ndim - 1))
        column, row = np.where(seen, np.rint(uv), 0).astype(np.intp)
        at = row * self._widths[views].reshape(by_view) + column
        at += self._begins[views].reshape(by_view)
        grey = self._grey.take(at)
        chance = self._chance.take(grey + 256 * views.reshape(by_view))
        by = self._exposure[views].reshape(by_view)
        level = np.where(seen, grey / by, np.float32(np.nan))
        return Levels(level, self._sd.take(at), chance)

    def warped(self, view: int, pixels: FloatArray, shape: tuple[int, int]) -> NDArray[np.float32]:
        """Return levels of a plane's points, of `shape`, as a view has them; NaN where the view
        does not see the point.

        `pixels` (3, 3) takes (column, row, 1) of a point to its homogeneous pixel, its last entry
        the depth up to a positive factor.
        """
        level = self._of_view(self._grey, view) / self._exposure[view]
        level[[0, -1]] = level[:, [0, -1]] = np.nan  # the border is no picture of its own
        found = _warp(level, pixels, shape)
        column, row = np.meshgrid([0, shape[1] - 1], [0, shape[0] - 1])
        if (pixels[2] @ [column.ravel(), row.ravel(), [1] * 4]).min() <= 0:
            found[~_plane_seen(pixels, shape)] = np.nan
        return found

    def warped_sds(
        self, view: int, pixels: FloatArray, shape: tuple[int, int]
    ) -> NDArray[np.float32]:
        """Return the standard deviations of the levels of a plane's points, as of `warped`."""
        return _warp(self._of_view(self._sd, view), pixels, shape)

    def _of_view(self, all_: NDArray[_Number], view: int) -> NDArray[_Number]:
        flat = all_[self._begins[view] : self._begins[view + 1]]
        return flat.reshape(-1, self._widths[view])


def _compute_sds(image: Image, slope: Gradient, noise: float) -> NDArray[np.float32]:
    level = image.astype(np.float32) * np.float32(LIGHT_SHARE)
    place = cv2.magnitude(slope.gx, slope.gy) * np.float32(PLACE_PX)
    return np.sqrt(level**2 + place**2 + np.float32(noise) ** 2)


def _warp(
    picture: NDArray[np.float32], pixels: FloatArray, shape: tuple[int, int]
) -> NDArray[np.float32]:
    flags = cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP
    border = cv2.BORDER_CONSTANT
    warped = cv2.warpPerspective(
        picture, pixels, shape[::-1], flags=flags, borderMode=border, borderValue=np.nan
    )
    return np.asarray(warped, dtype=np.float32)


def _plane_seen(matrix: FloatArray, shape: tuple[int, int]) -> NDArray[np.bool_]:
    # Which points (column, row) of a plane lie before the camera of a homography.
    column, row = np.arange(shape[1]), np.arange(shape[0])[:, None]
    return np.asarray(matrix[2, 0] * column + matrix[2, 1] * row + matrix[2, 2] > 0)


def agreement(levels: Levels, weight: FloatArray) -> Agreement:
    """Return the joint evidence of levels (V, ...), each view by its weight (V,) beside similar
    views.

    With h = HIDDEN, the ratio is the maximum over the surface's own level m of
    Σ weight · log(h + (1 - h) · N(level; m, sd²) / chance), less FREE_LEVEL: an occluded view, an
    outlier, costs little whatever it shows.
    """
    shape = levels.level.shape
    level = levels.level.reshape(len(weight), -1)
    seen = np.isfinite(level)
    grey = np.where(seen, level, np.float32(-1e4))
    inverse = np.float32(1.0) / levels.sd.reshape(grey.shape)
    chance = levels.chance.reshape(grey.shape)
    strength = np.float32((1 - HIDDEN) / np.sqrt(2 * np.pi)) * inverse / chance
    counts = weight.astype(np.float32)[:, None] * seen
    tried = np.linspace(0, len(grey) - 1, min(len(grey), TRIED_VIEWS)).round().astype(int)
    best, chosen = np.empty((2, grey.shape[1]), dtype=np.float32)
    # So many points at a time stay in the processor's cache.
    for first in range(0, grey.shape[1], BLOCK):
        part = slice(first, first + BLOCK)
        trial = grey[tried, part]  # (t, n)
        off = grey[:, part] - trial[:, None]
        off *= inverse[:, part]
        likely = np.float32(-0.5) * off
        likely *= off
        np.exp(likely, out=likely)
        likely *= strength[:, part]
        likely += np.float32(HIDDEN)
        np.log(likely, out=likely)
        ratio = np.einsum("tvn,vn->tn", likely, counts[:, part])
        ratio[trial < 0] = -np.inf
        most = ratio.argmax(axis=0), np.arange(trial.shape[1])
        best[part], chosen[part] = ratio[most], trial[most]
    agrees = seen & (np.abs(grey - chosen) * inverse < AGREES_SDS)
    ratio = np.where(np.isfinite(best), best, 0.0) - FREE_LEVEL
    mean = np.where(agrees, grey, 0).sum(axis=0) / np.maximum(agrees.sum(axis=0), 1)
    surface = np.asarray(mean, dtype=np.float32).reshape(shape[1:])
    return Agreement(ratio.reshape(shape[1:]), agrees.reshape(shape), surface)


def compute_known_surface_ratio(levels: Levels, surface: NDArray[np.float32]) -> FloatArray:
    """Return the log-likelihood ratio (V, ...) of levels (V, ...) of a surface of known level (...)
    against chance; 0 where a view does not see the point.
    """
    off = (levels.level - surface) / levels.sd
    density = np.exp(-0.5 * off**2) / (np.sqrt(2 * np.pi) * levels.sd)
    ratio = np.log(HIDDEN + (1 - HIDDEN) * density / levels.chance)
    known: FloatArray = np.where(np.isfinite(levels.level), ratio, 0.0)
    return known


def _averaged(image: Image, own: Noise) -> tuple[Image, float]:
    # The picture smoothed until its noise no longer hides agreement, but by no more than the width
    # of edges; and the noise left in it. Smoothing costs narrow faces.
    noise = own.sd
    sigma = min(noise / (AVERAGING * NOISE_BORNE), GRADIENT_SIGMA)
    if sigma < LEAST_SIGMA:
        return image, noise
    smooth = cv2.GaussianBlur(image, (0, 0), own.factor * sigma)
    return np.asarray(smooth, dtype=np.uint8), noise / (AVERAGING * sigma)


def _density(image: NDArray[np.uint8], noise: float) -> NDArray[np.float32]:
    # Density of levels (256,), blurred by the uncertainty of a level: so a background of one level,
    # which agrees by chance wherever one looks, proves nothing.
    count = cv2.calcHist([image], [0], None, [256], [0, 256]).ravel().astype(np.float64)
    # The median from the counts: of an even number the mean of both in the middle.
    half = [(image.size - 1) // 2, image.size // 2]
    median = np.searchsorted(np.cumsum(count), half, side="right").mean()
    width = float(np.hypot(noise, LIGHT_SHARE * median))
    smooth = cv2.GaussianBlur(count[None], (0, 0), width, borderType=cv2.BORDER_REFLECT)[0]
    density = (1 - EVEN_SHARE) * smooth / smooth.sum() + EVEN_SHARE / 256
    return np.asarray(density, dtype=np.float32)
