"""Sides of outlines by the edges of all views."""

import numpy as np
import pytest

from facetlog.perception.detection.line_front_end.evidence.side_evidence import SideJudge
from facetlog.perception.types import FloatArray
from tests.perception.detection.line_front_end.block_rig import Rig, block_rig

UP = np.array([0.0, 0.0, 1.0])


def judge(rig: Rig) -> SideJudge:
    return SideJudge(rig.views, rig.maps, np.ones(len(rig.views)))


def sides(corners: FloatArray) -> FloatArray:
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


def test_true_edges_score_high_and_lines_in_the_air_low() -> None:
    rig = block_rig()
    score = judge(rig).score(rig.edges)
    seen = rig.shown_edges.sum(axis=1) >= 3
    assert score[seen].min() > 20
    away = judge(rig).score(rig.edges + 0.5 * (rig.edges - rig.points.mean(axis=0)))
    assert np.median(away) < 0.2 * np.median(score[seen])


def test_a_side_counts_in_each_view_that_has_an_edge_there() -> None:
    rig = block_rig()
    top, _ = rig.top
    everyone = np.arange(len(rig.views))
    found = judge(rig).evidence(everyone, sides(top))
    assert found.found.shape == (len(rig.views), 4, 12)
    assert found.there.all()
    assert found.found.mean() > 0.9
    assert (found.ratio > 0).all()


def test_a_side_outside_the_picture_says_nothing() -> None:
    rig = block_rig()
    far = np.array([[[500.0, 500.0, 0.0], [520.0, 500.0, 0.0]]])
    found = judge(rig).evidence(np.arange(len(rig.views)), far)
    assert not found.there.any()
    assert not found.ratio.any()


@pytest.mark.parametrize("seed", range(4))
def test_a_rough_outline_moves_onto_the_edges(seed: int) -> None:
    rig = block_rig()
    top, normal = rig.top
    rng = np.random.default_rng(seed)
    moves = rng.uniform(-5, 5, (4, 2)) * rig.pixel
    rough = top + np.column_stack([moves, np.zeros(4)])
    views = np.arange(len(rig.views))
    found = judge(rig).onto_edges(views, rough, normal, rig.pixel)
    away = np.linalg.norm(found - top, axis=1).max()
    assert away < 2.6 * rig.pixel
    assert away < np.linalg.norm(rough - top, axis=1).max()
    np.testing.assert_allclose(found @ normal, top @ normal, atol=1e-9)


def test_an_outline_on_the_edges_stays() -> None:
    rig = block_rig()
    top, normal = rig.top
    views = np.arange(len(rig.views))
    np.testing.assert_allclose(judge(rig).onto_edges(views, top, normal, rig.pixel), top, atol=1e-9)


def test_nothing_to_go_by_leaves_an_outline_as_it_is() -> None:
    rig = block_rig()
    top, normal = rig.top
    none = np.zeros(0, dtype=np.intp)
    assert judge(rig).onto_edges(none, top, normal, rig.pixel) is top
    twice = top[[0, 0, 1, 2, 3]]
    views = np.arange(len(rig.views))
    assert judge(rig).onto_edges(views, twice, normal, rig.pixel) is twice
