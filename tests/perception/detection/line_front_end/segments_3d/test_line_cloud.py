"""The 3-D segments of rendered scenes."""

from functools import cache

import numpy as np
import pytest

from facetlog.perception.detection.edge_maps import edge_map
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import (
    MAX_RMS_PX,
    MIN_SUPPORT,
    LineCloud,
    agreement,
    best_of_owners,
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


def test_each_line_has_support_and_fits() -> None:
    cloud = block_lines()
    assert (cloud.support >= MIN_SUPPORT).all()
    assert (cloud.rms < MAX_RMS_PX).all()
    assert len(cloud.segments) == len(cloud.support) == len(cloud.rms) == len(cloud.end_covs)
    assert (np.linalg.eigvalsh(cloud.end_covs) > -1e-12).all()


def test_a_pixel_is_as_long_as_it_is_at_the_block() -> None:
    # The tour stands 37 to 50 in from the block; its focal length is 502 px.
    assert 0.05 < block_lines().pixel < 0.12


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


def test_pictures_without_segments_have_no_lines() -> None:
    views = tour("block")[:4]
    maps = [edge_map(v.image) for v in views]
    cloud = reconstruct_lines(views, maps, [np.zeros((0, 4))] * 4, view_graph(views))
    assert cloud.segments.shape == (0, 2, 3)
    assert cloud.support.shape == cloud.rms.shape == (0,)


def test_two_views_support_no_line() -> None:
    # Two planes through two pinholes always meet: only a third view can confirm it.
    assert not len(lines_of(tour("block")[:2]).segments)


def test_what_few_views_see_and_most_of_them_show_wins_over_what_many_should_show() -> None:
    nowhere = np.nan
    right = [1.0, 0.9, 1.0, 0.3, *[nowhere] * 12]
    wrong = [0.7, 0.8, 0.7, 0.9, 0.7, *[0.1] * 11]
    cover = np.array([right, wrong])
    shown = np.nansum(cover**2, axis=1)
    assert shown[1] > shown[0]
    both = np.array([[0, 1], [1, 2]])
    kept = best_of_owners(agreement(cover, np.ones(16)), shown, both)
    assert kept.tolist() == [True, False]


def test_all_that_is_nearly_the_best_of_a_segment_stays() -> None:
    cover = np.array([[1.0, 1.0, 0.1, 0.1], [1.0, 0.98, 0.1, 0.1], [0.7, 0.7, 0.7, 0.1]])
    shown = (cover**2).sum(axis=1)
    owners = np.array([[0, 3], [0, 4], [0, 5]])
    kept = best_of_owners(agreement(cover, np.ones(4)), shown, owners)
    assert kept.tolist() == [True, True, False]
