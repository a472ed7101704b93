"""Pictures under names that another machine wrote: found where that is sure, and named."""

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


def test_a_frame_that_is_there_twice_is_used_once_and_named(tmp_path: Path) -> None:
    document = transforms()
    document["frames"].append(dict(document["frames"][1], file_path="./images/1.png"))
    found = read_views(write_transforms(tmp_path, document))
    assert len(found.views) == 3
    assert any("images/1.png twice" in line for line in found.problems)
    document["frames"][3]["transform_matrix"] = document["frames"][2]["transform_matrix"]
    with pytest.raises(InputError, match="has two poses"):
        read_views(write_transforms(tmp_path, document))
