"""Model files among the model paths of the other commands."""

import json
from pathlib import Path

import pytest

from facetlog.cli import main
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
from facetlog.perception.surfaces.scene_file import write_scene
from facetlog.query_shell.session import Session

SLAB = """model slab
  face top
  level: top is level, top is upward                "it lies level"
  thin: height(this) at most 20 % of length(this)   "it is thin"
"""


@pytest.fixture(autouse=True)
def in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "slab.model").write_text(SLAB)
    write_scene(cuboid(0.8, 0.5, 0.05), tmp_path / "flat.json")
    write_scene(cuboid(0.8, 0.5, 0.5), tmp_path / "thick.json")


@pytest.mark.parametrize("path", ["models", "models/slab.model"])
@pytest.mark.slow
def test_why_and_why_not_explain_by_a_model_file(
    path: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["why", "flat.json", "slab", "--models", path]) == 0
    assert "+ thin: it is thin" in capsys.readouterr().out
    assert main(["why-not", "thick.json", "slab", "--models", path, "--json"]) == 0
    (miss, *_) = json.loads(capsys.readouterr().out)["near_misses"]
    assert [short["label"] for short in miss["shortfalls"]] == ["thin"]


def test_questions_ask_a_model_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["query", "flat.json", "--models", "models", "is_a(T, slab)"]) == 0
    assert "t1" in capsys.readouterr().out


def test_the_faults_of_a_model_file_are_told_before_any_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = SLAB.replace("level,", "levle,").replace("height", "hieght")
    (tmp_path / "models" / "slab.model").write_text(text)
    assert main(["demo", "--models", "models"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert [line.split(": ")[1].split("/")[-1] for line in err.splitlines()] == [
        "slab.model:3:17",
        "slab.model:4:9",
    ]


def test_a_folder_without_models_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "empty").mkdir()
    assert main(["why", "flat.json", "box", "--models", "empty"]) == 2
    assert "has no .model or .pl files" in capsys.readouterr().err


def test_a_session_loads_a_changed_model_file_again(tmp_path: Path) -> None:
    path = tmp_path / "models" / "slab.model"
    plank = tmp_path / "models" / "plank.model"
    plank.write_text('use "slab.model"\nmodel plank is slab\n  long: width(this) at most 0.3 m\n')
    with Session() as session:
        (scene,) = session.load_scenes([tmp_path / "flat.json"])
        assert session.load_models([plank]) == ("plank",)
        assert session.changed_models() == ()
        assert len(session.base.why(scene.name, "plank").conditions) == 3
        path.write_text(SLAB.split("  thin")[0])
        (line,) = session.changed_models()
        assert "slab.model, which " in line
        assert len(session.base.why(scene.name, "plank").conditions) == 2
        path.write_text(SLAB.replace("thin:", "thin"))
        (line,) = session.changed_models()
        assert "the version before stays in force" in line
        assert session.changed_models() == ()
        assert len(session.base.why(scene.name, "plank").conditions) == 2


def test_the_prompt_loads_a_folder_of_model_files(tmp_path: Path) -> None:
    with Session() as session:
        assert session.load(tmp_path / "models") == "loaded the models slab"
