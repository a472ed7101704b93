"""Does one see through an outline to lines behind it? A surface would hide them."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.evidence.face_conflicts import blocked
from facetlog.perception.detection.line_front_end.evidence.side_evidence import SAMPLES, SideJudge
from facetlog.perception.detection.line_front_end.evidence.witnesses import Witnesses
from facetlog.perception.detection.line_front_end.segments_3d.line_support import segment_samples
from facetlog.perception.types import FloatArray

__all__ = ["LEAST_RATIO", "LinesBehind"]

# A line is behind a plane by so many px at least, and by so many standard deviations.
BEHIND_PX, BEHIND_SDS = 6.0, 3.0
# Probability that one does not see a line through an outline that is no face: most lines behind a
# thing are hidden by more than one of its faces.
HIDDEN = 0.8
# Log-likelihood ratio of all lines together from which on one sees through: less than one of a
# thousand faces of a thousand scenes may be lost by chance.
LEAST_RATIO = float(np.log(1000.0 * 1000.0))


class LinesBehind:
    """3-D segments (n, 2, 3) as witnesses; `sds` (n, 3, 3) are the covariances of their places,
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

        What they see past it or through its `holes` says nothing.
        """
        sd = np.sqrt(np.maximum(np.einsum("i,nij,j->n", normal, self._covs, normal), 0.0))
        deep = np.maximum(BEHIND_PX * self._pixel, BEHIND_SDS * sd)
        depth = (corners.mean(axis=0) - self._samples) @ normal
        behind = depth > deep[:, None]
        lines = np.nonzero(behind.any(axis=1))[0]
        if not len(lines):
            return 0.0
        targets = self._samples[lines].reshape(-1, 3)
        centres = self._witnesses.centres[views]
        crosses = blocked(corners, normal, targets, centres, BEHIND_PX * self._pixel, holes)
        through = crosses.reshape(len(views), len(lines), SAMPLES) & behind[lines]
        # Seen whole or not at all: the ratio is the mean over the samples there, for all the line.
        ratio = self._sides.evidence(views, self._segments[lines], through).ratio
        of_lines = self._witnesses.weight[views] @ ratio
        seen = np.logaddexp(np.log(HIDDEN), np.log(1 - HIDDEN) + of_lines)
        return float(seen.sum())
