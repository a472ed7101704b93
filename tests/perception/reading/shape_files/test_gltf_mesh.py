"""glTF features that move, repeat or hide geometry are applied, or refused by their name."""

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from facetlog.errors import InputError
from facetlog.perception.facts.all_facts import fact_rows
from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh
from facetlog.perception.shapes.meshes.mesh_scene import make_mesh_scene
from tests.perception.reading.shape_files import mesh_measures
from tests.perception.reading.shape_files.mesh_measures import area, extent, volume

BLOCK = np.array([(x, y, z) for x in (0.0, 1.2) for y in (0.0, 0.7) for z in (0.0, 0.4)])
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
TRIANGLES = np.array([t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))])
AREA = 2 * (1.2 * 0.7 + 1.2 * 0.4 + 0.7 * 0.4)
KINDS = {"<i1": 5120, "<u1": 5121, "<i2": 5122, "<u2": 5123, "<u4": 5125, "<f4": 5126}
TYPES = {1: "SCALAR", 3: "VEC3", 4: "VEC4", 16: "MAT4"}


class Made:
    """A glTF of one mesh, its parts to be changed."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.document: dict[str, Any] = {
            "asset": {"version": "2.0"},
            "bufferViews": [],
            "accessors": [],
            "scenes": [{"nodes": [0]}],
            "scene": 0,
            "nodes": [{"mesh": 0}],
        }
        position, indices = self.add(BLOCK, "<f4"), self.add(TRIANGLES.ravel(), "<u2")
        self.primitive: dict[str, Any] = {"attributes": {"POSITION": position}, "indices": indices}
        self.document["meshes"] = [{"primitives": [self.primitive]}]

    @property
    def node(self) -> dict[str, Any]:
        node: dict[str, Any] = self.document["nodes"][0]
        return node

    def view(self, content: bytes, stride: int | None = None) -> int:
        self.data += b"\0" * (-len(self.data) % 4)
        made = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(content)}
        self.document["bufferViews"].append(made | ({"byteStride": stride} if stride else {}))
        self.data += content
        return len(self.document["bufferViews"]) - 1

    def add(self, values: Any, kind: str, *, stride: int | None = None, **more: Any) -> int:
        rows = np.asarray(values).reshape(len(values), -1).astype(kind)
        content = rows.tobytes()
        if stride:
            content = b"".join(row.tobytes().ljust(stride, b"\xff") for row in rows)
        accessor = {"componentType": KINDS[kind], "count": len(rows), "type": TYPES[rows.shape[1]]}
        self.document["accessors"].append(
            accessor | {"bufferView": self.view(content, stride)} | more
        )
        return len(self.document["accessors"]) - 1

    def read(self, folder: Path) -> Mesh:
        more = self.document.get("buffers", [])
        self.document["buffers"] = [{"byteLength": len(self.data)}, *more]
        text = json.dumps(self.document).encode()
        text += b" " * (-len(text) % 4)
        self.data += b"\0" * (-len(self.data) % 4)
        total = 28 + len(text) + len(self.data)
        content = (
            b"glTF"
            + struct.pack("<IIII", 2, total, len(text), 0x4E4F534A)
            + text
            + struct.pack("<II", len(self.data), 0x004E4942)
            + self.data
        )
        return mesh_measures.read(folder, "made.glb", content)


WHOLE = [0, 0, 0, 1.2, 0.7, 0.4]


@pytest.mark.parametrize(
    ("kind", "normalized", "stride"),
    [("<i1", True, 8), ("<u1", False, None), ("<i2", False, 8), ("<u2", True, None)],
)
def test_quantised_positions(
    tmp_path: Path, kind: str, *, normalized: bool, stride: int | None
) -> None:
    made = Made()
    most = np.iinfo(np.dtype(kind)).max
    grid = np.round(BLOCK / 1.2 * most)
    made.primitive["attributes"]["POSITION"] = made.add(
        grid, kind, stride=stride, normalized=normalized
    )
    scale = 1.2 if normalized else 1.2 / most
    made.node["scale"] = [scale] * 3
    made.primitive["indices"] = made.add(TRIANGLES.ravel(), "<u1" if normalized else "<u4")
    made.document["extensionsRequired"] = ["KHR_mesh_quantization"]
    assert extent(made.read(tmp_path)) == pytest.approx(WHOLE, abs=1.2 / most)


@pytest.mark.parametrize("kind", ["<i1", "<i2"])
def test_the_sd_of_quantised_sizes_is_as_large_as_their_error(tmp_path: Path, kind: str) -> None:
    made = Made()
    most = np.iinfo(np.dtype(kind)).max
    sizes = np.array([1.2, 0.6512, 0.4077])
    made.primitive["attributes"]["POSITION"] = made.add(
        np.round(BLOCK / BLOCK.max(axis=0) * sizes / 1.2 * most), kind, normalized=True
    )
    made.node["scale"] = [1.2] * 3
    scene = make_mesh_scene(made.read(tmp_path), up=(0.0, 0.0, 1.0), metric=True)
    lengths = [row[1:] for row in fact_rows(scene)["edge_length"]]
    assert len(lengths) == 12
    step = 1.2 / most
    for length, sd in lengths:
        error = np.abs(sizes - length).min()
        assert error < 3.0 * sd
        assert sd == pytest.approx(step / np.sqrt(6.0), rel=0.5)  # two ends, each step / √12


def test_interleaved_and_sparse_positions(tmp_path: Path) -> None:
    made = Made()
    made.primitive["attributes"]["POSITION"] = made.add(BLOCK, "<f4", stride=24)
    assert extent(made.read(tmp_path)) == pytest.approx(WHOLE)

    made = Made()
    at = np.flatnonzero(BLOCK.any(axis=1))
    sparse = {
        "count": len(at),
        "indices": {"bufferView": made.view(at.astype("<u1").tobytes()), "componentType": 5121},
        "values": {"bufferView": made.view(BLOCK[at].astype("<f4").tobytes())},
    }
    blank = {"componentType": 5126, "count": 8, "type": "VEC3", "sparse": sparse}
    made.document["accessors"].append(blank)
    made.primitive["attributes"]["POSITION"] = len(made.document["accessors"]) - 1
    assert extent(made.read(tmp_path)) == pytest.approx(WHOLE)


@pytest.mark.parametrize("indexed", [False, True])
@pytest.mark.parametrize("mode", [5, 6])
def test_strips_and_fans(tmp_path: Path, mode: int, *, indexed: bool) -> None:
    made = Made()
    made.document["meshes"][0]["primitives"] = []
    for a, b, c, d in QUADS:
        corners = np.array([a, b, d, c] if mode == 5 else [a, b, c, d])
        values = BLOCK if indexed else BLOCK[corners]
        primitive = {"attributes": {"POSITION": made.add(values, "<f4")}, "mode": mode}
        if indexed:
            primitive["indices"] = made.add(corners, "<u1")
        made.document["meshes"][0]["primitives"].append(primitive)
    mesh = made.read(tmp_path)
    assert area(mesh) == pytest.approx(AREA)
    assert abs(volume(mesh)) == pytest.approx(1.2 * 0.7 * 0.4)


def test_instances_repeat_a_mesh(tmp_path: Path) -> None:
    made = Made()
    turn = Rotation.from_rotvec(np.outer((0, 90, 180), (0, 1, 0)), degrees=True).as_quat()
    attributes = {
        "TRANSLATION": made.add([(0, 0, 0), (5, 0, 0), (0, 0, 9)], "<f4"),
        "ROTATION": made.add(np.round(turn * 32767), "<i2", normalized=True),
        "SCALE": made.add([(1, 1, 1), (2, 2, 2), (1, 3, 1)], "<f4"),
    }
    made.node["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": attributes}}
    made.node["translation"] = [0, 10, 0]
    made.document["extensionsRequired"] = ["EXT_mesh_gpu_instancing"]
    mesh = made.read(tmp_path)
    assert len(mesh.triangles) == 36
    parts = np.split(mesh.vertices, 3)
    assert np.ptp(parts[1], axis=0) == pytest.approx([0.8, 1.4, 2.4], abs=1e-3)
    assert parts[1].min(axis=0) == pytest.approx([5, 10, -2.4], abs=1e-3)
    assert np.ptp(parts[2], axis=0) == pytest.approx([1.2, 2.1, 0.4], abs=1e-3)


@pytest.mark.parametrize("weights", ["<f4", "<u1"])
def test_a_skin_places_its_mesh_by_its_joints(tmp_path: Path, weights: str) -> None:
    """A mesh in centimetres with z up, its node elsewhere, under a scaled and turned armature."""
    made = Made()
    lying = BLOCK[:, [0, 2, 1]] * 100 * [1, -1, 1]
    whole = 1 if weights == "<f4" else 255
    made.primitive["attributes"] = {
        "POSITION": made.add(lying, "<f4"),
        "JOINTS_0": made.add(np.tile((0, 1, 0, 0), (8, 1)), "<u1"),
        "WEIGHTS_0": made.add(
            np.tile((whole // 5, whole - whole // 5, 0, 0), (8, 1))
            if weights == "<u1"
            else np.tile((0.2, 0.8, 0, 0), (8, 1)),
            weights,
            normalized=weights != "<f4",
        ),
    }
    bind = np.eye(4)
    bind[:3, 3] = (0, 0, -50)  # of the second joint, which stands 50 above the first
    inverse = made.add(np.stack([np.eye(4).T.ravel(), bind.T.ravel()]), "<f4")
    made.node.update(skin=0, translation=[3, 3, 3], scale=[7, 7, 7])
    turn = Rotation.from_euler("x", -90, degrees=True).as_quat().tolist()
    made.document["nodes"] += [
        {"children": [2], "scale": [0.01] * 3, "rotation": turn},
        {"children": [3]},
        {"translation": [0, 0, 50]},
    ]
    made.document["scenes"][0]["nodes"] = [0, 1]
    made.document["skins"] = [{"joints": [2, 3], "inverseBindMatrices": inverse}]
    assert extent(made.read(tmp_path)) == pytest.approx(WHOLE, abs=1e-6)


@pytest.mark.parametrize("at_node", [False, True])
def test_morph_targets_by_their_weights(tmp_path: Path, *, at_node: bool) -> None:
    made = Made()
    made.primitive["targets"] = [
        {"POSITION": made.add(BLOCK, "<f4")},
        {"POSITION": made.add(100 * BLOCK, "<f4")},
    ]
    made.document["meshes"][0]["weights"] = [0.0, 1.0] if at_node else [0.5, 0.0]
    if at_node:
        made.node["weights"] = [0.5, 0.0]
    assert extent(made.read(tmp_path)) == pytest.approx(1.5 * np.array(WHOLE))


def test_hidden_nodes_and_other_scenes_are_not_shown(tmp_path: Path) -> None:
    made = Made()
    hide = {"KHR_node_visibility": {"visible": False}}
    made.document["nodes"] += [
        {"extensions": hide, "children": [2]},
        {"mesh": 0, "translation": [9, 9, 9]},
        {"mesh": 0, "translation": [-9, -9, -9]},
    ]
    made.document["scenes"] = [{"nodes": [3]}, {"nodes": [0, 1]}]
    made.document["scene"] = 1
    mesh = made.read(tmp_path)
    assert extent(mesh) == pytest.approx(WHOLE)
    assert "hidden" in mesh.warnings[0]


@pytest.mark.parametrize("extension", ["KHR_draco_mesh_compression", "EXT_meshopt_compression"])
@pytest.mark.parametrize("required", [False, True])
def test_compressed_geometry_is_refused_by_name(
    tmp_path: Path, extension: str, *, required: bool
) -> None:
    made = Made()
    made.document["extensionsUsed"] = [extension]
    if required:
        made.document["extensionsRequired"] = [extension]
    elif "draco" in extension:
        made.primitive["extensions"] = {extension: {"bufferView": 0}}
        del made.document["accessors"][0]["bufferView"]
    else:
        made.document["bufferViews"][0] |= {"buffer": 1, "extensions": {extension: {}}}
        made.document["buffers"] = [{"byteLength": 96, "extensions": {extension: {}}}]
    with pytest.raises(InputError, match=f"compressed.*{extension}"):
        made.read(tmp_path)


def test_a_fallback_of_compressed_geometry_is_read(tmp_path: Path) -> None:
    made = Made()
    made.primitive["extensions"] = {"KHR_draco_mesh_compression": {"bufferView": 0}}
    made.document["extensionsUsed"] = ["KHR_draco_mesh_compression"]
    assert extent(made.read(tmp_path)) == pytest.approx(WHOLE)


def test_an_index_beyond_the_vertices_is_inconsistent(tmp_path: Path) -> None:
    made = Made()
    made.primitive["indices"] = made.add(TRIANGLES.ravel() + 1, "<u2")
    with pytest.raises(InputError, match="names vertex 8 of 8"):
        made.read(tmp_path)
    made = Made()
    made.primitive["indices"] = made.add(TRIANGLES.ravel()[:-1], "<u2")
    with pytest.raises(InputError, match="35 corners"):
        made.read(tmp_path)
