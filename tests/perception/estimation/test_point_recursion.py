"""Points view by view: as good as all views at once, whatever the order, and gated."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.perception.estimation.ekf import Linearised, State, step
from facetlog.perception.estimation.incidence import updated
from facetlog.perception.estimation.point_filter import (
    estimate_points,
    measure_pixel,
    pixel_incidence,
)
from facetlog.perception.estimation.point_recursion import PointFilters
from tests.perception.rigs import PIXEL_SD, pictured, ring

SEEDS = st.integers(0, 2**32 - 1)


def _after_all(uv, cov, projections, order):
    filters = PointFilters(len(uv))
    for v in order:
        filters.add(projections[v], uv[:, v], cov[:, v], np.ones(len(uv), np.bool_))
    return filters


@settings(max_examples=20, derandomize=True)
@given(SEEDS)
def test_after_the_last_view_points_are_where_all_views_at_once_have_them(seed):
    rng = np.random.default_rng(seed)
    projections = ring(16)
    _, uv, cov, _ = pictured(rng, 20, projections)
    batch, covs, used, _ = estimate_points(uv, cov, np.ones(uv.shape[:2]), projections)
    filters = _after_all(uv, cov, projections, rng.permutation(16))
    assert filters.known.all()
    # Either may leave out a view that the other takes.
    same = used.all(axis=1) & (filters.views == 16)
    assert same.sum() >= 15
    off = (filters.points - batch)[same]
    assert np.einsum("ni,nij,nj->n", off, np.linalg.inv(covs[same]), off).max() < 0.1**2
    sizes = (np.trace(c[same], axis1=1, axis2=2) for c in (filters.covs, covs))
    np.testing.assert_allclose(*sizes, rtol=0.05)


def test_one_update_is_filterpys_of_the_pixel():
    rng = np.random.default_rng(3)
    projections = ring(4)
    points, uv, cov, _ = pictured(rng, 1, projections, sd=1e-3)
    start = State(points[0] + 0.01, 1e-4 * np.eye(3))
    mean, after, _ = updated(
        pixel_incidence(projections[0]), start.mean[None], start.cov[None], uv[:, 0], cov[:, 0]
    )
    # Made linear at where it ends, as the last of the passes is.
    at = mean[0]
    lin = measure_pixel(uv[0, 0], projections[0], cov[0, 0], at)(at)
    one = step(start, Linearised(lin.y, lin.M, lin.W))
    np.testing.assert_allclose(mean[0], one.mean, atol=1e-6)
    np.testing.assert_allclose(after[0], one.cov, rtol=1e-3, atol=1e-12)


def test_a_wrong_pixel_is_refused_and_changes_nothing():
    rng = np.random.default_rng(4)
    projections = ring(12)
    _, uv, cov, _ = pictured(rng, 3, projections)
    filters = _after_all(uv, cov, projections, range(11))
    before = filters.points.copy()
    wrong = uv[:, 11].copy()
    wrong[1] += 40 * PIXEL_SD
    refused = filters.add(projections[11], wrong, cov[:, 11], [True, True, False])
    assert refused.tolist() == [False, True, False]
    changed = (filters.points != before).any(axis=1)
    assert changed.tolist() == [True, False, False]


def test_wrong_pixels_in_the_first_views_do_not_spoil_the_start():
    rng = np.random.default_rng(5)
    projections = ring(16)
    points, uv, cov, _ = pictured(rng, 40, projections)
    uv[:, 1] = rng.uniform([100, 50], [540, 430], (40, 2))
    filters = _after_all(uv, cov, projections, range(16))
    off = filters.points - points
    nees = np.einsum("ni,nij,nj->n", off, np.linalg.inv(filters.covs), off)
    assert filters.known.all()
    assert nees.max() < 30


def test_views_without_parallax_leave_a_point_unknown():
    rng = np.random.default_rng(6)
    projections = np.repeat(ring(12)[:1], 5, axis=0)
    _, uv, cov, _ = pictured(rng, 2, projections)
    filters = _after_all(uv, cov, projections, range(5))
    assert not filters.known.any()
    assert np.isnan(filters.points).all()
