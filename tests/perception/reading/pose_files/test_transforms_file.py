"""Variants of transforms.json, and pictures under names that another machine wrote."""

from pathlib import Path

import pytest

from facetlog.errors import InputError
from facetlog.perception.reading.read_views import read_views
from tests.perception.reading.pose_files.pose_folders import same_views
from tests.perception.reading.view_folders import (
    colmap_rows,
    transforms,
    write_colmap_binary,
    write_colmap_text,
    write_pictures,
    write_transforms,
)


def test_is_fisheye_is_opencvs_fisheye(tmp_path: Path) -> None:
    lens = {"k1": 0.05, "k2": 0.01, "k3": 0.0, "k4": 0.0}
    plain = {key: value for key, value in transforms().items() if key != "camera_model"} | lens
    wanted = write_transforms(tmp_path / "a", plain | {"camera_model": "OPENCV_FISHEYE"})
    found = write_transforms(tmp_path / "b", plain | {"is_fisheye": True})
    same_views(read_views(found).views, read_views(wanted).views)
    other = write_transforms(tmp_path / "c", plain | {"is_fisheye": False})
    camera = write_transforms(tmp_path / "d", plain | {"camera_model": "OPENCV"})
    same_views(read_views(other).views, read_views(camera).views)


@pytest.mark.parametrize("start", ["/home/ann/scan/images", "C:\\scans\\images", "D:/x/images"])
def test_absolute_paths_of_another_machine_are_found_by_their_ends(
    start: str, tmp_path: Path
) -> None:
    document = transforms()
    slash = "\\" if "\\" in start else "/"
    for k, frame in enumerate(document["frames"]):
        frame["file_path"] = f"{start}{slash}{k}.png"
    found = read_views(write_transforms(tmp_path / "a", document))
    same_views(found.views, read_views(write_transforms(tmp_path / "b")).views)
    (note,) = found.problems
    assert "0.png" in note
    assert "below" in note


def test_of_two_files_of_a_name_that_with_the_same_folder_is_meant(tmp_path: Path) -> None:
    folder = write_transforms(tmp_path)
    write_pictures(folder / "thumbnails")
    document = transforms()
    for k, frame in enumerate(document["frames"]):
        frame["file_path"] = f"/elsewhere/images/{k}.png"
    write_transforms(tmp_path, document)
    assert len(read_views(folder).views) == 3
    for k, frame in enumerate(document["frames"]):
        frame["file_path"] = f"/elsewhere/pictures/{k}.png"
    write_transforms(tmp_path, document)
    with pytest.raises(InputError, match="outside of"):
        read_views(folder)


@pytest.mark.parametrize("write", [write_colmap_text, write_colmap_binary])
def test_colmaps_names_may_have_backslashes(write: object, tmp_path: Path) -> None:
    rows = [(f"left\\{name}", pose) for name, pose in colmap_rows()]
    assert callable(write)
    write(tmp_path / "sparse" / "0", rows)
    write_pictures(tmp_path / "images" / "left")
    assert len(read_views(tmp_path).views) == 3
