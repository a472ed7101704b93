"""Results and scenes as they are, read by pandas, DuckDB and trimesh."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from facetlog.batch.output import write_rows
from facetlog.cli import main
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid, table
from facetlog.perception.surfaces.scene_file import write_scene
from tests.batch.fake_worker import fake_row


@pytest.fixture
def results(tmp_path: Path) -> Path:
    for name in ("box-1", "lamp-1"):
        (tmp_path / f"{name}.json").touch()
    named = ("absent", "box-1", "lamp-1")  # an error first: no type may be guessed from its row
    rows = [fake_row(str(tmp_path / f"{name}.json"), ()) for name in named]
    write_rows(tmp_path / "r.jsonl", rows)
    return tmp_path / "r.jsonl"


def test_pandas_reads_lines_of_results(results: Path) -> None:
    pandas = pytest.importorskip("pandas")
    frame = pandas.read_json(results, lines=True)
    assert list(frame["error"].isna()) == [False, True, True]
    assert list(frame["model"].fillna("none")) == ["none", "box", "none"]
    assert frame["degree"][1] == pytest.approx(0.9)
    assert frame["verdicts"][1][0]["state"] == "holds"


def test_duckdb_asks_lines_of_results(results: Path) -> None:
    duckdb = pytest.importorskip("duckdb")
    verdicts = duckdb.read_json(str(results)).project("unnest(verdicts) as v")
    found = verdicts.filter("v.state = 'holds'").project("v.model, v.degree").fetchall()
    assert found == [("box", 0.9)]


def test_duckdb_asks_scenes_for_their_faces(tmp_path: Path) -> None:
    duckdb = pytest.importorskip("duckdb")
    write_scene(cuboid(), tmp_path / "a.json")
    write_scene(table(), tmp_path / "b.json")
    scenes = duckdb.read_json(str(tmp_path / "*.json")).order("name")
    counts = scenes.project("name, len(faces), len(vertices)")
    assert counts.fetchall() == [("cuboid", 6, 8), ("table", 26, 40)]


def test_pandas_makes_a_table_of_a_scenes_vertices(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    scene = cuboid(0.3, 0.2, 0.1)
    write_scene(scene, tmp_path / "a.json")
    vertices = pandas.json_normalize(
        pandas.read_json(tmp_path / "a.json", typ="series")["vertices"]
    )
    assert np.vstack(vertices["point"]) == pytest.approx(scene.points)


@pytest.mark.parametrize("suffix", [".ply", ".glb"])
def test_trimesh_has_the_solid_with_a_colour_for_each_face(suffix: str, tmp_path: Path) -> None:
    write_scene(cuboid(0.3, 0.2, 0.1), tmp_path / "a.json")
    out = tmp_path / f"a{suffix}"
    assert main(["scene", "convert", str(tmp_path / "a.json"), str(out)]) == 0
    mesh = trimesh.load_mesh(out)
    mesh.merge_vertices(merge_norm=True, merge_tex=True)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(0.006, rel=1e-5)
    parts = trimesh.load_scene(out).geometry
    assert len(parts) == (1 if suffix == ".ply" else 6)
