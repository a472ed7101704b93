"""Planes from 3-D points: the charts of figure 6, the paper's recursion, and the estimator.

A plane has three parameters (a, b, p) in each of three charts, named by the axis whose coefficient
is 1. The paper uses chart Z; there a vertical face has infinite slope and a steep one an angle
error of up to 20 times the bound. `fit_plane` takes the chart of the normal's largest component,
about the points' middle, from a total-least-squares start.

Its covariance assumes independent errors of the points. Vertices from the same views share the
errors of the poses: a common shift or rotation of all points is then not in the covariance of one
plane (it largely cancels between planes of one scene), and the caller must add it where absolute
place matters.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum, StrEnum
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import chdtrc

from facetlog.perception.estimation.ekf import State, recursion
from facetlog.perception.estimation.incidence import Incidence, fit_most_likely, measure_as_printed
from facetlog.perception.scene import Plane
from facetlog.perception.types import FloatArray

# Rounding of coordinates, as a share of the points' spread: the least standard deviation of a
# point, so that exact points (of a mesh) have a plane too.
LEAST_SD = 1e-9
# Points count as collinear unless noise alone would give their spread across the line less than
# once in 1,000.
LINE_PROBABILITY = 1e-3
# A normal with a larger standard deviation (rad) is undetermined: the plane perpendicular to it is
# within 3 sd of slope.
MAX_TILT_SD = 1.0 / 3.0


class Chart(IntEnum):
    """The axis whose coefficient is 1; the planes parallel to that axis are not in the chart.

    The two axes after it, in turn, have the coefficients a and b (figure 6): Z is
    a x + b y + z + p = 0, X is x + a y + b z + p = 0, Y is b x + y + a z + p = 0.
    """

    X = 0
    Y = 1
    Z = 2

    @property
    def axes(self) -> tuple[int, int, int]:
        """Indices of the axes of a, of b, and of the coefficient 1."""
        return (self + 1) % 3, (self + 2) % 3, int(self)


class PlaneFailure(StrEnum):
    """Why there is no plane."""

    TOO_FEW = "fewer than three points"
    COLLINEAR = "the points lie on one line, within their noise"
    UNCERTAIN = "the points do not fix the tilt of the plane"


@dataclass(frozen=True, eq=False, slots=True)
class PlaneFit:
    """A plane, the chart it was found in, and the chi-square of the n points, of n - 3 degrees."""

    plane: Plane
    chart: Chart
    chi2: float
    reason: None = None

    def __bool__(self) -> Literal[True]:
        return True


@dataclass(frozen=True, eq=False, slots=True)
class NoPlane:
    """No plane, and why; falsy."""

    reason: PlaneFailure

    def __bool__(self) -> Literal[False]:
        return False


def choose_best_chart(normal: ArrayLike) -> Chart:
    """Return the chart in which the slopes a and b of a plane with this normal are at most 1.

    >>> choose_best_chart([1.0, 0.0, 0.1])
    <Chart.X: 0>
    """
    return Chart(int(np.argmax(np.abs(np.asarray(normal, dtype=np.float64)))))


def convert_chart_to_plane(chart: Chart, state: State) -> Plane:
    """Return the plane of (a, b, p) with its covariance, by first order; its normal's entry 1 is
    positive.

    >>> convert_chart_to_plane(Chart.Z, State(np.array([0.0, 0.0, -3.0]), np.eye(3))).offset
    -3.0
    """
    i, j, k = chart.axes
    a, b, p = state.mean
    m = np.zeros(3)
    m[[i, j, k]] = a, b, 1.0
    length = float(np.linalg.norm(m))
    n = m / length
    # n = m / |m|, offset = p / |m|
    J = np.zeros((4, 3))
    J[:3, :2] = ((np.eye(3) - np.outer(n, n)) / length)[:, [i, j]]
    J[3, :2] = -p * m[[i, j]] / length**3
    J[3, 2] = 1.0 / length
    return Plane(n, float(p / length), J @ state.cov @ J.T)


def convert_plane_to_chart(chart: Chart, plane: Plane) -> State:
    """Return (a, b, p) of a plane with their covariance; ValueError if the plane is not in the
    chart.
    """
    i, j, k = chart.axes
    n = plane.normal
    if abs(n[k]) < np.finfo(np.float64).eps:
        raise ValueError(f"the plane is parallel to the axis of chart {chart.name}")
    # (a, b, p) = (n_i, n_j, offset) / n_k
    mean = np.array([n[i], n[j], plane.offset]) / n[k]
    J = np.zeros((3, 4))
    J[[0, 1, 2], [i, j, 3]] = 1.0 / n[k]
    J[:, k] = -mean / n[k]
    return State(mean, J @ plane.cov @ J.T)


def plain_plane_recursion(
    points: Sequence[ArrayLike], noise: ArrayLike, start: State, chart: Chart = Chart.Z
) -> Iterator[State]:
    """Return the states (a, b, p) of the paper's recursion as printed after each point (3,);
    `noise` (3, 3) is that of each point.
    """
    order = list(chart.axes)
    cov = np.asarray(noise, dtype=np.float64)[np.ix_(order, order)]
    x = np.asarray(points, dtype=np.float64)[:, order]
    return recursion(start, (measure_as_printed(PLANE_OF_POINTS, each, cov) for each in x))


def fit_plane(points: ArrayLike, covs: ArrayLike) -> PlaneFit | NoPlane:
    """Return the most likely plane of points (n, 3) with covariances (n, 3, 3); falsy with a
    reason.

    That of all the points at once (incidence.py) in the best chart, about their middle and in units
    of their spread, from a total-least-squares start. Independent of order, frame and unit. The
    normal's sign is the chart's: its largest component is positive.
    """
    x, noise = np.array(points, dtype=np.float64), np.array(covs, dtype=np.float64)
    if x.ndim != 2 or x.shape[1] != 3 or noise.shape != (len(x), 3, 3):
        raise ValueError(f"points {x.shape} and covariances {noise.shape} do not go together")
    if not (np.isfinite(x).all() and np.isfinite(noise).all()):
        raise ValueError("points and covariances must be finite")
    if len(x) < 3:
        return NoPlane(PlaneFailure.TOO_FEW)
    middle = x.mean(axis=0)
    spread = float(np.sqrt(((x - middle) ** 2).sum(axis=1).mean()))
    if spread <= 64 * np.finfo(np.float64).eps * float(np.abs(x).max()):
        return NoPlane(PlaneFailure.COLLINEAR)
    x = (x - middle) / spread
    noise = noise / spread**2 + LEAST_SD**2 * np.eye(3)
    # Total least squares: the normal is the direction of least spread (columns in rising order).
    axes = np.linalg.eigh(x.T @ x)[1]
    across = axes[:, 1]
    wide = float(((x @ across) ** 2 / np.einsum("i,nij,j->n", across, noise, across)).sum())
    if chdtrc(len(x) - 2, wide) > LINE_PROBABILITY:
        return NoPlane(PlaneFailure.COLLINEAR)
    chart = choose_best_chart(axes[:, 0])
    i, j, k = chart.axes
    start = np.array([axes[i, 0] / axes[k, 0], axes[j, 0] / axes[k, 0], 0.0])
    order = [i, j, k]
    at, cov, chi2 = fit_most_likely(
        PLANE_OF_POINTS, x[None, :, order], noise[None][:, :, order][..., order], start[None]
    )
    plane = _moved(convert_chart_to_plane(chart, State(at[0], cov[0])), middle, spread)
    if np.sqrt(np.linalg.eigvalsh(plane.cov[:3, :3])[2]) > MAX_TILT_SD:
        return NoPlane(PlaneFailure.UNCERTAIN)
    return PlaneFit(plane, chart, float(chi2[0]))


def propagate_common_errors(plane: Plane, points: ArrayLike, cov: ArrayLike) -> Plane:
    """Return the plane through points (n, 3) whose distances from it have the joint covariance (n,
    n).

    Points of one fit have correlated errors: `fit_plane`, which assumes independent ones, would
    overestimate the precision of their mean.
    """
    x, cov = np.asarray(points, dtype=np.float64), np.asarray(cov, dtype=np.float64)
    middle = x.mean(axis=0)
    axes = np.linalg.svd(plane.normal[None])[2][1:]
    # e = a u + b v + c at (u, v) along the plane's axes from the middle, by least squares
    solve = np.linalg.pinv(np.column_stack([(x - middle) @ axes.T, np.ones(len(x))]))
    # with t = a axes[0] + b axes[1]: normal' = normal - t; offset' = offset + t · middle - c
    J = np.zeros((4, 3))
    J[:3, :2] = -axes.T
    J[3] = [*(axes @ middle), -1.0]
    J = J @ solve
    return Plane(plane.normal, plane.offset, J @ cov @ J.T)


def _points(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    # (11)  f = a x + b y + z + p; (12), (13)  M = [x y 1], y = -z
    M = np.ones((*x.shape[:-1], 1, 3))
    M[..., 0, :2] = x[..., :2]
    return M, -x[..., 2:]


def _by_point(a: FloatArray) -> FloatArray:
    # (14)  ∂f/∂x = [a b 1]
    G = np.ones((*a.shape[:-1], 1, 3))
    G[..., 0, :2] = a[..., :2]
    return G


PLANE_OF_POINTS = Incidence(_points, _by_point)


def _moved(plane: Plane, middle: FloatArray, spread: float) -> Plane:
    """Return the plane in the world, x_world = middle + spread * x."""
    # offset_world = spread * offset - n · middle
    J = np.eye(4)
    J[3, :3] = -middle
    J[3, 3] = spread
    return Plane(
        plane.normal, float(spread * plane.offset - plane.normal @ middle), J @ plane.cov @ J.T
    )
