"""Packed symmetric systems: numpy's answers, and finite ones where it has none."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from facetlog.perception.estimation.symmetric_matrices import (
    inverses,
    quadratic,
    solutions,
    unpacked,
)

SEEDS = st.integers(0, 2**32 - 1)
PACKED = (0, 0, 0, 1, 1, 2), (0, 1, 2, 1, 2, 2)


def _positive(seed, rank=3):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(7, 3, rank)) * 10.0 ** rng.uniform(-3, 3, (7, 1, 1))
    full = A @ A.transpose(0, 2, 1)
    return full, full[:, *PACKED], rng.normal(size=(7, 3))


@given(SEEDS)
def test_solutions_inverses_and_lengths_are_those_of_the_full_matrices(seed):
    full, packed, g = _positive(seed)
    full = full + 1e-3 * np.trace(full, axis1=1, axis2=2)[:, None, None] * np.eye(3)
    packed = full[:, *PACKED]
    np.testing.assert_array_equal(unpacked(packed), full)
    expected = np.linalg.solve(full, g[:, :, None])[:, :, 0]
    np.testing.assert_allclose(solutions(packed, g), expected, rtol=1e-9, atol=1e-9 * abs(g).max())
    np.testing.assert_allclose(
        unpacked(inverses(packed)) @ full, np.tile(np.eye(3), (7, 1, 1)), atol=1e-9
    )
    np.testing.assert_allclose(
        quadratic(packed, g), np.einsum("ni,nij,nj->n", g, full, g), rtol=1e-9
    )


@given(SEEDS, st.integers(0, 2))
def test_a_singular_system_has_a_finite_answer_and_a_huge_inverse(seed, rank):
    full, packed, g = _positive(seed, rank)
    in_its_range = (full @ g[:, :, None])[:, :, 0]
    assert np.isfinite(solutions(packed, in_its_range)).all()
    inverse = inverses(packed)
    assert np.isfinite(inverse).all()
    size = np.trace(full, axis1=1, axis2=2) * inverse[:, [0, 3, 5]].max(axis=1)
    assert ((size > 1e6) | (size == 0)).all()
