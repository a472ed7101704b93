"""The map: what pictures show of the floor, and words that do not cover one another."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.perception.types import Camera
from facetlog.robot.collecting.map_picture import (
    Box,
    find_floor_in_view,
    looked_at,
    placed,
)
from facetlog.robot.mount.kinematics import Gaze, camera_pose
from facetlog.robot.mount.mount import DEFAULT_MOUNT
from facetlog.robot.pose2 import Pose2

CAMERA = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
angle = st.floats(-math.pi, math.pi)


@given(angle, st.floats(-1.5, 1.5), st.floats(-1.2, 0.6), st.floats(0.5, 8.0))
@settings(max_examples=40)
def test_every_place_of_the_outline_is_in_the_picture_and_within_reach(
    heading: float, pan: float, tilt: float, far: float
) -> None:
    pose = camera_pose(Pose2(0.3, -0.2, heading), DEFAULT_MOUNT, Gaze(pan, tilt))
    for x, y in find_floor_in_view(pose, CAMERA, far):
        assert math.hypot(x - pose.centre[0], y - pose.centre[1]) <= far + 1e-9
        ray = pose.rotation.T @ (np.array([x, y, 0.0]) - pose.centre)
        assert ray[2] > 0
        u, v = CAMERA.fx * ray[0] / ray[2] + CAMERA.cx, CAMERA.fy * ray[1] / ray[2] + CAMERA.cy
        assert -0.5 - 1e-6 <= u <= 639.5 + 1e-6
        assert -0.5 - 1e-6 <= v <= 479.5 + 1e-6


def test_a_camera_that_looks_up_sees_no_floor() -> None:
    pose = camera_pose(Pose2(), DEFAULT_MOUNT, Gaze(0.0, 1.0))
    assert len(find_floor_in_view(pose, CAMERA, 10.0)) == 0
    assert looked_at(pose, CAMERA, 2.0) == pytest.approx([pose.centre[0] + 2.0, 0.0])


@given(st.lists(st.tuples(st.floats(300, 700), st.floats(300, 700)), min_size=1, max_size=24))
@settings(max_examples=30)
def test_numbers_cover_neither_one_another_nor_what_is_drawn(
    anchors: list[tuple[float, float]],
) -> None:
    """Of 24 views anywhere on a map of a thousand pixels."""
    drawn = [Box(x - 4, y - 4, 8, 8) for x, y in anchors]
    boxes = placed(anchors, [(20.0, 12.0)] * len(anchors), drawn, (1000, 1000))
    for i, box in enumerate(boxes):
        assert box.outside(1000, 1000) == 0
        for other in (*boxes[:i], *drawn):
            assert box.shared(other) == 0
