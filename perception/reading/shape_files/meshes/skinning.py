"""Linear blend skinning: points moved by the joints that they hang on."""

import numpy as np

from facetlog.perception.ragged import Indices
from facetlog.perception.types import FloatArray

__all__ = ["skin_points"]


def skin_points(
    points: FloatArray, matrices: FloatArray, owners: Indices, weights: FloatArray
) -> FloatArray:
    """Return points (n, 3) moved by matrices (j, 4, 4): Σ w_k M_k p, weights normalised to 1.

    `owners` (n, k) are each point's joints, `weights` (n, k) their shares. Raises ValueError for a
    joint that there is not, and for points that hang on none.
    """
    total = weights.sum(axis=1, keepdims=True)
    used = weights != 0.0
    if not (len(owners) == len(weights) == len(points)) or not (total > 0.0).all():
        raise ValueError("a skin without weights for each vertex")
    if (owners[used] < 0).any() or (owners[used] >= len(matrices)).any():
        raise ValueError("a skin with a missing joint")
    moved = np.zeros_like(points)
    for k in range(owners.shape[1]):
        on = np.flatnonzero(used[:, k])
        matrix = matrices[owners[on, k]]
        placed = np.einsum("nij,nj->ni", matrix[:, :3, :3], points[on]) + matrix[:, :3, 3]
        moved[on] += (weights[on, k] / total[on, 0])[:, None] * placed
    return moved
