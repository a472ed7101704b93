"""OpenMVG's sfm_data.json gives the views that transforms.json of the same pictures gives."""

import json
from pathlib import Path
from typing import Any

import pytest

from facetlog.errors import InputError
from facetlog.perception.reading.lens import Distortion
from facetlog.perception.reading.pose_files.pose_reader import PoseOptions
from facetlog.perception.reading.pose_files.register import read_poses
from facetlog.perception.reading.read_views import read_views
from tests.perception.reading.pose_files.same_views import same_views
from tests.perception.reading.view_folders import (
    HEIGHT,
    WIDTH,
    transforms,
    write_pictures,
    write_transforms,
)

FIRST = 1 << 31
UNDEFINED = (1 << 32) - 1
# A camera as those of `transforms`: OpenCV's axes turned half round x.
TURN = [[1, 0, 0], [0, -1, 0], [0, 0, -1]]


def _view(number: int, pose: int, intrinsic: int = 0) -> dict[str, Any]:
    data = {"local_path": "", "filename": f"{number}.png", "width": WIDTH, "height": HEIGHT}
    data |= {"id_view": number, "id_intrinsic": intrinsic, "id_pose": pose}
    wrapper = {"id": FIRST + number + 1, "data": data}
    return {"key": number, "value": {"polymorphic_id": 1 << 30, "ptr_wrapper": wrapper}}


def _intrinsic(key: int, kind: dict[str, Any], more: dict[str, Any]) -> dict[str, Any]:
    data = {"width": WIDTH, "height": HEIGHT, "focal_length": 50.0, "principal_point": [24.0, 16.0]}
    return {"key": key, "value": {**kind, "ptr_wrapper": {"id": FIRST + 9, "data": data | more}}}


def _named(name: str, number: int = 1) -> dict[str, Any]:
    return {"polymorphic_id": FIRST + number, "polymorphic_name": name}


def _document(intrinsics: list[dict[str, Any]] | None = None) -> dict[str, Any]:
    return {
        "sfm_data_version": "0.3",
        "root_path": "/home/somebody/pictures",
        "views": [*(_view(k, k + 4) for k in range(3)), _view(3, UNDEFINED)],
        "intrinsics": intrinsics or [_intrinsic(0, _named("pinhole"), {})],
        "extrinsics": [
            {"key": k + 4, "value": {"rotation": TURN, "center": [k, 0, 0]}} for k in range(3)
        ],
        "structure": [],
        "control_points": [],
    }


def write_openmvg(folder: Path, document: Any = None) -> Path:
    """A folder of pictures with the file in a folder beside them."""
    write_pictures(folder / "images")
    (folder / "reconstruction").mkdir(exist_ok=True)
    path = folder / "reconstruction" / "sfm_data.json"
    path.write_text(json.dumps(document or _document()))
    return path.parent


def test_poses_and_cameras_are_those_of_transforms_json(tmp_path: Path) -> None:
    middle = {"fl_x": 50.0, "fl_y": 50.0, "cx": 24.5, "cy": 16.5}
    wanted = read_views(write_transforms(tmp_path / "wanted", transforms() | middle), unit="cm")
    found = read_views(write_openmvg(tmp_path / "tour"), unit="cm")
    same_views(found.views, wanted.views)
    assert found.description == "OpenMVG model, 3 pictures, up unknown"
    (problem,) = found.problems
    assert "3.png has no pose: it was not registered; left out" in problem


@pytest.mark.parametrize(
    ("kind", "more", "distortion", "radial", "tangential"),
    [
        ("pinhole_radial_k1", {"disto_k1": [0.1]}, "polynomial", (0.1, 0, 0, 0), (0, 0)),
        ("pinhole_radial_k3", {"disto_k3": [1, 2, 3]}, "polynomial", (1, 2, 3, 0), (0, 0)),
        ("pinhole_brown_t2", {"disto_t2": [1, 2, 3, 4, 5]}, "polynomial", (1, 2, 3, 0), (4, 5)),
        ("fisheye", {"fisheye": [1, 2, 3, 4]}, "fisheye", (1, 2, 3, 4), (0, 0)),
    ],
)
def test_kinds_of_cameras_are_known_by_name_and_then_by_number(
    tmp_path: Path,
    kind: str,
    more: dict[str, Any],
    distortion: str,
    radial: tuple[float, ...],
    tangential: tuple[float, ...],
) -> None:
    first, same = _intrinsic(7, _named(kind, 2), more), _intrinsic(0, {"polymorphic_id": 2}, more)
    folder = write_openmvg(tmp_path, _document([_intrinsic(5, _named("pinhole"), {}), first, same]))
    (picture, *_) = read_poses(folder / "sfm_data.json", PoseOptions()).pictures
    found = picture.intrinsics
    assert found.distortion is Distortion(distortion)
    assert (found.radial, found.tangential) == (radial, tangential)


def test_what_all_cameras_have_may_stand_one_level_down(tmp_path: Path) -> None:
    camera = _intrinsic(0, _named("pinhole_radial_k1"), {"disto_k1": [0.0]})
    data = camera["value"]["ptr_wrapper"]["data"]
    data["value0"] = {key: data.pop(key) for key in ("focal_length", "principal_point")}
    assert len(read_views(write_openmvg(tmp_path, _document([camera]))).views) == 3


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('"views"', '"looks"', r"sfm_data\.json: no 'views'"),
        ('"pinhole"', '"spherical"', r"intrinsic 0: .*'spherical', not one of pinhole,"),
        ('"id_intrinsic": 0', '"id_intrinsic": 8', r"view 0 \('0\.png'\): there is no intrinsic 8"),
        ("[24.0, 16.0]", "[24.0]", r"intrinsic 0: principal_point: not 2 finite numbers"),
        ('"center": [1, 0, 0]', '"center": [1, 0]', r"view 1 \('1\.png'\): center: not 3 finite"),
        ("[[1, 0, 0]", "[[2, 0, 0]", r"view 0 \('0\.png'\): .*the rotation is not one"),
        ('"data"', '"date"', r"a view: no 'data'"),
        ("{", "[", r"sfm_data\.json:1:\d+: not JSON"),
    ],
)
def test_faults_are_named_with_their_place(tmp_path: Path, old: str, new: str, says: str) -> None:
    folder = write_openmvg(tmp_path)
    text = (folder / "sfm_data.json").read_text()
    assert old in text
    (folder / "sfm_data.json").write_text(text.replace(old, new))
    with pytest.raises(InputError, match=says):
        read_views(folder)


def test_the_binary_form_is_named_with_the_way_to_json(tmp_path: Path) -> None:
    (write_pictures(tmp_path) / "sfm_data.bin").write_bytes(b"")
    with pytest.raises(InputError, match=r"write it by openMVG_main_ConvertSfM_DataFormat"):
        read_views(tmp_path)
