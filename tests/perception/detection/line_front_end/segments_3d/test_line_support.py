"""How much of a 3-D segment the pictures show."""

import numpy as np
import pytest

from facetlog.perception.detection.edge_maps import edge_map
from facetlog.perception.detection.line_front_end.segments_3d.line_support import (
    coverage,
    hits,
    project_points,
    segment_samples,
)
from tests.perception.detection.drawings import CAMERA, along, half_plane, project, view
from tests.perception.detection.line_front_end.block_rig import block_rig


def at_depth(pixels, depth: float = 3.0):
    """Points (..., 3) that the camera at the origin sees at these pixels (..., 2)."""
    rays = np.concatenate([pixels, np.ones((*pixels.shape[:-1], 1))], axis=-1)
    return depth * rays @ np.linalg.inv(CAMERA.matrix).T


def test_samples_lie_evenly_inside_a_segment() -> None:
    samples = segment_samples(np.array([[[0.0, 0, 0], [4, 0, 8]]]), 4)
    assert samples[0].tolist() == [[0.5, 0, 1], [1.5, 0, 3], [2.5, 0, 5], [3.5, 0, 7]]


def test_points_behind_the_camera_have_no_positive_depth() -> None:
    points = np.array([[[0.1, 0.2, 2.0], [0.1, 0.2, -2.0]], [[0.1, 0.2, 0.0], [1, 1, 5]]])
    uv, depth = project_points(view().projection, points)
    np.testing.assert_allclose(depth, points[..., 2])
    assert np.isfinite(uv).all()
    np.testing.assert_allclose(uv[depth > 0], project(view(), points[depth > 0]))


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


def test_an_edge_that_ends_halfway_covers_half() -> None:
    image = half_plane(0.0, np.array([160.0, 120.0]))
    image[:, 160:] = 130
    looking = view(image)
    segment = at_depth(np.array([[[60.0, 120.0], [260.0, 120.0]]]))
    assert coverage(segment, [looking], [edge_map(image)], samples=40)[0, 0] == pytest.approx(
        0.5, abs=0.05
    )


def test_a_view_says_nothing_about_what_it_does_not_see() -> None:
    looking = view(half_plane(0.0, np.array([160.0, 120.0])))
    maps = [edge_map(looking.image)]
    outside = np.array([[[-300.0, 120.0], [-50.0, 120.0]], [[-180.0, 120.0], [100.0, 120.0]]])
    behind = -at_depth(np.array([[[60.0, 120.0], [260.0, 120.0]]]))
    segments = np.concatenate([at_depth(outside), behind])
    assert np.isnan(coverage(segments, [looking], maps)).all()


def test_a_segment_partly_in_view_is_judged_by_that_part() -> None:
    looking = view(half_plane(0.0, np.array([160.0, 120.0])))
    segment = at_depth(np.array([[[-40.0, 120.0], [200.0, 120.0]]]))
    assert coverage(segment, [looking], [edge_map(looking.image)])[0, 0] == 1.0


def test_every_edge_of_a_block_is_covered_where_it_is_seen() -> None:
    rig = block_rig()
    cover = coverage(rig.edges, rig.views, rig.maps)
    assert cover.shape == rig.shown_edges.shape
    assert cover[rig.shown_edges].min() > 0.8
    # Nothing is seen through the block but where one edge happens to lie before another.
    assert np.median(cover[~rig.shown_edges]) < 0.3


def test_hits_return_which_samples_are_in_the_picture() -> None:
    looking = view(half_plane(0.0, np.array([160.0, 120.0])))
    pixels = np.stack([np.linspace(-100, 419, 53), np.full(53, 120.0)], axis=-1)
    found, inside = hits(looking, edge_map(looking.image), at_depth(pixels[None]))
    expected = (pixels[:, 0] >= -0.5) & (pixels[:, 0] < CAMERA.width - 0.5)
    assert inside[0].tolist() == expected.tolist()
    assert not (found & ~inside).any()


def test_no_segments_have_no_coverage() -> None:
    rig = block_rig()
    assert coverage(np.zeros((0, 2, 3)), rig.views, rig.maps).shape == (0, len(rig.views))
