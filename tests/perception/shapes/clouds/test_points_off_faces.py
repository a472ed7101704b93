"""Which points of a cloud a face's noise explains, and that a thing reaches no further for them."""

from dataclasses import replace

import numpy as np
import pytest

from facetlog.perception.scene import Plane
from facetlog.perception.shapes.clouds.cloud_scene import find_points_off_faces
from facetlog.perception.shapes.regions.flat_region import FlatRegion

NOISE = 0.01
SPACING = 0.02
SQUARE = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
HOLE = np.array([[0.3, 0.3, 0.0], [0.3, 0.7, 0.0], [0.7, 0.7, 0.0], [0.7, 0.3, 0.0]])
FACE = FlatRegion(Plane(np.array([0.0, 0.0, 1.0]), 0.0, np.zeros((4, 4))), SQUARE, (HOLE,))


@pytest.mark.parametrize(
    ("place", "off"),
    [
        ((0.1, 0.1, 0.04), False),  # 4 sd above it
        ((0.1, 0.1, -0.06), True),  # 6 sd behind it
        ((1.05, 0.5, 0.0), False),  # beyond its rim by a spacing and 3 sd
        ((1.07, 0.5, 0.0), True),
        ((0.5, 0.5, 0.0), True),  # in its hole
    ],
)
def test_points_within_the_noise_of_a_face_are_its_own(
    place: tuple[float, float, float], off: bool
) -> None:
    points, own = np.array([place]), np.array([0])
    assert find_points_off_faces(points, own, [FACE], noise=NOISE, spacing=SPACING).tolist() == [
        off
    ]


def test_a_face_noisier_than_the_cloud_explains_its_own_noise() -> None:
    points, own = np.array([[0.1, 0.1, 0.12], [0.1, 0.1, 0.18]]), np.array([0, 0])
    noisy = replace(FACE, noise=3.0 * NOISE)
    off = find_points_off_faces(points, own, [noisy], noise=NOISE, spacing=SPACING)
    assert off.tolist() == [False, True]
