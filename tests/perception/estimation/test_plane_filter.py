"""Planes from points: charts, the likeliest plane, and its covariance."""

import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2 as chi2_of

from facetlog.perception.estimation.ekf import Linearised, State, recursion
from facetlog.perception.estimation.plane_filter import (
    Chart,
    PlaneFailure,
    convert_chart_to_plane,
    convert_plane_to_chart,
    fit_plane,
    propagate_common_errors,
)
from facetlog.perception.scene import Plane
from tests.perception.rigs import rotation

SEEDS = st.integers(0, 2**32 - 1)
SD = 0.02


def _on_plane(rng, normal, count=8, middle=(0.0, 0.0, 0.0)):
    basis = np.linalg.svd(np.asarray(normal, dtype=float)[None])[2][1:]
    return rng.uniform(-1, 1, (count, 2)) @ basis + middle


def _noisy(rng, points, sd=SD):
    return points + sd * rng.normal(size=points.shape), np.tile(
        sd**2 * np.eye(3), (len(points), 1, 1)
    )


def _about(plane, middle, chart):
    """(a, b, p) with the origin moved to `middle`, where p and the slopes part ways."""
    J = np.eye(4)
    J[3, :3] = middle
    return convert_plane_to_chart(
        chart,
        Plane(plane.normal, plane.offset + plane.normal @ middle, J @ plane.cov @ J.T),
    )


@pytest.mark.parametrize("middle", [(0.0, 0.0, 0.0), (30.0, -20.0, 50.0)])
def test_covariance_is_honest_for_every_direction(middle):
    rng = np.random.default_rng(1)
    runs, nees, fits = 600, [], []
    for _ in range(runs):
        normal = rng.normal(size=3)
        normal /= np.linalg.norm(normal)
        true = _on_plane(rng, normal, middle=middle)
        points, covs = _noisy(rng, true)
        fit = fit_plane(points, covs)
        centre = points.mean(axis=0)
        truth = Plane(normal, float(-normal @ true[0]), np.zeros((4, 4)))
        found, wanted = (_about(p, centre, fit.chart) for p in (fit.plane, truth))
        error = found.mean - wanted.mean
        nees.append(error @ np.linalg.solve(found.cov, error))
        fits.append(fit.chi2)
    low, high = chi2_of.ppf([5e-5, 1 - 5e-5], runs * 3) / runs
    assert low < np.mean(nees) < high
    low, high = chi2_of.ppf([5e-5, 1 - 5e-5], runs * 5) / runs
    assert low < np.mean(fits) < high


@pytest.mark.parametrize("chart", list(Chart))
@given(seed=SEEDS)
def test_chart_and_plane_convert_back_and_forth(chart, seed):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(3, 3))
    state = State(rng.normal(size=3), A @ A.T + 0.1 * np.eye(3))
    plane = convert_chart_to_plane(chart, state)
    again = convert_plane_to_chart(chart, plane)
    np.testing.assert_allclose(again.mean, state.mean, atol=1e-9)
    np.testing.assert_allclose(again.cov, state.cov, atol=1e-7)
    assert np.linalg.matrix_rank(plane.cov, tol=1e-9) == 3
    np.testing.assert_allclose(plane.cov[:3, :3] @ plane.normal, 0.0, atol=1e-9)
    flipped = convert_plane_to_chart(chart, plane.flipped())
    np.testing.assert_allclose(flipped.cov, state.cov, atol=1e-7)


@pytest.mark.parametrize(
    ("chart", "point"),
    [
        (Chart.Z, (3, 5, -(2 * 3 + 7 * 5 + 11))),
        (Chart.X, (-(2 * 3 + 7 * 5 + 11), 3, 5)),
        (Chart.Y, (5, -(2 * 3 + 7 * 5 + 11), 3)),
    ],
)
def test_charts_are_those_of_figure_6(chart, point):
    # a x + b y + z + p = 0, x + a y + b z + p = 0 and b x + y + a z + p = 0, (a, b, p) = (2, 7, 11)
    plane = convert_chart_to_plane(chart, State(np.array([2.0, 7.0, 11.0]), np.eye(3)))
    assert plane.distance(point) == pytest.approx(0.0, abs=1e-12)


def test_plane_parallel_to_the_axis_is_not_in_its_chart():
    with pytest.raises(ValueError, match="parallel"):
        convert_plane_to_chart(Chart.Z, Plane([1.0, 0.0, 0.0], 0.0, np.zeros((4, 4))))


@settings(max_examples=40)
@given(SEEDS, st.floats(-4, 4), st.floats(0, 3))
def test_order_frame_and_unit_do_not_matter(seed, log_scale, log_shift):
    rng = np.random.default_rng(seed)
    normal = rng.normal(size=3)
    points, covs = _noisy(rng, _on_plane(rng, normal))
    scale = 10.0**log_scale
    R, shift = rotation(rng), scale * 10.0**log_shift * rng.normal(size=3)
    order = rng.permutation(len(points))
    here = fit_plane(points, covs)
    there = fit_plane(scale * points[order] @ R.T + shift, scale**2 * R @ covs[order] @ R.T)
    assert bool(here) == bool(there)
    if not here:
        return
    sign = np.sign(there.plane.normal @ R @ here.plane.normal)
    np.testing.assert_allclose(sign * R.T @ there.plane.normal, here.plane.normal, atol=1e-6)
    offset = sign * (there.plane.offset + there.plane.normal @ shift) / scale
    assert offset == pytest.approx(here.plane.offset, abs=1e-6)
    np.testing.assert_allclose(
        R.T @ there.plane.cov[:3, :3] @ R,
        here.plane.cov[:3, :3],
        atol=1e-4 * np.abs(here.plane.cov).max(),
    )
    assert there.chi2 == pytest.approx(here.chi2, rel=1e-4, abs=1e-6)


def test_fit_equals_the_recursion_and_filterpy():
    rng = np.random.default_rng(5)
    raw = _on_plane(rng, [0.2, -0.1, 1.0], 10)
    points, _ = _noisy(rng, raw)
    points = points - points.mean(axis=0)
    A = SD * rng.normal(size=(10, 3, 3))
    covs = A @ A.transpose(0, 2, 1) + 1e-5 * np.eye(3)
    fit = fit_plane(points, covs)
    found = convert_plane_to_chart(Chart.Z, fit.plane)
    start = State(np.zeros(3), 1e6 * np.eye(3))
    # Every point made linear at the plane found: equation (1)'s x* is the point moved onto it.
    g = np.array([*found.mean[:2], 1.0])
    measurements = []
    for x, cov in zip(points, covs, strict=True):
        off, W = g @ x + found.mean[2], g @ cov @ g
        M = np.append((x - cov @ g * (off / W))[:2], 1.0)[None]
        measurements.append(Linearised(M @ found.mean - off, M, np.array([[W]])))
    reference = ExtendedKalmanFilter(dim_x=3, dim_z=1)
    reference.x, reference.P = np.zeros(3), 1e6 * np.eye(3)
    for lin in measurements:
        reference.update(
            lin.y, lambda _, m: m, lambda x, m: m @ x, R=lin.W, args=lin.M, hx_args=lin.M
        )
    *_, state = recursion(start, [lambda _, lin=lin: lin for lin in measurements])
    np.testing.assert_allclose(state.mean, found.mean, atol=1e-5)
    np.testing.assert_allclose(reference.x, found.mean, atol=1e-5)
    np.testing.assert_allclose(state.cov, found.cov, rtol=1e-3, atol=1e-8)
    np.testing.assert_allclose(reference.P, found.cov, rtol=1e-3, atol=1e-8)


def test_exact_points_have_a_plane():
    rng = np.random.default_rng(7)
    points = _on_plane(rng, [1.0, 2.0, 3.0], 6, (100.0, 0.0, 0.0))
    fit = fit_plane(points, np.zeros((6, 3, 3)))
    np.testing.assert_allclose(fit.plane.distance(points), 0.0, atol=1e-9)
    assert fit.plane.cov.max() < 1e-10


def test_two_points_are_too_few():
    failed = fit_plane(np.eye(3)[:2], np.tile(np.eye(3), (2, 1, 1)))
    assert not failed
    assert failed.reason is PlaneFailure.TOO_FEW


@pytest.mark.parametrize("count", [3, 200])
@pytest.mark.parametrize("sd", [0.0, 0.01])
def test_points_on_a_line_give_no_plane(count, sd):
    rng = np.random.default_rng(count)
    line = np.outer(np.linspace(-1, 1, count), [1.0, 2.0, 3.0]) + 5.0
    failed = fit_plane(
        line + sd * rng.normal(size=line.shape), np.tile(sd**2 * np.eye(3), (count, 1, 1))
    )
    assert failed.reason is PlaneFailure.COLLINEAR


def test_points_vaguer_than_their_spread_give_no_plane():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.0]])
    covs = np.tile(np.diag([1e-6, 1e-6, 0.25]), (4, 1, 1))
    assert fit_plane(points, covs).reason is PlaneFailure.UNCERTAIN


def test_a_common_shift_is_no_tilt_and_as_large_as_at_any_point():
    rng, normal, middle = np.random.default_rng(8), np.array([0.48, 0.6, 0.64]), np.arange(3.0)
    points = _on_plane(rng, normal, middle=middle)
    fit = fit_plane(points, [SD**2 * np.eye(3)] * len(points))
    plane = propagate_common_errors(fit.plane, points, SD**2 * np.ones((len(points),) * 2))
    np.testing.assert_allclose(plane.cov[:3, :3], 0.0, atol=1e-12)
    assert plane.cov[3, 3] == pytest.approx(SD**2)
    np.testing.assert_array_equal(plane.normal, fit.plane.normal)


@pytest.mark.parametrize("middle", [(0.0, 0.0, 0.0), (5.0, -3.0, 8.0)])
def test_errors_apart_at_each_point_leave_the_covariance_of_the_fit(middle):
    rng = np.random.default_rng(9)
    points = _on_plane(rng, np.array([0.48, 0.6, 0.64]), middle=middle)
    fit = fit_plane(points, [SD**2 * np.eye(3)] * len(points))
    plane = propagate_common_errors(fit.plane, points, SD**2 * np.eye(len(points)))
    np.testing.assert_allclose(plane.cov, fit.plane.cov, atol=1e-3 * fit.plane.cov[3, 3])


def test_bad_arguments_are_refused():
    with pytest.raises(ValueError, match="go together"):
        fit_plane(np.zeros((4, 3)), np.zeros((3, 3, 3)))
    with pytest.raises(ValueError, match="finite"):
        fit_plane(np.full((4, 3), np.nan), np.zeros((4, 3, 3)))
