"""How far pixels are off beyond their own noise, as poses that are not exact leave them."""

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.estimation.point_filter import estimate_points
from facetlog.perception.types import FloatArray

__all__ = ["pose_noise_px"]

# Start of the search for the poses' own error: what real poses have, px.
START_NOISE_PX = 1.0
# Median of a chi-square with two degrees of freedom, over its mean.
MEDIAN_OVER_MEAN = 2 * np.log(2) / 2


def pose_noise_px(
    uv: FloatArray, cov: FloatArray, seen: NDArray[np.bool_], projections: FloatArray
) -> float:
    """Standard deviation in px, per axis, of what the corners' own noise does not explain.

    Shapes as in `estimate_points`. Robust: from the median of the residuals over all tracks.
    """
    loose = cov + START_NOISE_PX**2 * np.eye(2)
    points, _, used, ok = estimate_points(uv, loose, seen, projections)
    used = used & ok[:, None]
    if not used.any():
        return START_NOISE_PX
    h = np.einsum("vij,nj->nvi", projections[:, :, :3], points) + projections[:, :, 3]
    with np.errstate(invalid="ignore"):
        residual = uv - h[..., :2] / h[..., 2:]
    # A point takes three of its observations' 2 n numbers for itself.
    freedom = np.maximum(1.0 - 1.5 / np.maximum(used.sum(axis=1), 2), 0.25)
    square = ((residual**2).sum(axis=-1) / 2 / freedom[:, None])[used]
    own = (np.trace(cov, axis1=2, axis2=3) / 2)[used]
    excess = np.median(square) / MEDIAN_OVER_MEAN - np.median(own)
    return float(np.sqrt(max(excess, 0.0)))
