"""How much of a 3-D segment the pictures show."""

import numpy as np
import pytest

from facetlog.perception.detection.edge_maps import edge_map
from facetlog.perception.detection.line_front_end.segments_3d.line_support import (
    coverage,
)
from tests.perception.detection.drawings import CAMERA, along, half_plane, view
from tests.perception.detection.line_front_end.block_rig import block_rig


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


def test_a_view_says_nothing_about_what_it_does_not_see() -> None:
    looking = view(half_plane(0.0, np.array([160.0, 120.0])))
    maps = [edge_map(looking.image)]
    outside = np.array([[[-300.0, 120.0], [-50.0, 120.0]], [[-180.0, 120.0], [100.0, 120.0]]])
    behind = -at_depth(np.array([[[60.0, 120.0], [260.0, 120.0]]]))
    segments = np.concatenate([at_depth(outside), behind])
    assert np.isnan(coverage(segments, [looking], maps)).all()


def test_every_edge_of_a_block_is_covered_where_it_is_seen() -> None:
    rig = block_rig()
    cover = coverage(rig.edges, rig.views, rig.maps)
    assert cover.shape == rig.shown_edges.shape
    assert cover[rig.shown_edges].min() > 0.8
    # Nothing is seen through the block but where one edge happens to lie before another.
    assert np.median(cover[~rig.shown_edges]) < 0.3
