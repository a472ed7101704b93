"""What is written can be read back: poses, intrinsics, pictures and truth."""

import csv
import json
import tomllib
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from facetlog.perception.pan_tilt import pan_tilt_pose
from facetlog.perception.types import Camera, FloatArray, Pose, View
from facetlog.robot.recording import Format, compute_pan_tilt_angles, write_views
from facetlog.robot.rendering.views import (
    Similarity,
    draw_similarity,
    simulate,
)
from facetlog.robot.rendering.worlds import make_world
from facetlog.robot.tour import tour_poses

SMALL = Camera(80, 60, 62.0, 63.0, 39.5, 29.5)
angles = st.floats(-np.pi, np.pi)


@given(angles, angles, angles)
def test_pan_tilt_and_skew_describe_any_rotation(a: float, b: float, c: float) -> None:
    pose = Pose(Rotation.from_euler("zxz", [a, b, c]).as_matrix(), np.zeros(3))
    again = pan_tilt_pose(0, 0, 0, *compute_pan_tilt_angles(pose))
    np.testing.assert_allclose(again.rotation, pose.rotation, atol=1e-7)


@pytest.mark.parametrize("tilt", [0.0, -np.pi])
def test_a_camera_that_looks_straight_up_or_down_has_angles_too(tilt: float) -> None:
    pose = pan_tilt_pose(0, 0, 0, 0.4, tilt, 0.3)
    again = pan_tilt_pose(0, 0, 0, *compute_pan_tilt_angles(pose))
    np.testing.assert_allclose(again.rotation, pose.rotation, atol=1e-9)


def test_a_pan_tilt_folder_holds_the_views(tmp_path: Path) -> None:
    frame = draw_similarity(np.random.default_rng(4), scale=3.0, reach=10)
    views = simulate(tmp_path, make_world("block"), tour_poses()[:3], SMALL, frame=frame)
    camera = tomllib.loads((tmp_path / "camera.toml").read_text())
    assert camera.pop("unit") == "in"
    assert Camera(**camera) == SMALL
    with (tmp_path / "poses.csv").open() as file:
        rows = list(csv.reader(file))
    assert rows[0] == ["image", "x", "y", "z", "pan_deg", "tilt_deg", "skew_deg"]
    for view, (name, *numbers) in zip(views, rows[1:], strict=True):
        x, y, z, *degrees = map(float, numbers)
        pose = pan_tilt_pose(x, y, z, *np.deg2rad(degrees))
        np.testing.assert_allclose(pose.rotation, view.pose.rotation, atol=1e-9)
        np.testing.assert_allclose(pose.centre, view.pose.centre)
        image = cv2.imread(str(tmp_path / name), cv2.IMREAD_UNCHANGED)
        assert image is not None
        assert np.array_equal(image, view.image)


def test_transforms_json_has_opengl_axes_and_counts_pixels_from_the_corner(tmp_path: Path) -> None:
    poses = tour_poses()[:2]
    views = simulate(tmp_path, make_world("wedge"), poses, SMALL, layout=Format.TRANSFORMS)
    content = json.loads((tmp_path / "transforms.json").read_text())
    point = np.array([23.0, 56.0, 3.0])
    for view, frame in zip(views, content["frames"], strict=True):
        camera_from_world = np.linalg.inv(np.array(frame["transform_matrix"]))
        x, y, z = (camera_from_world @ [*point, 1.0])[:3]  # right, up, backward
        corner_u = content["fl_x"] * x / -z + content["cx"]
        corner_v = content["fl_y"] * -y / -z + content["cy"]
        u, v, w = view.projection @ [*point, 1.0]
        assert (corner_u - 0.5, corner_v - 0.5) == pytest.approx((u / w, v / w))
        assert (tmp_path / frame["file_path"]).is_file()
    assert (content["w"], content["h"]) == (80, 60)


def test_the_truth_written_projects_alike_in_every_frame(tmp_path: Path) -> None:
    def corners(folder: Path, frame: Similarity | None) -> FloatArray:
        views = simulate(folder, make_world("chair"), tour_poses()[:2], SMALL, frame=frame)
        solid = json.loads((folder / "ground_truth.json").read_text())["solids"][0]
        points = np.array(solid["vertices"])
        for i, j in solid["edges"]:
            assert i != j
        h = np.column_stack([points, np.ones(len(points))]) @ views[1].projection.T
        return np.asarray(h[:, :2] / h[:, 2:])

    moved = draw_similarity(np.random.default_rng(1), scale=1000.0, reach=50.0)
    plain = corners(tmp_path / "plain", None)
    np.testing.assert_allclose(corners(tmp_path / "moved", moved), plain, atol=1e-6)


def test_views_of_different_cameras_do_not_share_a_folder(tmp_path: Path) -> None:
    pose, other = Pose(np.eye(3), np.zeros(3)), Camera(80, 60, 70.0, 70.0, 39.5, 29.5)
    image = np.zeros((60, 80), dtype=np.uint8)
    views = [View("a.png", image, SMALL, pose), View("b.png", image, other, pose)]
    with pytest.raises(ValueError, match="different cameras"):
        write_views(tmp_path, views)
