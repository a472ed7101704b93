"""Paths in poses files: pictures in its own folder; all else only if it is trusted."""

import json
from pathlib import Path

import pytest

from facetlog.cli import main
from facetlog.errors import InputError
from facetlog.perception.reading.follow_views import FollowedViews
from facetlog.perception.reading.path_guard import OutsideError
from facetlog.perception.reading.read_views import read_views
from tests.perception.reading.view_folders import POSES, transforms, write_tour, write_transforms

ABSENT = "../elsewhere/absent.png"
OUTSIDE = (
    *("{elsewhere}/images/0.png", "../elsewhere/images/0.png", ABSENT),
    *("images/../../elsewhere/images/0.png", "images/link.png"),
    "linked/images/0",  # the extension is found
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder of views, with links to another one."""
    elsewhere = write_transforms(tmp_path / "elsewhere")
    folder = write_transforms(tmp_path / "views")
    (folder / "images" / "link.png").symlink_to(elsewhere / "images" / "0.png")
    (folder / "linked").symlink_to(elsewhere, target_is_directory=True)
    return folder


def _name(folder: Path, name: str) -> str:
    """Let the second frame have this name, and return it."""
    document = transforms()
    name = name.format(elsewhere=folder.parent / "elsewhere")
    document["frames"][1]["file_path"] = name
    write_transforms(folder, document)
    return name


@pytest.mark.parametrize("outside", OUTSIDE)
def test_a_picture_outside_of_the_folder_is_refused_before_any_is_read(
    outside: str, folder: Path
) -> None:
    name = _name(folder, outside)
    seen: list[object] = []
    with pytest.raises(OutsideError) as told:
        read_views(folder, progress=lambda *step: seen.append(step))
    said = str(told.value)
    assert said.startswith(f"{folder}/transforms.json: picture {name!r} is outside of {folder}: ")
    assert said.endswith("or trust the poses file (--trust, trust=True) if it is your own")
    assert "\n" not in said
    assert seen == []
    if outside != ABSENT:
        assert len(read_views(folder, trusted=True).views) == 3


def test_a_picture_that_becomes_a_link_while_its_folder_is_filled_is_not_followed(
    folder: Path,
) -> None:
    picture = folder / "images" / "1.png"
    views = iter(FollowedViews(folder, timeout=0.0))
    next(views)
    picture.unlink()
    picture.symlink_to(folder.parent / "elsewhere" / "images" / "1.png")
    with pytest.raises(OutsideError):
        next(views)


def test_names_and_links_that_stay_in_the_folder_are_read(folder: Path, tmp_path: Path) -> None:
    (folder / "images" / "inside.png").symlink_to("0.png")
    _name(folder, "images/../images/inside.png")
    assert len(read_views(folder).views) == 3
    (tmp_path / "linked").symlink_to(folder, target_is_directory=True)
    assert len(read_views(tmp_path / "linked").views) == 3
    (tmp_path / "linked.json").symlink_to(folder / "transforms.json")
    with pytest.raises(InputError, match=r"0\.png is missing"):  # they are named beside the link
        read_views(tmp_path / "linked.json")


@pytest.mark.parametrize("camera", [0, "/dev/video0", "rtsp://10.0.0.1/x", "file:///etc/passwd"])
def test_a_camera_is_opened_only_for_a_trusted_file(camera: object, folder: Path) -> None:
    write_transforms(folder, {**transforms(), "video": camera})
    with pytest.raises(OutsideError, match=f"camera {camera} is opened only if"):
        next(iter(FollowedViews(folder, timeout=0.0)))


def test_a_video_outside_of_the_folder_is_refused(folder: Path) -> None:
    write_transforms(folder, {**transforms(), "video": "../elsewhere/walk.mp4"})
    with pytest.raises(OutsideError, match=r"video '.*/\.\./elsewhere/walk\.mp4' is outside of"):
        read_views(folder)


@pytest.mark.parametrize(
    "command",
    [
        ("recognize",),
        ("recognize", "--follow", "--timeout", "0"),
        ("reconstruct", "-o", "scene.json"),
    ],
)
def test_every_command_that_reads_pictures_refuses_in_one_line_and_takes_trust(
    command: tuple[str, ...],
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(folder.parent)
    document = transforms()
    document["frames"][0]["file_path"] = "../elsewhere/images/0.png"
    (folder / "transforms.json").write_text(json.dumps(document))
    assert main([*command, "views"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert err.startswith("facetlog: views/transforms.json: picture '../elsewhere/images/0.png'")
    main([*command, "views", "--trust"])
    assert "outside" not in capsys.readouterr().err


@pytest.mark.parametrize("outside", OUTSIDE)
def test_a_followed_folder_is_held_to_the_same(outside: str, folder: Path) -> None:
    _name(folder, outside)
    views = iter(FollowedViews(folder, timeout=0.0))
    next(views)
    with pytest.raises(OutsideError, match=r"trust the poses file \(--trust, trust=True\)"):
        next(views)
    if outside != ABSENT:
        assert len(list(FollowedViews(folder, trusted=True, timeout=0.0))) == 3


def test_a_tour_is_held_to_the_same(tmp_path: Path) -> None:
    write_tour(tmp_path / "elsewhere")
    write_tour(tmp_path / "tour", POSES.replace("1.png", "../elsewhere/1.png"))
    with pytest.raises(OutsideError, match=r"picture '\.\./elsewhere/1\.png' is outside"):
        read_views(tmp_path / "tour")
    assert len(read_views(tmp_path / "tour", trusted=True).views) == 2
