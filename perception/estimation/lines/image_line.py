"""Lines in a picture from its points: the two charts of the paper's figure 4."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from facetlog.perception.estimation.ekf import State
from facetlog.perception.estimation.incidence import (
    MAX_SLOPE,
    SURE_SD,
    Incidence,
    converted,
    fit_most_likely,
    run_from_fit,
    solved,
    update_one,
)
from facetlog.perception.estimation.plane_filter import Chart
from facetlog.perception.types import FloatArray, frozen


@dataclass(frozen=True, eq=False, slots=True)
class ImageLine:
    """A line in a picture as (a, p) with its covariance, about a pixel `origin` (2,).

    Chart Y is a u + v + p = 0 (lines not parallel to the v axis), chart X is u + a v + p = 0, with
    (u, v) measured from the origin.
    """

    chart: Chart
    state: State
    origin: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", frozen(self.origin, 2))

    @property
    def homogeneous(self) -> tuple[FloatArray, FloatArray]:
        """l (3,) with l · (u, v, 1) = 0 in the picture's own pixels, and its covariance (3, 3)."""

        def line(state: FloatArray) -> FloatArray:
            normal = self._normal(state)
            return np.array([*normal, state[1] - normal @ self.origin])

        return converted(self.state.cov, self.state.mean, line)

    def in_chart(self, chart: Chart, origin: FloatArray | None = None) -> Self:
        """Return the same line in a chart, about another origin where one is given.

        ValueError if it is parallel to the chart's axis.
        """
        about = self.origin if origin is None else origin
        one = int(chart == Chart.Y)

        def to(state: FloatArray) -> FloatArray:
            normal, p = self._normal(state), state[1] + self._normal(state) @ (about - self.origin)
            described: FloatArray = np.array([normal[1 - one], p]) / normal[one]
            return described

        if self._normal(self.state.mean)[one] == 0.0:
            raise ValueError(f"the line is parallel to the axis of chart {chart.name}")
        mean, cov = converted(self.state.cov, self.state.mean, to)
        return type(self)(chart, State(mean, cov), about)

    def _normal(self, state: FloatArray) -> FloatArray:
        one = 0 * state[0] + 1.0
        normal: FloatArray = np.array([state[0], one] if self.chart == Chart.Y else [one, state[0]])
        return normal


def _equations(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    # f = a u + v + p, with x = (u, v)
    M = np.stack([x[..., 0], np.ones_like(x[..., 0])], axis=-1)[..., None, :]
    return M, -x[..., 1:]


def _by_point(a: FloatArray) -> FloatArray:
    return np.stack([a[..., 0], np.ones_like(a[..., 0])], axis=-1)[..., None, :]


POINT_ON_LINE = Incidence(_equations, _by_point)


def fit_image_line(points: ArrayLike, covs: ArrayLike) -> ImageLine:
    """Return the most likely line of pixels (n, 2), n at least 2, with covariances (n, 2, 2).

    About the pixels' middle, in the chart in which its slope is at most 1. ValueError for pixels
    that are all one.
    """
    x, noise = np.asarray(points, dtype=np.float64), np.asarray(covs, dtype=np.float64)
    if x.ndim != 2 or x.shape[1] != 2 or noise.shape != (len(x), 2, 2):
        raise ValueError(f"points {x.shape} and covariances {noise.shape} do not go together")
    origin = x.mean(axis=0)
    chart, x, noise = _choose_chart(x - origin, noise)
    start = solved(POINT_ON_LINE, x)
    mean, cov, _ = fit_most_likely(POINT_ON_LINE, x[None], noise[None], start[None])
    return ImageLine(chart, State(mean[0], cov[0]), origin)


def filter_image_line(points: ArrayLike, covs: ArrayLike) -> Iterator[ImageLine]:
    """Yield the line after each further pixel, as of `fit_image_line`, from the first that make its
    slope sure; each is used once, linearised at the previous line.
    """
    x, noise = np.asarray(points, dtype=np.float64), np.asarray(covs, dtype=np.float64)

    def update(line: ImageLine, k: int) -> ImageLine:
        order = _axes(line.chart)
        point, cov = (x[k] - line.origin)[order], noise[k][np.ix_(order, order)]
        state, _ = update_one(POINT_ON_LINE, line.state, point, cov)
        line = replace(line, state=state)
        if abs(line.state.mean[0]) > MAX_SLOPE:
            line = line.in_chart(Chart.X if line.chart == Chart.Y else Chart.Y)
        return line

    return run_from_fit(
        lambda n: fit_image_line(x[:n], noise[:n]),
        len(x),
        lambda line: bool(line.state.cov[0, 0] <= SURE_SD**2),
        update,
    )


def _axes(chart: Chart) -> list[int]:
    # The axis of the slope, then that of the coefficient 1.
    return [1, 0] if chart == Chart.X else [0, 1]


def _choose_chart(x: FloatArray, noise: FloatArray) -> tuple[Chart, FloatArray, FloatArray]:
    spread = np.ptp(x, axis=0)
    if not spread.any():
        raise ValueError("all points are one: there is no line")
    chart = Chart.Y if spread[0] >= spread[1] else Chart.X
    order = _axes(chart)
    return chart, x[:, order], noise[:, order][:, :, order]
