"""Names of scenes, files, labels and models never steer a terminal, nor a report.

Whatever prints is asked about names with control characters, and none comes out.
"""

import os
import re
from dataclasses import replace
from pathlib import Path

import pytest

from facetlog.cli import main
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid, table
from facetlog.perception.surfaces.scene_file import write_scene
from tests.perception.reading.view_folders import transforms, write_transforms

# A title, a bell, the 8-bit form of an escape, a carriage return, a new line, a delete, and what
# turns the direction of writing. Not only sequences that a terminal would understand: those are
# left out where standard output is none.
EVIL = "e\x1b]0;t\x07v\x9b31mi\u202el\nX\r\x7f"
STEERS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
RULES = r"""
:- module(slab, []).
:- use_module(facetlog(vocabulary)).
model(slab, "A \e[31m level \x9b\ board.\nX\a", [board]).
candidate(slab, Thing, [Board]) :- face_of(Thing, Board).
condition(slab, flat, "it \e[31m lies\n \a level", _, [Board], at_most(tilt(Board), 5)).
"""


@pytest.fixture
def says(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    scene = replace(cuboid(), name=EVIL, warnings=(EVIL,))
    write_scene(scene, Path("scene.json"))
    write_scene(scene, Path(f"{EVIL}.json"))
    write_scene(table(), Path("table.json"))
    Path(f"bad{EVIL}.json").write_text("{")
    Path("slab.pl").write_text(RULES)
    Path(f"{EVIL}.model").write_text("model slab\n  part top\n  bogus\n")

    def run(*argv: str) -> tuple[int, str, str]:
        code = main(argv)
        out, err = capsys.readouterr()
        for said in (out, err):
            assert not STEERS.search(said), ascii(said)
        assert "Traceback" not in err
        return code, out, err

    return run


def test_questions_print_no_control_characters(says):
    code, out, _ = says("query", "scene.json", "scene(N)")
    assert code == 0
    assert "]0;t" in out
    for goal in (r'X = "\e[31m\n\a"', r"X = f('\e[31m\a')", r"X = ['\a', \"\x202e\\\"]"):
        says("query", "scene.json", goal)
    says("query", f"{EVIL}.json", "scene(N)")
    says("query", "scene.json", EVIL)
    assert says("query", "scene.json", r"V = '\e[31m\a', atom_length(a, V)")[0] == 2


@pytest.mark.slow
def test_explanations_print_no_control_characters(says):
    for command in ("why", "why-not"):
        assert says(command, f"{EVIL}.json", "box")[0] in (0, 1)
        says(command, "scene.json", EVIL)
        says(command, "scene.json", "box", f"{EVIL}=f1")
        for full in ((), ("--full",)) if command == "why" else ((),):
            says(command, "scene.json", "slab", "--models", "slab.pl", "--trust", *full)


def test_what_is_said_of_scenes_has_no_control_characters(says):
    for file in (f"{EVIL}.json", f"bad{EVIL}.json", EVIL):
        says("scene", "show", file)
        says("scene", "validate", file)
        says("scene", "convert", file, f"{EVIL}.ply")


@pytest.mark.slow
def test_a_batch_and_its_report_have_no_control_characters(says):
    labels = "file,label,kind\n"
    labels += f'scene.json,"la{EVIL}bel","{EVIL}"\ntable.json,box,"{EVIL}2"\n'
    Path("labels.csv").write_text(labels, newline="")
    files = (f"{EVIL}.json", f"bad{EVIL}.json", "scene.json")
    code, out, err = says("classify", *files, "--workers", "1")
    assert code == 0
    assert out.count("\n") == 3
    assert "bade ]0;t v 31mi l X" in err
    argv = ("classify", "--labels", "labels.csv", "--workers", "1")
    says(*argv, "--count-as", f"{EVIL}=box", "--report", "report.html")
    page = Path("report.html").read_text(encoding="utf-8")
    assert not STEERS.search(page)
    assert "e ]0;t v 31mi l" in page
    says(*argv, "--classes", EVIL)
    says("classify", *files, "--models", "slab.pl", "--trust", "--workers", "1", "--html", "pages")
    for path in Path("pages").iterdir():
        assert not STEERS.search(path.name)
        # What shows 3-D is a page of a library's own.
        shown = re.sub(r'srcdoc="[^"]*"', "", path.read_text(encoding="utf-8"))
        assert not STEERS.search(shown)


def test_models_print_no_control_characters(says):
    for command in ("check", "format", "compile", "test"):
        assert says("model", command, f"{EVIL}.model")[0] in (1, 2)
    says("model", "new", EVIL)
    says("classify", "scene.json", "--models", EVIL)


def test_names_of_pictures_print_no_control_characters(says):
    document = transforms()
    for name in (EVIL, f"../{EVIL}", f"images/{EVIL}.png"):
        document["frames"][0]["file_path"] = name
        folder = write_transforms(Path(EVIL.replace("/", "")), document)
        for argv in (("recognize",), ("reconstruct", "-o", "out.json")):
            says(*argv, os.fspath(folder))
