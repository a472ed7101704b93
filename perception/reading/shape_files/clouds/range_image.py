"""The place of the camera whose picture an organised cloud is, from the points alone.

Row and column of a point are its image under some projection matrix P (3, 4), whatever frame the
points were moved into: u ~ P (X, 1). The camera's centre is the null vector of P (Hartley and
Zisserman, Multiple View Geometry, 7.1 and 6.2.4).
"""

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.types import FloatArray

__all__ = ["find_camera_centre"]

# The matrix has 11 unknowns, of two equations for each point; far more points show whether it fits.
LEAST_POINTS = 100
# So many points determine a centre to the resolution of the picture's pixels.
MOST_POINTS = 2_000
# A cloud of a depth camera lies on its pixels' rays, to within rounding and undistortion (pixels).
MOST_RESIDUAL = 1.0
# Centres of two halves of the points that differ by more than this share of the distance to the
# points are undetermined, as those of a picture of one plane are.
SURE_SHARE = 0.02


def find_camera_centre(points: FloatArray) -> FloatArray | None:
    """Return the place (3,) that a picture of points (rows, columns, 3) was taken from.

    Rows that are not finite have no point. None where the points are no picture of a pinhole
    camera, as of a scanner that turns, or where they do not determine its place.
    """
    rows, columns = points.shape[:2]
    flat = points.reshape(-1, 3)
    with np.errstate(invalid="ignore"):
        seen = np.flatnonzero(np.isfinite(flat).all(axis=1) & (np.abs(flat) > 0.0).any(axis=1))
    if min(rows, columns) < 2 or len(seen) < LEAST_POINTS:
        return None
    chosen = np.random.default_rng(0).permutation(seen)[:MOST_POINTS]
    places = flat[chosen]
    pixels = np.column_stack([chosen % columns, chosen // columns]).astype(np.float64)
    middle = places.mean(axis=0)
    local = places - middle
    scale = float(np.sqrt((local**2).sum(axis=1).mean()))
    if not np.isfinite(scale) or scale == 0.0:
        return None
    local = local / scale
    projection = _fit_projection(local, pixels)
    centre = _find_centre(projection)
    if centre is None or _find_residual(projection, local, pixels) > MOST_RESIDUAL:
        return None
    away = float(np.median(np.linalg.norm(local - centre, axis=1)))
    for half in (slice(None, None, 2), slice(1, None, 2)):
        other = _find_centre(_fit_projection(local[half], pixels[half]))
        if other is None or np.linalg.norm(other - centre) > SURE_SHARE * away:
            return None
    place: FloatArray = middle + scale * centre
    return place


def _fit_projection(places: FloatArray, pixels: FloatArray) -> FloatArray:
    """Return P (3, 4) that minimises the algebraic error of pixels (n, 2) of places (n, 3)."""
    shift, extent = pixels.mean(axis=0), max(float(pixels.std()), 1e-300)
    u, v = ((pixels - shift) / extent).T
    ones = np.column_stack([places, np.ones(len(places))])
    none = np.zeros_like(ones)
    equations = np.concatenate(
        [
            np.hstack([ones, none, -u[:, None] * ones]),
            np.hstack([none, ones, -v[:, None] * ones]),
        ]
    )
    fitted = np.linalg.eigh(equations.T @ equations)[1][:, 0].reshape(3, 4)
    back = np.array([[extent, 0.0, shift[0]], [0.0, extent, shift[1]], [0.0, 0.0, 1.0]])
    projection: FloatArray = back @ fitted
    return projection


def _find_centre(projection: FloatArray) -> FloatArray | None:
    """Return the centre (3,) of P, None where it is at infinity."""
    null: NDArray[np.float64] = np.linalg.svd(projection)[2][-1]
    return null[:3] / null[3] if abs(null[3]) > 1e-12 else None


def _find_residual(projection: FloatArray, places: FloatArray, pixels: FloatArray) -> float:
    """Return the rms distance in pixels; infinity where some points lie behind the camera."""
    image = places @ projection[:, :3].T + projection[:, 3]
    depth = image[:, 2]
    if not (depth > 0.0).all() and not (depth < 0.0).all():
        return np.inf
    off = image[:, :2] / depth[:, None] - pixels
    return float(np.sqrt((off**2).sum(axis=1).mean()))
