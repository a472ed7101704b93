"""The 3-D segments of rendered scenes."""

from functools import cache

import numpy as np
import pytest

from facetlog.perception.detection.edge_maps import edge_map
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import (
    LineCloud,
    reconstruct_lines,
)
from facetlog.perception.detection.segments import detect_segments
from facetlog.perception.detection.view_graph import view_graph
from facetlog.perception.types import FloatArray, View
from facetlog.robot.rendering.views import random_similarity, shuffled
from facetlog.robot.rendering.worlds import make_world
from tests.rendered import solid_truth, tour, true_edges, visible_faces


def lines_of(views: tuple[View, ...]) -> LineCloud:
    maps = [edge_map(v.image) for v in views]
    segments = [detect_segments(v.image) for v in views]
    return reconstruct_lines(views, maps, segments, view_graph(views))


@cache
def block_lines() -> LineCloud:
    return lines_of(tour("block"))


def seen_edges() -> FloatArray:
    """True edges (n, 2, 3) of the block that some view sees."""
    solid = solid_truth(make_world("block"))
    faces = {f for v in tour("block") for f in visible_faces(solid, v)}
    corners = [set(solid.faces[f]) for f in faces]
    shown = [any(set(e) <= face for face in corners) for e in solid.edges]
    return true_edges(solid)[np.array(shown)]


def found_share(edge: FloatArray, segments: FloatArray, tolerance: float) -> float:
    """Share of an edge (2, 3) that lies within `tolerance` of some segment (n, 2, 3)."""
    places = edge[0] + np.linspace(0.02, 0.98, 49)[:, None] * (edge[1] - edge[0])
    start = segments[:, 0]
    along = segments[:, 1] - start
    t = ((places[:, None] - start) * along).sum(-1) / (along**2).sum(-1)
    nearest = start + np.clip(t, 0, 1)[..., None] * along
    away = np.linalg.norm(places[:, None] - nearest, axis=-1)
    return float((away.min(axis=1) < tolerance).mean())


def test_every_edge_seen_of_a_block_is_found_whole() -> None:
    shares = [found_share(e, block_lines().segments, 0.1) for e in seen_edges()]
    assert len(shares) == 12
    assert min(shares) > 0.9


def test_the_same_lines_are_found_in_another_frame() -> None:
    frame = random_similarity(np.random.default_rng(5), scale=1000.0, reach=1e4)
    moved = lines_of(tuple(frame.view(v) for v in tour("block")))
    assert moved.pixel == pytest.approx(1000 * block_lines().pixel, rel=1e-6)
    edges = frame.scale * seen_edges() @ frame.rotation.T + frame.shift
    assert min(found_share(e, moved.segments, 0.1 * frame.scale) for e in edges) > 0.9


def test_wrong_poses_leave_few_lines_and_none_of_them_well_supported() -> None:
    views = shuffled(tour("block"), np.random.default_rng(0))
    cloud = lines_of(views)
    assert cloud.support.sum() < 0.2 * block_lines().support.sum()


def test_two_views_support_no_line() -> None:
    # Two planes through two pinholes always meet: only a third view can confirm it.
    assert not len(lines_of(tour("block")[:2]).segments)
