"""Blender's and NeRF's transforms_train.json is read as nerfstudio's transforms.json."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from facetlog.errors import InputError
from facetlog.perception.reading.read_views import read_views
from facetlog.perception.types import View
from tests.perception.reading.pose_files.pose_folders import same_views
from tests.perception.reading.view_folders import (
    WIDTH,
    transforms,
    write_pictures,
    write_transforms,
)


def test_blenders_export_gives_the_views_of_transforms_json(tmp_path: Path) -> None:
    square = transforms() | {"fl_x": 50.0, "fl_y": 50.0, "cx": WIDTH / 2, "cy": 16.0}
    wanted = read_views(write_transforms(tmp_path / "wanted", square))
    folder = write_pictures(tmp_path / "blender" / "train").parent
    frames = [
        {"file_path": f"./train/{i}", "rotation": 0.01, "transform_matrix": f["transform_matrix"]}
        for i, f in enumerate(square["frames"])
    ]
    document = {"camera_angle_x": 2 * math.atan(WIDTH / 2 / 50.0), "frames": frames}
    (folder / "transforms_train.json").write_text(json.dumps(document))
    (folder / "transforms_test.json").write_text(json.dumps(document | {"frames": []}))
    found = read_views(folder)
    close = []
    for one, other in zip(found.views, wanted.views, strict=True):  # tan of atan rounds
        np.testing.assert_allclose(one.camera.matrix, other.camera.matrix, rtol=1e-12)
        close.append(View(one.name, one.image, other.camera, one.pose))
    same_views(tuple(close), wanted.views)
    assert found.description.startswith("Blender's transforms_train.json, 3 pictures, up unknown")


def test_is_fisheye_is_opencvs_fisheye(tmp_path: Path) -> None:
    lens = {"k1": 0.05, "k2": 0.01, "k3": 0.0, "k4": 0.0}
    plain = {key: value for key, value in transforms().items() if key != "camera_model"} | lens
    wanted = write_transforms(tmp_path / "a", plain | {"camera_model": "OPENCV_FISHEYE"})
    found = write_transforms(tmp_path / "b", plain | {"is_fisheye": True})
    same_views(read_views(found).views, read_views(wanted).views)
    other = write_transforms(tmp_path / "c", plain | {"is_fisheye": False})
    camera = write_transforms(tmp_path / "d", plain | {"camera_model": "OPENCV"})
    same_views(read_views(other).views, read_views(camera).views)


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ({"is_fisheye": "yes"}, "is_fisheye is 'yes': give true or false"),
        ({"is_fisheye": True, "camera_model": "OPENCV"}, "is_fisheye is true, yet camera_model"),
    ],
)
def test_an_unclear_is_fisheye_is_named(tmp_path: Path, more: dict[str, object], says: str) -> None:
    with pytest.raises(InputError, match=says):
        read_views(write_transforms(tmp_path, transforms() | more))
