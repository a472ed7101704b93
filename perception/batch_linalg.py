"""Products of vectors and matrices of two to four numbers, row by row, written out in full.

A BLAS may add in another order when there are more rows; here a row's result depends on the row
alone, to the last bit, and many rows cost less than as many calls.
"""

import numpy as np

from facetlog.perception.ragged import Indices
from facetlog.perception.types import FloatArray


def dots(one: FloatArray, two: FloatArray) -> FloatArray:
    """Return scalar products (...) of vectors (..., k).

    >>> dots(np.array([[1.0, 2.0, 3.0]]), np.array([1.0, 0.0, 2.0]))
    array([7.])
    """
    total: FloatArray = one[..., 0] * two[..., 0]
    for i in range(1, one.shape[-1]):
        total = total + one[..., i] * two[..., i]
    return total


def project_on_axes(points: FloatArray, axes: FloatArray) -> FloatArray:
    """Return coordinates (r, k, a) of points (r, k, d) along axes (r, a, d), or (a, d) for all
    rows.

    >>> project_on_axes(np.array([[[1.0, 2.0]]]), np.array([[0.0, 1.0], [1.0, 0.0]]))
    array([[[2., 1.]]])
    """
    found = np.empty((*points.shape[:-1], axes.shape[-2]))
    for i in range(axes.shape[-2]):
        way = axes[..., i, :]
        found[..., i] = dots(points, way[:, None] if way.ndim > 1 else way)
    return found


def compute_quadratic_forms(
    vectors: FloatArray, matrices: FloatArray, rows: Indices | None = None
) -> FloatArray:
    """Return vᵀ C v (n,) of vectors (n, k) and matrices (n, k, k), or `rows` (n,) of matrices (m,
    k, k).

    >>> compute_quadratic_forms(np.array([[1.0, 2.0]]), np.array([[[2.0, 0.0], [0.0, 1.0]]]))
    array([6.])
    """
    total = np.zeros(len(vectors))
    columns = tuple(np.ascontiguousarray(vectors.T))
    for i, left in enumerate(columns):
        product = np.zeros(len(vectors))
        for j, right in enumerate(columns):
            entry = matrices[:, i, j]
            # Few matrices stay in the processor's cache: their copies, one a row, would not.
            product += (entry if rows is None else entry.take(rows)) * right
        total += left * product
    return total
