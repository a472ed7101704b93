"""Planes through texture points."""

import numpy as np

from facetlog.perception.detection.line_front_end.planes.texture_planes import (
    texture_planes,
)
from facetlog.perception.detection.line_front_end.points_3d.texture_points import TexturePoints
from facetlog.perception.types import FloatArray

PIXEL = 0.01
SD = 0.01


def texture_of(points: FloatArray) -> TexturePoints:
    covs = np.broadcast_to(SD**2 * np.eye(3), (len(points), 3, 3)).copy()
    return TexturePoints(points, covs, np.ones((len(points), 4), np.bool_))


def scattered(rng: np.random.Generator, count: int) -> FloatArray:
    return rng.uniform(-1, 1, (count, 3))


def level(rng: np.random.Generator, count: int, height: float, size: float = 0.5) -> FloatArray:
    flat = rng.uniform(-size, size, (count, 2))
    return np.column_stack([flat, height + SD * rng.normal(size=count)])


def test_points_on_a_plane_among_others_are_a_patch() -> None:
    rng = np.random.default_rng(0)
    points = np.concatenate([scattered(rng, 60), level(rng, 40, 0.3)])
    (patch,) = texture_planes(texture_of(points), PIXEL)
    assert abs(patch.normal[2]) > 0.999
    assert abs(abs(patch.distance) - 0.3) < 0.01
    assert (patch.points >= 60).sum() > 35
    assert (patch.points < 60).sum() < 4
    assert patch.score > patch.penalty


def test_points_anywhere_are_no_patch() -> None:
    for seed in range(10):
        points = scattered(np.random.default_rng(seed), 150)
        assert texture_planes(texture_of(points), PIXEL) == ()


def test_points_on_a_line_or_in_a_place_raise_nothing() -> None:
    line = np.linspace(0, 1, 20)[:, None] * np.array([1.0, 2.0, 3.0])
    texture_planes(texture_of(line), PIXEL)
    texture_planes(texture_of(np.zeros((20, 3))), PIXEL)


def test_the_unit_of_length_and_the_frame_change_no_patch() -> None:
    rng = np.random.default_rng(2)
    points = np.concatenate([scattered(rng, 50), level(rng, 40, 0.3)])
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    (patch,) = texture_planes(texture_of(points), PIXEL)
    moved = TexturePoints(
        1000 * points @ turn.T + 7.0, texture_of(points).covs * 1e6, np.ones((90, 4), np.bool_)
    )
    (other,) = texture_planes(moved, 1000 * PIXEL)
    np.testing.assert_array_equal(patch.points, other.points)
    assert abs(abs((turn @ patch.normal) @ other.normal) - 1) < 1e-9


def test_texture_on_a_curved_surface_is_on_no_plane() -> None:
    rng = np.random.default_rng(8)
    flat = level(rng, 120, 0.0)
    assert texture_planes(texture_of(flat), PIXEL)
    reach = np.abs(flat[:, 0]).max()
    for height in (6.0, 12.0):  # of the bulge, px
        bowed = flat.copy()
        bowed[:, 2] -= height * PIXEL * (flat[:, 0] / reach) ** 2
        for plane in texture_planes(texture_of(bowed), PIXEL):
            # What is taken for flat bulges by less than a point is known.
            x = bowed[plane.points, 0]
            assert np.ptp(x) < 1.5 * reach
