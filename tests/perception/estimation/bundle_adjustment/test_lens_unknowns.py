"""Focal length and radial distortion as unknowns of each camera."""

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from facetlog.perception.estimation.bundle_adjustment.lens_unknowns import lenses_of
from facetlog.perception.types import Camera, FloatArray, View
from tests.perception.estimation.bundle_adjustment.test_adjust import CAMERA, ring

UV = np.array([[[319.5, 239.5], [50.0, 400.0], [600.0, 20.0]]]).transpose(1, 0, 2)


def two_cameras(count: int = 6) -> tuple[View, ...]:
    other = replace(CAMERA, fx=500.0, fy=510.0, cx=300.0)
    views = ring(count)
    return tuple(replace(v, camera=other) if k % 2 else v for k, v in enumerate(views))


def spread(uv: FloatArray, views: int) -> FloatArray:
    return np.tile(uv, (1, views, 1))


@given(focal=st.floats(-0.2, 0.2), radial=st.floats(-0.3, 0.3))
def test_a_pixel_freed_of_its_distortion_is_the_pinholes(focal: float, radial: float) -> None:
    lenses = lenses_of(ring(3))
    unknowns = np.array([[focal, radial]])
    seen, _, _ = lenses.seen(unknowns, spread(UV, 3))
    off = spread(UV, 3) - lenses.centre
    np.testing.assert_allclose(
        lenses.undistorted(unknowns, seen), lenses.centre + (1.0 + focal) * off, atol=1e-3
    )


@given(focal=st.floats(-0.2, 0.2), radial=st.floats(-0.3, 0.3))
def test_derivatives_are_those_of_differences(focal: float, radial: float) -> None:
    lenses = lenses_of(two_cameras())
    unknowns = np.array([[focal, radial], [radial / 2, focal]])
    uv, step = spread(UV, 6), 1e-6
    at, by_pixel, by_lens = lenses.seen(unknowns, uv)
    for axis in range(2):
        moved = uv + step * np.eye(2)[axis]
        change = (lenses.seen(unknowns, moved)[0] - at) / step
        np.testing.assert_allclose(by_pixel[..., axis], change, atol=1e-4)
        change = (lenses.seen(unknowns + step * np.eye(2)[axis], uv)[0] - at) / step
        np.testing.assert_allclose(by_lens[..., axis], change, atol=1e-2)


def test_a_camera_of_two_views_has_no_unknowns() -> None:
    views = two_cameras(4)
    lone = Camera(640, 480, 700.0, 700.0, 319.5, 239.5)
    views = (*ring(3), replace(views[0], camera=lone), replace(views[1], camera=lone))
    lenses = lenses_of(views)
    assert lenses.count == 1
    unknowns = np.array([[0.1, 0.1]])
    seen, _, by_lens = lenses.seen(unknowns, spread(UV, 5))
    np.testing.assert_array_equal(seen[:, 3:], spread(UV, 2))
    assert not by_lens[:, 3:].any()
    assert [e.focal_sd for e in lenses.errors(unknowns, unknowns)] == [0.1] * 3 + [0.0] * 2
