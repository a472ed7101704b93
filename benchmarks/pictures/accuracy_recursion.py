"""How good are points after each view, when every view is taken once?

Ten thousand points in a hundred worlds of 24 cameras, 2 to 6 away all round or on an arc of 60
degrees, half a pixel of noise, views in random order. The recursion stands beside the fit of all
views so far; a point has diverged when it is farther than 6 of its own standard deviations from the
truth (chi-square of 3 degrees: one in 10 million).
"""

from collections.abc import Iterator

import numpy as np

from benchmarks.common import Cell, Report, Settings, Table
from facetlog.perception.estimation.point_filter import estimate_points
from facetlog.perception.estimation.point_recursion import PointFilters
from facetlog.perception.types import FloatArray

NAME = "accuracy_recursion"
WORLDS, POINTS, VIEWS = 100, 100, 24
PIXEL_SD, FOCAL = 0.5, 600.0
SHOWN = (2, 3, 4, 6, 8, 12, 16, 24)
DIVERGED_SD = 6.0
ARCS = {"all round": 2 * np.pi, "arc of 60 degrees": np.pi / 3}


def rig(rng: np.random.Generator, arc: float, views: int) -> FloatArray:
    """Return projections (views, 3, 4) of cameras that look at the origin."""
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
    """Return points (n, 3) of a cube of .6, their pixels (n, V, 2) with noise, covariances."""
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


def measure(settings: Settings) -> Report:
    """Compare errors with the fit after each number of views."""
    seeds = settings.seeds(WORLDS)
    rows = tuple(row for name in ARCS for row in _by_views(name, seeds))
    return Report(
        NAME,
        (Table("after so many views", rows),),
        {"worlds": len(seeds), "points a world": POINTS, "pixel sd": PIXEL_SD},
    )
