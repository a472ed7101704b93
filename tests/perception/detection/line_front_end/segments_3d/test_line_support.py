"""Edges along projected segments: what of a segment they show, and how far it reaches."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.perception.detection.edge_maps import edge_map
from facetlog.perception.detection.line_front_end.segments_3d.line_extent import (
    MARGIN,
    SAMPLES,
    LineProfiles,
    find_covered_extents,
    measure_line_profiles,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_refine import (
    read_edges,
    refine_segments,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_support import (
    coverage,
)
from tests.perception.detection.drawings import CAMERA, along, half_plane, view
from tests.perception.detection.line_front_end.block_rig import Rig, block_rig


def at_depth(pixels, depth: float = 3.0):
    """Points (..., 3) that the camera at the origin sees at these pixels (..., 2)."""
    rays = np.concatenate([pixels, np.ones((*pixels.shape[:-1], 1))], axis=-1)
    return depth * rays @ np.linalg.inv(CAMERA.matrix).T


@pytest.mark.parametrize("angle", np.radians([0.0, 20.0, 90.0, 135.0]))
def test_a_segment_on_a_drawn_edge_is_covered(angle: float) -> None:
    middle = np.array([160.0, 120.0])
    looking = view(half_plane(angle, middle))
    maps = [edge_map(looking.image)]
    ends = along(angle, middle, count=2)
    normal = np.array([-np.sin(angle), np.cos(angle)])
    across = middle + np.array([[-60.0], [60.0]]) * normal
    segments = at_depth(np.array([ends, ends + 8 * normal, across]))
    on_it, beside_it, across_it = coverage(segments, [looking], maps)[:, 0]
    assert on_it == 1.0
    assert beside_it == 0.0
    assert across_it <= 0.1  # the sample in the middle may lie on the edge, but not along it


def test_every_edge_of_a_block_is_covered_where_it_is_seen() -> None:
    rig = block_rig()
    cover = coverage(rig.edges, rig.views, rig.maps)
    assert cover.shape == rig.shown_edges.shape
    assert cover[rig.shown_edges].min() > 0.8
    # Nothing is seen through the block but where one edge happens to lie before another.
    assert np.median(cover[~rig.shown_edges]) < 0.3


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


LINE = np.array([0])
PLACE = st.floats(-1.5, 2.5)


def profile(covered) -> LineProfiles:
    """One line along x of length 1, its coverage given at the samples from -1 to 2."""
    cumulated = np.concatenate([[0.0], np.cumsum(covered)])[None]
    step = np.array([3.0 / SAMPLES])
    return LineProfiles(np.zeros((1, 3)), np.eye(3)[:1], np.array([-1.0]), step, cumulated)


def mean(profiles: LineProfiles, start: float, end: float) -> float:
    return float(profiles.mean(LINE, np.array([start]), np.array([end]))[0])


@given(st.integers(0, 1000), PLACE, PLACE, PLACE)
def test_parts_add_up_whichever_way_they_run(seed: int, a: float, b: float, c: float) -> None:
    profiles = profile(np.random.default_rng(seed).uniform(size=SAMPLES))
    a, b, c = sorted((a, b, c))
    whole = mean(profiles, c, a) * (c - a)
    assert whole == pytest.approx(
        mean(profiles, a, b) * (b - a) + mean(profiles, b, c) * (c - b), abs=1e-9
    )
    assert 0.0 <= mean(profiles, a, c) <= 1.0


def test_the_edges_of_a_block_are_covered_to_their_ends_and_not_beyond() -> None:
    rig = block_rig()
    profiles = measure_line_profiles(
        rig.edges, rig.views, rig.maps, rig.shown_edges, np.ones(len(rig.views))
    )
    lines = np.arange(len(rig.edges))
    length = np.linalg.norm(rig.edges[:, 1] - rig.edges[:, 0], axis=1)
    zero = np.zeros(len(lines))
    assert profiles.mean(lines, zero, length).min() > 0.9
    margin = 0.1 * length
    for start, end in ((-MARGIN * length, -margin), (length + margin, (1 + MARGIN) * length)):
        assert profiles.mean(lines, start, end).max() < 0.35
    np.testing.assert_allclose(
        profiles.origin + length[:, None] * profiles.direction, rig.edges[:, 1], atol=1e-9
    )


def test_where_half_of_the_views_see_a_line_rounding_does_not_end_it() -> None:
    # Three of six views, all of one weight, cover it half: to the last digit or not.
    segment = np.array([[[0.25, 0.0, 0.0], [0.75, 0.0, 0.0]]])
    half = [find_covered_extents(segment, profile(np.full(SAMPLES, c))) for c in (0.5, 0.5 - 1e-12)]
    np.testing.assert_allclose(half[0], half[1], atol=1e-9)
    assert np.ptp(half[0][0, :, 0]) > 1.0
