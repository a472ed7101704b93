"""Rotations of rotation vectors, without the half second of scipy.spatial."""

import numpy as np

from facetlog.perception.types import FloatArray


def convert_to_matrices(vectors: FloatArray) -> FloatArray:
    """Return the rotation matrices (..., 3, 3) of rotation vectors (..., 3), by Rodrigues' formula.

    R = 1 + sin θ / θ K + (1 - cos θ) / θ² K², K x = v × x, θ = |v|.

    >>> convert_to_matrices(np.array([0.0, 0.0, np.pi / 2])).round(9) + 0.0
    array([[ 0., -1.,  0.],
           [ 1.,  0.,  0.],
           [ 0.,  0.,  1.]])
    """
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    k = np.cross(np.eye(3), vectors[..., None, :])
    # np.sinc(x) is sin πx / πx, and 1 - cos θ is 2 sin² θ / 2.
    first, second = np.sinc(angle / np.pi), 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
    matrices: FloatArray = np.eye(3) + first * k + second * (k @ k)
    return matrices
