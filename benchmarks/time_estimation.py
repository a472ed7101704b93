"""Prints the time to filter points: filterpy's class in a loop, one by one, and all at once.

CPU time of this process, one thread (set OMP_NUM_THREADS=1): median and quartiles of the repeats.

    python benchmarks/time_estimation.py [--points N] [--views V] [--repeats R] [--json]
"""

import argparse
import json
import platform
import time
from collections.abc import Callable

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter

from facetlog.perception.point_filter import estimate_point, estimate_points, ray_measurement
from facetlog.perception.types import FloatArray, Observation

SEED = 20260101
PIXEL_SD = 0.5
K = np.array([[600.0, 0.0, 320.0], [0.0, 600.0, 240.0], [0.0, 0.0, 1.0]])


def scene(points: int, views: int, wrong: float) -> tuple[FloatArray, FloatArray]:
    """Projections (V, 3, 4) and pixels (n, V, 2), some of them wrong matches."""
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


def by_filterpy(P: FloatArray, uv: FloatArray) -> None:
    """The paper's plain recursion by filterpy's class: no gate, no start, one pass."""
    noise = PIXEL_SD**2 * np.eye(2)
    for pixels in uv:
        ekf = ExtendedKalmanFilter(dim_x=3, dim_z=2)
        ekf.x, ekf.P = np.zeros(3), 1e4 * np.eye(3)
        for v, pixel in enumerate(pixels):
            lin = ray_measurement(pixel, P[v], noise)(ekf.x)
            ekf.update(
                lin.y, lambda _, m: m, lambda x, m: m @ x, R=lin.W, args=lin.M, hx_args=lin.M
            )


def one_by_one(P: FloatArray, uv: FloatArray) -> None:
    """`estimate_point` in a loop."""
    noise = PIXEL_SD**2 * np.eye(2)
    projections = list(P)
    for pixels in uv:
        estimate_point([Observation(v, p, noise) for v, p in enumerate(pixels)], projections)


def at_once(P: FloatArray, uv: FloatArray) -> None:
    """`estimate_points`."""
    cov = np.broadcast_to(PIXEL_SD**2 * np.eye(2), (*uv.shape, 2))
    estimate_points(uv, cov, np.ones(uv.shape[:2], dtype=np.bool_), P)


def _time(
    work: Callable[[FloatArray, FloatArray], None], P: FloatArray, uv: FloatArray, repeats: int
) -> list[float]:
    work(P, uv)
    times = []
    for _ in range(repeats):
        start = time.process_time()
        work(P, uv)
        times.append(1e3 * (time.process_time() - start))
    return [round(float(q), 2) for q in np.percentile(times, [50, 25, 75])]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0] if __doc__ else None)
    parser.add_argument("--points", type=int, default=200)
    parser.add_argument("--views", type=int, default=40)
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--json", action="store_true", help="machine-readable")
    args = parser.parse_args()
    rows = []
    for wrong in (0.0, 0.1):
        P, uv = scene(args.points, args.views, wrong)
        timed = {
            name: _time(work, P, uv, max(1, args.repeats // (3 if work is not at_once else 1)))
            for name, work in (
                ("filterpy, plain recursion", by_filterpy),
                ("estimate_point in a loop", one_by_one),
                ("estimate_points", at_once),
            )
        }
        base = timed["filterpy, plain recursion"][0]
        rows += [
            {
                "wrong matches": wrong,
                "what": name,
                "median_ms": t[0],
                "quartiles_ms": t[1:],
                "times filterpy": round(base / t[0], 1),
            }
            for name, t in timed.items()
        ]
    if args.json:
        machine = f"{platform.machine()}, Python {platform.python_version()}"
        head = {"schema": "facetlog-benchmark/1", "seed": SEED, "machine": machine}
        print(json.dumps({**head, "points": args.points, "views": args.views, "rows": rows}))
        return
    print(f"{args.points} points, {args.views} views, CPU")
    for row in rows:
        print(
            f"{row['wrong matches']:4.0%} wrong  {row['what']:27} {row['median_ms']:9.2f} ms  "
            f"quartiles {row['quartiles_ms']}  {row['times filterpy']:6.1f} x"
        )


if __name__ == "__main__":
    main()
