import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.perception.detection.block_front_end.correspondence import (
    epipolar_chi_square,
    fundamental_matrix,
    triangulate_pairs,
)

coordinate = st.floats(-3.0, 3.0)


def pixel(projection, point):
    x = projection @ np.append(point, 1.0)
    return x[:2] / x[2]


@settings(max_examples=40)
@given(st.tuples(coordinate, coordinate, st.floats(0.0, 6.0)), st.integers(1, 7))
def test_a_projected_point_comes_back(tour, point, other):
    first, second = tour.views[0].projection, tour.views[other].projection
    uv1, uv2 = pixel(first, point), pixel(second, point)
    back = triangulate_pairs(first, second, uv1[None], uv2[None])[0]
    assert np.allclose(back, point, atol=1e-3)


def test_corresponding_pixels_lie_on_each_others_epipolar_lines(tour):
    first, second = tour.views[0].projection, tour.views[2].projection
    points = tour.corners
    uv1 = np.array([pixel(first, p) for p in points])
    uv2 = np.array([pixel(second, p) for p in points])
    covs = np.tile(0.01 * np.eye(2), (8, 1, 1))
    off = epipolar_chi_square(fundamental_matrix(first, second), uv1, covs, uv2, covs)
    assert np.diag(off).max() < 1e-6
    assert np.median(off[~np.eye(8, dtype=bool)]) > 100


def test_the_epipolar_chi_square_has_one_degree_of_freedom(tour):
    rng = np.random.default_rng(0)
    first, second = tour.views[0].projection, tour.views[2].projection
    uv1 = np.tile(pixel(first, tour.corners[6]), (4000, 1)) + rng.normal(0, 0.3, (4000, 2))
    uv2 = pixel(second, tour.corners[6])[None] + rng.normal(0, 0.3, (1, 2)) * 0
    off = epipolar_chi_square(
        fundamental_matrix(first, second),
        uv1,
        np.tile(0.09 * np.eye(2), (4000, 1, 1)),
        uv2,
        np.zeros((1, 2, 2)),
    )
    assert off.mean() == pytest.approx(1.0, abs=0.1)
