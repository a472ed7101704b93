"""The pixels of each view that faces explain already: they are no evidence for others."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.segments_3d.line_support import project_points
from facetlog.perception.types import FloatArray, View

# Pixels at a face's rim belong to its neighbours too: half this width, px. A gap between two faces
# belongs to both.
RIM, BETWEEN = np.ones((5, 5), dtype=np.uint8), np.ones((7, 7), dtype=np.uint8)


def take_pixels(
    taken: list[NDArray[np.uint8]],
    views: Sequence[View],
    shown: NDArray[np.bool_],
    rings: Sequence[FloatArray],
) -> None:
    """Add to `taken`, of each view its pixels (H, W), 1 where they are explained, those within the
    outline of a face and outside of its holes (`rings`, the outline first), in the views (V,) that
    are `shown` to show it.
    """
    for k in np.nonzero(shown)[0].tolist():
        drawn = [project_points(views[k].projection, ring) for ring in rings]
        if all((depth > 0).all() for _, depth in drawn):
            filled = np.zeros_like(taken[k])
            cv2.fillPoly(filled, [np.rint(uv).astype(np.int32) for uv, _ in drawn], 1)
            more = cv2.bitwise_or(taken[k], cv2.erode(filled, RIM))
            taken[k] = np.asarray(cv2.morphologyEx(more, cv2.MORPH_CLOSE, BETWEEN), dtype=np.uint8)
