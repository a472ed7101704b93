"""Do the pictures show the same texture at places of a plane? Patches are compared by correlation.

Where a surface is rough or finely textured, the level of a single pixel hardly shows that views
agree: its uncertainty grows with the picture's gradient. A whole patch of the plane does, whatever
the light: each view's patch is warped onto the plane and compared (normalised cross-correlation).
"""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.evidence.beside_segments import (
    MIN_CONSISTENT,
    MIN_INSIDE,
    MIN_WEIGHT,
)
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.segments_3d.line_support import project_points
from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.min_views import FEWEST_VIEWS
from facetlog.perception.types import FloatArray, View

# A piece has SAMPLES x SAMPLES samples this far apart, px at the object: as patches of features,
# large enough to be distinctive and small enough to lie on one surface.
SAMPLES, STEP_PX = 8, 2.5
PIECE_PX = SAMPLES * STEP_PX
# Between a point of a plane and so many of its neighbours the plane is looked at.
NEIGHBOURS = 4
# Two views show the same texture where they correlate this much; of two that have nothing in
# common, each of some twenty independent samples, one in a hundred does, and three hardly ever.
MIN_CORRELATION = 0.5


def texture_correlation(
    views: Sequence[View],
    which: NDArray[np.intp],
    points: FloatArray,
    normal: FloatArray,
    pixel: float,
) -> FloatArray:
    """Return the mean correlation (n,) of what two of the views `which` (v,) show round points of a
    plane.

    0 where fewer than FEWEST_VIEWS see all of the piece round a point (n, 3); `pixel` is a
    pixel's length.
    """
    steps = (np.arange(SAMPLES) - (SAMPLES - 1) / 2) * STEP_PX * pixel
    axes = make_plane_axes(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2) @ axes
    total = np.zeros((len(points), SAMPLES**2), dtype=np.float32)
    count = np.zeros(len(points))
    for k in which.tolist():
        view = views[k]
        uv, depth = project_points(view.projection, points[:, None] + grid)
        height, width = view.image.shape
        u, v = uv[..., 0], uv[..., 1]
        inside = (depth > 0) & (u >= 0) & (u <= width - 1) & (v >= 0) & (v <= height - 1)
        whole = inside.all(axis=1)
        if not whole.any():
            continue
        at = uv[whole].astype(np.float32)
        read = cv2.remap(view.image, at[..., 0], at[..., 1], cv2.INTER_LINEAR).astype(np.float32)
        read -= read.mean(axis=1, keepdims=True)
        read /= np.maximum(np.linalg.norm(read, axis=1, keepdims=True), np.float32(1e-6))
        total[whole] += read
        count[whole] += 1
    # Of unit vectors |Σ p|² = V + V (V - 1) · the mean product of two.
    square = (total.astype(np.float64) ** 2).sum(axis=1)
    pairs = np.maximum(count * (count - 1), 1.0)
    return np.where(count >= FEWEST_VIEWS, (square - count) / pairs, 0.0)


def find_surface_between(
    photos: PhotometricViews,
    views: Sequence[View],
    pixel: float,
    normal: FloatArray,
    points: FloatArray,
) -> NDArray[np.bool_]:
    """Return whether a plane is surface between each of its points (n, 3) and the next ones: (2,
    n).

    By grey levels or by texture, first as seen from its front, then from its back. The corners of
    a frame lie on a plane, too, but there is air between them.
    """
    apart = np.linalg.norm(points[:, None] - points, axis=-1)
    near = np.argsort(apart, axis=1, kind="stable")[:, 1 : NEIGHBOURS + 1]
    middles = ((points[:, None] + points[near]) / 2).reshape(-1, 3)
    found = np.zeros((2, len(points)), dtype=np.bool_)
    for facing, row in zip((normal, -normal), found, strict=True):
        which = photos.facing(points.mean(axis=0), facing)
        if photos.weight[which].sum() < MIN_WEIGHT:
            continue
        ratio = photos.agree(which, middles)[0].ratio.reshape(near.shape)
        even = (ratio.mean(axis=1) > MIN_INSIDE) & ((ratio > 0).mean(axis=1) >= MIN_CONSISTENT)
        likeness = texture_correlation(views, which, middles, normal, pixel).reshape(near.shape)
        row[:] = even | ((likeness > MIN_CORRELATION).mean(axis=1) >= MIN_CONSISTENT)
    return found
