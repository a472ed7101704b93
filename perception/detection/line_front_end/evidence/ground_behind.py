"""Likelihood that the ground explains the pixels taken for a face before it."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.evidence.face_conflicts import blocked
from facetlog.perception.detection.line_front_end.evidence.photo_consistency import FREE_LEVEL
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.planes.ground_plane import Ground
from facetlog.perception.types import FloatArray


def compute_ground_ratio(
    photos: PhotometricViews,
    ground: Ground,
    corners: FloatArray,
    normal: FloatArray,
    points: FloatArray,
    shown: NDArray[np.bool_],
    taken: Sequence[NDArray[np.uint8]],
) -> FloatArray:
    """Return the log-likelihood ratio (n,) that the views `shown` (V,) see the ground at points (n,
    3).

    The points lie on a supposed face (k, 3). A pattern of the ground repeats itself: some views see
    one tile where others see the next; and one sees through between legs. So each view's pixels are
    compared with the ground that they would show, whose level is taken from the other views that
    see it past the face; or from all others, with a penalty, since they may see the face there.
    `taken` are each view's pixels that show a face found already.
    """
    everyone, showing = np.arange(len(photos.weight)), np.nonzero(shown)[0]
    total = np.zeros((2, len(points)))
    for k in showing.tolist():
        behind, meets = ground.behind(photos.centres[k], points)
        others = everyone[everyone != k]
        past = ~blocked(corners, normal, behind, photos.centres[others])
        agreements = photos.compare_clear_views(others, behind, taken, past)
        for by_level, found in zip(total, agreements, strict=True):
            ratio = photos.judge_known_surface(k, behind, found.level)
            by_level += photos.weight[k] * np.where(meets & (found.ratio > 0), ratio, 0.0)
    best: FloatArray = np.maximum(total[0], total[1] - FREE_LEVEL)
    return best
