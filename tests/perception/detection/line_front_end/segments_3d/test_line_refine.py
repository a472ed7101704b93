"""Edges read across projected segments, and segments drawn to them."""

import numpy as np
import pytest

from facetlog.perception.detection.edge_maps import edge_map
from facetlog.perception.detection.line_front_end.segments_3d.line_refine import (
    read_edges,
    refine_segments,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_support import segment_samples
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


@pytest.mark.parametrize("angle", np.radians([0.0, 20.0, 61.0, 90.0, 150.0]))
@pytest.mark.parametrize("off", [-1.6, -0.4, 0.0, 0.7, 2.1])
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


def test_an_edge_further_away_than_the_search_is_not_read() -> None:
    looking = view(half_plane(0.0, MIDDLE + np.array([0.0, 12.0])))
    points = at_depth(along(0.0, MIDDLE)[None])
    assert np.isnan(read_edges(looking, edge_map(looking.image), points, 4.0).offset).all()


def test_what_is_out_of_the_picture_or_behind_is_not_read() -> None:
    looking = view(half_plane(0.0, MIDDLE))
    maps = edge_map(looking.image)
    outside = at_depth(along(0.0, MIDDLE - np.array([400.0, 0.0]))[None])
    for points in (outside, -at_depth(along(0.0, MIDDLE)[None])):
        reading = read_edges(looking, maps, points, 4.0)
        assert not reading.visible.any()
        assert np.isnan(reading.offset).all()


@pytest.mark.parametrize("seed", range(3))
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


def test_a_segment_moves_across_itself_only() -> None:
    rig = block_rig()
    start = perturbed(rig, 0, 1.0)
    fitted, _, _ = refine_segments(
        start, rig.views, rig.maps, rig.shown_edges, np.ones(len(rig.views))
    )
    length = np.linalg.norm(start[:, 1] - start[:, 0], axis=1)
    after = np.linalg.norm(fitted[:, 1] - fitted[:, 0], axis=1)
    np.testing.assert_allclose(after, length, rtol=0.01)


def test_views_that_are_not_used_change_nothing() -> None:
    rig = block_rig()
    start = perturbed(rig, 1, 1.0)
    use = rig.shown_edges.copy()
    use[:, 5:] = False
    weight = np.ones(len(rig.views))
    every, _, _ = refine_segments(start, rig.views, rig.maps, use, weight)
    first, _, _ = refine_segments(start, rig.views[:5], rig.maps[:5], use[:, :5], weight[:5])
    np.testing.assert_allclose(every, first)


def test_a_segment_that_no_view_shows_stays_and_has_no_residual() -> None:
    rig = block_rig()
    start = perturbed(rig, 2, 1.0)
    unused = np.zeros_like(rig.shown_edges)
    fitted, _, rms = refine_segments(start, rig.views, rig.maps, unused, np.ones(len(rig.views)))
    np.testing.assert_array_equal(fitted, start)
    assert np.isnan(rms).all()


def test_on_the_true_edges_the_readings_are_near_zero() -> None:
    rig = block_rig()
    for k, (looking, edges) in enumerate(zip(rig.views, rig.maps, strict=True)):
        shown = rig.shown_edges[:, k]
        reading = read_edges(looking, edges, segment_samples(rig.edges[shown], 20), 3.0)
        middle = reading.offset[:, 4:-4]  # away from the corners, where edges meet
        assert np.nanmedian(np.abs(middle)) < 0.1
        assert np.isfinite(middle).mean() > 0.9
