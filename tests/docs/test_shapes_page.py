"""Test that faulty shape files are refused with a reason, and docs/shapes.md lists all suffixes."""

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


REFUSED = {
    "absent.ply": "cannot be read (No such file or directory); check the path",
    "zero.stl": "is empty; export the mesh again",
    "cut.stl": "claims 12 triangles, more than it holds; it is truncated: export or copy it again",
    "cut.off": "claims 8 vertices and 12 faces, more than it holds; it is truncated: "
    "export or copy it again",
    "words.ply": "has no PLY header; export it again",
    "nan.ply": "no triangle has three finite corners; export the mesh again",
    "line.ply": "no triangle has an area; export the mesh again",
    "place.ply": "all corners are in one place; export the mesh again",
    "far.ply": "lies 1e+09 from the origin, where its numbers are 1.2e+02 apart, too coarse for a "
    "shape of 0.22: move it to the origin before it is exported",
    "bomb.gltf": "has more than 20000000 triangles; reduce or split the mesh",
    "outside.gltf": "points outside its folder (../secret.bin); put the data beside it",
    "few.xyz": "2 different points with finite coordinates, at least 16 are needed: export the "
    "cloud again",
}


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


@pytest.mark.parametrize(("name", "message"), REFUSED.items(), ids=REFUSED)
def test_faulty_files_are_refused_with_the_reason(name: str, message: str, folder: Path) -> None:
    with pytest.raises(InputError) as caught:
        read_shape(folder / name, ShapeOptions(find_floor=True))
    assert str(caught.value) == f"{name}: {message}"


def test_the_page_lists_all_kinds_of_files() -> None:
    section = PAGE.partition("\n## Files\n")[2].partition("\n\n**")[0]
    for suffix in (*MESH_SUFFIXES, *CLOUD_SUFFIXES, ".json"):
        assert f"`{suffix}`" in section


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
