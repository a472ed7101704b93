"""Size checks of mesh files: header counts are compared with the file's size before it is read.

A header of a few bytes can ask for terabytes: counts of a PLY, STL or OFF, accessors of a glTF, and
parts of a scene that are shown thousands of times.
"""

import base64
import binascii
import json
import re
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO
from urllib.parse import unquote

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.suffixes import MESH_SUFFIXES

__all__ = [
    "DEFAULT_LIMITS",
    "Claim",
    "Limits",
    "NoTrianglesError",
    "binary_stl_bytes",
    "check_file",
]

# Four times the 5 million triangles that must work: a binary STL of them has 1 GB.
MAX_TRIANGLES = 20_000_000
MAX_BYTES = 4 << 30
# A header ends within this; a PLY's has some 300 bytes, comments may make it long.
HEADER_BYTES = 1 << 16
# A number in text takes a digit and a blank.
LEAST_TEXT_BYTES = 2
STL_HEADER_BYTES, STL_TRIANGLE_BYTES = 84, 50
PLY_BYTES = {
    "char": 1, "uchar": 1, "int8": 1, "uint8": 1, "short": 2, "ushort": 2, "int16": 2,
    "uint16": 2, "int": 4, "uint": 4, "int32": 4, "uint32": 4, "float": 4, "float32": 4,
    "double": 8, "float64": 8,
}  # fmt: skip
# glTF 2.0, tables in 3.6.2.2: bytes of a component, components of an element.
GLTF_COMPONENT_BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
GLTF_COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
GLB_MAGIC, GLB_JSON = b"glTF", 0x4E4F534A
# These keep geometry in other ways than accessors do.
GLTF_COMPRESSED = ("KHR_draco_mesh_compression", "EXT_meshopt_compression")


class NoTrianglesError(InputError):
    """The file is sound and has no faces: it may be a point cloud."""


@dataclass(frozen=True, slots=True)
class Limits:
    """What is refused: files of more `size_bytes`, meshes of more `triangles`."""

    size_bytes: int = MAX_BYTES
    triangles: int = MAX_TRIANGLES


DEFAULT_LIMITS = Limits()


@dataclass(frozen=True, slots=True)
class Claim:
    """A file's claims: its kind (the suffix without the dot), and the least number of faces."""

    kind: str
    faces: int = 0


def check_file(path: Path, limits: Limits = DEFAULT_LIMITS) -> Claim:
    """The claims of a mesh file, after they were found possible.

    Raises InputError where the file is missing, empty, too large, of no known kind or claims more
    than it can hold; NoTrianglesError for a PLY without faces.
    """
    kind = path.suffix.lower().removeprefix(".")
    if path.suffix.lower() not in MESH_SUFFIXES:
        raise InputError(f"{path.name}: is no mesh file; give one of {', '.join(MESH_SUFFIXES)}")
    try:
        size = path.stat().st_size
        if not path.is_file():
            raise InputError(f"{path.name}: is no file; give a mesh file")
        if size == 0:
            raise InputError(f"{path.name}: is empty; export the mesh again")
        if size > limits.size_bytes:
            raise InputError(
                f"{path.name}: has {size} bytes, more than {limits.size_bytes}; reduce the mesh"
            )
        with path.open("rb") as file:
            return Claim(kind, _check_content(file, path, kind, size, limits))
    except OSError as exc:
        raise InputError(f"{path.name}: cannot be read ({exc.strerror}); check the path") from exc


def _check_content(file: BinaryIO, path: Path, kind: str, size: int, limits: Limits) -> int:
    """How many faces the file claims to have, at least; 0 where its kind does not say."""
    match kind:
        case "ply":
            return _check_ply(file, path.name, size, limits)
        case "stl":
            _check_stl(file, path.name, size, limits)
        case "off":
            return _check_off(file, path.name, size, limits)
        case "gltf" | "glb":
            _check_gltf(_gltf_document(file, path.name, kind, size), path, size, limits)
        case "dae":
            # Entities of a document type can unfold without end; no exporter writes any.
            if re.search(rb"<!\s*(DOCTYPE|ENTITY)", file.read(HEADER_BYTES), re.IGNORECASE):
                raise InputError(f"{path.name}: has a document type; export the DAE without one")
    return 0


def _claims_too_much(name: str, claim: str) -> InputError:
    return InputError(f"{name}: claims {claim}, more than it holds; it is truncated or damaged")


def _too_many(name: str, limits: Limits) -> InputError:
    return InputError(f"{name}: has more than {limits.triangles} triangles; reduce the mesh")


def _check_ply(file: BinaryIO, name: str, size: int, limits: Limits) -> int:
    head, ended, _ = file.read(HEADER_BYTES).partition(b"end_header")
    if not head.startswith(b"ply") or not ended:
        raise InputError(f"{name}: has no PLY header; export the mesh again")
    text = head.decode("ascii", "replace").splitlines()
    ascii_text = any(line.split()[:2] == ["format", "ascii"] for line in text)
    counts: dict[str, int] = {}
    row_bytes: dict[str, int] = {}
    element = ""
    try:
        for words in (line.split() for line in text):
            if words[:1] == ["element"]:
                element = words[1]
                counts[element] = int(words[2])
                row_bytes[element] = 0
            elif words[:1] == ["property"] and element:
                # a list has at least its count
                row_bytes[element] += (
                    LEAST_TEXT_BYTES if ascii_text else PLY_BYTES[words[1 + (words[1] == "list")]]
                )
    except (IndexError, KeyError, ValueError) as exc:
        raise InputError(f"{name}: has a damaged PLY header; export the mesh again") from exc
    if any(count < 0 for count in counts.values()):
        raise InputError(f"{name}: has a damaged PLY header; export the mesh again")
    needed = sum(count * row_bytes[element] for element, count in counts.items())
    # the last number of a text needs no blank
    if needed > size - len(head) + LEAST_TEXT_BYTES:
        raise _claims_too_much(name, f"{needed} bytes of data")
    if counts.get("tristrips", 0):
        raise InputError(
            f"{name}: has triangle strips (tristrips), which are not read; "
            "export the mesh with faces (triangles)"
        )
    faces = counts.get("face", 0)
    if faces == 0:
        raise NoTrianglesError(f"{name}: has no faces; read it as a cloud, or export the faces too")
    if faces > limits.triangles:
        raise _too_many(name, limits)
    return faces


def binary_stl_bytes(file: BinaryIO) -> int | None:
    """How many bytes a binary STL says that it has, from its start; None of an STL in text.

    A binary one may begin with "solid" as text does, but not without a zero byte: numbers of
    triangles below 2^24, and the two bytes after each, have some.
    """
    head = file.read(STL_HEADER_BYTES + STL_TRIANGLE_BYTES)
    if head.lstrip()[:5].lower() == b"solid" and b"\0" not in head:
        return None
    if len(head) < STL_HEADER_BYTES:
        return STL_HEADER_BYTES
    (count,) = struct.unpack("<I", head[80:84])
    return STL_HEADER_BYTES + STL_TRIANGLE_BYTES * int(count)


def _check_stl(file: BinaryIO, name: str, size: int, limits: Limits) -> None:
    needed = binary_stl_bytes(file)
    if needed is None:
        return  # text has no counts
    if size < STL_HEADER_BYTES:
        raise InputError(f"{name}: is shorter than an STL header; export the mesh again")
    count = (needed - STL_HEADER_BYTES) // STL_TRIANGLE_BYTES
    if needed > size:
        raise _claims_too_much(name, f"{count} triangles")
    if count > limits.triangles:
        raise _too_many(name, limits)


def _check_off(file: BinaryIO, name: str, size: int, limits: Limits) -> int:
    text = re.sub(rb"#[^\n]*", b"", file.read(HEADER_BYTES))
    counts = re.match(rb"\s*[A-Z]*OFF\s+(\d+)\s+(\d+)", text)
    if counts is None:
        raise InputError(f"{name}: has no OFF header; export the mesh again")
    vertices, faces = int(counts[1]), int(counts[2])
    if 3 * LEAST_TEXT_BYTES * vertices + 4 * LEAST_TEXT_BYTES * faces > size:
        raise _claims_too_much(name, f"{vertices} vertices and {faces} faces")
    if faces > limits.triangles:
        raise _too_many(name, limits)
    return faces


def _gltf_document(file: BinaryIO, name: str, kind: str, size: int) -> dict[str, Any]:
    """The JSON of a glTF, or of the first chunk of a GLB."""
    if kind == "glb":
        head = file.read(20)
        if len(head) < 20 or head[:4] != GLB_MAGIC:
            raise InputError(f"{name}: has no GLB header; export the mesh again")
        total, length, chunk = struct.unpack("<8xIII", head)
        if total > size or length > size or chunk != GLB_JSON:
            raise _claims_too_much(name, f"{max(total, length)} bytes")
        text = file.read(length)
    else:
        text = file.read()
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as exc:
        raise InputError(f"{name}: is no glTF, its JSON is damaged; export it again") from exc
    if not isinstance(document, dict):
        raise InputError(f"{name}: is no glTF, its JSON is no object; export it again")
    return document


def _check_gltf(document: dict[str, Any], path: Path, size: int, limits: Limits) -> None:
    name = path.name
    for extension in GLTF_COMPRESSED:
        if extension in document.get("extensionsRequired", ()):
            raise InputError(f"{name}: is compressed ({extension}); export it without compression")
    try:
        held = [_buffer_bytes(buffer, path, size) for buffer in document.get("buffers", ())]
        views = document.get("bufferViews", ())
        for view in views:
            if view.get("byteOffset", 0) + view["byteLength"] > held[view["buffer"]]:
                raise _claims_too_much(name, f"a view of {view['byteLength']} bytes")
        accessors = document.get("accessors", ())
        if any("sparse" in accessors[at] for at in _surface_accessors(document)):
            raise InputError(f"{name}: sparse accessors are not read; export without them")
        zeros = 0
        for accessor in accessors:
            element = GLTF_COMPONENT_BYTES[accessor["componentType"]]
            element *= GLTF_COMPONENTS[accessor["type"]]
            view = views[accessor["bufferView"]]["byteLength"] if "bufferView" in accessor else 0
            if "sparse" in accessor and "bufferView" not in accessor:
                # zeros but for a few, as shapes to morph into are: trimesh makes room for them
                zeros += abs(accessor["count"])
                if zeros <= 3 * limits.triangles:
                    continue
            if accessor["count"] * element > view:
                raise _claims_too_much(name, f"{accessor['count']} values in {view} bytes")
        if _shown_triangles(document) > limits.triangles:
            raise _too_many(name, limits)
    except (AttributeError, IndexError, KeyError, TypeError, ValueError) as exc:
        raise InputError(f"{name}: is no sound glTF ({exc!r:.80}); export it again") from exc


def _surface_accessors(document: dict[str, Any]) -> set[int]:
    """The accessors that say where surfaces are."""
    primitives = [p for mesh in document.get("meshes", ()) for p in mesh["primitives"]]
    positions = {primitive["attributes"]["POSITION"] for primitive in primitives}
    return positions | {p["indices"] for p in primitives if "indices" in p}


def _buffer_bytes(buffer: dict[str, Any], path: Path, size: int) -> int:
    """How many bytes a buffer really has; no file outside the folder is looked at."""
    uri = buffer.get("uri")
    if uri is None:
        return size  # the binary chunk of the GLB itself
    if uri.startswith("data:"):
        try:
            return len(base64.b64decode(uri.partition(",")[2], validate=True))
        except binascii.Error as exc:
            raise InputError(f"{path.name}: has a damaged buffer; export it again") from exc
    folder = path.resolve().parent
    target = (folder / unquote(uri)).resolve()
    if "://" in uri or not target.is_relative_to(folder):
        raise InputError(
            f"{path.name}: points outside its folder ({uri[:80]}); put the data beside it"
        )
    if target.exists() and not target.is_file():
        raise InputError(f"{path.name}: {uri[:80]} is no regular file; put the data itself there")
    if not target.is_file():
        raise InputError(f"{path.name}: {uri[:80]} is missing; put it beside the glTF")
    return target.stat().st_size


def _shown_triangles(document: dict[str, Any]) -> int:
    """Triangles of all meshes of a glTF, each as often as a node shows it."""
    accessors = document.get("accessors", ())

    def of_primitive(primitive: dict[str, Any]) -> int:
        key = primitive.get("indices", primitive["attributes"]["POSITION"])
        return int(accessors[key]["count"]) // 3

    meshes = [
        sum(of_primitive(primitive) for primitive in mesh["primitives"])
        for mesh in document.get("meshes", ())
    ]
    nodes = document.get("nodes", ())
    children = [child for node in nodes for child in node.get("children", ())]
    if len(children) != len(set(children)):
        raise ValueError("a node has two parents")
    shown = [meshes[node["mesh"]] for node in nodes if "mesh" in node]
    return sum(shown)
