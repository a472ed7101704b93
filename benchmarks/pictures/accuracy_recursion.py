"""How good are points after each view, when every view is taken once?

Ten thousand points in a hundred worlds of 24 cameras, 2 to 6 away all round or on an arc of 60
degrees, half a pixel of noise, views in random order. The recursion stands beside the fit of all
views so far; a point has diverged when it is farther than 6 of its own standard deviations from the
truth (chi-square of 3 degrees: one in 10 million). Twenty orders of the same views show how much of
the last estimate the order makes.
"""

from collections.abc import Iterator
from time import process_time

import numpy as np

from benchmarks.common import Cell, Report, Settings, Table, median_and_spread
from facetlog.perception.estimation.point_filter import estimate_points
from facetlog.perception.estimation.point_recursion import PointFilters
from facetlog.perception.types import FloatArray

__all__ = ["NAME", "measure"]

NAME = "accuracy_recursion"
WORLDS, POINTS, VIEWS = 100, 100, 24
ORDERS = 20
PIXEL_SD, FOCAL = 0.5, 600.0
SHOWN = (2, 3, 4, 6, 8, 12, 16, 24)
DIVERGED_SD = 6.0
ARCS = {"all round": 2 * np.pi, "arc of 60 degrees": np.pi / 3}
MANY, LONG = 10_000, 200


def rig(rng: np.random.Generator, arc: float, views: int) -> FloatArray:
    """Projections (views, 3, 4) of cameras that look at the origin."""
    projections = []
    for _ in range(views):
        turn = rng.uniform(-arc / 2, arc / 2)
        z = -np.array([np.cos(turn), np.sin(turn), rng.uniform(0.1, 1.0)])
        z /= np.linalg.norm(z)
        x = np.cross(z, [0.0, 0.0, 1.0])
        x /= np.linalg.norm(x)
        R = np.array([x, np.cross(z, x), z])
        K = np.array([[FOCAL, 0.0, 320.0], [0.0, FOCAL, 240.0], [0.0, 0.0, 1.0]])
        projections.append(K @ np.column_stack([R, [0.0, 0.0, rng.uniform(2.0, 6.0)]]))
    return np.array(projections)


def pictured(
    rng: np.random.Generator, count: int, P: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Points (n, 3) of a cube of .6, their pixels (n, V, 2) with noise, covariances."""
    points = rng.uniform(-0.3, 0.3, (count, 3))
    h = np.einsum("vij,nj->nvi", P[:, :, :3], points) + P[:, :, 3]
    uv = h[..., :2] / h[..., 2:]
    cov = np.broadcast_to(PIXEL_SD**2 * np.eye(2), (*uv.shape, 2))
    return points, uv + PIXEL_SD * rng.normal(size=uv.shape), cov


def _errors(
    found: FloatArray, covs: FloatArray, points: FloatArray, known: FloatArray
) -> tuple[FloatArray, FloatArray]:
    # Squared distances from the truth, and the same in standard deviations, of known points.
    rows = np.flatnonzero(known)
    off = found[rows] - points[rows]
    nees = np.einsum("ni,nij,nj->n", off, np.linalg.inv(covs[rows]), off)
    return (off**2).sum(axis=1), nees


def _by_views(arc_name: str, seeds: range) -> Iterator[dict[str, Cell]]:
    ours: dict[int, list[FloatArray]] = {k: [] for k in SHOWN}
    nees: dict[int, list[FloatArray]] = {k: [] for k in SHOWN}
    batch: dict[int, list[FloatArray]] = {k: [] for k in SHOWN}
    known: dict[int, int] = dict.fromkeys(SHOWN, 0)
    for seed in seeds:
        rng = np.random.default_rng(seed)
        P = rig(rng, ARCS[arc_name], VIEWS)
        points, uv, cov = pictured(rng, POINTS, P)
        everywhere = np.ones(POINTS, np.bool_)
        filters = PointFilters(POINTS)
        for v in range(VIEWS):
            filters.add(P[v], uv[:, v], cov[:, v], everywhere)
            taken = v + 1
            if taken not in SHOWN:
                continue
            square, mahalanobis = _errors(filters.points, filters.covs, points, filters.known)
            ours[taken].append(square)
            nees[taken].append(mahalanobis)
            known[taken] += int(filters.known.sum())
            fit, covs, _, ok = estimate_points(
                uv[:, :taken], cov[:, :taken], np.ones((POINTS, taken)), P[:taken]
            )
            batch[taken].append(_errors(fit, covs, points, filters.known & ok)[0])
    for k in SHOWN:
        chi2 = np.concatenate(nees[k])
        rms = [float(np.sqrt(np.mean(np.concatenate(e[k])))) for e in (ours, batch)]
        yield {
            "cameras": arc_name,
            "views": k,
            "known, share": round(known[k] / (POINTS * len(seeds)), 4),
            "rms error": f"{rms[0]:.2e}",
            "÷ all at once": round(rms[0] / rms[1], 3),
            "NEES / 3": round(float(chi2.mean() / 3), 3),
            "diverged": int((chi2 > DIVERGED_SD**2).sum()),
        }


def _orders(arc_name: str, seeds: range) -> dict[str, Cell]:
    """How far twenty orders of the same views bring the last estimate from their mean, in sd."""
    spreads = []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        P = rig(rng, ARCS[arc_name], VIEWS)
        _, uv, cov = pictured(rng, POINTS, P)
        ends, covs = [], np.zeros((POINTS, 3, 3))
        for _ in range(ORDERS):
            filters = PointFilters(POINTS)
            for v in rng.permutation(VIEWS):
                filters.add(P[v], uv[:, v], cov[:, v], np.ones(POINTS, np.bool_))
            ends.append(filters.points)
            covs = filters.covs
        off = np.array(ends) - np.mean(ends, axis=0)
        square = np.einsum("oni,nij,onj->on", off, np.linalg.inv(covs), off) / 3
        spreads.append(np.sqrt(square.mean(axis=0)))
    spread = np.concatenate(spreads)
    return {
        "cameras": arc_name,
        "points": len(spread),
        "spread, sd (median)": f"{np.median(spread):.1e}",
        "spread, sd (99 %)": f"{np.quantile(spread, 0.99):.1e}",
        "beyond .1 sd, share": round(float((spread > 0.1).mean()), 4),
    }


def _times(seed: int) -> Iterator[dict[str, Cell]]:
    """Processor time of a view, early and late, of ten thousand points."""
    rng = np.random.default_rng(seed)
    P = rig(rng, 2 * np.pi, LONG)
    _, uv, cov = pictured(rng, MANY, P)
    filters, seconds = PointFilters(MANY), []
    for v in range(LONG):
        start = process_time()
        filters.add(P[v], uv[:, v], cov[:, v], np.ones(MANY, np.bool_))
        seconds.append(process_time() - start)
    for first, last in ((2, 10), (10, 30), (LONG - 20, LONG)):
        milliseconds = [1e3 * s for s in seconds[first:last]]
        figures = median_and_spread(milliseconds, digits=1)
        yield {"views": f"{first} to {last}", **{f"ms a view, {k}": v for k, v in figures.items()}}


def measure(settings: Settings) -> Report:
    """Errors against views beside the fit, NEES, divergences; the spread of orders; times."""
    worlds = settings.number(WORLDS)
    seeds = range(settings.first, settings.first + worlds)
    few = range(settings.first, settings.first + max(1, worlds // 10))
    rows = [row for name in ARCS for row in _by_views(name, seeds)]
    orders = [_orders(name, few) for name in ARCS]
    return Report(
        NAME,
        (
            Table("after so many views", tuple(rows)),
            Table("twenty orders of 24 views", tuple(orders)),
            Table("ten thousand points, one view", tuple(_times(settings.first))),
        ),
        {"worlds": worlds, "points a world": POINTS, "pixel sd": PIXEL_SD},
    )
