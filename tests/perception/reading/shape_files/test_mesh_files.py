"""Mesh files: every kind read alike, and every damaged one refused in one line."""

import json
import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh
from trimesh.exchange import gltf, obj, off, ply, stl

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.meshes.mesh_checks import NoTrianglesError
from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh, read_mesh
from facetlog.perception.reading.shape_files.shape_file import Limits
from tests.perception.reading.shape_files.mesh_measures import (
    AREA,
    area,
    block,
    read,
    volume,
    write,
)


def as_bytes(kind: str) -> bytes:
    made = block()
    match kind:
        case "ply":
            return bytes(ply.export_ply(made))
        case "ascii.ply":
            return bytes(ply.export_ply(made, encoding="ascii"))
        case "stl":
            return bytes(stl.export_stl(made))
        case "ascii.stl":
            return stl.export_stl_ascii(made).encode()
        case "off":
            return off.export_off(made).encode()
        case "obj":
            return obj.export_obj(made).encode()
        case "glb":
            return bytes(gltf.export_glb(trimesh.Scene(made)))
        case _:
            return bytes(gltf.export_gltf(trimesh.Scene(made), embed_buffers=True)["model.gltf"])


KINDS = ("ply", "ascii.ply", "stl", "ascii.stl", "off", "obj", "glb", "gltf")


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_of_file_gives_the_same_surface(tmp_path: Path, kind: str) -> None:
    mesh = read(tmp_path, f"block.{kind}", as_bytes(kind))
    assert area(mesh) == pytest.approx(AREA)
    assert len(mesh.triangles) == 12
    assert mesh.warnings == ()


def test_only_formats_that_say_so_have_an_up_axis_and_a_unit(tmp_path: Path) -> None:
    plain = read(tmp_path, "block.ply", as_bytes("ply"))
    assert (plain.up, plain.unit_metres) == (None, None)
    told = read(tmp_path, "block.glb", as_bytes("glb"))
    assert told.up is not None
    assert (told.up.tolist(), told.unit_metres) == ([0.0, 1.0, 0.0], 1.0)


COUNTED = tuple(kind for kind in KINDS if kind not in ("obj", "ascii.stl"))
SHARES = (0.0, 0.3, 0.8)


@pytest.mark.parametrize("kind", COUNTED)
@pytest.mark.parametrize("share", SHARES)
def test_what_is_cut_short_is_refused_in_one_line(tmp_path: Path, kind: str, share: float) -> None:
    whole = as_bytes(kind)
    path = write(tmp_path, f"cut.{kind}", whole[: int(share * len(whole))])
    with pytest.raises(InputError, match=f"^cut.{kind}: .*$") as refused:
        read_mesh(path)
    assert "\n" not in str(refused.value)


def test_parts_of_a_scene_are_put_where_it_shows_them(tmp_path: Path) -> None:
    scene = trimesh.Scene()
    made = block()
    mirror = np.diag([-2.0, 2.0, 2.0, 1.0])
    scene.add_geometry(made, geom_name="block")
    scene.graph.update(frame_to="again", matrix=mirror, geometry="block")
    content = bytes(gltf.export_glb(scene))
    mesh = read(tmp_path, "two.glb", content)
    assert area(mesh) == pytest.approx(AREA + 4 * AREA)
    assert volume(mesh) == pytest.approx(6.0 + 8 * 6.0)  # a mirror does not turn it inside out


def test_a_ply_without_faces_is_distinguished(tmp_path: Path) -> None:
    cloud = trimesh.PointCloud(np.random.default_rng(0).random((10, 3)))
    path = write(tmp_path, "cloud.ply", bytes(ply.export_ply(cloud)))
    with pytest.raises(NoTrianglesError, match=r"cloud.ply: has no faces"):
        read_mesh(path)


@pytest.mark.parametrize("kind", ["ply", "stl", "off"])
def test_counts_beyond_the_file_are_refused_before_reading(tmp_path: Path, kind: str) -> None:
    content = as_bytes(kind)
    if kind == "stl":
        content = content[:80] + struct.pack("<I", 4_000_000_000) + content[84:]
    elif kind == "ply":
        content = content.replace(b"element vertex 8", b"element vertex 4000000000")
    else:
        content = content.replace(b"8 12", b"4000000000 12", 1)
    path = write(tmp_path, f"liar.{kind}", content)
    with pytest.raises(InputError, match="more than it holds"):
        read_mesh(path)


def liar(change: str) -> bytes:
    document = json.loads(as_bytes("gltf"))
    match change:
        case "accessor":
            document["accessors"][0]["count"] = 4_000_000_000
        case "no view":
            del document["accessors"][0]["bufferView"]
            document["accessors"][0]["count"] = 4_000_000_000
        case "view":
            document["bufferViews"][0]["byteLength"] = 4_000_000_000
        case "fetched":
            document["buffers"][0]["uri"] = "http://example.org/model.bin"
        case "outside":
            document["buffers"][0]["uri"] = "../secret.bin"
        case "missing":
            document["buffers"][0]["uri"] = "model.bin"
        case "sparse":
            document["accessors"][0]["sparse"] = {"count": 1}
        case "sparse zeros":
            blank = {"componentType": 5126, "type": "VEC3", "sparse": {"count": 1}}
            document["accessors"].append({**blank, "count": 4_000_000_000})
            document["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 2
        case "version":
            document["asset"]["version"] = "1.0"
        case "unknown":
            document["extensionsRequired"] = ["KHR_mesh_quantization", "VENDOR_moves_all"]
        case "compressed":
            document["extensionsRequired"] = ["KHR_draco_mesh_compression"]
        case "instances":
            node = next(n for n in document["nodes"] if "mesh" in n)
            count = len(document["nodes"])
            document["nodes"] += [dict(node) for _ in range(200)]
            document["scenes"][0]["nodes"] += range(count, count + 200)
        case _:
            document["nodes"][0]["children"] = [1, 1]
    return json.dumps(document).encode()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("accessor", "has more than 2000 triangles"),
        ("no view", "has more than 2000 triangles"),
        ("view", "more than it holds"),
        ("fetched", "points outside its folder"),
        ("outside", "points outside its folder"),
        ("missing", "put it beside"),
        ("sparse", "no sound glTF"),
        ("sparse zeros", "values in 0 bytes"),
        ("compressed", "without compression"),
        ("instances", "has more than 2000 triangles"),
        ("two parents", "no sound glTF"),
        ("version", "is glTF 1.0, which is not read; convert it to glTF 2.0"),
        ("unknown", "requires the extension VENDOR_moves_all, which is not read"),
    ],
)
def test_a_gltf_that_lies_is_refused_before_reading(tmp_path: Path, change: str, said: str) -> None:
    path = write(tmp_path, "liar.gltf", liar(change))
    with pytest.raises(InputError, match=said):
        read_mesh(path, Limits(triangles=2000))


def test_too_much_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path, "block.ply", as_bytes("ply"))
    with pytest.raises(InputError, match="has more than 11 triangles"):
        read_mesh(path, Limits(triangles=11))
    with pytest.raises(InputError, match="more than 100; reduce the mesh"):
        read_mesh(path, Limits(size_bytes=100))


@pytest.mark.parametrize("name", ["nothing.ply", "block.docx"])
def test_a_missing_or_foreign_file_is_an_input_error(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match=name):
        read_mesh(tmp_path / name)


def test_triangles_that_are_not_finite_are_left_out_with_a_warning() -> None:
    made = block()
    vertices = np.array(made.vertices)
    vertices[0] = np.nan
    mesh = Mesh.of(vertices, made.faces)
    assert 0 < len(mesh.triangles) < 12
    assert "left out: corners" in mesh.warnings[0]
    with pytest.raises(InputError, match="no triangle has three finite corners"):
        Mesh.of(vertices * np.nan, made.faces)
