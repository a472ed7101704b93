"""Does one see through an outline to lines behind it? A surface would hide them."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.evidence.face_conflicts import blocked
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.evidence.side_evidence import (
    INDEPENDENT_PX,
    SAMPLES,
    SideJudge,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import LineCloud
from facetlog.perception.detection.line_front_end.segments_3d.line_support import segment_samples
from facetlog.perception.ragged import find_row_starts
from facetlog.perception.types import FloatArray

# A line counts as behind a plane by so many px at least, and so many standard deviations of its
# depth: for lines along the cameras' motion depth is uncertain, and pose errors put texture far
# behind its own face.
BEHIND_PX, BEHIND_SDS = 6.0, 3.0
# One sees through from this total score of all lines on: a chance line with that score is one in a
# million.
LEAST_SCORE = float(np.log(1000.0 * 1000.0))


class LinesBehind:
    """Whether 3-D segments (n, 2, 3) are seen through a polygon that they lie behind.

    `covs` (n, 3, 3) are the covariances of their places, `pixel` is a pixel's length at the focus.
    """

    def __init__(
        self,
        photos: PhotometricViews,
        sides: SideJudge,
        segments: FloatArray,
        covs: FloatArray,
        pixel: float,
    ) -> None:
        self._photos = photos
        self._sides = sides
        self._segments, self._line = _cut_into_pieces(segments, SAMPLES * INDEPENDENT_PX * pixel)
        self._samples = segment_samples(self._segments, SAMPLES)
        self._covs = covs[self._line]
        self._pixel = pixel
        # A line was chosen among as many depths as edges can tell apart: a penalty for that choice.
        self._penalty = float(np.log(sides.edges_abreast))

    @classmethod
    def of(
        cls, cloud: LineCloud, extents: FloatArray, photos: PhotometricViews, sides: SideJudge
    ) -> "LinesBehind":
        """Return the lines of a cloud, of which the pictures cover the `extents` (n, 2, 3)."""
        return cls(photos, sides, extents, cloud.end_covs.mean(axis=1), cloud.pixel)

    def seen_through(
        self,
        corners: FloatArray,
        normal: FloatArray,
        views: NDArray[np.intp],
        holes: Sequence[FloatArray] = (),
    ) -> bool:
        """Return whether the chosen views (v,) see lines through a polygon (k, 3)."""
        return self.score(corners, normal, views, holes) > LEAST_SCORE

    def score(
        self,
        corners: FloatArray,
        normal: FloatArray,
        views: NDArray[np.intp],
        holes: Sequence[FloatArray] = (),
    ) -> float:
        """Return the summed evidence that the chosen views (v,) see lines through a polygon (k, 3).

        Each line counts by its log-likelihood ratio less its penalty, and by no less than 0: a
        hidden line shows that there is surface in front of it, and nothing about where another one
        is seen. Views past the polygon or through its `holes` do not count, nor do lines that are
        more likely texture on it, as far as other views can tell the two apart.
        """
        sd = np.sqrt(np.maximum(np.einsum("i,nij,j->n", normal, self._covs, normal), 0.0))
        deep = BEHIND_PX * self._pixel
        depth = (corners.mean(axis=0) - self._samples) @ normal
        behind = (depth > deep) & (BEHIND_SDS * sd < deep)[:, None]
        pieces = np.nonzero(behind.any(axis=1))[0]
        if not len(pieces):
            return 0.0
        targets = self._samples[pieces].reshape(-1, 3)
        crosses = blocked(corners, normal, targets, self._photos.centres[views], deep, holes)
        through = crosses.reshape(len(views), len(pieces), SAMPLES) & behind[pieces]
        ratio = self._photos.weight[views, None] * (
            self._sides.evidence(views, self._segments[pieces], through).ratio
        )
        counts = self._of_lines(pieces, ratio)[self._line[pieces]] > self._penalty
        pieces, through, ratio = pieces[counts], through[:, counts], ratio[:, counts]
        height = float(normal @ corners.mean(axis=0))
        ratio[self._is_texture(views, pieces, through, ratio, normal, height)] = 0.0
        return float(np.maximum(self._of_lines(pieces, ratio) - self._penalty, 0.0).sum())

    def _of_lines(self, pieces: NDArray[np.intp], ratio: FloatArray) -> FloatArray:
        # The sums for each line of what all views (v,) say of some pieces (p,).
        count = int(self._line.max(initial=-1)) + 1
        sums = np.bincount(self._line[pieces], ratio.sum(axis=0), minlength=count)
        return np.asarray(sums, dtype=np.float64)

    def _is_texture(
        self,
        views: NDArray[np.intp],
        pieces: NDArray[np.intp],
        through: NDArray[np.bool_],
        ratio: FloatArray,
        normal: FloatArray,
        height: float,
    ) -> NDArray[np.bool_]:
        # Which hits (v, p) are more likely texture on the plane: views that would see the line
        # behind elsewhere see an edge where it would lie on the plane. Grain fits any depth.
        texture = np.zeros(ratio.shape, dtype=np.bool_)
        for k, centre in enumerate(self._photos.centres[views]):
            rays = self._segments[pieces] - centre
            hits = np.nonzero((ratio[k] > 0) & (rays @ normal < 0).all(axis=1))[0]
            others = np.delete(views, k)
            if not len(hits) or not len(others):
                continue
            rays = rays[hits]
            drawn = centre + ((height - normal @ centre) / (rays @ normal))[..., None] * rays
            apart = self._sides.apart(others, drawn, self._segments[pieces[hits]])
            found = self._sides.evidence(others, drawn, apart & through[k, hits]).ratio
            texture[k, hits] = self._photos.weight[others] @ found > 0
        return texture


def _cut_into_pieces(segments: FloatArray, longest: float) -> tuple[FloatArray, NDArray[np.intp]]:
    """Return segments (n, 2, 3) in equal pieces (p, 2, 3), none longer, and of which segment each
    is (p,).

    A sample stands for as much of its segment as lies between two: of a long one for more than may
    be seen through an outline.
    """
    span = segments[:, 1] - segments[:, 0]
    counts = np.ceil(np.linalg.norm(span, axis=1) / longest).astype(np.intp)
    counts = np.maximum(counts, 1)
    line = np.repeat(np.arange(len(segments)), counts)
    nth = np.arange(len(line)) - find_row_starts(counts)[line]
    share = (nth[:, None] + np.array([0.0, 1.0])) / counts[line, None]
    pieces: FloatArray = segments[line, :1] + share[..., None] * span[line, None]
    return pieces, line
