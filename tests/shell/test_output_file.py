"""No command writes over what it reads, nor over a file of others unless it is asked to."""

import os
from pathlib import Path

import pytest

from facetlog.cli import main
from facetlog.errors import InputError
from facetlog.output_file import OWN_PAGE, OWN_SCENE, check_distinct, check_output_file
from facetlog.output_folder import check_replaceable, output_folder
from facetlog.perception.atomic_write import write_atomically
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
from facetlog.perception.surfaces.scene_file import write_scene

FOREIGN = b"mine\n"


def _link(path: Path) -> Path:
    (path.parent / "link").symlink_to(path.name)
    return path.parent / "link"


def _hard_link(path: Path) -> Path:
    os.link(path, path.parent / "hard")
    return path.parent / "hard"


def _roundabout(path: Path) -> Path:
    return path.parent / ".." / path.parent.name / path.name


@pytest.mark.parametrize("renamed", [lambda path: path, _link, _hard_link, _roundabout])
def test_an_input_is_replaced_under_no_name(renamed, tmp_path):
    given = tmp_path / "poses.json"
    given.write_bytes(FOREIGN)
    with pytest.raises(InputError, match="is what is read"):
        check_output_file(renamed(given), "-o", (given,), overwrite=True)


def test_a_file_in_a_folder_that_is_read_is_not_replaced(tmp_path):
    views = tmp_path / "views"
    (views / "images").mkdir(parents=True)
    for name in ("transforms.json", "images/a.png"):
        (views / name).write_bytes(FOREIGN)
        with pytest.raises(InputError, match=r"exists in .*views, which is read"):
            check_output_file(views / name, "-o", (views,), overwrite=True)
    check_output_file(views / "scene.json", "-o", (views,))
    write_scene(cuboid(), views / "scene.json")
    check_output_file(views / "scene.json", "-o", (views,), own=OWN_SCENE)


def test_what_is_there_is_replaced_on_request_or_if_it_is_our_own(tmp_path):
    path = tmp_path / "page.html"
    path.write_bytes(b"")  # as mktemp makes it
    check_output_file(path, "--html")
    path.write_bytes(FOREIGN)
    with pytest.raises(InputError, match="exists: give --overwrite"):
        check_output_file(path, "--html", own=OWN_PAGE)
    check_output_file(path, "--html", own=OWN_PAGE, overwrite=True)
    path.write_bytes(b"<!doctype html>" + OWN_PAGE + b' 1.0">')
    check_output_file(path, "--html", own=OWN_PAGE)


def test_a_folder_that_holds_what_is_read_is_not_replaced(tmp_path):
    run = tmp_path / "run"
    with output_folder(run, {}) as made:
        (made / "scene.json").write_text("{}")
    check_replaceable(run)
    for read in (run, run / "scene.json"):
        with pytest.raises(InputError, match=r"which is read|is what is read"):
            check_replaceable(run, "--html", (read,))


def test_two_outputs_are_not_one_file(tmp_path):
    with pytest.raises(InputError, match="both -o and --report"):
        check_distinct(
            (("-o", tmp_path / "a"), ("--html", None), ("--report", tmp_path / "." / "a"))
        )


def test_a_link_is_written_through_also_where_it_leads_nowhere_yet(tmp_path):
    (tmp_path / "file").symlink_to("target")
    for content in (b"first", b"second"):
        write_atomically(tmp_path / "file", content)
        assert (tmp_path / "file").is_symlink()
        assert (tmp_path / "target").read_bytes() == content
    (tmp_path / "folder").symlink_to("inner")
    for content in ("first", "second"):
        with output_folder(tmp_path / "folder", {}) as made:
            (made / "a").write_text(content)
        assert (tmp_path / "folder").is_symlink()
        assert (tmp_path / "inner" / "a").read_text() == content
    (tmp_path / "round").symlink_to("round")
    with pytest.raises(InputError, match="round"):
        check_output_file(tmp_path / "round", "-o")
    with pytest.raises(InputError, match="round"):
        check_replaceable(tmp_path / "round")


@pytest.mark.parametrize(
    ("argv", "target"),
    [
        (["reconstruct", "views", "-o", "views/transforms.json"], "views/transforms.json"),
        (["scene", "convert", "scene.json", "scene.json", "--overwrite"], "scene.json"),
        (["why", "scene.json", "box", "--html", "mine.html"], "mine.html"),
        (["model", "compile", "a.model", "-o", "mine.pl"], "mine.pl"),
        (["model", "new", "a"], "a.model"),
        (["mat", "-o", "mine.pdf"], "mine.pdf"),
        (["classify", "scene.json", "-o", "mine.csv"], "mine.csv"),
        (["classify", "--labels", "labels.csv", "-o", "labels.csv", "--overwrite"], "labels.csv"),
        (["classify", "--labels", "labels.csv", "--report", "mine.html"], "mine.html"),
        (["classify", "scene.json", "--html", "views"], "views/transforms.json"),
        (["recognize", "views", "-o", "views"], "views"),
        (["map", "views", "-o", "views"], "views"),
        (["record", "views", "--mcap", "mine.mcap"], "mine.mcap"),
        (
            [
                *("mount", "127.0.0.1:1", "-o", "mine.toml"),
                *("--board", "7x6", "--square", "0.1", "--marker", "0.08"),
            ],
            "mine.toml",
        ),
    ],
)
def test_no_command_replaces_what_is_not_its_own(argv, target, tmp_path, monkeypatch, capsys):
    if "--mcap" in argv:
        pytest.importorskip("rosbags", reason="MCAP is written by rosbags")
    monkeypatch.chdir(tmp_path)
    Path("views").mkdir()
    write_scene(cuboid(), Path("scene.json"))
    names = ("views/transforms.json", "mine.png", "mine.html", "mine.pl", "mine.pdf", "mine.csv")
    for name in (*names, "mine.mcap", "mine.toml"):
        Path(name).write_bytes(b"scene.json\n")
    Path("labels.csv").write_text("file,label\nscene.json,box\n")
    Path("a.model").write_text('model a\n  "A thing."\n  face f\n  level: f is level\n')
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    assert main(argv) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert Path(target).name in err
    after = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    assert after == before
