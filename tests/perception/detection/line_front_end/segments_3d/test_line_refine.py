"""Edges read across projected segments, and segments drawn to them."""

import numpy as np
import pytest

from facetlog.perception.detection.edge_maps import edge_map
from facetlog.perception.detection.line_front_end.segments_3d.line_refine import (
    read_edges,
    refine_segments,
)
from tests.perception.detection.drawings import along, half_plane, view, with_noise
from tests.perception.detection.line_front_end.block_rig import Rig, block_rig
from tests.perception.detection.line_front_end.segments_3d.test_line_support import at_depth

MIDDLE = np.array([159.3, 120.4])


def line_errors(rig: Rig, segments) -> float:
    """Distances (n, 2) of segments' ends from the true edges' lines."""
    start = rig.edges[:, :1]
    unit = rig.edges[:, 1:] - start
    unit = unit / np.linalg.norm(unit, axis=-1, keepdims=True)
    relative = segments - start
    inside = (relative * unit).sum(axis=-1, keepdims=True)
    return np.linalg.norm(relative - inside * unit, axis=-1)


def perturbed(rig: Rig, seed: int, px: float):
    """True edges with each end moved at random by up to `px` pixels along each axis."""
    rng = np.random.default_rng(seed)
    return rig.edges + px * rig.pixel * rng.uniform(-1, 1, rig.edges.shape)


@pytest.mark.parametrize("angle", np.radians([0.0, 61.0, 150.0]))
@pytest.mark.parametrize("off", [-1.6, 0.7])
def test_the_offset_of_a_drawn_edge_is_read(angle: float, off: float) -> None:
    normal = np.array([-np.sin(angle), np.cos(angle)])
    looking = view(half_plane(angle, MIDDLE + off * normal))
    points = at_depth(along(angle, MIDDLE, count=41)[None])
    reading = read_edges(looking, edge_map(looking.image), points, search_px=4.0)
    assert np.abs(reading.offset - off).max() < 0.2
    assert abs(reading.offset.mean() - off) < 0.06  # remap reads at 1/32 px
    np.testing.assert_allclose(reading.normal[0], normal, atol=1e-9)
    np.testing.assert_allclose(reading.uv[0], along(angle, MIDDLE, count=41), atol=1e-9)
    assert reading.visible.all()


def test_noise_scatters_the_readings_but_does_not_shift_them() -> None:
    points = at_depth(along(0.0, MIDDLE, reach=120, count=121)[None])
    means = []
    for seed in range(10):
        looking = view(with_noise(half_plane(0.0, MIDDLE), 5.0, seed))
        means.append(np.nanmean(read_edges(looking, edge_map(looking.image), points, 4.0).offset))
    assert abs(np.mean(means)) < 0.08
    assert np.std(means) < 0.1


@pytest.mark.parametrize("seed", range(2))
def test_a_perturbed_edge_of_a_block_returns_to_the_truth(seed: int) -> None:
    rig = block_rig().noisy(seed, 2.0)
    used = rig.shown_edges
    fitted, _, rms = refine_segments(
        perturbed(rig, seed, 1.5), rig.views, rig.maps, used, np.ones(len(rig.views))
    )
    errors = line_errors(rig, fitted)
    assert np.median(errors) < 0.02
    assert np.sqrt((errors**2).mean()) < 0.04  # a third of a pixel
    assert np.median(line_errors(rig, perturbed(rig, seed, 1.5))) > 0.08
    assert rms.max() < 1.0
