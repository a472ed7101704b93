"""Lines in pictures: the two charts of figure 4, the fit, and the recursion beside it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.perception.estimation.ekf import State
from facetlog.perception.estimation.lines.image_line import (
    ImageLine,
    filter_image_line,
    fit_image_line,
)
from facetlog.perception.estimation.plane_filter import Chart

SD = 0.5
DEGREES = st.integers(0, 359)


def _pixels(degrees, count=20, length=100.0, middle=(320.0, 240.0)):
    turn = np.radians(degrees)
    along = length * np.array([np.cos(turn), np.sin(turn)])
    points = np.array(middle) + np.linspace(-0.5, 0.5, count)[:, None] * along
    return points[np.argsort(-np.abs(np.linspace(-0.5, 0.5, count)), kind="stable")]


def _covs(points, sd=SD):
    return np.tile(sd**2 * np.eye(2), (len(points), 1, 1))


def test_the_charts_are_those_of_figure_4():
    # a x + y + p = 0 and x + a y + p = 0 with (a, p) = (2, 7) at 3, and at y = 3
    state = State(np.array([2.0, 7.0]), np.eye(2))
    for chart, point in ((Chart.Y, (3.0, -13.0)), (Chart.X, (-13.0, 3.0))):
        across, _ = ImageLine(chart, state, np.zeros(2)).homogeneous
        assert across @ [*point, 1.0] == pytest.approx(0.0)


@given(DEGREES, st.floats(-100, 100), st.floats(-100, 100))
def test_chart_and_origin_change_neither_line_nor_covariance(degrees, u, v):
    points = _pixels(degrees)
    line = fit_image_line(points, _covs(points))
    if abs(line.state.mean[0]) < 0.01:
        return
    other = line.in_chart(Chart(1 - line.chart), np.array([320.0 + u, 240.0 + v]))
    again = other.in_chart(line.chart, line.origin)
    np.testing.assert_allclose(again.state.mean, line.state.mean, atol=1e-9)
    np.testing.assert_allclose(again.state.cov, line.state.cov, rtol=1e-6, atol=1e-12)
    ours, theirs = line.homogeneous[0], other.homogeneous[0]
    np.testing.assert_allclose(np.cross(ours, theirs) / np.linalg.norm(theirs), 0.0, atol=1e-6)


@settings(derandomize=True)
@given(DEGREES, st.integers(0, 2**32 - 1))
def test_the_recursion_ends_at_the_fit(degrees, seed):
    points = _pixels(degrees)
    points = points + SD * np.random.default_rng(seed).normal(size=points.shape)
    fit = fit_image_line(points, _covs(points))
    *_, last = filter_image_line(points, _covs(points))
    last = last.in_chart(fit.chart, fit.origin)
    off = last.state.mean - fit.state.mean
    assert off @ np.linalg.solve(fit.state.cov, off) < 0.1**2
    np.testing.assert_allclose(last.state.cov, fit.state.cov, rtol=0.1, atol=1e-3 * SD**2)


def test_pixels_that_are_all_one_have_no_line():
    with pytest.raises(ValueError, match="no line"):
        fit_image_line(np.zeros((3, 2)), _covs(np.zeros((3, 2))))
