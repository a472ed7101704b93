"""Does one see through an outline to lines behind it? A surface would hide them."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.evidence.face_conflicts import (
    blocked,
    well_within,
)
from facetlog.perception.detection.line_front_end.evidence.side_evidence import SAMPLES, SideJudge
from facetlog.perception.detection.line_front_end.evidence.witnesses import Witnesses
from facetlog.perception.detection.line_front_end.segments_3d.line_support import segment_samples
from facetlog.perception.types import FloatArray

__all__ = ["LEAST_RATIO", "LinesBehind"]

# A line is behind a plane by so many px at least, which are so many standard deviations of its
# depth: along the way that cameras moved a line's depth is hardly known, and errors of poses put
# print there far behind its own face.
BEHIND_PX, BEHIND_SDS = 6.0, 3.0
# Log-likelihood ratio of all lines together from which on one sees through: less than one of a
# thousand faces of a thousand scenes may be lost by chance.
LEAST_RATIO = float(np.log(1000.0 * 1000.0))


class LinesBehind:
    """3-D segments (n, 2, 3) as witnesses; `covs` (n, 3, 3) are the covariances of their places,
    `pixel` is a pixel's length at the focus.
    """

    def __init__(
        self,
        witnesses: Witnesses,
        sides: SideJudge,
        segments: FloatArray,
        covs: FloatArray,
        pixel: float,
    ) -> None:
        self._witnesses = witnesses
        self._sides = sides
        self._segments = segments
        self._samples = segment_samples(segments, SAMPLES)
        self._covs = covs
        self._pixel = pixel

    def seen_through(
        self,
        corners: FloatArray,
        normal: FloatArray,
        views: NDArray[np.intp],
        holes: Sequence[FloatArray] = (),
    ) -> bool:
        """Whether the chosen views (v,) see lines through a polygon (k, 3)."""
        return self.ratio(corners, normal, views, holes) > LEAST_RATIO

    def ratio(
        self,
        corners: FloatArray,
        normal: FloatArray,
        views: NDArray[np.intp],
        holes: Sequence[FloatArray] = (),
    ) -> float:
        """Log-likelihood ratio that the chosen views (v,) see lines through a polygon (k, 3).

        What they see past it or through its `holes` says nothing. Lines on it within its outline
        are print, which speaks for a surface: glossy wood shows what it mirrors behind it, too.
        """
        sd = np.sqrt(np.maximum(np.einsum("i,nij,j->n", normal, self._covs, normal), 0.0))
        deep = BEHIND_PX * self._pixel
        depth = (corners.mean(axis=0) - self._samples) @ normal
        behind = (depth > deep) & (BEHIND_SDS * sd < deep)[:, None]
        lines = np.nonzero(behind.any(axis=1))[0]
        if not len(lines):
            return 0.0
        targets = self._samples[lines].reshape(-1, 3)
        centres = self._witnesses.centres[views]
        crosses = blocked(corners, normal, targets, centres, deep, holes)
        through = crosses.reshape(len(views), len(lines), SAMPLES) & behind[lines]
        seen = self._of(views, lines, through)
        on = np.nonzero((np.abs(depth) < deep).all(axis=1))[0]
        within = well_within(corners, normal, self._samples[on], deep, holes)
        printed = self._of(views, on, np.broadcast_to(within, (len(views), *within.shape)))
        return float(seen.sum() - np.maximum(printed, 0.0).sum())

    def _of(
        self, views: NDArray[np.intp], lines: NDArray[np.intp], bare: NDArray[np.bool_]
    ) -> FloatArray:
        # Log-likelihood ratio of lines (l,), seen whole or not at all: it is the mean over the
        # samples that are `bare` (v, l, SAMPLES), for all of a line.
        ratio = self._sides.evidence(views, self._segments[lines], bare).ratio
        of_lines: FloatArray = self._witnesses.weight[views] @ ratio
        return of_lines
