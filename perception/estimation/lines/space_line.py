"""Lines in space from points and from lines in pictures, and planes of them.

The three charts of the paper's figure 5: Z is x = a z + p, y = b z + q, and X, Y in turn.
"""

from collections.abc import Iterator, Sequence
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
from facetlog.perception.estimation.lines.image_line import ImageLine
from facetlog.perception.estimation.plane_filter import (
    Chart,
    choose_best_chart,
    convert_chart_to_plane,
    convert_plane_to_chart,
)
from facetlog.perception.scene import Plane
from facetlog.perception.types import FloatArray, frozen


@dataclass(frozen=True, eq=False, slots=True)
class SpaceLine:
    """A line in space as (a, b, p, q) of its chart with their covariance, about `origin` (3,)."""

    chart: Chart
    state: State
    origin: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", frozen(self.origin, 3))

    @property
    def direction_and_foot(self) -> tuple[FloatArray, FloatArray]:
        """The direction with 1 along the chart's axis, and where the line meets the plane of the
        other two, from the origin: (6,), and its covariance (6, 6) of rank 4.
        """
        return converted(self.state.cov, self.state.mean, self._drawn)

    def near(self, point: FloatArray, cov: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return a point (3,) known to be on the line, projected onto it, and its covariance (3,
        3).

        Across the line it has the line's covariance, along the line its own (3, 3).
        """
        i, j, k = self.chart.axes
        a = self.state.mean
        z = point[k] - self.origin[k]
        on, J, along = np.zeros(3), np.zeros((3, 4)), np.ones(3)
        on[i], on[j], on[k] = a[0] * z + a[2], a[1] * z + a[3], z
        J[i, 0] = J[j, 1] = z
        J[i, 2] = J[j, 3] = 1.0
        along[i], along[j] = a[0], a[1]
        known = J @ self.state.cov @ J.T + cov[k, k] * np.outer(along, along)
        return on + self.origin, known

    def seen(self, image: ImageLine, projection: FloatArray) -> tuple[Self, float]:
        """Return the line after one more view, with `projection` (3, 4), shows it as `image`; and
        the squared Mahalanobis length of the innovation, chi-square with two degrees of freedom.
        """
        planes, noise = _shifted(*_build_viewing_planes([image], [projection]), self.origin)
        (x,), (cov,) = _in_order(planes, noise, self.chart)
        state, chi2 = update_one(LINE_OF_PLANES, self.state, x, cov)
        return replace(self, state=state).to_best_chart(), chi2

    def in_chart(self, chart: Chart, origin: FloatArray | None = None) -> Self:
        """Return the same line in another chart, about another origin where one is given.

        ValueError if it is orthogonal to the chart's axis.
        """
        i, j, k = chart.axes
        about = self.origin if origin is None else origin
        if self._drawn(self.state.mean)[k] == 0.0:
            raise ValueError(f"the line is orthogonal to the axis of chart {chart.name}")

        def described(state: FloatArray) -> FloatArray:
            drawn = self._drawn(state)
            slopes = drawn[:3] / drawn[k]
            foot = drawn[3:] + self.origin - about
            foot = foot - foot[k] * slopes
            return np.array([slopes[i], slopes[j], foot[i], foot[j]])

        mean, cov = converted(self.state.cov, self.state.mean, described)
        return type(self)(chart, State(mean, cov), about)

    def to_best_chart(self) -> Self:
        """Return the same line where no slope is beyond MAX_SLOPE."""
        if np.abs(self.state.mean[:2]).max() <= MAX_SLOPE:
            return self
        return self.in_chart(choose_best_chart(self._drawn(self.state.mean)[:3]))

    def _drawn(self, state: FloatArray) -> FloatArray:
        i, j, k = self.chart.axes
        drawn = np.zeros(6, dtype=state.dtype)
        drawn[[i, j, 3 + i, 3 + j]] = state
        drawn[k] = 1.0
        return drawn


def _points(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    # f = (a z + p - x, b z + q - y)
    M = np.zeros((*x.shape[:-1], 2, 4))
    M[..., 0, 0] = M[..., 1, 1] = x[..., 2]
    M[..., 0, 2] = M[..., 1, 3] = 1.0
    return M, x[..., :2]


def _by_point(a: FloatArray) -> FloatArray:
    G = np.zeros((*a.shape[:-1], 2, 3))
    G[..., 0, 0] = G[..., 1, 1] = -1.0
    G[..., :, 2] = a[..., :2]
    return G


def _planes(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    # x is a plane n · (x, y, z) + d = 0 that holds the line:
    # f = (n · (a, b, 1), n · (p, q, 0) + d)
    M = np.zeros((*x.shape[:-1], 2, 4))
    M[..., 0, :2] = M[..., 1, 2:] = x[..., :2]
    return M, -x[..., 2:]


def _by_plane(a: FloatArray) -> FloatArray:
    G = np.zeros((*a.shape[:-1], 2, 4))
    G[..., 0, :2], G[..., 1, :2] = a[..., :2], a[..., 2:]
    G[..., 0, 2] = G[..., 1, 3] = 1.0
    return G


def _lines(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    # x is a line's direction and foot: f = (m · direction, m · foot + p), m = (a, b, 1)
    M = np.zeros((*x.shape[:-1], 2, 3))
    M[..., 0, :2], M[..., 1, :2] = x[..., :2], x[..., 3:5]
    M[..., 1, 2] = 1.0
    return M, -x[..., [2, 5]]


def _by_line(a: FloatArray) -> FloatArray:
    G = np.zeros((*a.shape[:-1], 2, 6))
    G[..., 0, :2] = G[..., 1, 3:5] = a[..., :2]
    G[..., 0, 2] = G[..., 1, 5] = 1.0
    return G


LINE_OF_POINTS = Incidence(_points, _by_point)
LINE_OF_PLANES = Incidence(_planes, _by_plane)
PLANE_OF_LINES = Incidence(_lines, _by_line)


def fit_line_to_points(points: ArrayLike, covs: ArrayLike) -> SpaceLine:
    """Return the most likely line of points (n, 3), n at least 2, with covariances (n, 3, 3)."""
    x, noise = np.asarray(points, dtype=np.float64), np.asarray(covs, dtype=np.float64)
    if x.ndim != 2 or x.shape[1] != 3 or len(x) < 2 or noise.shape != (len(x), 3, 3):
        raise ValueError(f"points {x.shape} and covariances {noise.shape} make no line")
    origin = x.mean(axis=0)
    along = np.linalg.svd(x - origin)[2][0]
    return _fit_line(LINE_OF_POINTS, x - origin, noise, choose_best_chart(along), origin)


def fit_line_to_images(images: Sequence[ImageLine], projections: Sequence[FloatArray]) -> SpaceLine:
    """Return the most likely line that views with projections (3, 4) show as lines in their
    pictures.

    The plane through a pinhole and a line in its picture holds the line in space. ValueError where
    the planes are one: views from places that the line is in a plane with.
    """
    planes, noise = _build_viewing_planes(images, projections)
    # The line's direction is across all normals: the last right singular vector.
    _, values, axes = np.linalg.svd(planes[:, :3])
    if len(planes) < 2 or values[1] <= np.sqrt(np.finfo(np.float64).eps) * values[0]:
        raise ValueError("the views and the line are in one plane: it has no depth")
    # The origin is where the ray through the first line's middle comes nearest to the line.
    P = projections[0]
    ray = np.linalg.solve(P[:, :3], [*images[0].origin, 1.0])
    pinhole = -np.linalg.solve(P[:, :3], P[:, 3])
    foot = np.linalg.lstsq(
        np.vstack([planes[:, :3], axes[2]]), [*-(planes[:, :3] @ pinhole + planes[:, 3]), 0.0]
    )[0]
    across = np.stack([axes[2], -ray], axis=1)
    origin = pinhole + foot + np.linalg.lstsq(across, -foot)[0][0] * axes[2]
    planes, noise = _shifted(planes, noise, origin)
    return _fit_line(LINE_OF_PLANES, planes, noise, choose_best_chart(axes[2]), origin)


def filter_line_of_images(
    images: Sequence[ImageLine], projections: Sequence[FloatArray]
) -> Iterator[SpaceLine]:
    """Yield the line after each further view, each used once, linearised at the previous line.

    It starts from the first views that make the line's direction sure, and its place as a share of
    the distance.
    """
    pinhole = -np.linalg.solve(projections[0][:, :3], projections[0][:, 3])
    return run_from_fit(
        lambda n: fit_line_to_images(images[:n], projections[:n]),
        len(images),
        lambda line: _is_sure(line, float(np.linalg.norm(line.origin - pinhole))),
        lambda line, k: line.seen(images[k], projections[k])[0],
    )


def plane_of_lines(lines: Sequence[SpaceLine]) -> Plane:
    """Return the most likely plane of lines, at least two of them, with its covariance.

    ValueError where the lines are one.
    """
    origin = lines[0].origin
    x, noise = _draw_about(lines, origin)
    apart = x[:, 3:] - x[:, 3:].mean(axis=0)
    along = x[:, :3] / np.linalg.norm(x[:, :3], axis=1, keepdims=True)
    apart -= np.einsum("nk,nk->n", apart, along)[:, None] * along
    _, values, axes = np.linalg.svd(np.concatenate([along, apart / (np.abs(apart).max() or 1.0)]))
    if len(lines) < 2 or values[1] <= np.sqrt(np.finfo(np.float64).eps) * values[0]:
        raise ValueError("the lines are one: they have no plane")
    chart = choose_best_chart(axes[2])
    x, noise = _in_order(x, noise, chart)
    mean, cov, _ = fit_most_likely(
        PLANE_OF_LINES, x[None], noise[None], solved(PLANE_OF_LINES, x)[None]
    )
    return _move_to_world_frame(convert_chart_to_plane(chart, State(mean[0], cov[0])), origin)


def filter_plane_of_lines(lines: Sequence[SpaceLine]) -> Iterator[Plane]:
    """Yield the plane after each further line, from the first ones that make it sure."""
    origin = lines[0].origin

    def update(plane: Plane, k: int) -> Plane:
        here = _move_to_world_frame(plane, -origin)
        chart = choose_best_chart(here.normal)
        (x,), (noise,) = _in_order(*_draw_about([lines[k]], origin), chart)
        state, _ = update_one(PLANE_OF_LINES, convert_plane_to_chart(chart, here), x, noise)
        return _move_to_world_frame(convert_chart_to_plane(chart, state), origin)

    return run_from_fit(
        lambda n: plane_of_lines(lines[:n]),
        len(lines),
        lambda plane: bool(np.linalg.eigvalsh(plane.cov[:3, :3])[2] <= SURE_SD**2),
        update,
    )


def _is_sure(line: SpaceLine, distance: float = np.inf) -> bool:
    sds = np.sqrt(np.diagonal(line.state.cov)) / [1.0, 1.0, distance, distance]
    return bool(sds.max() <= SURE_SD)


def _fit_line(
    on: Incidence, x: FloatArray, noise: FloatArray, chart: Chart, origin: FloatArray
) -> SpaceLine:
    x, noise = _in_order(x, noise, chart)
    mean, cov, _ = fit_most_likely(on, x[None], noise[None], solved(on, x)[None])
    return SpaceLine(chart, State(mean[0], cov[0]), origin).to_best_chart()


def _in_order(x: FloatArray, noise: FloatArray, chart: Chart) -> tuple[FloatArray, FloatArray]:
    # Points (3), planes (4) or directions and feet (6) with the chart's axes in the order a, b, 1.
    axes = list(chart.axes)
    order = axes + [3 + k for k in axes if x.shape[-1] == 6] + [3] * (x.shape[-1] == 4)
    return x[..., order], noise[..., order, :][..., :, order]


def _build_viewing_planes(
    images: Sequence[ImageLine], projections: Sequence[FloatArray]
) -> tuple[FloatArray, FloatArray]:
    # The planes (n, 4) through pinhole and line in the picture, and covariances (n, 4, 4).
    planes, noise = [], []
    for image, P in zip(images, projections, strict=True):
        line, cov = image.homogeneous
        plane = P.T @ line
        size = float(np.linalg.norm(plane[:3]))
        planes.append(plane / size)
        noise.append(P.T @ cov @ P / size**2)
    return np.array(planes).reshape(-1, 4), np.array(noise).reshape(-1, 4, 4)


def _shifted(
    planes: FloatArray, noise: FloatArray, origin: FloatArray
) -> tuple[FloatArray, FloatArray]:
    # In coordinates from the origin: d' = d + n · origin.
    J = np.eye(4)
    J[3, :3] = origin
    return planes @ J.T, J @ noise @ J.T


def _draw_about(lines: Sequence[SpaceLine], origin: FloatArray) -> tuple[FloatArray, FloatArray]:
    drawn = [line.direction_and_foot for line in lines]
    x = np.array([d for d, _ in drawn])
    x[:, 3:] += np.array([line.origin for line in lines]) - origin
    return x, np.array([cov for _, cov in drawn])


def _move_to_world_frame(plane: Plane, origin: FloatArray) -> Plane:
    # The plane known from `origin` in the coordinates that the origin is given in.
    J = np.eye(4)
    J[3, :3] = -origin
    return Plane(plane.normal, plane.offset - float(plane.normal @ origin), J @ plane.cov @ J.T)
