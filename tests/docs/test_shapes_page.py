"""docs/shapes.md: files that are refused are told as its table says."""

import base64
import json
import re
from pathlib import Path

import numpy as np
import pytest
import trimesh

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.suffixes import CLOUD_SUFFIXES, MESH_SUFFIXES
from facetlog.perception.shapes.read_shape import ShapeOptions, read_shape

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "shapes.md").read_text(encoding="utf-8")


def _table(title: str) -> list[list[str]]:
    section = PAGE.partition(f"\n## {title}\n")[2].partition("\n## ")[0]
    rows = [line.strip("| ").split(" | ") for line in section.splitlines() if line[:1] == "|"]
    return rows[2:]


REFUSED = {name.strip("`"): message for name, message in _table("What is refused")}


def _gltf(uri: str, count: int) -> str:
    accessor = {"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3"}
    return json.dumps(
        {
            "asset": {"version": "2.0"},
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "accessors": [accessor],
            "bufferViews": [{"buffer": 0, "byteLength": 36}],
            "buffers": [{"byteLength": 36, "uri": uri}],
        }
    )


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    block = trimesh.creation.box((0.3, 0.2, 0.1))

    def changed(name: str, vertices: np.ndarray) -> None:
        trimesh.Trimesh(vertices, block.faces, process=False).export(tmp_path / name)

    data = "data:application/octet-stream;base64," + base64.b64encode(bytes(36)).decode()
    (tmp_path / "zero.stl").touch()
    (tmp_path / "cut.stl").write_bytes(block.export(file_type="stl")[:400])
    (tmp_path / "cut.off").write_text(block.export(file_type="off")[:150])
    (tmp_path / "words.ply").write_text("once upon a time")
    changed("nan.ply", np.full_like(block.vertices, np.nan))
    changed("line.ply", block.vertices * [1.0, 0.0, 0.0])
    changed("place.ply", block.vertices * 0.0)
    changed("far.ply", block.vertices + np.array([1e9, 0.0, 0.0]))
    (tmp_path / "bomb.gltf").write_text(_gltf(data, 10**12))
    (tmp_path / "outside.gltf").write_text(_gltf("../secret.bin", 3))
    (tmp_path / "few.xyz").write_text("0 0 0\n1 0 0\n")
    return tmp_path


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_refused_is_told_as_the_page_says(name: str, folder: Path) -> None:
    with pytest.raises(InputError) as caught:
        read_shape(folder / name, ShapeOptions(find_floor=True))
    assert str(caught.value) == REFUSED[name]


def test_the_page_lists_all_kinds_of_files() -> None:
    listed = " ".join(row[1] for row in _table("Files"))
    for suffix in (*MESH_SUFFIXES, *CLOUD_SUFFIXES, ".json"):
        assert f"`{suffix}`" in listed


@pytest.mark.parametrize(
    "path", [DOCS / "README.md", DOCS / "shapes.md", DOCS.parent / "README.md"]
)
def test_links_lead_to_files_that_are_there(path: Path) -> None:
    links = re.findall(r"\]\(([^)#:]+)", path.read_text(encoding="utf-8"))
    assert links
    assert [link for link in links if not (path.parent / link).exists()] == []


def test_all_documents_are_in_the_index() -> None:
    index = (DOCS / "README.md").read_text(encoding="utf-8")
    documents = {p.name for p in DOCS.iterdir() if p.suffix in (".md", ".json")} - {"README.md"}
    assert {name for name in documents if f"[{name}]({name})" not in index} == set()
