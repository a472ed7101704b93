"""Many symmetric 3 x 3 systems at once, packed as their upper six entries (00, 01, 02, 11, 12, 22).

By L D Lᵀ, whose pivots are kept positive: a singular system has a huge solution and inverse, which
callers see by their size, instead of an exception for all the others.
"""

import numpy as np

from facetlog.perception.types import FloatArray

# Pivots are at least this share of the trace: parallel rays leave the last of them at rounding.
LEAST_PIVOT = 1e-13
# Pivots of a matrix of zeros; its reciprocal may still be squared.
ZERO_PIVOT = 1e-100

_Factors = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]


def _factors(H: FloatArray) -> _Factors:
    """Entries 10, 20, 21 of L and the inverses of the three pivots, (n,) each."""
    h00, h01, h02, h11, h12, h22 = H.T
    least = LEAST_PIVOT * (h00 + h11 + h22) + ZERO_PIVOT
    i0 = 1.0 / np.maximum(h00, least)
    l10, l20 = h01 * i0, h02 * i0
    i1 = 1.0 / np.maximum(h11 - l10 * h01, least)
    rest = h12 - l20 * h01
    l21 = rest * i1
    i2 = 1.0 / np.maximum(h22 - l20 * h02 - l21 * rest, least)
    return l10, l20, l21, i0, i1, i2


def solutions(H: FloatArray, g: FloatArray) -> FloatArray:
    """x (n, 3) of H x = g, for positive semidefinite H (n, 6) and g (n, 3).

    >>> solutions(np.array([[2.0, 0.0, 0.0, 4.0, 0.0, 8.0]]), np.ones((1, 3))).tolist()
    [[0.5, 0.25, 0.125]]
    """
    l10, l20, l21, i0, i1, i2 = _factors(H)
    x = np.empty_like(g)
    y1 = g[:, 1] - l10 * g[:, 0]
    y2 = g[:, 2] - l20 * g[:, 0] - l21 * y1
    x[:, 2] = y2 * i2
    x[:, 1] = y1 * i1 - l21 * x[:, 2]
    x[:, 0] = g[:, 0] * i0 - l10 * x[:, 1] - l20 * x[:, 2]
    return x


def inverses(H: FloatArray) -> FloatArray:
    """H⁻¹, packed (n, 6), of positive semidefinite H (n, 6)."""
    l10, l20, l21, i0, i1, i2 = _factors(H)
    m20 = l10 * l21 - l20
    S = np.empty_like(H)
    S[:, 2] = m20 * i2
    S[:, 4] = -l21 * i2
    S[:, 5] = i2
    S[:, 0] = i0 + l10 * l10 * i1 + m20 * S[:, 2]
    S[:, 1] = -l10 * i1 - l21 * S[:, 2]
    S[:, 3] = i1 - l21 * S[:, 4]
    return S


def quadratic(H: FloatArray, x: FloatArray) -> FloatArray:
    """xᵀ H x (n,) of H (n, 6) and x (n, 3)."""
    a, b, c = x.T
    return np.asarray(
        a * (H[:, 0] * a + 2.0 * (H[:, 1] * b + H[:, 2] * c))
        + b * (H[:, 3] * b + 2.0 * H[:, 4] * c)
        + H[:, 5] * c * c
    )


def unpacked(H: FloatArray) -> FloatArray:
    """The full matrices (n, 3, 3) of H (n, 6)."""
    return H[:, (0, 1, 2, 1, 3, 4, 2, 4, 5)].reshape(-1, 3, 3)
