"""Captures of Polycam and Record3D give the views that transforms.json of them gives."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from facetlog.errors import InputError
from facetlog.perception.reading.pose_files.pose_reader import PoseOptions
from facetlog.perception.reading.pose_files.register import read_poses
from facetlog.perception.reading.read_views import read_views
from tests.perception.reading.pose_files.same_views import same_views
from tests.perception.reading.view_folders import (
    HEIGHT,
    WIDTH,
    write_pictures,
    write_transforms,
)

CAMERA = {"fx": 50.0, "fy": 51.0, "cx": 24.5, "cy": 16.5}


def write_polycam(folder: Path, cameras: str = "corrected_cameras") -> Path:
    """Keyframes whose names are times; of some length, so that 10 comes after 9."""
    inside = folder / "keyframes"
    pictures = write_pictures(inside / cameras.replace("cameras", "images"))
    (inside / cameras).mkdir(parents=True)
    for k in range(3):
        matrix = np.eye(4)[:3]
        matrix[0, 3] = k
        entries = {
            f"t_{row}{column}": matrix[row, column] for row in range(3) for column in range(4)
        }
        fields = {**CAMERA, "width": WIDTH, "height": HEIGHT, "blur_score": 1.0, **entries}
        (inside / cameras / f"{8 + k}.json").write_text(json.dumps(fields))
        (pictures / f"{k}.png").rename(pictures / f"{8 + k}.png")
    return folder


def write_record3d(folder: Path, document: dict[str, Any] | None = None) -> Path:
    write_pictures(folder / "rgbd")
    columns = [50.0, 0.0, 0.0, 0.0, 51.0, 0.0, 24.5, 16.5, 1.0]
    poses = [[0.0, 0.0, 0.0, 1.0, k, 0.0, 0.0] for k in range(3)]
    whole = {"w": WIDTH, "h": HEIGHT, "fps": 60, "K": columns, "poses": poses}
    (folder / "metadata.json").write_text(json.dumps(whole | (document or {})))
    return folder


@pytest.mark.parametrize("cameras", ["cameras", "corrected_cameras"])
def test_polycams_keyframes_are_those_of_transforms_json(tmp_path: Path, cameras: str) -> None:
    wanted = read_views(write_transforms(tmp_path / "wanted"), unit="m")
    found = read_views(write_polycam(tmp_path / "tour", cameras))
    same_views(found.views, wanted.views)
    assert found.up is not None
    assert found.up.tolist() == [0.0, 1.0, 0.0]
    assert (found.name, found.description) == ("tour", "Polycam capture, 3 pictures")


def test_polycams_cameras_without_a_size_are_of_that_of_the_pictures(tmp_path: Path) -> None:
    write_polycam(tmp_path)
    wanted = read_views(tmp_path)
    for path in (tmp_path / "keyframes" / "corrected_cameras").iterdir():
        fields = json.loads(path.read_text())
        del fields["width"], fields["height"]
        path.write_text(json.dumps(fields))
    same_views(read_views(tmp_path).views, wanted.views)


def test_record3ds_metadata_may_have_no_suffix(tmp_path: Path) -> None:
    (write_record3d(tmp_path) / "metadata.json").rename(tmp_path / "metadata")
    assert len(read_views(tmp_path).views) == 3
    assert len(read_views(tmp_path / "metadata").views) == 3


def test_record3ds_zip_is_named_with_how_to_unpack_it(tmp_path: Path) -> None:
    path = tmp_path / "box.r3d"
    path.write_bytes(b"PK")
    for given in (path, tmp_path):
        with pytest.raises(InputError, match=r"unzip box\.r3d -d box"):
            read_views(given)


def test_optimised_cameras_go_before_those_of_arkit(tmp_path: Path) -> None:
    write_polycam(write_polycam(tmp_path, "cameras"), "corrected_cameras")
    assert read_views(tmp_path).views[0].name.startswith("corrected_images/8")


def test_record3ds_poses_are_those_of_transforms_json(tmp_path: Path) -> None:
    wanted = read_views(write_transforms(tmp_path / "wanted"), unit="m")
    found = read_views(write_record3d(tmp_path / "tour"))
    same_views(found.views, wanted.views)
    assert found.description == "Record3D capture, 3 pictures, up unknown"


def test_intrinsics_of_each_picture_go_before_those_of_all(tmp_path: Path) -> None:
    each = [[60.0 + k, 61.0, 20.5, 10.5] for k in range(3)]
    write_record3d(tmp_path, {"perFrameIntrinsicCoeffs": each})
    last = read_poses(tmp_path / "metadata.json", PoseOptions()).pictures[2].intrinsics
    assert (last.focal, last.centre) == ((62.0, 61.0), (20.0, 10.0))


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('"t_12": ', '"t": ', r"9\.json: no 't_12': export it again"),
        ('"fx": 50.0', '"fx": -1', r"9\.json: fx is -1"),
        ('"t_00": 1.0', '"t_00": 2.0', r"9\.json: the rotation is not one, it scales"),
    ],
)
def test_faults_of_a_keyframe_are_named(tmp_path: Path, old: str, new: str, says: str) -> None:
    path = write_polycam(tmp_path) / "keyframes" / "corrected_cameras" / "9.json"
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(InputError, match=says):
        read_views(tmp_path)


@pytest.mark.parametrize(
    ("document", "says"),
    [
        ({"poses": 3}, r'metadata\.json: no list of "poses"'),
        ({"poses": [[0, 0, 0, 0, 0, 0, 0]] * 3}, r"pose 1: .*of length 0"),
        ({"poses": [[0, 0, 0, 1, 0, 0, 0], [1]]}, r"pose 2: not 7 finite numbers"),
        ({"K": [1, 2]}, r"pose 1: K: not 9 finite numbers"),
        ({"perFrameIntrinsicCoeffs": [[1, 1, 0, 0]]}, r"pose 2: its intrinsics: not 4 finite"),
    ],
)
def test_faults_of_metadata_are_named(tmp_path: Path, document: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says):
        read_views(write_record3d(tmp_path, document))
