"""What a poses file may name: pictures in its own folder; all else only if it is trusted."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from facetlog.cli import main
from facetlog.errors import InputError
from facetlog.perception.reading.follow_views import FollowedViews
from facetlog.perception.reading.own_folder import OutsideError
from facetlog.perception.reading.read_views import read_views
from tests.perception.reading.view_folders import POSES, transforms, write_tour, write_transforms


def _absolute(folder: Path, elsewhere: Path) -> str:
    del folder
    return str(elsewhere / "images" / "0.png")


def _upwards(folder: Path, elsewhere: Path) -> str:
    del folder
    return f"../{elsewhere.name}/images/0.png"


def _down_and_up(folder: Path, elsewhere: Path) -> str:
    del folder
    return f"images/../../{elsewhere.name}/images/0.png"


def _by_a_link(folder: Path, elsewhere: Path) -> str:
    (folder / "images" / "link.png").symlink_to(elsewhere / "images" / "0.png")
    return "images/link.png"


def _by_a_linked_folder(folder: Path, elsewhere: Path) -> str:
    (folder / "linked").symlink_to(elsewhere, target_is_directory=True)
    return "linked/images/0"  # the extension is found


def _that_is_not_there(folder: Path, elsewhere: Path) -> str:
    del folder
    return f"../{elsewhere.name}/absent.png"


LEAD_OUTSIDE = (
    *(_absolute, _upwards, _down_and_up, _by_a_link, _by_a_linked_folder),
    _that_is_not_there,
)
Naming = Callable[[Path, Path], str]


def _document(**changes: Any) -> dict[str, Any]:
    document = transforms()
    document["frames"][1] |= changes
    return document


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_transforms(tmp_path / "elsewhere")
    return write_transforms(tmp_path / "views")


def _name(folder: Path, name: str) -> None:
    write_transforms(folder, _document(file_path=name))


@pytest.mark.parametrize("naming", LEAD_OUTSIDE)
def test_a_picture_outside_of_the_folder_is_refused_before_any_is_read(
    naming: Naming, folder: Path
) -> None:
    _name(folder, name := naming(folder, folder.parent / "elsewhere"))
    seen: list[object] = []
    with pytest.raises(OutsideError) as told:
        read_views(folder, progress=lambda *step: seen.append(step))
    said = str(told.value)
    assert said.startswith(f"{folder}/transforms.json: picture {name!r} is outside of {folder}: ")
    assert said.endswith("or trust the poses file (--trust, trust=True) if it is your own")
    assert "\n" not in said
    assert seen == []


@pytest.mark.parametrize("naming", LEAD_OUTSIDE[:-1])
def test_a_trusted_file_may_name_any_picture(naming: Naming, folder: Path) -> None:
    _name(folder, naming(folder, folder.parent / "elsewhere"))
    assert len(read_views(folder, trusted=True).views) == 3


@pytest.mark.parametrize("naming", LEAD_OUTSIDE)
def test_a_followed_folder_is_held_to_the_same(naming: Naming, folder: Path) -> None:
    _name(folder, naming(folder, folder.parent / "elsewhere"))
    views = iter(FollowedViews(folder, timeout=0.0))
    next(views)
    with pytest.raises(OutsideError, match=r"trust the poses file \(--trust, trust=True\)"):
        next(views)
    if naming is not _that_is_not_there:
        assert len(list(FollowedViews(folder, trusted=True, timeout=0.0))) == 3


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
    (folder / "images" / "link.png").symlink_to("0.png")
    _name(folder, "images/../images/link.png")
    assert len(read_views(folder).views) == 3
    (tmp_path / "linked").symlink_to(folder, target_is_directory=True)
    assert len(read_views(tmp_path / "linked").views) == 3
    (tmp_path / "linked.json").symlink_to(folder / "transforms.json")
    with pytest.raises(InputError, match=r"0\.png is missing"):  # they are named beside the link
        read_views(tmp_path / "linked.json")


def test_a_loop_of_links_is_a_picture_that_cannot_be_read(folder: Path) -> None:
    (folder / "loop.png").symlink_to("loop.png")
    _name(folder, "loop.png")
    views = read_views(folder)
    assert len(views.views) == 2
    assert len(views.problems) == 1


@pytest.mark.parametrize("camera", [0, "/dev/video0", "rtsp://10.0.0.1/x", "file:///etc/passwd"])
def test_a_camera_is_opened_only_for_a_trusted_file(camera: object, folder: Path) -> None:
    write_transforms(folder, {**transforms(), "video": camera})
    with pytest.raises(OutsideError, match=f"camera {camera} is opened only if"):
        next(iter(FollowedViews(folder, timeout=0.0)))


def test_a_video_outside_of_the_folder_is_refused(folder: Path) -> None:
    write_transforms(folder, {**transforms(), "video": "../elsewhere/walk.mp4"})
    with pytest.raises(OutsideError, match=r"video '.*/\.\./elsewhere/walk\.mp4' is outside of"):
        read_views(folder)


def test_a_tour_is_held_to_the_same(tmp_path: Path) -> None:
    write_tour(tmp_path / "elsewhere")
    write_tour(tmp_path / "tour", POSES.replace("1.png", "../elsewhere/1.png"))
    with pytest.raises(OutsideError, match=r"picture '\.\./elsewhere/1\.png' is outside"):
        read_views(tmp_path / "tour")
    assert len(read_views(tmp_path / "tour", trusted=True).views) == 2


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
