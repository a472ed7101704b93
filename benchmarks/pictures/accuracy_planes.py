"""How many of fifty planes in one cloud of 200,000 points are found, how well, and how fast?

Rectangles of 1 to 3 units at random in a cube of 10, with Gaussian noise. A plane is found if one
of the regions has more than half of its points, and more than half of that region's are its own.
The oracle is least squares on the true points of each plane. The peers, Open3D's
`detect_planar_patches` and CGAL's region growing (which is told the true noise),
are measured where they are installed. Seconds are processor time, so that other programs' load
does not count.
"""

from collections.abc import Callable, Iterator, Sequence
from importlib import import_module
from time import process_time
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.common import Cell, Report, Settings, Table, compute_median_and_spread
from facetlog.perception.shapes.clouds.cloud_planes import cloud_planes, fit_least_squares_plane

NAME = "accuracy_planes"
SEEDS = 3
PLANES, POINTS = 50, 200_000
CUBE, SIDES = 10.0, (1.0, 3.0)
NOISES = (0.003, 0.01, 0.03)
# Neighbours and least points of the peers: the defaults of their manuals' examples, scaled to the
# 4,000 points of a plane.
NEIGHBOURS, LEAST_POINTS = 32, 200
# Points within so many sd are of a plane.
GATE_SDS = 3.5
SAME_WAY_DEG = 25.0

FloatArray = NDArray[np.float64]


class Cloud(NamedTuple):
    """Points (n, 3), the plane of each (n,), and the planes' normals (50, 3)."""

    points: FloatArray
    labels: NDArray[np.intp]
    normals: FloatArray
    noise: float


# Takes a cloud in, which is not timed, and gives what finds the planes, which is.
Finder = Callable[[Cloud], Callable[[], NDArray[np.intp]]]


def make_random_cloud(seed: int, noise: float) -> Cloud:
    """Return fifty rectangles at random, as many points on each."""
    rng = np.random.default_rng(seed)
    each = POINTS // PLANES
    points, normals = [], []
    for _ in range(PLANES):
        axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        flat = (rng.uniform(size=(each, 2)) - 0.5) * rng.uniform(*SIDES, 2)
        points.append(rng.uniform(0.0, CUBE, 3) + flat @ axes[:2])
        normals.append(axes[2])
    every = np.concatenate(points) + rng.normal(0.0, noise, (POINTS, 3))
    return Cloud(every, np.repeat(np.arange(PLANES), each), np.array(normals), noise)


def facetlog(cloud: Cloud) -> Callable[[], NDArray[np.intp]]:
    """Return what finds the plane of each point, -1: none."""
    return lambda: cloud_planes(cloud.points).owner


def _open3d() -> Finder:
    o3d: Any = import_module("open3d")

    def take(cloud: Cloud) -> Callable[[], NDArray[np.intp]]:
        pcd = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(cloud.points))
        search = o3d.geometry.KDTreeSearchParamKNN(knn=NEIGHBOURS)

        def find() -> NDArray[np.intp]:
            pcd.estimate_normals(search)
            patches = pcd.detect_planar_patches(min_num_points=LEAST_POINTS, search_param=search)
            owner = np.full(len(cloud.points), -1)
            for nth, patch in enumerate(patches):
                own = patch.get_point_indices_within_bounding_box(pcd.points)
                owner[np.asarray(own, dtype=np.intp)] = nth
            return owner

        return find

    return take


def _cgal() -> Finder:
    shapes: Any = import_module("CGAL.CGAL_Shape_detection")
    sets: Any = import_module("CGAL.CGAL_Point_set_3")
    kernel: Any = import_module("CGAL.CGAL_Kernel")
    processing: Any = import_module("CGAL.CGAL_Point_set_processing_3")

    def take(cloud: Cloud) -> Callable[[], NDArray[np.intp]]:
        points = sets.Point_set_3()
        for place in cloud.points.tolist():
            points.insert(kernel.Point_3(*place))
        points.add_normal_map()
        region = points.add_int_map("region")
        gate = GATE_SDS * cloud.noise
        same_way = float(np.cos(np.deg2rad(SAME_WAY_DEG)))

        def find() -> NDArray[np.intp]:
            processing.pca_estimate_normals(points, NEIGHBOURS)
            shapes.region_growing(points, region, LEAST_POINTS, gate, -1, same_way, NEIGHBOURS)
            return np.array([region.get(index) for index in points.indices()])

        return find

    return take


PEERS = {"Open3D": _open3d, "CGAL": _cgal}


class Score(NamedTuple):
    """Share of planes found, and angle errors (radians) of the found ones and of the oracle."""

    recall: float
    errors: list[float]
    oracle: list[float]


def score(cloud: Cloud, owner: NDArray[np.intp]) -> Score:
    """Return how well regions (n,) stand for a cloud's planes."""
    errors, oracle, found = [], [], 0
    for label in range(PLANES):
        rows = cloud.labels == label
        oracle.append(_angle(cloud.points[rows], cloud.normals[label]))
        own = owner[rows]
        own = own[own >= 0]
        best = np.bincount(own).argmax() if len(own) else -2
        members = owner == best
        if (own == best).sum() > 0.5 * rows.sum() and rows[members].mean() > 0.5:
            found += 1
            errors.append(_angle(cloud.points[members], cloud.normals[label]))
    return Score(found / PLANES, errors, oracle)


def _angle(points: FloatArray, normal: FloatArray) -> float:
    plane, _ = fit_least_squares_plane(points)
    return float(np.arcsin(min(1.0, float(np.linalg.norm(np.cross(plane.normal, normal))))))


def _rows(name: str, take: Finder, noise: float, seeds: Sequence[int]) -> Iterator[dict[str, Cell]]:
    seconds, recalls, ratios = [], [], []
    for seed in seeds:
        cloud = make_random_cloud(seed, noise)
        find = take(cloud)
        start = process_time()
        owner = find()
        seconds.append(process_time() - start)
        result = score(cloud, owner)
        recalls.append(result.recall)
        ratios.append(float(np.median(result.errors or [np.nan]) / np.median(result.oracle)))
    yield {
        "noise": noise,
        "method": name,
        "recall": float(np.mean(recalls)),
        "error / oracle's": round(float(np.median(ratios)), 3),
        **{f"s {key}": value for key, value in compute_median_and_spread(seconds).items()},
    }


def measure(settings: Settings) -> Report:
    """Measure recall, angle error over the oracle's, and processor seconds, by method and noise."""
    finders: dict[str, Finder] = {"facetlog": facetlog}
    missing = []
    for name, load in PEERS.items():
        try:
            finders[name] = load()
        except ImportError as exc:
            missing.append(f"{name} was not measured: {exc}")
    seeds = range(settings.first, settings.first + settings.number(SEEDS))
    rows = [
        row
        for noise in NOISES
        for name, take in finders.items()
        for row in _rows(name, take, noise, seeds)
    ]
    return Report(
        NAME,
        (Table("fifty planes, 200,000 points", tuple(rows)),),
        {"planes": PLANES, "points": POINTS, "seeds": len(seeds)},
        tuple(missing),
    )
