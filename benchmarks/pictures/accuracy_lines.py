"""How good are lines in pictures and in space, and planes of lines, one measurement at a time?

Random worlds, each construction by the recursion (every measurement taken once) and by maximum
likelihood of all at once. Errors are counted in standard deviations of the bound (Cramér-Rao: the
covariance of the fit to exact measurements), so that 1 is as good as can be; NEES / n is the error
in those of the covariance that is stated. Lines lie in all directions, those that are degenerate in
a chart among them.
"""

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from benchmarks.common import Cell, Report, Settings, Table
from facetlog.perception.estimation.ekf import State
from facetlog.perception.estimation.lines.image_line import (
    fit_image_line,
    image_line_recursion,
)
from facetlog.perception.estimation.lines.space_line import (
    SpaceLine,
    line_of_images,
    line_of_images_recursion,
    line_of_points,
    line_of_points_recursion,
    plane_of_lines,
    plane_of_lines_recursion,
)
from facetlog.perception.estimation.plane_filter import best_chart, chart_from_plane
from facetlog.perception.scene import Plane
from facetlog.perception.types import FloatArray

__all__ = ["NAME", "measure"]

NAME = "accuracy_lines"
WORLDS = 1000
PIXEL_SD = 0.5
FOCAL, CENTRE = 600.0, (320.0, 240.0)
VIEWS, PIXELS = 12, 20
POINTS, LINES = 8, 5


class Trial(NamedTuple):
    """One construction: what the recursion, the fit and the fit of exact measurements come to."""

    recursion: State
    fit: State
    exact: State


World: TypeAlias = Callable[[np.random.Generator], Trial]


def image_line(rng: np.random.Generator) -> Trial:
    """A line of 20 to 300 px from 20 pixels."""
    exact, covs = _pixels(rng, *_random_ends(rng))
    noisy = exact + PIXEL_SD * rng.normal(size=exact.shape)
    truth = fit_image_line(exact, covs)
    *_, last = image_line_recursion(noisy, covs)
    fit = fit_image_line(noisy, covs)
    states = (line.in_chart(truth.chart, truth.origin).state for line in (last, fit, truth))
    return Trial(*states)


def _random_ends(rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    turn, half = rng.uniform(0, 2 * np.pi), rng.uniform(10, 150)
    along = half * np.array([np.cos(turn), np.sin(turn)])
    return np.array(CENTRE) - along, np.array(CENTRE) + along


def _pixels(
    rng: np.random.Generator, start: FloatArray, end: FloatArray
) -> tuple[FloatArray, FloatArray]:
    share = rng.uniform(size=(PIXELS, 1))
    # The first two are the ends: an edge is traced from where it starts.
    share[:2] = [[0.0], [1.0]]
    return start + share * (end - start), np.tile(PIXEL_SD**2 * np.eye(2), (PIXELS, 1, 1))


def line_from_points(rng: np.random.Generator) -> Trial:
    """A line of length 1 from 8 points, each with a covariance of its own."""
    start, along = rng.normal(size=3), _direction(rng)
    share = rng.uniform(-0.5, 0.5, (POINTS, 1))
    share[:2] = [[-0.5], [0.5]]
    exact = start + share * along
    root = 0.01 * rng.normal(size=(POINTS, 3, 3))
    covs = root @ root.transpose(0, 2, 1) + 1e-5 * np.eye(3)
    noisy = exact + np.einsum("nij,nj->ni", np.linalg.cholesky(covs), rng.normal(size=(POINTS, 3)))
    *_, last = line_of_points_recursion(noisy, covs)
    return _of_space(last, line_of_points(noisy, covs), line_of_points(exact, covs))


def line_from_images(rng: np.random.Generator) -> Trial:
    """A line of .4 in 12 views from 3 away all round, 20 pixels of it in each."""
    start, along = rng.uniform(-0.2, 0.2, 3), _direction(rng)
    ends = start + 0.2 * np.array([[-1.0], [1.0]]) * along
    projections, exact, noisy = [], [], []
    while len(noisy) < VIEWS:
        P = _camera(rng)
        h = ends @ P[:, :3].T + P[:, 3]
        uv = h[:, :2] / h[:, 2:]
        if np.linalg.norm(uv[1] - uv[0]) < 15.0:
            continue  # seen end on: no line is found there
        pixels, covs = _pixels(rng, *uv)
        projections.append(P)
        exact.append(fit_image_line(pixels, covs))
        noisy.append(fit_image_line(pixels + PIXEL_SD * rng.normal(size=pixels.shape), covs))
    *_, last = line_of_images_recursion(noisy, projections)
    return _of_space(last, line_of_images(noisy, projections), line_of_images(exact, projections))


def plane_from_lines(rng: np.random.Generator) -> Trial:
    """A plane from 5 lines in it, each from 8 points."""
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    middle = rng.normal(size=3)
    noisy, exact = [], []
    for _ in range(LINES):
        ends = middle + rng.uniform(-1, 1, (2, 2)) @ axes[:2]
        points = ends[0] + np.linspace(0, 1, POINTS)[:, None] * (ends[1] - ends[0])
        covs = np.tile(0.01**2 * np.eye(3), (POINTS, 1, 1))
        exact.append(line_of_points(points, covs))
        noisy.append(line_of_points(points + 0.01 * rng.normal(size=points.shape), covs))
    *_, last = plane_of_lines_recursion(noisy)
    planes = (last, plane_of_lines(noisy), plane_of_lines(exact))
    chart = best_chart(axes[2])
    return Trial(*(chart_from_plane(chart, _about(plane, middle)) for plane in planes))


def _about(plane: Plane, origin: FloatArray) -> Plane:
    J = np.eye(4)
    J[3, :3] = origin
    return Plane(plane.normal, plane.offset + float(plane.normal @ origin), J @ plane.cov @ J.T)


def _of_space(last: SpaceLine, fit: SpaceLine, exact: SpaceLine) -> Trial:
    return Trial(*(line.in_chart(exact.chart, exact.origin).state for line in (last, fit, exact)))


def _direction(rng: np.random.Generator) -> FloatArray:
    # One in four lies along an axis or across one: degenerate in one chart or in two.
    along = rng.normal(size=3)
    if rng.random() < 0.25:
        along[rng.permutation(3)[: rng.integers(1, 3)]] = 0.0
    direction: FloatArray = along / np.linalg.norm(along)
    return direction


def _camera(rng: np.random.Generator) -> FloatArray:
    away = rng.normal(size=3)
    z = -away / np.linalg.norm(away)
    x = np.cross(z, rng.normal(size=3))
    x /= np.linalg.norm(x)
    R = np.array([x, np.cross(z, x), z])
    K = np.array([[FOCAL, 0.0, CENTRE[0]], [0.0, FOCAL, CENTRE[1]], [0.0, 0.0, 1.0]])
    P: FloatArray = K @ np.column_stack([R, 3.0 * R @ z])
    return P


CONSTRUCTIONS: dict[str, World] = {
    "line in a picture, of 20 pixels": image_line,
    "line in space, of 8 points": line_from_points,
    "line in space, of 12 views": line_from_images,
    "plane, of 5 lines": plane_from_lines,
}


def _row(name: str, world: World, seeds: range) -> dict[str, Cell]:
    errors: dict[str, list[float]] = {key: [] for key in ("recursion", "fit")}
    nees: dict[str, list[float]] = {key: [] for key in ("recursion", "fit")}
    apart = []
    for seed in seeds:
        trial = world(np.random.default_rng(seed))
        n = trial.exact.mean.size
        for key, state in (("recursion", trial.recursion), ("fit", trial.fit)):
            error = state.mean - trial.exact.mean
            errors[key].append(float(error @ np.linalg.solve(trial.exact.cov, error)) / n)
            nees[key].append(float(error @ np.linalg.solve(state.cov, error)) / n)
        off = trial.recursion.mean - trial.fit.mean
        apart.append(float(off @ np.linalg.solve(trial.fit.cov, off)) / n)
    rms = {key: float(np.sqrt(np.mean(values))) for key, values in errors.items()}
    return {
        "construction": name,
        "worlds": len(seeds),
        "recursion / bound": round(rms["recursion"], 3),
        "all at once / bound": round(rms["fit"], 3),
        "recursion / all at once": round(rms["recursion"] / rms["fit"], 3),
        "NEES / n of the recursion": round(float(np.mean(nees["recursion"])), 3),
        "NEES / n of all at once": round(float(np.mean(nees["fit"])), 3),
        "apart, sd (rms)": round(float(np.sqrt(np.mean(apart))), 3),
        "apart, sd (worst)": round(float(np.sqrt(np.max(apart))), 3),
    }


def measure(settings: Settings) -> Report:
    """Errors over the bound and NEES, of the recursion and of the fit, by construction."""
    seeds = range(settings.first, settings.first + settings.number(WORLDS))
    rows = tuple(_row(name, world, seeds) for name, world in CONSTRUCTIONS.items())
    return Report(
        NAME,
        (Table("the recursion beside maximum likelihood of all at once", rows),),
        {"worlds": len(seeds), "pixel sd": PIXEL_SD},
    )
