"""Clouds whose truth is known: boxes, cylinders and spheres at random points, with noise."""

import numpy as np
from scipy.spatial.transform import Rotation

from facetlog.perception.types import FloatArray

__all__ = ["box_points", "boxes_points", "cylinder_points", "rectangle", "sphere_points", "turned"]


def rectangle(
    rng: np.random.Generator, count: int, origin: FloatArray, a: FloatArray, b: FloatArray
) -> FloatArray:
    """Points (count, 3) anywhere on a parallelogram from `origin` along `a` and `b`."""
    shares = rng.uniform(size=(count, 2))
    points: FloatArray = origin + shares @ np.array([a, b])
    return points


def box_points(
    size: tuple[float, float, float],
    count: int,
    *,
    seed: int = 0,
    noise: float = 0.0,
    sides: tuple[str, ...] = ("-x", "+x", "-y", "+y", "-z", "+z"),
) -> FloatArray:
    """Points on sides of a box from the origin, as many on each as its area asks."""
    rng = np.random.default_rng(seed)
    edges = np.diag(size)
    areas = {side: np.prod(np.delete(size, "xyz".index(side[1]))) for side in sides}
    parts = []
    for side in sides:
        axis = "xyz".index(side[1])
        origin = edges[axis] if side[0] == "+" else np.zeros(3)
        a, b = np.delete(edges, axis, axis=0)
        share = areas[side] / sum(areas.values())
        parts.append(rectangle(rng, round(count * share), origin, a, b))
    points = np.concatenate(parts)
    return points + rng.normal(0.0, 1.0, points.shape) * noise


def boxes_points(
    *parts: tuple[tuple[float, float, float], tuple[float, float, float]],
    count: int,
    noise: float = 0.0,
) -> FloatArray:
    """Points all over boxes of these sizes and lowest corners, by their areas."""
    areas = [2.0 * (a * b + b * c + a * c) for (a, b, c), _ in parts]
    return np.concatenate(
        [
            box_points(size, round(count * area / sum(areas)), seed=k, noise=noise) + place
            for k, ((size, place), area) in enumerate(zip(parts, areas, strict=True))
        ]
    )


def cylinder_points(radius: float, height: float, count: int, noise: float) -> FloatArray:
    """Points on the wall of an upright cylinder."""
    rng = np.random.default_rng(0)
    angle, z = rng.uniform(0.0, 2.0 * np.pi, count), rng.uniform(0.0, height, count)
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), z])
    return points + rng.normal(0.0, 1.0, points.shape) * noise


def sphere_points(radius: float, count: int, noise: float) -> FloatArray:
    """Points on a sphere about the origin."""
    rng = np.random.default_rng(0)
    points = rng.normal(size=(count, 3))
    points *= radius / np.linalg.norm(points, axis=1)[:, None]
    return points + rng.normal(0.0, 1.0, points.shape) * noise


def turned(points: FloatArray, seed: int = 0) -> FloatArray:
    """The points turned about the origin by any rotation."""
    rotation = Rotation.random(rng=np.random.default_rng(seed))
    return np.asarray(rotation.apply(points), dtype=np.float64)
