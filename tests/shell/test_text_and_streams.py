"""Names that are no text, encodings that lack letters, closed streams: no traceback."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from facetlog.cli import main
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
from facetlog.perception.surfaces.scene_file import read_scene, write_scene
from facetlog.plain_text import ESCAPED, plain_text

NAME = os.fsdecode(b"b\xffx")
SHOWN = r"b\xffx"
MODEL = 'model a\n  "A thing."\n  face f\n  level: f is level\n'


@pytest.fixture
def folder(tmp_path):
    try:
        (tmp_path / NAME).mkdir()
    except OSError:
        pytest.skip("this file system takes no names but of text")
    write_scene(cuboid(), tmp_path / NAME / "scene.json")
    write_scene(cuboid(), tmp_path / f"{NAME}.json")
    (tmp_path / f"{NAME}.model").write_text(MODEL)
    return tmp_path


def _run(
    folder: Path, *argv: str, first: str = "", **environment: str
) -> subprocess.CompletedProcess[bytes]:
    paths = os.pathsep.join(path for path in sys.path if path)
    command = [sys.executable, "-m", "facetlog", *argv]
    if first:
        command = ["sh", "-c", f'{first} exec "$@"', "sh", *command]
    done = subprocess.run(
        command,
        cwd=folder,
        capture_output=True,
        check=False,
        env={**os.environ, "PYTHONPATH": paths, **environment},
    )
    assert b"Traceback" not in done.stderr, done.stderr
    return done


@pytest.mark.parametrize(
    ("argv", "code"),
    [
        (("scene", "show", f"{NAME}.json"), 0),
        (("scene", "convert", f"{NAME}.json", f"{NAME}.ply"), 0),
        (("query", NAME, "face(F)", "--html", f"{NAME}.html"), 0),
        (("why", f"{NAME}.json", "box", "--json"), 0),
        (("classify", NAME, f"{NAME}.json", "--workers", "1", "--html", f"{NAME}.d"), 0),
        (("model", "check", f"{NAME}.model", "--output", "sarif"), 0),
        (("model", "compile", f"{NAME}.model", "-o", f"{NAME}.pl"), 0),
        (("recognize", NAME), 0),
        (("model", "check", f"{NAME}.absent.model"), 2),
    ],
)
@pytest.mark.slow
def test_names_that_are_no_text_are_names(argv, code, folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    monkeypatch.setattr("sys.argv", ["facetlog", *argv])
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(errors=ESCAPED)  # type: ignore[union-attr] # as open_streams does
    assert main(argv) == code
    assert "Traceback" not in capsys.readouterr().err
    for path in folder.rglob("*"):
        if path.suffix in (".pl", ".html"):
            path.read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_scene_is_called_by_its_name_escaped(folder):
    assert plain_text(NAME) == SHOWN
    write_scene(replace(cuboid(), name=NAME, warnings=(NAME, "\ud800")), folder / "s.json")
    assert read_scene(folder / "s.json").name == SHOWN
    assert read_scene(folder / "s.json").warnings == (SHOWN, r"\ud800")
    done = _run(folder, "classify", f"{NAME}.json", "--workers", "1", "--json")
    assert json.loads(done.stdout)["path"] == f"{SHOWN}.json"


@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
def test_what_an_encoding_lacks_is_replaced(encoding, folder):
    goal = 'X = "25 ± 1 → ü"'
    done = _run(folder, "query", f"{NAME}.json", goal, PYTHONIOENCODING=encoding)
    assert done.returncode == 0
    assert done.stdout


@pytest.mark.parametrize("closed", [">&-", "<&- >&- 2>&-"])
@pytest.mark.slow
def test_closed_streams_are_no_files_that_are_opened_later(closed, folder):
    page = folder / "page.html"
    done = _run(folder, "why", f"{NAME}.json", "box", "--html", page.name, first=f"exec {closed};")
    assert done.returncode == 0
    assert page.read_text(encoding="utf-8").startswith("<!doctype html>")
    assert page.read_text(encoding="utf-8").rstrip().endswith("</html>")


def test_a_current_folder_that_was_removed_is_one_line(folder):
    (folder / "gone").mkdir()
    done = _run(
        folder, "query", str(folder / f"{NAME}.json"), "box(T)", first='cd gone; rmdir "$PWD";'
    )
    assert done.returncode == 2
    assert done.stderr.decode().splitlines()[-1] == (
        "facetlog: the current folder was removed: change to one that exists"
    )
