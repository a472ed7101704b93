"""How near the bound do points come, how honest are their covariances, and when are they lost?

Synthetic, fixed seeds: cameras on an arc round points near its middle, 0.5 px noise, many points at
once, also with large shares of wrong matches. RMSE/CRB: root mean square error over the Cramér-Rao
bound, of the points not lost. NEES/n: 1 is an honest covariance. Lost: more than 6 sd off.
"""

import numpy as np

from benchmarks.common import Report, Row, Settings, Table
from facetlog.perception.estimation.point_filter import estimate_points
from facetlog.perception.types import FloatArray

NAME = "accuracy_estimation"
SEEDS, POINTS_A_SEED = 20, 520
PIXEL_SD = 0.5
SEED = 20260101
LOST_SD = 6.0
K = np.array([[600.0, 0.0, 320.0], [0.0, 600.0, 240.0], [0.0, 0.0, 1.0]])


def ring(views: int, arc: float) -> FloatArray:
    """Return the projections (V, 3, 4) of cameras on a level arc, 3 away from the origin."""
    projections = []
    for k in range(views):
        turn = arc * k / views
        c = np.array([3 * np.cos(turn), 3 * np.sin(turn), 1.5])
        z = -c / np.linalg.norm(c)
        x = np.cross(z, [0.0, 0.0, 1.0])
        x /= np.linalg.norm(x)
        R = np.array([x, np.cross(z, x), z])
        projections.append(K @ np.column_stack([R, -R @ c]))
    return np.array(projections)


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


def measure_many_points(points: int) -> list[Row]:
    """Return one row a scene: `estimate_points` for many points at once."""
    rows: list[Row] = []
    for arc, views, wrong in MANY_SCENES:
        rng = np.random.default_rng(SEED)
        P = ring(views, np.radians(arc))
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


def measure(settings: Settings) -> Report:
    """Measure 520 points of each scene for each seed."""
    points = POINTS_A_SEED * settings.number(SEEDS)
    return Report(
        NAME,
        (Table("Many points at once", tuple(measure_many_points(points))),),
        {"points": points, "noise px": PIXEL_SD, "seed": SEED},
    )
