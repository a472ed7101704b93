"""How long does it take to filter points: by filterpy's class in a loop, and all at once?

CPU time of this process; OMP_NUM_THREADS=1 keeps it to one thread.
"""

import time
from collections.abc import Callable

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter

from benchmarks.common import Report, Row, Settings, Table, compute_median_and_spread
from facetlog.perception.estimation.point_filter import (
    estimate_points,
    ray_measurement,
)
from facetlog.perception.types import FloatArray

NAME = "time_estimation"
POINTS, VIEWS = 10_000, 24
LOOP_POINTS = 200  # as many of them for the slow loops
REPEATS = 9  # of the work at once; of the slow loops a third
WRONG_SHARES = (0.0, 0.1)
SEED = 20260101
PIXEL_SD = 0.5
K = np.array([[600.0, 0.0, 320.0], [0.0, 600.0, 240.0], [0.0, 0.0, 1.0]])


def scene(points: int, views: int, wrong: float) -> tuple[FloatArray, FloatArray]:
    """Return projections (V, 3, 4) and pixels (n, V, 2), some of them wrong matches."""
    rng = np.random.default_rng(SEED)
    projections = []
    for turn in np.linspace(0.0, 2 * np.pi, views, endpoint=False):
        c = np.array([3 * np.cos(turn), 3 * np.sin(turn), 1.5])
        z = -c / np.linalg.norm(c)
        x = np.cross(z, [0.0, 0.0, 1.0])
        x /= np.linalg.norm(x)
        R = np.array([x, np.cross(z, x), z])
        projections.append(K @ np.column_stack([R, -R @ c]))
    P = np.array(projections)
    X = rng.uniform(-0.3, 0.3, (points, 3))
    h = np.einsum("vij,nj->nvi", P[:, :, :3], X) + P[:, :, 3]
    uv = h[..., :2] / h[..., 2:] + PIXEL_SD * rng.normal(size=(points, views, 2))
    bad = rng.random((points, views)) < wrong
    uv[bad] = rng.uniform([100, 50], [540, 430], (int(bad.sum()), 2))
    return P, uv


def filter_by_filterpy(P: FloatArray, uv: FloatArray) -> None:
    """Run the paper's plain recursion by filterpy's class: no gate, no start, one pass."""
    noise = PIXEL_SD**2 * np.eye(2)
    for pixels in uv:
        ekf = ExtendedKalmanFilter(dim_x=3, dim_z=2)
        ekf.x, ekf.P = np.zeros(3), 1e4 * np.eye(3)
        for v, pixel in enumerate(pixels):
            lin = ray_measurement(pixel, P[v], noise)(ekf.x)
            ekf.update(
                lin.y, lambda _, m: m, lambda x, m: m @ x, R=lin.W, args=lin.M, hx_args=lin.M
            )


def at_once(P: FloatArray, uv: FloatArray) -> None:
    """Run `estimate_points`."""
    cov = np.broadcast_to(PIXEL_SD**2 * np.eye(2), (*uv.shape, 2))
    estimate_points(uv, cov, np.ones(uv.shape[:2], dtype=np.bool_), P)


WORK: dict[str, Callable[[FloatArray, FloatArray], None]] = {
    "filterpy, plain recursion": filter_by_filterpy,
    "estimate_points": at_once,
}


def _times(
    work: Callable[[FloatArray, FloatArray], None], P: FloatArray, uv: FloatArray, repeats: int
) -> list[float]:
    """Return CPU microseconds a point of each repeat; one more goes before them, uncounted."""
    work(P, uv)
    times = []
    for _ in range(repeats):
        start = time.process_time()
        work(P, uv)
        times.append(1e6 * (time.process_time() - start) / len(uv))
    return times


def measure(settings: Settings) -> Report:
    """Measure all ways of work; the number of repeats is that of seeds asked for."""
    repeats = settings.number(REPEATS)
    rows: list[Row] = []
    for wrong in WRONG_SHARES:
        P, uv = scene(POINTS, VIEWS, wrong)
        base = None
        for name, work in WORK.items():
            many = work is at_once
            points = uv if many else uv[:LOOP_POINTS]
            times = _times(work, P, points, repeats if many else max(1, repeats // 3))
            middle = float(np.median(times))
            base = middle if base is None else base
            rows.append(
                {
                    "wrong matches": f"{wrong:.0%}",
                    "what": name,
                    "points": len(points),
                    **{f"µs {k}": v for k, v in compute_median_and_spread(times, digits=2).items()},
                    "times filterpy": round(base / middle, 1),
                }
            )
    counts = {"views": VIEWS, "repeats": repeats, "seed": SEED}
    return Report(NAME, (Table("CPU time a point", tuple(rows)),), counts)
