"""Blender's and NeRF's transforms_train.json is read as nerfstudio's transforms.json."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from facetlog.errors import InputError
from facetlog.perception.reading.read_views import read_views
from facetlog.perception.types import View
from tests.perception.reading.pose_files.same_views import same_views
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


def test_both_files_in_one_folder_are_refused(tmp_path: Path) -> None:
    folder = write_transforms(tmp_path)
    (folder / "transforms_train.json").write_text("{}")
    with pytest.raises(InputError, match=r"has both transforms_train\.json .* name the one to use"):
        read_views(folder)
