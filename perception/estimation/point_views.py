"""Posed views and their observations in a normalised frame, independent of origin, unit and lens.

The arithmetic of many points at once: cameras centred on the mean of their pinholes and scaled by
their spread, pixels taken to the plane at depth 1 before the pinhole, with their information.
Estimates in this frame are the same, up to rounding, whatever the world's origin and unit, or the
unit of the pixels.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from facetlog.errors import CalibrationError
from facetlog.perception.types import FloatArray

BoolArray = NDArray[np.bool_]
IndexArray = NDArray[np.intp]

# A projection whose left 3 x 3 block is flatter than this (ratio of singular values after its
# rows are scaled) has no pinhole in double precision.
SINGULAR_CAMERA = 1e-12
# Pixels that are weighed at once: few enough for the processor's cache.
BLOCK = 12_000


@dataclass(frozen=True, eq=False, slots=True)
class Cameras:
    """Cameras in the neutral frame: world = origin + scale * neutral.

    `projections` (V, 3, 4) are [R | -R c] with a rotation R and a pinhole c, `centres` (V, 3);
    their third coordinate is the depth before the camera. `lenses` (V, 2, 3) take points of the
    plane at depth 1 to pixels: the first two rows of the calibration matrix, with positive focal
    lengths (Hartley and Zisserman, 6.2.4). This takes pictures not to be mirrored. `products`
    (6 V, 12) are those of the projections' rows, of which all sums over views are made.
    """

    projections: FloatArray
    centres: FloatArray
    lenses: FloatArray
    products: FloatArray
    origin: FloatArray
    scale: float

    @classmethod
    def of(cls, projections: ArrayLike) -> Self:
        """Return the neutral cameras of projections (V, 3, 4), world to pixels, of any scale and
        sign.
        """
        P = np.array(projections, dtype=np.float64)
        if P.ndim != 3 or P.shape[1:] != (3, 4):
            raise ValueError(f"expected projections of shape (V, 3, 4), got {P.shape}")
        left = P[:, :, :3]
        rows = np.linalg.norm(left, axis=2, keepdims=True)
        if not np.isfinite(P).all() or not (rows > 0).all():
            raise CalibrationError("a projection matrix is not finite or has an empty row")
        singular = np.linalg.svd(left / rows, compute_uv=False)
        if (singular[:, 2] < SINGULAR_CAMERA * singular[:, 0]).any():
            raise CalibrationError(
                "a projection matrix has no pinhole (its left block is singular)"
            )
        centres = -np.linalg.solve(left, P[:, :, 3:])[:, :, 0]
        origin = centres.mean(axis=0)
        spread = float(np.sqrt(((centres - origin) ** 2).sum(axis=1).mean()))
        # Cameras in one place leave no unit; no point can be found from them in any.
        rounding = 64 * np.finfo(np.float64).eps * float(np.abs(centres).max())
        scale = spread if spread > rounding else 1.0
        neutral = (centres - origin) / scale if spread > rounding else np.zeros_like(centres)
        # Rows scaled so that the third is a unit vector to the front: positive determinant.
        R, lenses = _split_projection(
            left / (np.sign(np.linalg.det(left)) * rows[:, 2, 0])[:, None, None]
        )
        turned = np.concatenate([R, -R @ neutral[:, :, None]], axis=2)
        return cls(turned, neutral, lenses, _build_products(turned), origin, scale)

    def distances(self, points: FloatArray) -> FloatArray:
        """Return the distances (n, V) of points (n, 3) from the pinholes."""
        square = (points * points).sum(axis=1)[:, None] + (self.centres**2).sum(axis=1)
        square -= 2.0 * points @ self.centres.T
        return np.asarray(np.sqrt(np.maximum(square, 0.0)))


def _split_projection(left: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return R (V, 3, 3) and the first two rows of upper triangular K (V, 2, 3) of left = K R."""
    R, K = np.empty_like(left), np.zeros((len(left), 2, 3))
    R[:, 2] = left[:, 2]
    K[:, 1, 2] = (left[:, 1] * R[:, 2]).sum(axis=1)
    across = left[:, 1] - K[:, 1, 2, None] * R[:, 2]
    K[:, 1, 1] = np.linalg.norm(across, axis=1)
    R[:, 1] = across / K[:, 1, 1, None]
    R[:, 0] = np.cross(R[:, 1], R[:, 2])
    K[:, 0] = (left[:, :1] @ R.transpose(0, 2, 1))[:, 0]
    return R, K


def _build_products(projections: FloatArray) -> FloatArray:
    """Return products (6 V, 12) of the rows p1, p2, p3 of projections (V, 3, 4).

    First p1 p1, p1 p2 + p2 p1, p2 p2, p1 p3 + p3 p1, p2 p3 + p3 p2, p3 p3 of each view, as the
    upper 3 x 4 block of these symmetric matrices.
    """
    p1, p2, p3 = projections.transpose(1, 0, 2)
    products = []
    for p, q in ((p1, p1), (p1, p2), (p2, p2), (p1, p3), (p2, p3), (p3, p3)):
        outer = p[:, :3, None] * q[:, None, :]
        products.append(outer if p is q else outer + q[:, :3, None] * p[:, None, :])
    return np.concatenate(products).reshape(-1, 12)


def _weigh_pixels(
    lenses: FloatArray, pixels: FloatArray, noise: FloatArray, mask: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Return `xy` and `info` of `Sightings`."""
    u, v = np.where(mask, pixels[..., 0], 0.0), np.where(mask, pixels[..., 1], 0.0)
    a, c = np.where(mask, noise[..., 0, 0], 1.0), np.where(mask, noise[..., 1, 1], 1.0)
    b = np.where(mask, noise[..., 0, 1], 0.0)
    determinant = a * c - b * b
    sound = (a > 0) & (determinant > 0) & np.isfinite(u + v) & np.isfinite(determinant)
    if not sound.all():
        raise ValueError("pixels must be finite and their covariances positive definite")
    fx, skew, cx = lenses[:, 0].T
    _, fy, cy = lenses[:, 1].T
    y = (v - cy) / fy
    x = (u - cx - skew * y) / fx
    # Kᵀ Λ⁻¹ K for the upper triangular K of the focal lengths and the skew
    weight = mask / determinant
    a, b, c = c * weight, -b * weight, a * weight
    info = (
        fx * fx * a,
        fx * (skew * a + fy * b),
        skew * (skew * a + 2.0 * fy * b) + fy * fy * c,
    )
    return np.stack((x, y), axis=1), np.stack(info, axis=1)


@dataclass(frozen=True, eq=False, slots=True)
class Sightings:
    """Observations: `xy` (n, 2, V) on the planes at depth 1, and their `info` (n, 3, V).

    `info` holds the entries (0, 0), (0, 1), (1, 1) of the inverse covariances, zero where a view
    did not see the point, which then has no weight anywhere. Views come last in all arrays: numpy
    is fast along the last axis, and slow where that has two or three entries.
    """

    xy: FloatArray
    info: FloatArray
    seen: BoolArray

    @classmethod
    def of(cls, cameras: Cameras, uv: ArrayLike, cov: ArrayLike, seen: ArrayLike) -> Self:
        """Return sightings of pixels (n, V, 2) with covariances (n, V, 2, 2); unseen ones may hold
        anything.
        """
        mask = np.array(seen, dtype=np.bool_)
        if mask.ndim != 2:
            raise ValueError(f"expected seen of shape (n, V), got {mask.shape}")
        pixels, noise = np.asarray(uv, dtype=np.float64), np.asarray(cov, dtype=np.float64)
        if pixels.shape != (*mask.shape, 2) or noise.shape != (*mask.shape, 2, 2):
            raise ValueError(
                f"pixels {pixels.shape} and covariances {noise.shape} do not fit seen {mask.shape}"
            )
        if mask.shape[1] != len(cameras.projections):
            raise ValueError(
                f"{mask.shape[1]} columns of pixels, {len(cameras.projections)} projections"
            )
        n, views = mask.shape
        xy, info = np.empty((n, 2, views)), np.empty((n, 3, views))
        step = max(1, BLOCK // max(1, views))
        for first in range(0, n, step):
            part = slice(first, first + step)
            xy[part], info[part] = _weigh_pixels(
                cameras.lenses, pixels[part], noise[part], mask[part]
            )
        return cls(xy, info, mask)

    def cov(self, point: int, view: int) -> FloatArray:
        """Return the covariance (2, 2) of one of `xy` that was seen."""
        a, b, c = self.info[point, :, view]
        return np.asarray(np.array([[c, -b], [-b, a]]) / (a * c - b * b))

    def take(self, index: IndexArray | slice) -> Self:
        """Return the sightings of some of the points."""
        return type(self)(self.xy[index], self.info[index], self.seen[index])
