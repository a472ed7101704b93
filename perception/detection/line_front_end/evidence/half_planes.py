"""Half-planes at 3-D segments: on which side of a segment is a plane a surface, and from where?

After Baillard & Zisserman, "Automatic reconstruction of piecewise planar models from multiple
views" (CVPR 1999), who turn a half-plane about a line until the pictures beside the line agree.
"""

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.evidence.side_evidence import SAMPLES
from facetlog.perception.detection.line_front_end.segments_3d.line_support import segment_samples
from facetlog.perception.types import FloatArray

# This far beside a side, px, its own edge ends.
CLEAR_PX = 5.0
# A surface has at least this mean log-likelihood ratio, and this share of it is consistent.
MIN_INSIDE, MIN_CONSISTENT = 2.0, 0.75
# Distinct views that must agree.
MIN_WEIGHT = 2.0


def find_surface_beside(
    photos: PhotometricViews, normal: FloatArray, segments: FloatArray, pixel: float
) -> NDArray[np.bool_]:
    """Return whether a plane is surface right beside its segments (n, 2, 3), on either side: (2,
    n).

    First as seen from its front, then from its back; `pixel` is the length of a pixel there.
    """
    across = np.cross(normal, segments[:, 1] - segments[:, 0])
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300)
    step = CLEAR_PX * pixel * across[:, None]
    samples = segment_samples(segments, SAMPLES)
    points = np.stack([samples - step, samples + step]).reshape(-1, 3)
    found = np.zeros((2, len(segments)), dtype=np.bool_)
    for facing, row in zip((normal, -normal), found, strict=True):
        views = photos.facing(segments.mean(axis=(0, 1)), facing)
        if photos.weight[views].sum() < MIN_WEIGHT:
            continue
        ratio = photos.agree(views, points)[0].ratio.reshape(2, len(segments), SAMPLES)
        surface = ratio.mean(axis=2) > MIN_INSIDE
        surface &= (ratio > 0).mean(axis=2) >= MIN_CONSISTENT
        row[:] = surface.any(axis=0)
    return found
