"""Pictures and poses that belong together, and such that do not."""

import numpy as np
import pytest

from facetlog.errors import InconsistentViewsError
from facetlog.perception.detection.line_front_end.segments_3d.pose_consistency import (
    check_consistency,
    explained_share,
)
from facetlog.perception.detection.segments import detect_segments
from facetlog.robot.rendering.views import shuffled
from tests.perception.detection.line_front_end.block_rig import block_rig

NO_SEGMENTS = np.zeros((0, 2, 3))
ALL = np.ones(len(block_rig().views))


def test_a_blocks_edges_explain_its_pictures() -> None:
    rig = block_rig()
    found = [detect_segments(v.image) for v in rig.views]
    assert explained_share(rig.edges, rig.shown_edges, rig.views, found) > 0.8
    check_consistency(rig.edges, rig.shown_edges, ALL, rig.views, found)


def test_wrong_poses_explain_little_and_are_reported() -> None:
    rig = block_rig()
    found = [detect_segments(v.image) for v in rig.views]
    views = shuffled(rig.views, np.random.default_rng(0))
    everywhere = np.ones_like(rig.shown_edges)
    assert explained_share(rig.edges, everywhere, views, found) < 0.2
    with pytest.raises(InconsistentViewsError, match="10 views"):
        check_consistency(rig.edges, everywhere, ALL, views, found)


def test_views_that_agree_with_no_other_are_named_first() -> None:
    rig = block_rig()
    found = [detect_segments(v.image) for v in rig.views]
    shown = rig.shown_edges.copy()
    shown[:, 2:] = False
    names = ", ".join(v.name for v in rig.views[2:5])
    with pytest.raises(InconsistentViewsError, match=f"least in {names} and 5 more; check"):
        check_consistency(rig.edges, shown, ALL, rig.views, found)


def test_a_few_views_are_never_called_inconsistent() -> None:
    rig = block_rig()
    few = rig.views[:4]
    found = [detect_segments(v.image) for v in few]
    check_consistency(NO_SEGMENTS, np.zeros((0, 4), np.bool_), ALL[:4], few, found)
