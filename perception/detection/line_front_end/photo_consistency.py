"""Do the pictures show one and the same surface at given points? A log-likelihood ratio says it.

A point of a surface has one brightness: the views that see it agree, up to noise, a change of
light and the error of its place. A point in the air has the brightness of whatever lies behind it,
in each view another. How likely a level is by chance follows from each picture's own levels, so
that a plain background proves nothing and a rare level much.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.edge_maps import EdgeMap, working_noise
from facetlog.perception.types import FloatArray, View

__all__ = ["Agreement", "GreyLevels", "Levels", "agreement"]

# Probability that a view does not see the surface, though it faces it: something is before it.
HIDDEN = 0.3
# Light changes with the view by this share of the level: gloss, vignetting, exposure.
LIGHT_SHARE = 0.02
# Error in px of where a point of a surface is looked up, before its plane is fitted.
PLACE_PX = 0.5
# Share of the chance density that is even over all levels: no level is impossible.
EVEN_SHARE = 0.1
# Price of the surface's own level, which is chosen after the fact: among some twenty that differ.
FREE_LEVEL = float(np.log(20.0))
# Levels tried are those of so many views: of a surface that half of them show 1 in 250 is missed.
TRIED_VIEWS = 8
# A view agrees when its level is within this many standard deviations.
AGREES_SDS = 3.0


@dataclass(frozen=True, eq=False, slots=True)
class Levels:
    """Grey levels (V, ...) float32 of points in V views, their standard deviations, and the density
    of such a level by chance; a level is NaN where the view does not see the point.
    """

    level: NDArray[np.float32]
    sd: NDArray[np.float32]
    chance: NDArray[np.float32]


@dataclass(frozen=True, eq=False, slots=True)
class Agreement:
    """`ratio` (...): log-likelihood ratio of a surface against chance; `agrees` (V, ...)."""

    ratio: FloatArray
    agrees: NDArray[np.bool_]


class GreyLevels:
    """The pictures of a set of views, ready to be asked for levels at any points."""

    def __init__(self, views: Sequence[View], maps: Sequence[EdgeMap]) -> None:
        self._images = [view.image for view in views]
        self._slopes = [np.hypot(edges.gx, edges.gy) for edges in maps]
        self._noise = [working_noise(view.image) for view in views]
        self._chance = [
            _density(view.image, noise) for view, noise in zip(views, self._noise, strict=True)
        ]

    def read(
        self, views: Sequence[int], uv: Sequence[FloatArray], seen: Sequence[NDArray[np.bool_]]
    ) -> Levels:
        """Levels of the chosen views at pixels (..., 2), one array a view, where `seen` (...)."""
        level, sd, chance = [], [], []
        for k, at, ok in zip(views, uv, seen, strict=True):
            flat = at.reshape(len(at), -1, 2).astype(np.float32)
            grey = _bilinear(self._images[k], flat).reshape(ok.shape)
            slope = _bilinear(self._slopes[k], flat).reshape(ok.shape)
            own = self._noise[k] ** 2 + (LIGHT_SHARE * grey) ** 2 + (PLACE_PX * slope) ** 2
            chance.append(self._chance[k][np.clip(grey, 0, 255).astype(np.uint8)])
            level.append(np.where(ok, grey, np.float32(np.nan)))
            sd.append(np.sqrt(own))
        return Levels(*(np.array(part, dtype=np.float32) for part in (level, sd, chance)))


def agreement(levels: Levels, weight: FloatArray) -> Agreement:
    """What levels (V, ...) say together, each view by its weight (V,) beside views almost like it.

    With h = HIDDEN, the ratio is the maximum over the surface's own level m of
    Σ weight · log(h + (1 - h) · N(level; m, sd²) / chance), less FREE_LEVEL: a hidden view costs
    little, whatever it shows.
    """
    seen = np.isfinite(levels.level)
    grey = np.where(seen, levels.level, np.float32(-1e4))
    inverse = np.float32(1.0) / levels.sd
    strength = np.float32((1 - HIDDEN) / np.sqrt(2 * np.pi)) * inverse / levels.chance
    by_view = weight.reshape(-1, *[1] * (grey.ndim - 1)).astype(np.float32)
    best = np.full(grey.shape[1:], -np.inf, dtype=np.float32)
    chosen = np.zeros(grey.shape[1:], dtype=np.float32)
    tried = np.unique(np.linspace(0, len(grey) - 1, TRIED_VIEWS).round().astype(int))
    for trial in grey[tried]:
        off = (grey - trial) * inverse
        ratio = (by_view * np.log(HIDDEN + strength * np.exp(-0.5 * off * off)) * seen).sum(axis=0)
        better = (ratio > best) & (trial >= 0)
        best[better], chosen[better] = ratio[better], trial[better]
    agrees = seen & (np.abs(grey - chosen) < AGREES_SDS * levels.sd)
    return Agreement(np.where(seen.any(axis=0), best, 0.0) - FREE_LEVEL, agrees)


def _bilinear(
    picture: NDArray[np.uint8] | NDArray[np.float32], at: NDArray[np.float32]
) -> NDArray[np.float32]:
    return np.asarray(
        cv2.remap(picture, at[..., 0], at[..., 1], cv2.INTER_LINEAR), dtype=np.float32
    )


def _density(image: NDArray[np.uint8], noise: float) -> NDArray[np.float32]:
    # Density of levels (256,), as unsharp as a level is known: so a background of one level, which
    # is there by chance wherever one looks, proves nothing.
    count = np.bincount(image.ravel(), minlength=256).astype(np.float64)
    width = float(np.hypot(noise, LIGHT_SHARE * np.median(image)))
    smooth = cv2.GaussianBlur(count[None], (0, 0), width, borderType=cv2.BORDER_REFLECT)[0]
    density = (1 - EVEN_SHARE) * smooth / smooth.sum() + EVEN_SHARE / 256
    return np.asarray(density, dtype=np.float32)
