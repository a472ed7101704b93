"""Noise, gradients, coarser scales and the oriented mask, on pictures whose edges are drawn."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.perception.detection.coarse_pictures import coarse_pictures
from facetlog.perception.detection.edge_maps import (
    ORIENTATION_BINS,
    edge_map,
    encode_direction,
)
from facetlog.perception.detection.picture_noise import Noise, measure_working_noise
from tests.perception.detection.drawings import along, flat, half_plane, with_noise

MIDDLE = np.array([159.3, 120.2])
ANGLES = np.radians([0.0, 33.75, 61.0, 179.0])


@pytest.mark.parametrize("sd", [2.0, 20.0])
def test_noise_is_measured_to_five_percent(sd: float) -> None:
    estimates = [measure_working_noise(with_noise(flat(), sd, seed)).sd for seed in range(5)]
    # Whole greys add the variance of rounding, 1/12.
    assert np.mean(estimates) == pytest.approx(np.hypot(sd, np.sqrt(1 / 12)), rel=0.05)


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("sd", [0.0, 5.0])
def test_a_drawn_edge_has_the_bits_of_its_direction(angle: float, sd: float) -> None:
    mask = edge_map(with_noise(half_plane(angle, MIDDLE), sd)).mask
    u, v = np.rint(along(angle, MIDDLE)).astype(int).T
    own = (mask[v, u] & encode_direction(np.full(len(u), angle))) != 0
    assert own.mean() > 0.98
    across = (mask[v, u] & encode_direction(np.full(len(u), angle + np.pi / 2))) != 0
    assert across.mean() < 0.02


@pytest.mark.parametrize("angle", ANGLES)
def test_the_mask_reaches_as_far_as_it_says(angle: float) -> None:
    edges = edge_map(half_plane(angle, MIDDLE))
    normal = np.array([-np.sin(angle), np.cos(angle)])
    near = along(angle, MIDDLE) + 0.5 * edges.reach_px * normal
    # The edge pixel itself is off by up to 0.7 px, the dilating disc by another.
    far = along(angle, MIDDLE) + (edges.reach_px + 2.5) * normal
    for places, share in ((near, 1.0), (far, 0.0)):
        u, v = np.rint(places).astype(int).T
        assert (edges.mask[v, u] != 0).mean() == share


@pytest.mark.parametrize("angle", ANGLES[:2])
def test_faint_edges_of_a_noisy_picture_have_their_bits(angle: float) -> None:
    faint = half_plane(angle, MIDDLE, low=100, high=110)
    mask = edge_map(with_noise(faint, 5.0)).mask
    u, v = np.rint(along(angle, MIDDLE)).astype(int).T
    own = (mask[v, u] & encode_direction(np.full(len(u), angle))) != 0
    assert own.mean() > 0.8


@pytest.mark.parametrize("sd", [3.0, 10.0])
def test_noise_alone_makes_hardly_an_edge(sd: float) -> None:
    mask = edge_map(with_noise(flat(), sd)).mask
    assert (mask != 0).mean() < 0.01


@pytest.mark.parametrize("sd", [3.0, 10.0])
def test_the_noise_of_the_gradient_is_what_it_says(sd: float) -> None:
    edges = edge_map(with_noise(flat(), sd))
    assert edges.gx.std() == pytest.approx(edges.gradient_noise, rel=0.1)
    assert edges.gy.std() == pytest.approx(edges.gradient_noise, rel=0.1)


@given(st.floats(-20.0, 20.0))
def test_a_direction_has_its_bin_and_both_neighbours(direction: float) -> None:
    bits = int(encode_direction(np.array(direction)))
    own = int((direction % np.pi) / np.pi * ORIENTATION_BINS) % ORIENTATION_BINS
    assert bits == sum(1 << ((own + d) % ORIENTATION_BINS) for d in (-1, 0, 1))


@pytest.mark.parametrize(("sd", "scale"), [(5.0, 2), (14.0, 8)])
@pytest.mark.parametrize("column", [160, 163])
def test_edges_that_only_coarser_scales_show_stand_where_they_are(
    sd: float, scale: int, column: int
) -> None:
    step = np.full((240, 320), 120.0)
    step[:, column:] += 1.3 * sd
    noisy = np.rint(step + np.random.default_rng(column).normal(0.0, sd, step.shape))
    mask = edge_map(noisy.astype(np.uint8), reach_px=2.0).mask
    upright = (mask & encode_direction(np.array(np.pi / 2))) > 0
    marked = np.nonzero(upright.mean(axis=0) > 0.4)[0]
    assert len(marked) > 0
    # In the mean at the step, between the pixels `column` - 1 and `column`.
    assert abs(marked.mean() - (column - 0.5)) < scale / 2


@pytest.mark.parametrize(("sd", "count"), [(1.5, 0), (5.0, 1), (60.0, 3)])
def test_the_noisier_a_picture_the_more_often_it_is_halved(sd: float, count: int) -> None:
    assert [c.factor for c in coarse_pictures(flat(), Noise(sd))] == [2, 4, 8][:count]


def test_a_picture_of_one_pixel_is_not_halved() -> None:
    assert coarse_pictures(with_noise(flat()[:1, :1], 5.0), Noise(5.0)) == []
