"""The focus of a set of cameras, how much each counts, and which pair up."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import (
    MERGE_VIEWS,
    SCREEN_VIEWS,
    _choose_distinct_views,
)
from facetlog.perception.detection.view_graph import (
    measure_view_motion,
    view_graph,
)
from facetlog.perception.types import Pose, View
from facetlog.robot.rendering.views import draw_similarity
from facetlog.robot.tour import make_ring_poses
from tests.perception.detection.drawings import CAMERA, view

TARGET = np.array([3.0, -2.0, 1.0])


def ring(count: int = 12, *, jitter: float = 0.0, seed: int = 0) -> tuple[View, ...]:
    rng = np.random.default_rng(seed)
    poses = make_ring_poses(TARGET, 10.0, (4.0, 7.0), count, jitter=jitter, rng=rng)
    return tuple(view(pose=p) for p in poses)


def test_cameras_that_look_at_a_point_have_it_as_their_focus() -> None:
    graph = view_graph(ring())
    assert np.linalg.norm(graph.focus - TARGET) < 0.02
    assert graph.distance == pytest.approx(np.median([np.hypot(10, 4), np.hypot(10, 7)]), rel=0.01)


def test_three_views_far_apart_count_as_three() -> None:
    # An even billionth less, and no segment would be shown by three distinct views.
    steps = 30.0 / CAMERA.fx * np.arange(3)
    poses = [Pose(np.eye(3), np.array([10.0 * step, 0.0, -10.0])) for step in steps]
    assert view_graph([view(pose=p) for p in poses]).weight.sum() == 3.0


@settings(max_examples=25)
@given(st.integers(0, 10_000), st.sampled_from([1e-3, 1.0, 1e3]))
def test_another_frame_and_scale_change_no_weight_and_no_pair(seed: int, scale: float) -> None:
    views = ring(jitter=0.1, seed=seed)
    frame = draw_similarity(np.random.default_rng(seed), scale=scale, reach=10.0)
    before, after = view_graph(views), view_graph([frame.view(v) for v in views])
    focus = frame.scale * frame.rotation @ before.focus + frame.shift
    assert np.linalg.norm(after.focus - focus) < 1e-6 * after.distance
    assert after.distance == pytest.approx(scale * before.distance)
    np.testing.assert_allclose(after.weight, before.weight, rtol=1e-6)
    assert after.pairs == before.pairs


@settings(max_examples=25)
@given(st.permutations(range(12)))
def test_the_order_of_the_views_does_not_matter(order: list[int]) -> None:
    views = ring(jitter=0.1)
    before, after = view_graph(views), view_graph([views[k] for k in order])
    np.testing.assert_allclose(after.focus, before.focus, rtol=1e-9)
    np.testing.assert_allclose(after.weight, before.weight[list(order)], rtol=1e-9)
    named = {tuple(sorted((order[i], order[j]))) for i, j in after.pairs}
    assert named == set(before.pairs)


@pytest.mark.parametrize("copies", [2, 5])
def test_a_view_taken_again_shares_its_weight(copies: int) -> None:
    views = ring(6)
    graph = view_graph((*views, *[views[0]] * (copies - 1)))
    again = [0, *range(len(views), len(views) + copies - 1)]
    np.testing.assert_allclose(graph.weight[again], 1 / copies, rtol=0.01)
    assert graph.weight.sum() == pytest.approx(len(views), rel=0.01)


@pytest.mark.parametrize("heights", [(5.0,), (3.0, 5.0, 7.0)])
@pytest.mark.parametrize("count", [16, 30])
def test_rings_of_any_size_have_partners_under_moderate_angles(
    count: int, heights: tuple[float, ...]
) -> None:
    views = tuple(view(pose=p) for p in make_ring_poses(TARGET, 10.0, heights, count))
    graph = view_graph(views)
    units = [(graph.focus - v.pose.centre) for v in views]
    units = [r / np.linalg.norm(r) for r in units]
    angles = [np.degrees(np.arccos(np.clip(units[i] @ units[j], -1, 1))) for i, j in graph.pairs]
    assert max(angles) < 60


@pytest.mark.parametrize("heights", [(5.0,), (3.0, 5.0, 7.0)])
@pytest.mark.parametrize("count", [12, 30])
def test_rounding_of_a_ring_changes_no_pair_weight_or_choice(
    count: int, heights: tuple[float, ...]
) -> None:
    poses = make_ring_poses(TARGET, 10.0, heights, count)
    before = view_graph([view(pose=p) for p in poses])
    for seed in range(2):
        rng = np.random.default_rng(seed)
        nudged = [
            Pose(
                p.rotation @ cv2.Rodrigues(1e-12 * rng.uniform(-1, 1, 3))[0],
                p.centre + 1e-12 * rng.uniform(-1, 1, 3),
            )
            for p in poses
        ]
        after = view_graph([view(pose=p) for p in nudged])
        assert after.pairs == before.pairs
        np.testing.assert_allclose(after.weight, before.weight, rtol=1e-9)
        for wanted in (MERGE_VIEWS, SCREEN_VIEWS):
            chosen = _choose_distinct_views(before.weight, wanted)
            assert len(chosen) == min(count, wanted)
            assert _choose_distinct_views(after.weight, wanted) == chosen


def turned(degrees: float, centre: np.ndarray) -> Pose:
    """A camera at a place that is turned so far about its own vertical, from along z."""
    return Pose(cv2.Rodrigues(np.array([0.0, np.radians(degrees), 0.0]))[0], centre)


@pytest.mark.parametrize(("degrees", "x"), [(0.0, 8.0), (90.0, 8.0), (90.0, 0.0), (180.0, 0.0)])
def test_a_view_that_does_not_face_the_focus_counts_as_one_of_its_own(
    degrees: float, x: float
) -> None:
    # The focus is in its plane (depth 0), behind it, or where it stands.
    poses = [turned(0.0, np.array([x, 0.0, 0.0])) for x in (-1.0, -0.5, 0.0, 0.5, 1.0)]
    focus = view_graph([view(pose=p) for p in poses]).focus
    aside = turned(degrees, np.array([x, 0.0, focus[2]]))
    views = [view(pose=p) for p in (*poses, aside)]
    motion, graph = measure_view_motion(views), view_graph(views)
    assert np.isfinite(motion).all()
    assert np.isfinite(graph.weight).all()
    np.testing.assert_array_equal(motion, motion.T)
    assert not motion.diagonal().any()
    assert graph.weight[-1] == 1.0
