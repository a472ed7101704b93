"""`facetlog query`, `why` and `why-not`: exit codes, streams, JSON."""

import io
import json
import re

import pytest
import trimesh

from facetlog.cli import main
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
from facetlog.perception.surfaces.scene_file import write_scene


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return


@pytest.fixture
def scene(tmp_path):
    write_scene(cuboid(0.3, 0.2, 0.1), tmp_path / "scene.json")
    return str(tmp_path / "scene.json")


@pytest.mark.parametrize(
    ("goal", "code", "out"),
    [
        ("face(f1)", 0, "yes\n"),
        ("face(f99)", 1, "no\n"),
        ("angel(X)", 2, ""),
    ],
)
def test_the_exit_code_says_what_came_of_a_goal(goal, code, out, scene, capsys):
    assert main(["query", scene, goal]) == code
    assert capsys.readouterr().out == out


@pytest.mark.slow
def test_up_and_unit_of_a_mesh_are_stated_where_it_is_asked(tmp_path, capsys):
    mesh = str(tmp_path / "t.stl")
    legs = [((x, y, 0.0), (x + 5.0, y + 5.0, 70.0)) for x in (0.0, 115.0) for y in (0.0, 75.0)]
    boxes = [*legs, ((0.0, 0.0, 70.0), (120.0, 80.0, 73.0))]
    made = [trimesh.creation.box(bounds=bounds) for bounds in boxes]
    trimesh.util.concatenate(made).export(mesh)
    assert main(["why", mesh, "table"]) == 1
    out, err = capsys.readouterr()
    assert "table is unknown" in out
    assert "--up z (or another axis) says which way is up\n" in err
    assert main(["why", mesh, "table", "--up", "z", "--unit", "cm"]) == 0
    out, err = capsys.readouterr()
    assert "length 1.2 m" in out
    assert "--up" not in err
    assert main(["why", mesh, "box", "--up", "z"]) == 1
    assert f"facetlog why-not --up=z {mesh} box shows" in capsys.readouterr().err
    assert main(["why-not", "--up=z", mesh, "box", "--count", "1"]) == 0
    assert main(["query", mesh, "piece_on_ground(P)"]) == 1
    assert main(["query", mesh, "--up", "z", "piece_on_ground(P)"]) == 0
    assert main(["query", mesh, "--up", "w", "face(F)"]) == 2
    assert "--up 'w': use one of" in capsys.readouterr().err


def test_goals_come_from_standard_input(scene, monkeypatch, capsys):
    monkeypatch.setattr("sys.stdin", io.StringIO("face(F).\nfoo(X)\nwhy box\n"))
    assert main(["query", scene, "--json", "--limit", "1"]) == 2
    out, err = capsys.readouterr()
    first, fault, why = map(json.loads, out.splitlines())
    assert first["rows"] == [["f1"]]
    assert "foo/1" in fault["error"]["message"]
    assert why["verdict"]["model"] == "box"
    assert "line 2: foo/1" in err


@pytest.mark.parametrize(
    "arguments",
    [
        ["absent.json"],
        ["face(F)"],
        ["SCENE", "--timeout", "0", "face(F)"],
        ["SCENE", "--models", "absent.pl", "face(F)"],
    ],
)
def test_a_question_that_cannot_be_asked_is_one_line(arguments, scene, capsys):
    assert main(["query", *(scene if a == "SCENE" else a for a in arguments)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("facetlog: ")
    assert err.count("\n") == 1


def test_why_ends_with_whether_it_holds(scene, capsys):
    assert main(["why", scene, "box", "a=f1"]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("t1 is a box")
    assert err == "facetlog: --full shows all of it\n"
    assert main(["why", scene, "table"]) == 1
    out, err = capsys.readouterr()
    assert "table" in out.splitlines()[0]
    assert f"facetlog why-not {scene} table" in err


def test_why_says_whether_one_belongs_to_a_set(scene, capsys):
    assert main(["why", scene, "table", "leg=f1", "--json"]) == 1
    (asked,) = json.loads(capsys.readouterr().out)["verdict"]["asked"]
    assert (asked["role"], asked["name"], asked["state"]) == ("leg", "f1", "fails")
    assert main(["why", scene, "table", "leg=f1"]) == 1
    assert capsys.readouterr().out.startswith(asked["text"].partition(" (")[0])
    assert main(["why-not", scene, "table", "leg=f1"]) == 2
    assert "leg is a set" in capsys.readouterr().err


def test_why_in_full_goes_down_to_the_vertices(scene, capsys):
    assert main(["why", scene, "box", "--full"]) == 0
    text = capsys.readouterr().out
    assert "v1" in text
    assert re.search(r" \[box\.model:\d+: each pair x, y of a, b, c: ", text)
    assert main(["why", scene, "box"]) == 0
    brief = capsys.readouterr().out
    assert "each pair x, y" not in brief
    assert max(map(len, brief.splitlines())) <= 100
    assert main(["why", scene, "box", "--json"]) == 0
    short = json.loads(capsys.readouterr().out)
    assert not any("proof" in condition for condition in short["verdict"]["conditions"])
    assert main(["why", scene, "box", "--full", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["schema"] == "facetlog-why/2"
    assert all("proof" in condition for condition in found["verdict"]["conditions"])
    faces = [face for part in found["verdict"]["parts"].values() for face in part]
    assert sorted(found["origins"]) == sorted(faces)


def test_near_misses_are_counted(scene, capsys):
    assert main(["why-not", scene, "table", "--json", "--count", "2"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["schema"], found["model"]) == ("facetlog-why-not/2", "table")
    assert 1 <= len(found["near_misses"]) <= 2
    assert main(["why-not", scene, "table", "--count", "1"]) == 0
    brief = capsys.readouterr().out
    assert main(["why-not", scene, "table", "--count", "1", "--full"]) == 0
    whole = capsys.readouterr().out
    assert len(whole) > len(brief)
    assert re.search(r"table.model:\d+: top is measured", whole)
    assert "top is measured" not in brief


@pytest.mark.parametrize(
    "arguments",
    [
        ["bx"],
        ["box", "nose=f1"],
        ["box", "--thing", "t99"],
        ["box", "--models", "absent.pl"],
    ],
)
@pytest.mark.parametrize("command", ["why", "why-not"])
def test_reasons_for_what_there_is_not_are_refused_in_one_line(command, arguments, scene, capsys):
    assert main([command, scene, *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1


def test_where_a_name_or_fact_comes_from(scene, capsys):
    for about in ("f1", "e1", "v1", "t1", "angle(f1, f2)"):
        assert main(["why", scene, about]) == 0
        assert capsys.readouterr().out.startswith(about.rstrip(")"))
    assert main(["why", scene, "t1"]) == 0
    brief, note = capsys.readouterr()
    assert "--full" in note
    assert main(["why", scene, "t1", "--full"]) == 0
    assert len(capsys.readouterr().out) > len(brief)
    assert main(["why", scene, "f1", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["schema"] == "facetlog-origin/1"


def test_reasons_and_answers_are_pages_as_well(scene, tmp_path, capsys):
    page = tmp_path / "page.html"
    assert main(["why", scene, "box", "--html", str(page)]) == 0
    assert re.search(r"<h1>t1 is a box \(.*\d+%\)</h1>", page.read_text(encoding="utf-8"))
    assert main(["why-not", scene, "chair", "--count", "2", "--html", str(page)]) == 0
    text = page.read_text(encoding="utf-8")
    assert 1 <= text.count('<details class="verdict ') <= 2
    assert "<iframe" in text
    assert (
        main(["query", scene, "face(F), area(F, A, _)", "--limit", "2", "--html", str(page)]) == 0
    )
    text = page.read_text(encoding="utf-8")
    assert text.count("<tr>") == 3
    assert '<th scope="col">A (cm²)</th>' in text
    assert main(["query", scene, "face(f99)", "--html", str(page)]) == 1
    assert re.search(r"<td>\s*no\s*</td>", page.read_text(encoding="utf-8"))
    capsys.readouterr()


@pytest.mark.parametrize(
    ("argv", "says"),
    [
        (["query", "SCENE", "--html", "a.html"], "of one scene and one goal"),
        (["query", "SCENE", "SCENE", "face(F)", "--html", "a.html"], "of one scene and one goal"),
        (["query", "SCENE", "face(F). edge(E).", "--html", "a.html"], "of one scene and one goal"),
        (["why", "SCENE", "box", "--html", "a.json"], "what can be written is .html"),
        (["why", "SCENE", "f1", "--html", "a.html"], "a.html was not written"),
    ],
)
def test_what_is_no_page_is_said(argv, says, scene, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    main([scene if word == "SCENE" else word for word in argv])
    assert says in capsys.readouterr().err
    assert not list(tmp_path.glob("*.html"))
