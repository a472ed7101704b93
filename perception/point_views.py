"""Posed views and what they saw, in a frame in which neither origin nor unit matters.

The arithmetic of many points at once: cameras (V, 3, 4) centred on the mean of their pinholes and
scaled by their spread, pictures weighted by their covariance. Everything that is estimated in this
frame is the same, up to rounding, wherever the world's origin lies and whatever its unit is.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from facetlog.errors import CalibrationError
from facetlog.perception.types import FloatArray

__all__ = ["BoolArray", "Cameras", "IndexArray", "Sightings", "normal_equations", "whiten"]

BoolArray = NDArray[np.bool_]
IndexArray = NDArray[np.intp]

# A projection whose left 3 x 3 block is flatter than this (ratio of singular values after its
# rows are scaled) has no pinhole in double precision.
SINGULAR_CAMERA = 1e-12
# Depths are kept this far from zero (unit: spread of the cameras) so that no division fails.
LEAST_DEPTH = 1e-12


@dataclass(frozen=True, eq=False, slots=True)
class Cameras:
    """Cameras in the neutral frame: world = origin + scale * neutral.

    `projections` (V, 3, 4) have rows scaled so that the third coordinate is the depth in front of
    the camera (positive det of the left block, unit third row; Hartley and Zisserman, 6.2.3).
    This takes pictures not to be mirrored. `centres` (V, 3) are the pinholes, `inverses` (V, 3, 3)
    take pixels to rays.
    """

    projections: FloatArray
    centres: FloatArray
    inverses: FloatArray
    origin: FloatArray
    scale: float

    @classmethod
    def of(cls, projections: ArrayLike) -> Self:
        """The neutral cameras of projections (V, 3, 4), world to pixels, of any scale and sign."""
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
        left = left / (np.sign(np.linalg.det(left)) * rows[:, 2, 0])[:, None, None]
        neutral = (centres - origin) / scale if spread > rounding else np.zeros_like(centres)
        moved = -left @ neutral[:, :, None]
        return cls(
            np.concatenate([left, moved], axis=2), neutral, np.linalg.inv(left), origin, scale
        )

    def project(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Pixels (n, 2, V) and depths (n, V) of points (n, 3)."""
        flat = self.projections.swapaxes(0, 1).reshape(-1, 4)
        h = (points @ flat[:, :3].T + flat[:, 3]).reshape(len(points), 3, len(self.projections))
        depth = h[:, 2]
        divisor = np.where(np.abs(depth) < LEAST_DEPTH, LEAST_DEPTH, depth)
        return h[:, :2] / divisor[:, None], depth

    def jacobian(self, pixels: FloatArray, depth: FloatArray) -> FloatArray:
        """∂(pixel)/∂(point), (n, 3, 2, V): (p12 - pixel p3) / depth."""
        left = self.projections[:, :, :3].transpose(2, 1, 0)
        divisor = np.where(np.abs(depth) < LEAST_DEPTH, LEAST_DEPTH, depth)
        derivative = pixels[:, None] * left[:, 2:]
        np.subtract(left[:, :2], derivative, out=derivative)
        derivative /= divisor[:, None, None]
        return derivative

    def rays(self, uv: FloatArray) -> FloatArray:
        """Unit directions (n, 3, V) from the pinholes through pixels (n, 2, V), to the front."""
        inverse = self.inverses.transpose(2, 1, 0)
        d = uv[:, :1] * inverse[0] + uv[:, 1:] * inverse[1] + inverse[2]
        return np.asarray(d / np.sqrt((d * d).sum(axis=1, keepdims=True)))


@dataclass(frozen=True, eq=False, slots=True)
class Sightings:
    """What was seen: pixels (n, 2, V), whitening factors (n, 3, V), mask `seen` (n, V).

    Views come last in all arrays of this module: numpy is quick along the last axis, and slow where
    that has two or three entries.

    The factors are the entries (0, 0), (1, 0), (1, 1) of the inverse of the Cholesky factor of
    each covariance: applied to a residual they leave unit noise.
    """

    uv: FloatArray
    factors: FloatArray
    seen: BoolArray

    @classmethod
    def of(cls, uv: ArrayLike, cov: ArrayLike, seen: ArrayLike) -> Self:
        """Of pixels (n, V, 2) and covariances (n, V, 2, 2); what was not seen may hold anything."""
        mask = np.array(seen, dtype=np.bool_)
        if mask.ndim != 2:
            raise ValueError(f"expected seen of shape (n, V), got {mask.shape}")
        pixels = np.array(uv, dtype=np.float64, order="C")
        noise = np.array(cov, dtype=np.float64, order="C")
        if pixels.shape != (*mask.shape, 2) or noise.shape != (*mask.shape, 2, 2):
            raise ValueError(
                f"pixels {pixels.shape} and covariances {noise.shape} do not fit seen {mask.shape}"
            )
        pixels[~mask] = 0.0
        noise[~mask] = np.eye(2)
        a, b, c = noise[..., 0, 0], noise[..., 0, 1], noise[..., 1, 1]
        if not (np.isfinite(pixels).all() and (a > 0).all() and (a * c - b * b > 0).all()):
            raise ValueError("pixels must be finite and their covariances positive definite")
        first = 1.0 / np.sqrt(a)
        last = 1.0 / np.sqrt(c - b * b / a)
        factors = np.stack([first, -b / a * last, last], axis=1)
        return cls(np.ascontiguousarray(pixels.swapaxes(1, 2)), factors, mask)

    def take(self, index: IndexArray) -> Self:
        """The sightings of some of the points."""
        return type(self)(self.uv[index], self.factors[index], self.seen[index])


def whiten(factors: FloatArray, values: FloatArray) -> FloatArray:
    """`values` (n, 2, V) or (n, k, 2, V) with unit noise in the axis of 2."""
    f = factors if values.ndim == 3 else factors[:, None]
    white = np.empty_like(values)
    np.multiply(f[..., 0, :], values[..., 0, :], out=white[..., 0, :])
    np.multiply(f[..., 2, :], values[..., 1, :], out=white[..., 1, :])
    white[..., 1, :] += f[..., 1, :] * values[..., 0, :]
    return white


def normal_equations(
    jacobian: FloatArray, residual: FloatArray, mask: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Σ JᵀJ (n, 3, 3) and Σ Jᵀr (n, 3) over the views in `mask`, of whitened J and r."""
    n, views = mask.shape
    J = (jacobian * mask[:, None, None]).reshape(n, 3, 2 * views)
    return J @ J.transpose(0, 2, 1), (J @ residual.reshape(n, 2 * views, 1))[:, :, 0]
