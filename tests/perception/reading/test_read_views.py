"""The way in: what is read, and what is refused in one line that names the file."""

import re
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from facetlog.errors import CalibrationError, InputError
from facetlog.perception.reading.read_views import ViewSet, read_views
from facetlog.perception.types import PoseErrorKind
from tests.perception.reading.view_folders import (
    CAMERA,
    POSES,
    picture,
    transforms,
    write_tour,
    write_transforms,
)


def test_nerfstudio_axes_and_pixels_become_opencv(tmp_path: Path) -> None:
    found = read_views(write_transforms(tmp_path / "cube"))
    view = found.views[1]
    assert (found.name, found.metric, found.up) == ("cube", False, None)
    assert (view.camera.cx, view.camera.cy) == (24.0, 16.0)
    np.testing.assert_allclose(view.pose.rotation @ [0, 0, 1], [0, 0, -1])  # looks along -z
    np.testing.assert_allclose(view.pose.rotation @ [0, 1, 0], [0, -1, 0])  # picture down is -y
    np.testing.assert_allclose(view.pose.centre, [1, 0, 0])
    np.testing.assert_array_equal(view.image, picture(1))


def test_unit_up_and_covariances_in_the_file_are_taken_from_there(tmp_path: Path) -> None:
    document = transforms()
    document.update(unit="cm", up=[0, 0, 2])
    for frame in document["frames"]:
        frame["covariance"] = np.diag([4.0, 4.0, 1.0, 0.01, 0.01, 0.02]).tolist()
    found = read_views(write_transforms(tmp_path, document))
    assert found.metric
    assert found.up == pytest.approx([0, 0, 1])
    assert found.views[1].pose.centre == pytest.approx([0.01, 0, 0])
    assert found.pose_errors is not None
    assert found.pose_errors.covariances.shape == (3, 6, 6)
    assert np.diag(found.pose_errors.covariances[2]) == pytest.approx(
        [4e-4, 4e-4, 1e-4, 0.01, 0.01, 0.02]
    )
    assert found.pose_errors.kind is PoseErrorKind.ODOMETRY
    document["pose_errors"] = "independent"
    again = read_views(write_transforms(tmp_path, document))
    assert again.pose_errors is not None
    assert again.pose_errors.kind is PoseErrorKind.INDEPENDENT
    with pytest.raises(InputError, match="its unit is 'cm', and 'mm' was given: leave one out"):
        read_views(tmp_path, unit="mm")
    del document["frames"][1]["covariance"]
    assert read_views(write_transforms(tmp_path, document)).pose_errors is None


def test_a_tour_in_inches_becomes_metres_with_z_up(tmp_path: Path) -> None:
    found = read_views(write_tour(tmp_path))
    assert found.metric
    np.testing.assert_array_equal(found.up, [0, 0, 1])
    np.testing.assert_allclose(found.views[1].pose.centre, [0.127, 0, 0.254])
    np.testing.assert_allclose(found.views[0].pose.rotation @ [0, 0, 1], [0, 1, 0], atol=1e-12)
    assert found.views[0].camera.cx == 23.5


def test_blender_exports_need_no_size_and_no_extension(tmp_path: Path) -> None:
    document = {"camera_angle_x": 2 * np.arctan(24 / 60), "frames": transforms()["frames"]}
    for frame in document["frames"]:
        frame["file_path"] = frame["file_path"].removesuffix(".png")
    folder = write_transforms(tmp_path, document)
    (folder / "transforms.json").rename(folder / "transforms_train.json")
    (folder / "transforms_test.json").write_text('{"frames": []}')
    _write_other_size(folder, 1, (24, 16))  # an angle is that of pictures of any size
    found = read_views(folder)
    assert found.description.startswith("Blender's transforms_train.json, 3 pictures, up unknown")
    assert found.problems == ()
    assert [v.camera.width for v in found.views] == [48, 24, 48]
    camera = found.views[0].camera
    assert (camera.fx, camera.fy) == pytest.approx((60, 60))
    assert (camera.cx, camera.cy) == (23.5, 15.5)


def test_a_camera_of_one_frame_goes_before_the_camera_of_all(tmp_path: Path) -> None:
    document = transforms()
    document["frames"][2].update(w=24, h=16, fl_x=30.0, fl_y=31.0, cx=12.0, cy=8.0)
    folder = write_transforms(tmp_path, document)
    _write_other_size(folder, 2, (24, 16))
    found = read_views(folder)
    assert found.problems == ()
    assert [(v.camera.width, v.camera.fx) for v in found.views] == [(48, 50), (48, 50), (24, 30)]
    assert found.views[2].image.shape == (16, 24)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"frames": []}, "no usable views"),
        ({"frames": transforms(1)["frames"]}, "1 usable view:"),
        ({"frames": 3}, "frames"),
        ({"frames": [3]}, "file_path"),
        ({"video": "http://127.0.0.1:1/stream.mjpg"}, "recognize --follow"),
        ({"pose_errors": "huge"}, "independent or odometry"),
    ],
)
def test_unusable_documents_are_refused(tmp_path: Path, change: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says):
        read_views(write_transforms(tmp_path, transforms() | change))


@pytest.mark.parametrize(
    ("poses", "camera", "says"),
    [
        (POSES.replace("skew_deg", "skew"), CAMERA, r"poses\.csv:1: no column skew_deg"),
        (POSES.replace("5,0,10,10", "5,0,10,left"), CAMERA, r"poses\.csv:4: pan_deg is 'left'"),
        (POSES.replace("5,0,10,10", "5,0,10,inf"), CAMERA, r"poses\.csv:4: pan_deg"),
        (POSES.replace("5,0,10,10", "5,0,10"), CAMERA, r"poses\.csv:4: 6 fields"),
        (POSES + '"', CAMERA, r"poses\.csv:5: not CSV: .*: correct it there$"),
        (POSES.replace("1.png", ""), CAMERA, "no image"),
        ("", CAMERA, "empty"),
        (POSES, None, r"camera\.toml is missing"),
        (POSES, CAMERA + "fx 3", r"camera\.toml: not TOML: .*line 8.*: correct it there$"),
        (POSES, CAMERA.replace("fx = 50\nfy = 51\n", ""), "no intrinsics"),
        (POSES, CAMERA.replace('"in"', '"furlong"'), "unknown unit 'furlong'"),
        (POSES, CAMERA.replace('"in"', "3"), "in quotes"),
    ],
)
def test_faults_of_a_tour_are_named_with_their_line(
    tmp_path: Path, poses: str, camera: str | None, says: str
) -> None:
    with pytest.raises(InputError, match=says):
        read_views(write_tour(tmp_path, poses, camera))


def _write_other_size(folder: Path, k: int, size: tuple[int, int]) -> None:
    path = str(folder / "images" / f"{k}.png")
    cv2.imwrite(path, np.asarray(cv2.resize(picture(k), size)))


@pytest.mark.parametrize(
    ("size", "remedy"),
    [
        ((40, 32), "use the pictures at the size"),
        ((32, 48), "the way round that the camera was calibrated"),
        ((24, 16), r"0\.5 times the size, scale the camera"),
    ],
)
def test_a_picture_that_is_not_of_its_cameras_size_is_named_and_left_out(
    tmp_path: Path, size: tuple[int, int], remedy: str
) -> None:
    folder = write_transforms(tmp_path, transforms(4), 4)
    _write_other_size(folder, 2, size)
    found = read_views(folder)
    assert [v.name for v in found.views] == [f"images/{k}.png" for k in (0, 1, 3)]
    (problem,) = found.problems
    assert re.search(
        rf"frame 3 .*{size[0]} x {size[1]}, its camera says 48 x 32.*{remedy}", problem
    )
    assert problem.endswith("left out")


def test_a_picture_of_one_pixel_is_none_whatever_its_camera(tmp_path: Path) -> None:
    folder = write_transforms(tmp_path, transforms(4), 4)
    _write_other_size(folder, 2, (1, 1))
    found = read_views(folder)
    assert len(found.views) == 3
    (problem,) = found.problems
    assert f"{folder / 'images' / '2.png'} is 1 x 1 px, too small to show anything" in problem
    assert "scale the camera" not in problem


def test_a_fault_that_many_pictures_have_is_one_line(tmp_path: Path) -> None:
    folder = write_transforms(tmp_path, transforms(14), 14)
    for k in range(12):
        path = folder / "images" / f"{k}.png"
        cv2.imwrite(str(path), picture(k).astype(np.uint16) << 2)
    found = read_views(folder)
    assert (len(found.views), found.left_out) == (2, 12)
    (problem,) = found.problems
    assert "0.png has 16 bits, yet no level above 4095: write it with 8 bits" in problem
    assert problem.endswith(
        "left out, and so are images/1.png, images/2.png, images/3.png and 8 more"
    )


def test_of_a_camera_without_a_size_the_odd_picture_is_named_and_left_out(tmp_path: Path) -> None:
    document = transforms(4)
    del document["w"], document["h"]
    folder = write_transforms(tmp_path, document, 4)
    _write_other_size(folder, 1, (40, 30))
    found = read_views(folder)
    assert len(found.views) == 3
    (problem,) = found.problems
    assert "frame 2" in problem
    assert "40 x 30, most of its camera are 48 x 32" in problem
    for k in range(3):
        _write_other_size(folder, k, (40, 30 + k))
    with pytest.raises(CalibrationError, match="pictures of one camera are of 4 sizes"):
        read_views(folder)


@pytest.mark.parametrize("damage", ["missing", "truncated", "folder", "loop of links"])
def test_one_unreadable_picture_among_many_is_left_out(tmp_path: Path, damage: str) -> None:
    path = write_transforms(tmp_path) / "images" / "1.png"
    data = path.read_bytes()
    path.unlink()
    if damage == "truncated":
        path.write_bytes(data[: len(data) // 2])
    elif damage == "folder":
        path.mkdir()
    elif damage == "loop of links":
        path.symlink_to(path.name)
    found = read_views(tmp_path)
    assert [v.name for v in found.views] == ["images/0.png", "images/2.png"]
    assert len(found.problems) == 1
    assert str(path) in found.problems[0]


def test_too_few_readable_pictures_are_an_error_that_names_one(tmp_path: Path) -> None:
    write_transforms(tmp_path)
    for i in range(2):
        (tmp_path / "images" / f"{i}.png").unlink()
    with pytest.raises(InputError, match=r"1 usable view, 2 are needed: .*0\.png.* 1 more"):
        read_views(tmp_path)


def test_folders_without_or_with_two_kinds_of_poses_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="does not exist"):
        read_views(tmp_path / "absent")
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="has no poses, it is empty: add pictures of a thing on"):
        read_views(tmp_path / "empty")
    write_transforms(write_tour(tmp_path / "both"))
    with pytest.raises(InputError, match="has both"):
        read_views(tmp_path / "both")
    assert len(read_views(tmp_path / "both" / "poses.csv").views) == 2


def test_a_frame_that_is_there_twice_is_used_once_and_named(tmp_path: Path) -> None:
    document = transforms()
    document["frames"].append(dict(document["frames"][1], file_path="./images/1.png"))
    found = read_views(write_transforms(tmp_path, document))
    assert len(found.views) == 3
    assert any("images/1.png twice" in line for line in found.problems)
    document["frames"][3]["transform_matrix"] = document["frames"][2]["transform_matrix"]
    with pytest.raises(InputError, match="has two poses"):
        read_views(write_transforms(tmp_path, document))


def test_progress_counts_all_pictures(tmp_path: Path) -> None:
    calls: list[tuple[str, int, int]] = []
    read_views(write_transforms(tmp_path), progress=lambda *call: calls.append(call))
    assert calls == [("pictures", i, 3) for i in (1, 2, 3)]


def _input_error_or_views(path: Path) -> None:
    try:
        found = read_views(path)
    except InputError as exc:
        assert str(exc)  # noqa: PT017 - either outcome is right, none other is
    else:
        assert isinstance(found, ViewSet)


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.binary(max_size=60), st.sampled_from(["transforms.json", "poses.csv", "camera.toml"]))
def test_no_bytes_make_it_fail_otherwise(tmp_path: Path, data: bytes, name: str) -> None:
    write_tour(tmp_path)
    (tmp_path / name).write_bytes(data)
    _input_error_or_views(tmp_path / name)
    _input_error_or_views(tmp_path / "poses.csv")
    (tmp_path / "transforms.json").unlink(missing_ok=True)


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("walk.mp4", "", r'with "video": "walk\.mp4" and a pose'),
        ("poses.yaml", "", "no poses file"),
        ("transforms.json", "[" * 100_000, "too deep"),
        ("transforms.json", '{\n "frames": [}\n', r"json:2:13: not JSON: .*: correct it there, or"),
    ],
)
def test_files_that_are_no_poses_are_named(tmp_path: Path, name: str, text: str, says: str) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=says):
        read_views(tmp_path / name)


def test_a_unit_makes_lengths_metres(tmp_path: Path) -> None:
    found = read_views(write_transforms(tmp_path) / "transforms.json", unit="mm")
    assert found.metric
    np.testing.assert_allclose(found.views[2].pose.centre, [0.002, 0, 0])


def test_a_unit_that_contradicts_the_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="leave one out"):
        read_views(write_tour(tmp_path), unit="mm")
