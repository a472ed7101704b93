"""Covariances of points against one another: what moves all alike is not in them."""

import numpy as np

from facetlog.perception.estimation.bundle_adjustment.adjusted_points import without_common_motion
from facetlog.perception.types import FloatArray


def cloud(count: int = 8) -> FloatArray:
    return np.random.default_rng(0).normal(size=(count, 3))


def motions(points: FloatArray) -> FloatArray:
    """Return what a unit shift along and turn about each axis does to points: (n, 6, 3)."""
    turns = [np.cross(axis, points) for axis in np.eye(3)]
    shifts = [np.broadcast_to(axis, points.shape) for axis in np.eye(3)]
    return np.stack([*shifts, *turns], axis=1)


def test_a_common_shift_and_turn_are_not_in_them() -> None:
    points = cloud()
    shared = motions(points) * np.array([3.0, 1.0, 2.0, 0.1, 0.2, 0.3])[:, None]
    own = np.tile(1e-6 * np.eye(3), (len(points), 1, 1))
    covs = without_common_motion(points, own, shared)
    assert np.trace(covs, axis1=1, axis2=2).max() < 3.1e-6


def test_they_are_those_of_points_moved_onto_the_truth() -> None:
    rng = np.random.default_rng(1)
    points, count = cloud(6), 20_000
    own = np.tile(np.eye(3), (6, 1, 1))
    shared = rng.normal(size=(6, 5, 3))
    errors = rng.normal(size=(count, 6, 3))
    errors += np.einsum("cm,nmi->cni", rng.normal(size=(count, 5)), shared)
    weight = 1.0 / np.trace(own + shared.transpose(0, 2, 1) @ shared, axis1=1, axis2=2)
    rows = motions(points).transpose(0, 2, 1).reshape(18, 6)
    root = np.repeat(np.sqrt(weight), 3)
    best = np.linalg.lstsq(rows * root[:, None], (errors.reshape(count, 18) * root).T, rcond=None)
    left = errors.reshape(count, 18) - (rows @ best[0]).T
    found = np.einsum("cni,cnj->nij", left.reshape(count, 6, 3), left.reshape(count, 6, 3)) / count
    np.testing.assert_allclose(without_common_motion(points, own, shared), found, atol=0.15)


def test_one_point_is_nowhere_against_others() -> None:
    covs = without_common_motion(np.ones((1, 3)), np.eye(3)[None], np.zeros((1, 2, 3)))
    np.testing.assert_allclose(covs, 0.0, atol=1e-12)
    assert without_common_motion(
        np.zeros((0, 3)), np.zeros((0, 3, 3)), np.zeros((0, 2, 3))
    ).shape == (
        0,
        3,
        3,
    )
