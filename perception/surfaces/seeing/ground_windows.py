"""Print and grey levels that views show at the points of a lattice on the ground."""

from collections.abc import Callable, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.evidence.photo_consistency import (
    AGREES_SDS,
    GreyLevels,
)
from facetlog.perception.types import FloatArray

__all__ = ["KEPT", "Windows"]

# Print is compared in square windows of so many points across.
WINDOW = 7
# n independent samples of noise correlate with an sd of 1 / √n: beyond so many once in 4,000.
CORRELATES_SDS = 3.5
# A window shows print if its variance is this many times that of the picture's noise: of noise
# alone, with 49 samples, an sd is a fifth of it.
PRINT_VARIANCE = 2.0
# So many other views, by weight, show the same as one,
WITNESSES = 2.0
# and this share of those that show print there: two windows of smooth print, with some four
# independent samples, correlate by chance as well as one time in six.
AGREE_SHARE = 1 / 3
# Levels are about so much, from which they are counted so that their squares stay small.
MIDDLE_GREY = np.float32(128.0)
# Of lattice points across and down one in so many is kept: windows overlap.
EVERY = 2

KEPT = (slice(None, None, EVERY), slice(None, None, EVERY))
"""The points of a lattice that are kept."""

# Of the levels those that tell the ground best from what hides it are taken as the ground's, until
# this share of what is known to be hidden shows them: they are wrong one time in 20.
RARE = 0.05
# What shows the ground shows one level: more than half of the views that may see it.
MOST_SHARE = 0.5

_Bits = NDArray[np.bool_]
_Reals = NDArray[np.float32]


class Windows:
    """Windows that V views show at the points kept of a lattice, (rows, columns) of them.

    `pictured` (V, rows, columns) are the points in the pictures.
    """

    def __init__(
        self,
        levels: GreyLevels,
        views: NDArray[np.intp],
        pixels: Sequence[FloatArray],
        shape: tuple[int, int],
    ) -> None:
        kept = len(views), *np.empty(shape, dtype=np.bool_)[KEPT].shape
        self._all = np.empty((len(views), *shape), dtype=np.float32)
        self._level, self._sd, self._mean, self._variance = np.empty((4, *kept), dtype=np.float32)
        self.pictured, whole = np.empty((2, *kept), dtype=np.bool_)
        for n, (k, matrix) in enumerate(zip(views.tolist(), pixels, strict=True)):
            level, sd = levels.warped(k, matrix, shape)
            seen = np.isfinite(level)
            level = self._all[n] = np.where(seen, level - MIDDLE_GREY, np.float32(0.0))
            self.pictured[n] = seen[KEPT]
            whole[n] = _find_full_windows(seen)[KEPT]
            self._level[n], self._sd[n] = level[KEPT], sd[KEPT]
            self._mean[n] = _average_windows(level)[KEPT]
            self._variance[n] = _average_windows(level * level)[KEPT] - self._mean[n] ** 2
        least = PRINT_VARIANCE * levels.noise[views, None, None] ** 2
        self._has_print = whole & (self._variance > least)

    def printed(self, weight: _Reals) -> _Bits:
        """Return where (V, rows, columns) a view shows the same print as others, and their
        level.
        """
        # cov > r sd sd, where no print reaches it without print.
        least = np.where(self._has_print, CORRELATES_SDS / WINDOW * self._variance, np.inf)
        least = np.sqrt(least, dtype=np.float32)

        def agree(a: int, b: int) -> _Bits:
            cov = _average_windows(self._all[a] * self._all[b])[KEPT]
            cov -= self._mean[a] * self._mean[b]
            return np.asarray(cov > least[a] * least[b])

        seen = _find_confirmed(agree, self._has_print, weight, AGREE_SHARE)
        return np.asarray(seen & self._near(_compute_level_medians(self._level, seen)))

    def unlike(self, weight: _Reals, hidden: _Bits) -> _Bits:
        """Return where (V, rows, columns) a view shows, as others do, a level that is rare where
        faces hide the ground, `hidden`, and common elsewhere.
        """
        may_see = self.pictured & ~hidden
        if not may_see.any() or not hidden.any():
            return np.zeros_like(may_see)
        bins = np.asarray(np.clip(self._level + MIDDLE_GREY, 0, 255), dtype=np.uint8)
        sd = float(np.median(self._sd[may_see]))
        common = _choose_ground_levels(*(_density(bins[which], sd) for which in (may_see, hidden)))
        seen: _Bits = self.pictured & common[bins]

        def agree(a: int, b: int) -> _Bits:
            apart, sd = self._level[a] - self._level[b], np.hypot(self._sd[a], self._sd[b])
            return np.asarray(seen[a] & seen[b] & (np.abs(apart) < AGREES_SDS * sd))

        return seen & _find_confirmed(agree, seen, weight, MOST_SHARE)

    def _near(self, surface: _Reals) -> _Bits:
        # Where the views show a surface of that level.
        return np.asarray(np.abs(self._level - surface) < AGREES_SDS * self._sd)


def _find_confirmed(
    agree: Callable[[int, int], _Bits], may: _Bits, weight: _Reals, share: float
) -> _Bits:
    """Return where (V, rows, columns) so many views agree with one, and that share of those that
    `may`.
    """
    witnesses = np.zeros(may.shape, dtype=np.float32)
    for a in range(len(weight)):
        for b in range(a):
            both = agree(a, b)
            witnesses[a] += weight[b] * both
            witnesses[b] += weight[a] * both
    others = np.einsum("v,vij->ij", weight, may) - weight[:, None, None]
    return np.asarray(witnesses >= np.maximum(WITNESSES, share * others))


def _choose_ground_levels(ground: _Reals, faces: _Reals) -> _Bits:
    """Return levels (256,) that tell the ground best from the faces that hide it, by both
    densities.
    """
    least = np.finfo(np.float32).tiny
    best = np.asarray(np.argsort(-ground / (faces + least), kind="stable"))
    common = np.zeros(len(ground), dtype=np.bool_)
    common[best] = (np.cumsum(faces[best]) <= RARE) & (ground[best] > faces[best])
    return common


def _compute_level_medians(level: _Reals, seen: _Bits) -> _Reals:
    """Return medians (...) of the levels (V, ...) of the views that see a point, NaN where none
    does.
    """
    median = np.full(level.shape[1:], np.nan, dtype=np.float32)
    some = seen.any(axis=0)
    ranked = np.sort(np.where(seen, level, np.float32(np.inf))[:, some], axis=0)
    count, point = seen[:, some].sum(axis=0), np.arange(ranked.shape[1])
    median[some] = (ranked[(count - 1) // 2, point] + ranked[count // 2, point]) / 2
    return median


def _density(bins: NDArray[np.uint8], sd: float) -> NDArray[np.float32]:
    count = np.bincount(bins, minlength=256).astype(np.float32)
    smooth = cv2.GaussianBlur(count[None], (0, 0), sd, borderType=cv2.BORDER_REFLECT)[0]
    return np.asarray(smooth / smooth.sum())


def _average_windows(values: _Reals) -> _Reals:
    return np.asarray(cv2.blur(values, (WINDOW, WINDOW)), dtype=np.float32)


def _find_full_windows(bits: _Bits) -> _Bits:
    around = np.ones((WINDOW, WINDOW), dtype=np.uint8)
    return cv2.erode(bits.view(np.uint8), around, borderValue=0).view(np.bool_)
