"""Planes of clouds: all of them, nearly as good as least squares can be, with honest errors."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.perception.shapes.clouds.cloud_planes import cloud_planes, fit_least_squares_plane
from facetlog.perception.types import FloatArray
from tests.perception.shapes.sampled_shapes import (
    box_points,
    cylinder_points,
    sphere_points,
    turned,
)


@pytest.mark.parametrize(("count", "noise"), [(2000, 0.005), (20_000, 0.0), (20_000, 0.005)])
def test_six_sides_of_a_box_come_out_with_nearly_all_points(count: int, noise: float) -> None:
    points = box_points((3.0, 2.0, 1.0), count, noise=noise * np.sqrt(14.0))
    found = cloud_planes(points)
    assert len(found.planes) == 6
    # every plane is square to one axis, two to each
    along = np.abs([p.plane.normal for p in found.planes])
    assert (along.max(axis=1) > np.cos(np.deg2rad(1.0))).all()
    assert sorted(along.argmax(axis=1).tolist()) == [0, 0, 1, 1, 2, 2]
    assert (found.owner >= 0).mean() > 0.99


@settings(max_examples=5)
@given(st.integers(0, 1000), st.floats(1e-6, 1e6), st.tuples(*[st.floats(-1e3, 1e3)] * 3))
def test_planes_do_not_depend_on_place_turn_and_unit(
    seed: int, scale: float, shift: tuple[float, float, float]
) -> None:
    points = box_points((3.0, 2.0, 1.0), 3000, noise=0.01, seed=1)
    moved = scale * (turned(points, seed) + np.array(shift))
    assert len(cloud_planes(moved).planes) == len(cloud_planes(points).planes) == 6


@pytest.mark.parametrize("noise", [0.0, 0.005])
def test_cylinders_and_spheres_have_no_planes(noise: float) -> None:
    for points in (cylinder_points(0.5, 1.0, 8000, noise), sphere_points(0.5, 8000, noise)):
        found = cloud_planes(points)
        assert (found.owner >= 0).mean() < 0.1


def test_outliers_change_nothing() -> None:
    points = box_points((3.0, 2.0, 1.0), 6000, noise=0.01)
    wild = np.random.default_rng(3).uniform(-1.0, 4.0, (600, 3))
    found = cloud_planes(np.vstack([points, wild]))
    assert len(found.planes) == 6
    assert (found.owner[:6000] >= 0).mean() > 0.98
    assert (found.owner[6000:] >= 0).mean() < 0.2


def test_warped_sheet_is_one_plane_whose_error_has_the_warp() -> None:
    rng = np.random.default_rng(0)
    flat = rng.uniform(0.0, 1.0, (8000, 2))
    height = 0.006 * np.sin(2.0 * np.pi * flat[:, 0]) + rng.normal(0.0, 0.001, 8000)
    found = cloud_planes(np.column_stack([flat, height]))
    assert len(found.planes) == 1
    # the plane takes 6 / π² of a sine's variance, as its slope
    rms = np.hypot(0.006 * np.sqrt((1.0 - 6.0 / np.pi**2) / 2.0), 0.001)
    assert found.planes[0].rms == pytest.approx(rms, rel=0.1)
    even, _ = fit_least_squares_plane(np.column_stack([flat, rng.normal(0.0, rms, 8000)]))
    warped_sd = np.sqrt(np.trace(found.planes[0].plane.cov[:3, :3]))
    # neighbours err together: the normal is much less sure than 8,000 errors of that size make it
    assert warped_sd > 3.0 * np.sqrt(np.trace(even.cov[:3, :3]))


def test_covariance_is_honest_over_many_planes() -> None:
    rng = np.random.default_rng(0)
    total, runs = 0.0, 400
    for _ in range(runs):
        flat = rng.uniform(-1.0, 1.0, (300, 2)) * [2.0, 0.7] + 5.0
        points = np.column_stack([flat, rng.normal(0.0, 0.02, 300)])
        plane, _ = fit_least_squares_plane(points)
        sign = np.sign(plane.normal[2])
        error = np.array([*(sign * plane.normal), sign * plane.offset]) - [0.0, 0.0, 1.0, 0.0]
        total += float(error @ np.linalg.pinv(plane.cov, rcond=1e-10) @ error)
    nees = total / (3 * runs)
    # chi² with 1,200 degrees of freedom over 1,200: its sd is 0.041
    assert 0.85 < nees < 1.15


@pytest.mark.parametrize(
    "points",
    [
        np.zeros((0, 3)),
        np.ones((40, 3)),
        np.linspace(0.0, 1.0, 90)[:, None] * np.ones(3),
        np.random.default_rng(0).normal(size=(7, 3)),
    ],
    ids=["none", "one place", "a line", "seven"],
)
def test_what_is_no_surface_has_no_planes(points: FloatArray) -> None:
    found = cloud_planes(points)
    assert found.planes == ()
    assert (found.owner == -1).all()
