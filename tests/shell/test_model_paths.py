"""Model files among the model paths of the other commands."""

import json

import pytest

from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
from facetlog.perception.surfaces.scene_file import write_scene
from facetlog.query_shell.session import Session

SLAB = """model slab
  face top
  level: top is level, top is upward                "it lies level"
  thin: height(this) at most 20 % of length(this)   "it is thin"
"""


@pytest.fixture(autouse=True)
def models(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "slab.model").write_text(SLAB)
    write_scene(cuboid(0.8, 0.5, 0.05), tmp_path / "flat.json")
    write_scene(cuboid(0.8, 0.5, 0.5), tmp_path / "thick.json")


@pytest.mark.parametrize("path", ["models", "models/slab.model"])
@pytest.mark.slow
def test_why_and_why_not_explain_by_a_model_file(path, run):
    code, out, _ = run("why", "flat.json", "slab", "--models", path)
    assert (code, "+ thin: it is thin" in out) == (0, True)
    code, out, _ = run("why-not", "thick.json", "slab", "--models", path, "--json")
    (miss, *_) = json.loads(out)["near_misses"]
    assert (code, [short["label"] for short in miss["shortfalls"]]) == (0, ["thin"])


@pytest.mark.parametrize(
    "command", [["demo"], ["query", "flat.json", "face(F)"], ["why", "flat.json", "box"]]
)
def test_each_fault_of_a_model_file_has_its_line_before_any_work(command, run, tmp_path):
    text = SLAB.replace("level,", "levle,").replace("height", "hieght")
    (tmp_path / "models" / "slab.model").write_text(text)
    code, out, err = run(*command, "--models", "models")
    assert (code, out) == (2, "")
    places = [line.split(": ")[1].split("/")[-1] for line in err.splitlines()]
    assert places == ["slab.model:3:17", "slab.model:4:9"]


def test_a_session_loads_a_changed_model_file_again(tmp_path):
    path = tmp_path / "models" / "slab.model"
    plank = tmp_path / "models" / "plank.model"
    plank.write_text('use "slab.model"\nmodel plank is slab\n  long: width(this) at most 0.3 m\n')
    with Session() as session:
        (scene,) = session.load_scenes([tmp_path / "flat.json"])
        assert session.load_models([plank]) == ("plank",)
        assert session.reload_changed_models() == ()
        assert len(session.base.why(scene.name, "plank").conditions) == 3
        path.write_text(SLAB.split("  thin")[0])
        (line,) = session.reload_changed_models()
        assert "slab.model, which " in line
        assert len(session.base.why(scene.name, "plank").conditions) == 2
        path.write_text(SLAB.replace("thin:", "thin"))
        (line,) = session.reload_changed_models()
        assert "the version before stays in force" in line
        assert session.reload_changed_models() == ()
        assert len(session.base.why(scene.name, "plank").conditions) == 2
