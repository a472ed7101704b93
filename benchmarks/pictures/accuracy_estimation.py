"""How near the bound do points and planes come, how honest are their covariances, and when are
they lost?

Plain recursion, robust estimator and batch likelihood, also at large shares of wrong matches.
Synthetic, fixed seeds: cameras on a ring or an arc round points near its middle, 0.5 px noise.
RMSE/CRB: root mean square error over the Cramér-Rao bound, of the points not lost. NEES/n: 1 is an
honest covariance (over the points not lost). Lost: more than 6 sd (by the bound) off, or no result.
Order: largest and median change, in sd, when the views are shuffled.
"""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.optimize import least_squares

from benchmarks.common import Cell, Report, Row, Settings, Table
from facetlog.perception.estimation.ekf import State
from facetlog.perception.estimation.plane_filter import (
    Chart,
    chart_from_plane,
    fit_plane,
    plain_plane_recursion,
    plane_from_chart,
)
from facetlog.perception.estimation.point_filter import (
    estimate_point,
    estimate_points,
    plain_recursion,
)
from facetlog.perception.scene import Plane
from facetlog.perception.types import FloatArray, Observation

__all__ = ["NAME", "measure"]

NAME = "accuracy_estimation"
POINTS, POINTS_A_SEED = 200, 10  # of each scene; of each seed asked for
PLANES_A_POINT = 5
MANY_A_POINT = 52  # points at once, for what is rare
PIXEL_SD = 0.5
SEED = 20260101
LOST_SD = 6.0
K = np.array([[600.0, 0.0, 320.0], [0.0, 600.0, 240.0], [0.0, 0.0, 1.0]])
Estimator = Callable[[Sequence[Observation], FloatArray], tuple[FloatArray, FloatArray] | None]


def ring(
    views: int, arc: float, origin: Sequence[float] = (0.0, 0.0, 0.0), wave: float = 0.2
) -> FloatArray:
    """Projections (V, 3, 4) of cameras on an arc, 3 from the points, which lie at `origin`.

    The cameras go up and down by `wave`.
    """
    projections = []
    for k in range(views):
        turn = arc * k / views
        c = np.array([3 * np.cos(turn), 3 * np.sin(turn), 1.5 + wave * np.sin(3 * k)])
        z = -c / np.linalg.norm(c)
        x = np.cross(z, [0.0, 0.0, 1.0])
        x /= np.linalg.norm(x)
        R = np.array([x, np.cross(z, x), z])
        projections.append(K @ np.column_stack([R, -R @ (c + origin)]))
    return np.array(projections)


def project(projections: FloatArray, point: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Pixels (V, 2) of a point and their derivatives (V, 2, 3)."""
    h = projections[:, :, :3] @ point + projections[:, :, 3]
    uv = h[:, :2] / h[:, 2:]
    p12, p3 = projections[:, :2, :3], projections[:, 2:, :3]
    return uv, (p12 - uv[:, :, None] * p3) / h[:, 2, None, None]


def plain(seen: Sequence[Observation], projections: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The paper's recursion from the null vector."""
    *_, last = plain_recursion(seen, list(projections), State(np.zeros(3), 1e6 * np.eye(3)))
    return last.mean, last.cov


def robust(
    seen: Sequence[Observation], projections: FloatArray
) -> tuple[FloatArray, FloatArray] | None:
    """The estimator of the project."""
    found = estimate_point(seen, list(projections))
    return (found.point, found.cov) if found else None


def batch(seen: Sequence[Observation], projections: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Maximum likelihood by scipy from the direct linear solution; no gate."""
    P = projections[[o.view for o in seen]]
    uv = np.array([o.uv for o in seen])
    rows = (P[:, :2] - uv[:, :, None] * P[:, 2:]).reshape(-1, 4)
    start = np.linalg.svd(rows / np.linalg.norm(rows, axis=1, keepdims=True))[2][-1]

    def residual(a: FloatArray) -> FloatArray:
        return np.asarray((project(P, a)[0] - uv).ravel() / PIXEL_SD)

    def jacobian(a: FloatArray) -> FloatArray:
        return np.asarray(project(P, a)[1].reshape(-1, 3) / PIXEL_SD)

    found = np.asarray(least_squares(residual, start[:3] / start[3], jac=jacobian).x)
    J = jacobian(found)
    cov = np.asarray(np.linalg.inv(J.T @ J), dtype=np.float64)
    return found, cov


ESTIMATORS: dict[str, Estimator] = {"plain": plain, "robust": robust, "batch ML": batch}
# name, views, arc in degrees, where the points lie, share of wrong matches
SCENES = (
    ("24 views round, origin in the object", 24, 360.0, (0.0, 0.0, 0.0), 0.0),
    ("the same, origin before the first camera", 24, 360.0, (-2.7, 0.0, -1.3), 0.0),
    ("the same, origin far outside", 24, 360.0, (40.0, -25.0, 3.0), 0.0),
    ("24 views, arc of 12 degrees", 24, 12.0, (0.0, 0.0, 0.0), 0.0),
    ("4 views, arc of 20 degrees", 4, 20.0, (0.0, 0.0, 0.0), 0.0),
    ("24 views round, 10 % wrong matches", 24, 360.0, (0.0, 0.0, 0.0), 0.1),
    ("24 views round, 40 % wrong matches", 24, 360.0, (0.0, 0.0, 0.0), 0.4),
)


def _sd(error: FloatArray, cov: FloatArray) -> float:
    return float(np.sqrt(max(float(error @ np.linalg.solve(cov, error)), 0.0)))


def point_rows(points: int) -> list[Row]:
    """One row a scene and estimator."""
    rows: list[Row] = []
    for scene, views, arc, origin, wrong in SCENES:
        rng = np.random.default_rng(SEED)
        projections = ring(views, np.radians(arc), origin)
        results: dict[str, list[tuple[float, float, float, float]]] = {k: [] for k in ESTIMATORS}
        for _ in range(points):
            truth = np.asarray(origin) + rng.uniform(-0.3, 0.3, 3)
            uv, J = project(projections, truth)
            uv = uv + PIXEL_SD * rng.normal(size=uv.shape)
            bad = rng.random(views) < wrong
            uv[bad] = rng.uniform([100, 50], [540, 430], (int(bad.sum()), 2))
            # The bound is that of the right matches.
            bound = np.linalg.inv(np.einsum("vai,vaj->ij", J[~bad], J[~bad]) / PIXEL_SD**2)
            seen = [Observation(v, uv[v], PIXEL_SD**2 * np.eye(2)) for v in range(views)]
            shuffled = [seen[i] for i in rng.permutation(views)]
            for name, estimator in ESTIMATORS.items():
                found, other = estimator(seen, projections), estimator(shuffled, projections)
                if found is None or other is None or not np.isfinite(found[0]).all():
                    results[name].append((np.inf, 1.0, np.nan, np.nan))
                    continue
                error = found[0] - truth
                results[name].append(
                    (
                        _sd(error, bound),
                        float(error @ error / np.trace(bound)),
                        _sd(error, found[1]) ** 2 / 3,
                        _sd(found[0] - other[0], bound),
                    )
                )
        for name, values in results.items():
            table = np.array(values)
            kept = table[table[:, 0] <= LOST_SD]
            enough = len(kept) > 0
            rows.append(
                {
                    "scene": scene,
                    "estimator": name,
                    "lost %": round(100 * (1 - len(kept) / points), 1),
                    "RMSE/CRB": round(float(np.sqrt(kept[:, 1].mean())), 3) if enough else None,
                    "NEES/n": round(float(kept[:, 2].mean()), 2) if enough else None,
                    "order median": round(float(np.median(kept[:, 3])), 4) if enough else None,
                    "order worst": round(float(kept[:, 3].max()), 4) if enough else None,
                }
            )
    return rows


# arc in degrees, views, share of wrong matches; arcs are level: no other parallax than theirs
MANY_SCENES = (
    (360.0, 24, 0.0),
    (360.0, 24, 0.1),
    (360.0, 24, 0.4),
    (30.0, 24, 0.4),
    (10.0, 24, 0.4),
    (3.0, 24, 0.4),
    (3.0, 24, 0.0),
    (12.0, 8, 0.4),
)


def many_rows(points: int) -> list[Row]:
    """One row a scene: `estimate_points` for many points at once."""
    rows: list[Row] = []
    for arc, views, wrong in MANY_SCENES:
        rng = np.random.default_rng(SEED)
        P = ring(views, np.radians(arc), wave=0.0)
        truth = rng.uniform(-0.3, 0.3, (points, 3))
        h = np.einsum("vij,nj->nvi", P[:, :, :3], truth) + P[:, :, 3]
        exact, depth = h[..., :2] / h[..., 2:], h[..., 2]
        uv = exact + PIXEL_SD * rng.normal(size=exact.shape)
        bad = rng.random(depth.shape) < wrong
        uv[bad] = rng.uniform([100, 50], [540, 430], (int(bad.sum()), 2))
        J = (P[:, :2, :3] - exact[..., None] * P[:, None, 2, :3]) / depth[..., None, None]
        right = J * ~bad[..., None, None]
        information = np.einsum("nvai,nvaj->nij", right, right) / PIXEL_SD**2
        bounded = (~bad).sum(axis=1) >= 2
        information[~bounded] = np.eye(3)
        cov = np.broadcast_to(PIXEL_SD**2 * np.eye(2), (*uv.shape, 2))
        found, covs, used, ok = estimate_points(uv, cov, np.ones(bad.shape, np.bool_), P)
        error = np.where(ok[:, None], found - truth, 0.0)
        square = np.einsum("ni,nij,nj->n", error, information, error)
        nees = np.einsum("ni,nij,nj->n", error[ok], np.linalg.inv(covs[ok]), error[ok])
        bound = np.trace(np.linalg.inv(information), axis1=1, axis2=2)
        kept = ok & bounded & (square <= LOST_SD**2)
        rows.append(
            {
                "arc, degrees": arc,
                "views": views,
                "wrong matches": f"{wrong:.0%}",
                "refused %": round(100 * float((~ok).mean()), 2),
                "less than three right %": round(100 * float(((~bad).sum(axis=1) < 3).mean()), 2),
                "over 6 sd off": int((ok & (square > LOST_SD**2)).sum()),
                "over 6 of its own sd off": int((nees > LOST_SD**2).sum()),
                "RMSE/CRB": round(
                    float(np.sqrt(((error**2).sum(axis=1)[kept] / bound[kept]).mean())), 3
                ),
                "NEES/n": round(float(nees.mean()) / 3, 3),
                "wrong used": int((used & bad).sum()),
            }
        )
    return rows


def plane_rows(planes: int) -> list[Row]:
    """Angle error of the normal over the bound, and NEES, for the plain and the robust filter."""
    sd, count = 0.02, 8
    rng = np.random.default_rng(SEED)
    values: dict[str, list[tuple[float, float]]] = {"plain, chart Z": [], "robust": []}
    for _ in range(planes):
        normal = rng.normal(size=3)
        normal /= np.linalg.norm(normal)
        basis = np.linalg.svd(normal[None])[2][1:]
        middle = rng.uniform(-3, 3, 3)
        flat = rng.uniform(-1, 1, (count, 2))
        points = flat @ basis + middle + sd * rng.normal(size=(count, 3))
        noise = sd**2 * np.eye(3)
        spread = flat - flat.mean(axis=0)
        bound = np.trace(np.linalg.inv(spread.T @ spread / sd**2))
        *_, last = plain_plane_recursion(list(points), noise, State(np.zeros(3), 1e6 * np.eye(3)))
        fit = fit_plane(points, np.tile(noise, (count, 1, 1)))
        candidates = [("plain, chart Z", plane_from_chart(Chart.Z, last), Chart.Z)]
        if fit:
            candidates.append(("robust", fit.plane, fit.chart))
        centre = points.mean(axis=0)
        for name, plane, chart in candidates:
            angle = np.linalg.norm(np.cross(plane.normal, normal))
            J = np.eye(4)
            J[3, :3] = centre
            here = Plane(plane.normal, plane.offset + plane.normal @ centre, J @ plane.cov @ J.T)
            true = Plane(normal, float(normal @ (centre - middle)), np.zeros((4, 4)))
            found, wanted = chart_from_plane(chart, here), chart_from_plane(chart, true)
            nees = _sd(found.mean - wanted.mean, found.cov) ** 2 / 3
            values[name].append((float(angle**2 / bound), nees))
    rows: list[Row] = []
    for name, pairs in values.items():
        table = np.array(pairs)
        rows.append(
            {
                "estimator": name,
                "fitted %": round(100 * len(table) / planes, 1),
                "angle RMSE/CRB": round(float(np.sqrt(table[:, 0].mean())), 3),
                "NEES/n": round(float(table[:, 1].mean()), 2),
            }
        )
    return rows


def measure(settings: Settings) -> Report:
    """Points and planes; 10 points of each scene for each seed asked for."""
    points = POINTS_A_SEED * settings.number(POINTS // POINTS_A_SEED)
    planes = PLANES_A_POINT * points
    counts: dict[str, Cell] = {
        "points a scene": points,
        "at once": MANY_A_POINT * points,
        "planes": planes,
        "noise px": PIXEL_SD,
    }
    return Report(
        NAME,
        (
            Table("Points", tuple(point_rows(points))),
            Table("Many points at once", tuple(many_rows(MANY_A_POINT * points))),
            Table("Planes through 8 points, in any direction", tuple(plane_rows(planes))),
        ),
        {**counts, "seed": SEED},
        ("Lost: more than 6 sd of the bound off, or no result; the rest makes the other figures.",),
    )
