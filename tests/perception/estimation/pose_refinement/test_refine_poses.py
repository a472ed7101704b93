"""Poses of a robot's tour, corrected by the pictures: rendered, with a known drift."""

from dataclasses import replace

import numpy as np
import pytest

from facetlog.perception.estimation.pose_refinement.refine_poses import (
    correct_poses,
    refine_views,
)
from facetlog.perception.reading.read_views import ViewSet
from facetlog.perception.types import FloatArray, Pose, PoseErrorKind, PoseErrors, View
from facetlog.robot.rendering.views import add_drift, draw_similarity, pose_errors
from tests.rendered import tour

TURN_SD = float(np.radians(0.6))


@pytest.mark.parametrize(
    ("world", "seed"), [("block", 1), pytest.param("wedge", 0, marks=pytest.mark.slow)]
)
@pytest.mark.slow
def test_drifting_poses_are_put_right(world: str, seed: int) -> None:
    true = tour(world, seed)
    given, covs = add_drift(true, np.random.default_rng(seed), turn_sd=TURN_SD, way_sd=0.02)
    found = refine_views(given, covs)
    place, turn = pose_errors(found.views, true)
    place_before, turn_before = pose_errors(given, true)
    assert found.explained > max(0.9, found.explained_before)
    assert place < 0.5 * place_before
    assert turn < 0.5 * turn_before
    went = max(
        np.linalg.norm(a.pose.centre - b.pose.centre)
        for a, b in zip(found.views, given, strict=True)
    )
    assert found.shift == pytest.approx(went)


@pytest.mark.slow
def test_what_is_found_does_not_depend_on_the_frame_or_unit_of_the_world() -> None:
    true = tour("block", 1)[:10]
    given, covs = add_drift(true, np.random.default_rng(4), turn_sd=TURN_SD, way_sd=0.02)
    frame = draw_similarity(np.random.default_rng(2), scale=0.03, reach=5.0)
    turn = np.kron(np.eye(2), frame.rotation)
    units = np.array([frame.scale] * 3 + [1.0] * 3)
    there = turn @ covs @ turn.T * units[:, None] * units
    here = refine_views(given, covs)
    moved = refine_views([frame.view(v) for v in given], there)
    assert moved.explained == pytest.approx(here.explained, abs=0.05)
    place, angle = pose_errors(moved.views, [frame.view(v) for v in here.views])
    assert place / frame.scale < 0.1
    assert angle < np.radians(0.2)


def test_poses_that_are_right_stay_where_they_are() -> None:
    true = tour("block")[:8]
    _, covs = add_drift(true, np.random.default_rng(0), turn_sd=TURN_SD, way_sd=0.02)
    found = refine_views(true, covs)
    place, turn = pose_errors(found.views, true)
    assert place < 0.25
    assert turn < np.radians(0.3)


def test_errors_of_single_poses_are_left_to_the_adjustment() -> None:
    true = _in_metres(tour("block")[:6])
    _, covs = add_drift(true, np.random.default_rng(1), turn_sd=TURN_SD, way_sd=0.02)
    errors = replace(_stated(true, covs), kind=PoseErrorKind.INDEPENDENT)
    view_set = ViewSet("tour", true, metric=True, pose_errors=errors)
    assert correct_poses(view_set) is view_set


def _stated(views: tuple[View, ...], covs: FloatArray) -> PoseErrors:
    return PoseErrors(tuple(v.pose for v in views), covs)


def _in_metres(views: tuple[View, ...]) -> tuple[View, ...]:
    return tuple(replace(v, pose=Pose(v.pose.rotation, 0.0254 * v.pose.centre)) for v in views)
