"""Outlines of faces whose noise is wider than their points are apart."""

import tracemalloc

import numpy as np
import pytest

from facetlog.perception.flat_faces import compute_vector_area
from facetlog.perception.reading.shape_files.clouds.point_cloud import Cloud
from facetlog.perception.shapes.clouds.cloud_outlines import find_covered_area
from facetlog.perception.shapes.clouds.cloud_scene import make_cloud_scene
from facetlog.perception.types import FloatArray
from tests.perception.shapes.sampled_shapes import box_points, rectangle

X, Y, Z = np.eye(3)
SPACING = 0.01


def square(noise: float, *, side: float = 0.6, seed: int = 0) -> FloatArray:
    rng = np.random.default_rng(seed)
    flat = rng.uniform(0.0, side, (round((side / SPACING) ** 2), 2))
    return flat + rng.normal(0.0, 1.0, flat.shape) * noise


@pytest.mark.parametrize("noise", [0.0, 0.006, 0.01, 0.03])
@pytest.mark.parametrize("seed", [0, 1])
def test_noise_does_not_widen_an_area(noise: float, seed: int) -> None:
    flat = square(noise, seed=seed)
    areas, _ = find_covered_area(flat, np.full(len(flat), SPACING), noise)
    assert len(areas) == 1
    assert areas[0].area == pytest.approx(0.36, rel=0.07)


def noisy_with_distance(points: FloatArray, eye: FloatArray, share: float) -> FloatArray:
    rng = np.random.default_rng(2)
    sd = share * ((points - eye) ** 2).sum(axis=1)
    return points + rng.normal(0.0, 1.0, points.shape) * sd[:, None]


def on_floor(thing: FloatArray, count: int, side: float = 2.0) -> FloatArray:
    rng = np.random.default_rng(1)
    start = np.array([-side / 2.0, -side / 2.0, 0.0])
    return np.concatenate([thing, rectangle(rng, count, start, side * X, side * Y)])


def test_noise_that_grows_with_distance_leaves_a_box_its_faces() -> None:
    upper = ("-x", "+x", "-y", "+y", "+z")
    box = box_points((0.4, 0.3, 0.25), 1700, sides=upper) - [0.2, 0.15, 0.0]
    points = noisy_with_distance(on_floor(box, 13_000), np.array([2.0, -1.5, 1.5]), 0.002)
    scene = make_cloud_scene(Cloud.of(points), up=Z)
    assert len(scene.bodies) == 1
    faces = [scene.faces[i] for i in scene.bodies[0].faces]
    areas = [
        float(f.plane.normal @ compute_vector_area(scene.points[list(f.outline)])) for f in faces
    ]
    assert sorted(areas) == pytest.approx([0.075, 0.075, 0.1, 0.1, 0.12], rel=0.1)


def test_a_wide_ground_with_dense_noisy_points_takes_little_memory() -> None:
    rng = np.random.default_rng(3)
    near, far = rng.uniform(0.0, 0.14, (20_000, 2)), rng.uniform(-20.0, 20.0, (400, 2))
    tracemalloc.start()
    areas, _ = find_covered_area(np.concatenate([near, far]), np.full(20_400, 0.001), 0.002)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert areas[0].area == pytest.approx(0.14**2, rel=0.1)
    assert peak < 1e9
