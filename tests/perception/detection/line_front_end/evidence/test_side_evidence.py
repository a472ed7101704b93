"""Sides of outlines by the edges of all views."""

import numpy as np
import pytest

from facetlog.perception.detection.line_front_end.evidence.side_evidence import SideJudge
from tests.perception.detection.line_front_end.block_rig import Rig, block_rig


def judge(rig: Rig) -> SideJudge:
    return SideJudge(rig.views, rig.maps, np.ones(len(rig.views)))


def test_true_edges_score_high_and_lines_in_the_air_low() -> None:
    rig = block_rig()
    score = judge(rig).score(rig.edges)
    seen = rig.shown_edges.sum(axis=1) >= 3
    assert score[seen].min() > 20
    away = judge(rig).score(rig.edges + 0.5 * (rig.edges - rig.points.mean(axis=0)))
    assert np.median(away) < 0.2 * np.median(score[seen])


@pytest.mark.parametrize("seed", range(2))
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
