"""Meshes in glTF 2.0, where its scene shows them: nodes, instances, skins and morph targets.

What moves, repeats or hides geometry is applied or refused by name; materials are not read. A
document of a few bytes can ask for terabytes: what it claims is compared with its bytes. Nothing is
fetched, and no file outside the folder is opened.
"""

import base64
import binascii
import json
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import unquote

import numpy as np
from scipy.spatial.transform import Rotation

from facetlog.errors import InputError
from facetlog.perception.ragged import Indices
from facetlog.perception.reading.shape_files.file_text import to_plain_bytes
from facetlog.perception.reading.shape_files.meshes.mesh_checks import (
    NoTrianglesError,
    TriangleList,
    merge_parts,
    move_part,
    skin_points,
)
from facetlog.perception.reading.shape_files.meshes.polygons import fan_triangles, strip_triangles
from facetlog.perception.reading.shape_files.shape_file import ShapeFile
from facetlog.perception.types import FloatArray
from facetlog.safe_read import read_regular

# glTF 2.0, section 3.4: right-handed, +y is up, metres.
UP = (0.0, 1.0, 0.0)
# Section 3.7.2.1; points and lines have no surface.
TRIANGLES, STRIP, FAN = 4, 5, 6
GLB_MAGIC, GLB_JSON, GLB_BINARY = b"glTF", 0x4E4F534A, 0x004E4942
# glTF 2.0, tables in 3.6.2.2: types of a component, components of an element.
COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
# Extensions that keep geometry in other ways than accessors do.
COMPRESSED = {
    "KHR_draco_mesh_compression": "Draco",
    "EXT_meshopt_compression": "meshopt",
    "KHR_meshopt_compression": "meshopt",
}
DRACO = "KHR_draco_mesh_compression"
INSTANCES = "EXT_mesh_gpu_instancing"
# Nothing of these moves, adds or removes geometry, or they are applied here. All others that a
# document requires are refused (section 3.12: a client has to).
KNOWN = frozenset(
    {
        INSTANCES,
        "EXT_instance_features",
        "EXT_mesh_features",
        "EXT_structural_metadata",
        "EXT_texture_webp",
        "EXT_texture_avif",
        "KHR_animation_pointer",
        "KHR_lights_punctual",
        "KHR_mesh_quantization",
        "KHR_node_visibility",
        "KHR_texture_basisu",
        "KHR_technique_webgl",
        "KHR_techniques_webgl",
        "KHR_texture_transform",
        "KHR_xmp_json_ld",
        "MSFT_texture_dds",
    }
)
MATERIALS = "KHR_materials_"


def read_gltf(data: bytes, shape: ShapeFile) -> TriangleList:
    """Return the triangles of the scene that a glTF or GLB shows, in metres, +y up.

    Raise InputError where it needs what is not read, or claims more than it holds.
    """
    document, binary = read_document(data, shape)
    try:
        _check_asset(document, shape)
        scene = _Scene(GltfData(document, binary, shape))
        scene.check_size()
        vertices, triangles = merge_parts(scene.iter_parts(), shape)
    except KeyError as exc:
        raise shape.error(f"is no sound glTF (it lacks {exc!s:.40}); export it again") from exc
    except IndexError as exc:
        raise shape.error(
            "is no sound glTF (it refers to a part that is missing); export it again"
        ) from exc
    except (AttributeError, TypeError, ValueError) as exc:
        raise shape.error(f"is no sound glTF ({exc!s:.80}); export it again") from exc
    if not len(triangles):
        raise NoTrianglesError(f"{shape.name}: shows no triangles; export the mesh with its scene")
    return TriangleList(vertices, triangles, UP, 1.0, scene.warnings, scene.step)


def _check_asset(document: dict[str, Any], shape: ShapeFile) -> None:
    """Raise InputError where the document is of another version, or requires what is not read."""
    asset = document.get("asset", {})
    version = str(asset.get("minVersion", asset.get("version", "1.0")))
    if version.split(".")[0] != "2" or ("minVersion" in asset and version != "2.0"):
        raise shape.error(f"is glTF {version}, which is not read; convert it to glTF 2.0")
    for extension in map(str, document.get("extensionsRequired", ())):
        if extension in COMPRESSED:
            raise make_compression_error(shape, extension)
        if extension not in KNOWN and not extension.startswith(MATERIALS):
            raise shape.error(
                f"requires the extension {extension:.60}, which is not read; export it without"
            )


class _Scene:
    """The nodes that a glTF shows, and their meshes."""

    def __init__(self, data: "GltfData") -> None:
        self.data = data
        self.shape = data.shape
        self.document = data.document
        self.nodes: Sequence[dict[str, Any]] = self.document.get("nodes", ())
        self.places: dict[int, FloatArray] = {}
        """World matrices (4, 4) of all nodes, by their numbers."""
        self.shown: list[int] = []
        self.warnings: tuple[str, ...] = ()
        self.step = 0.0
        """Quantisation step of the coarsest part that was read; 0 if all are floats."""
        parents: dict[int, int] = {}
        for parent, node in enumerate(self.nodes):
            for child in node.get("children", ()):
                if child in parents or not 0 <= child < len(self.nodes):
                    raise ValueError("a node has two parents, or is missing")
                parents[child] = parent
        self._place_nodes(parents)
        self._show(self._find_roots(parents))

    def _place_nodes(self, parents: dict[int, int]) -> None:
        waiting = [(node, np.eye(4)) for node in range(len(self.nodes)) if node not in parents]
        while waiting:
            number, above = waiting.pop()
            node = self.nodes[number]
            self.places[number] = above @ _compute_local_matrix(node)
            waiting += [(child, self.places[number]) for child in node.get("children", ())]
        if len(self.places) < len(self.nodes):
            raise ValueError("a node is its own ancestor")

    def _find_roots(self, parents: dict[int, int]) -> list[int]:
        scenes = self.document.get("scenes", ())
        if not scenes:
            return [node for node in range(len(self.nodes)) if node not in parents]
        default = self.document.get("scene")
        if default is None and len(scenes) > 1:
            self.warnings += (f"has {len(scenes)} scenes and no default: the first is read",)
        return list(scenes[default or 0].get("nodes", ()))

    def _show(self, roots: list[int]) -> None:
        """Find the nodes that are shown; KHR_node_visibility hides what is below, too."""
        waiting, hidden = list(roots), 0
        while waiting:
            number = waiting.pop()
            node = self.nodes[number]
            visibility = node.get("extensions", {}).get("KHR_node_visibility", {})
            if not visibility.get("visible", True):
                hidden += 1
                continue
            self.shown.append(number)
            waiting += node.get("children", ())
        if len(self.shown) != len(set(self.shown)):
            raise ValueError("a scene shows a node twice")
        if hidden:
            self.warnings += (f"{hidden} nodes are hidden and left out (KHR_node_visibility)",)
        self.shown.sort()

    def check_size(self) -> None:
        """Raise InputError where too many triangles are shown; nothing is read for this."""
        meshes, accessors = self.document.get("meshes", ()), self.document.get("accessors", ())
        count = 0
        for number in self.shown:
            node = self.nodes[number]
            if "mesh" not in node:
                continue
            for primitive in meshes[node["mesh"]]["primitives"]:
                key = primitive.get("indices", primitive["attributes"].get("POSITION"))
                if key is None:
                    continue
                corners = int(accessors[key]["count"])
                each = corners // 3 if primitive.get("mode", TRIANGLES) == TRIANGLES else corners
                count += each * self._count_instances(node)
            self.shape.check_triangles(count)

    def _count_instances(self, node: dict[str, Any]) -> int:
        attributes = node.get("extensions", {}).get(INSTANCES, {}).get("attributes", {})
        return max(
            (int(self.document["accessors"][a]["count"]) for a in attributes.values()), default=1
        )

    def iter_parts(self) -> Iterator[tuple[FloatArray, Indices]]:
        """Yield points and triangles of all shown meshes in the scene's frame."""
        for number in self.shown:
            node = self.nodes[number]
            if "mesh" not in node:
                continue
            mesh = self.document["meshes"][node["mesh"]]
            weights = node.get("weights", mesh.get("weights", ()))
            for primitive in mesh["primitives"]:
                found = self._read_primitive(primitive, weights)
                if found is None:
                    continue
                points, triangles = found
                if "skin" in node and "JOINTS_0" in primitive["attributes"]:
                    # section 3.7.3.3: the skinned mesh's own node does not move it
                    yield self._skin(points, primitive, node["skin"]), triangles
                    continue
                for matrix in self._iter_instances(node):
                    place = self.places[number] @ matrix
                    self._note_step(primitive, place)
                    yield move_part(points, triangles, place)

    def _note_step(self, primitive: dict[str, Any], *places: FloatArray) -> None:
        """Keep how far apart neighbouring coordinates of a primitive are, at most, once moved."""
        step = self.data.step(primitive["attributes"]["POSITION"])
        if step:
            self.step = max(
                self.step, *(step * float(np.linalg.norm(m[:3, :3], 2)) for m in places)
            )

    def _read_primitive(
        self, primitive: dict[str, Any], weights: Sequence[float]
    ) -> tuple[FloatArray, Indices] | None:
        """Return points and triangles of a primitive, morphed; None where it has no surface."""
        mode = primitive.get("mode", TRIANGLES)
        if mode not in (TRIANGLES, STRIP, FAN) or "POSITION" not in primitive["attributes"]:
            return None
        position = primitive["attributes"]["POSITION"]
        accessor = self.document["accessors"][position]
        compressed = DRACO in primitive.get("extensions", {})
        if compressed and "bufferView" not in accessor and "sparse" not in accessor:
            raise make_compression_error(self.shape, DRACO)
        if accessor["type"] != "VEC3":
            raise ValueError("positions that are no VEC3")
        points = self.data.read(position)
        for target, weight in zip(primitive.get("targets", ()), weights, strict=False):
            if weight and "POSITION" in target:
                points = points + float(weight) * self.data.read(target["POSITION"])
        if "indices" in primitive:
            corners = self.data.read(primitive["indices"]).ravel().astype(np.int64)
        else:
            corners = np.arange(len(points))
        if len(corners) and int(corners.max()) >= len(points):
            raise self.shape.make_inconsistency_error(
                f"a face names vertex {corners.max()} of {len(points)}"
            )
        if mode == TRIANGLES:
            if len(corners) % 3:
                raise self.shape.make_inconsistency_error(
                    f"has triangles of {len(corners)} corners, no multiple of three"
                )
            return points, corners.reshape(-1, 3)
        return points, strip_triangles(corners) if mode == STRIP else fan_triangles(corners)

    def _iter_instances(self, node: dict[str, Any]) -> Iterator[FloatArray]:
        """Yield matrices of a node's instances in its frame; the identity where it has none."""
        attributes = node.get("extensions", {}).get(INSTANCES, {}).get("attributes", {})
        held = {
            key: self.data.read(attributes[key])
            for key in ("TRANSLATION", "ROTATION", "SCALE")
            if key in attributes
        }
        if not held:
            yield np.eye(4)
            return
        counts = {len(values) for values in held.values()}
        if len(counts) != 1:
            raise ValueError(f"instances of {sorted(counts)} attributes")
        for row in range(counts.pop()):
            yield _compose_matrix(
                held["TRANSLATION"][row] if "TRANSLATION" in held else (0.0, 0.0, 0.0),
                held["ROTATION"][row] if "ROTATION" in held else (0.0, 0.0, 0.0, 1.0),
                held["SCALE"][row] if "SCALE" in held else (1.0, 1.0, 1.0),
            )

    def _skin(self, points: FloatArray, primitive: dict[str, Any], number: int) -> FloatArray:
        skin, attributes = self.document["skins"][number], primitive["attributes"]
        joints = skin["joints"]
        matrices = np.stack([self.places[joint] for joint in joints])
        if "inverseBindMatrices" in skin:
            inverse = self.data.read(skin["inverseBindMatrices"]).reshape(-1, 4, 4)
            matrices = matrices @ inverse[: len(joints)].transpose(0, 2, 1)  # column-major
        self._note_step(primitive, *matrices)
        sets = [key.removeprefix("JOINTS_") for key in attributes if key.startswith("JOINTS_")]
        owners = np.hstack([self.data.read(attributes[f"JOINTS_{k}"]) for k in sets])
        weights = np.hstack([self.data.read(attributes[f"WEIGHTS_{k}"]) for k in sets])
        return skin_points(points, matrices, owners.astype(np.int64), weights)


def _compute_local_matrix(node: dict[str, Any]) -> FloatArray:
    if "matrix" in node:
        return np.asarray(node["matrix"], dtype=np.float64).reshape(4, 4).T
    return _compose_matrix(
        node.get("translation", (0.0, 0.0, 0.0)),
        node.get("rotation", (0.0, 0.0, 0.0, 1.0)),
        node.get("scale", (1.0, 1.0, 1.0)),
    )


def _compose_matrix(
    translation: Sequence[float] | FloatArray,
    rotation: Sequence[float] | FloatArray,
    scale: Sequence[float] | FloatArray,
) -> FloatArray:
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_quat(rotation).as_matrix() * np.asarray(scale, dtype=np.float64)
    matrix[:3, 3] = translation
    return matrix


def read_document(data: bytes, shape: ShapeFile) -> tuple[dict[str, Any], bytes | None]:
    """Return the JSON of a glTF, and the binary chunk of a GLB (None where there is none)."""
    binary = None
    chunks = data[:4] == GLB_MAGIC
    if chunks:
        data, binary = _read_chunks(data, shape)
    text = to_plain_bytes(data).lstrip()
    if not text.startswith(b"{"):
        what = "GLB header" if shape.path.suffix.lower() == ".glb" and not chunks else "JSON object"
        shown = text[:30].decode("utf-8", "replace").partition("\n")[0]
        begins = f", it begins with {shown}" if shown.isprintable() and shown else ""
        raise shape.error(f"has no {what}{begins}; export the mesh again")
    try:
        document: dict[str, Any] = json.loads(text)
    except (ValueError, RecursionError) as exc:
        raise shape.error(
            f"is no glTF, its JSON is truncated or damaged ({exc!s:.80}); export it again"
        ) from exc
    return document, binary


def make_compression_error(shape: ShapeFile, extension: str) -> InputError:
    """Return the error of geometry that is kept by an extension of `COMPRESSED`."""
    return shape.error(
        f"is compressed with {COMPRESSED[extension]} ({extension}); export it without compression"
    )


def _read_chunks(data: bytes, shape: ShapeFile) -> tuple[bytes, bytes | None]:
    if len(data) < 20:
        raise shape.make_truncation_error("ends within its GLB header")
    version, total, length, chunk = struct.unpack("<4xIIII", data[:20])
    if version != 2:
        raise shape.error(f"is glTF {version}.0, which is not read; convert it to glTF 2.0")
    if total > len(data) or 20 + length > len(data) or chunk != GLB_JSON:
        raise shape.make_false_claim_error(f"{max(total, 20 + length)} bytes")
    place, binary = 20 + length, None
    while place + 8 <= total and binary is None:
        size, chunk = struct.unpack("<II", data[place : place + 8])
        if place + 8 + size > total:
            raise shape.make_false_claim_error(f"a chunk of {size} bytes")
        if chunk == GLB_BINARY:
            binary = data[place + 8 : place + 8 + size]
        place += 8 + size
    return data[20 : 20 + length], binary


@dataclass(slots=True)
class GltfData:
    """The numbers that a glTF's accessors hold."""

    document: dict[str, Any]
    binary: bytes | None
    shape: ShapeFile
    _buffers: dict[int, bytes] = field(default_factory=dict)
    _zeros: int = 0

    def read(self, index: int) -> FloatArray:
        """Return the elements (count, width) of an accessor; normalised integers as -1 to 1."""
        accessor = self.document["accessors"][index]
        count, width = accessor["count"], WIDTHS[accessor["type"]]
        component = np.dtype(COMPONENTS[accessor["componentType"]])
        if not isinstance(count, int) or count < 0:
            raise ValueError(f"an accessor of {count} elements")
        if "bufferView" in accessor:
            raw = self._read_elements(accessor, count, width, component).astype(np.float64)
        else:
            # zeros (3.6.2.1), with `sparse` all but a few
            self._zeros += count
            if self._zeros > 3 * self.shape.limits.triangles:
                raise self.shape.make_false_claim_error(f"{count} values in 0 bytes")
            raw = np.zeros((count, width))
        if "sparse" in accessor:
            self._replace_sparse(raw, accessor["sparse"], width, component)
        if accessor.get("normalized") and component.kind in "iu":
            # 3.6.2.2: f = max(c / 127, -1) and the like
            raw = np.maximum(raw / np.iinfo(component).max, -1.0)
        return raw

    def step(self, index: int) -> float:
        """Return the distance of neighbouring values of an accessor; 0 where they are floats."""
        accessor = self.document["accessors"][index]
        component = np.dtype(COMPONENTS[accessor["componentType"]])
        if component.kind not in "iu":
            return 0.0
        return 1.0 / float(np.iinfo(component).max) if accessor.get("normalized") else 1.0

    def _replace_sparse(
        self, raw: FloatArray, sparse: dict[str, Any], width: int, component: np.dtype[Any]
    ) -> None:
        count = sparse["count"]
        kind = np.dtype(COMPONENTS[sparse["indices"]["componentType"]])
        at = self._read_elements(sparse["indices"], count, 1, kind).astype(np.int64).ravel()
        raw[at] = self._read_elements(sparse["values"], count, width, component)

    def _read_elements(
        self, part: dict[str, Any], count: int, width: int, component: np.dtype[Any]
    ) -> np.ndarray[Any, Any]:
        view = self.document["bufferViews"][part["bufferView"]]
        data = self._get_view_bytes(view)
        start, element = part.get("byteOffset", 0), width * component.itemsize
        stride = view.get("byteStride", element) or element
        if count and (start < 0 or start + stride * (count - 1) + element > len(data)):
            raise self.shape.make_false_claim_error(f"{count} values in {len(data)} bytes")
        if count == 0:
            return np.zeros((0, width), dtype=component)
        return np.ndarray((count, width), component, data, start, (stride, component.itemsize))

    def _get_view_bytes(self, view: dict[str, Any]) -> memoryview:
        index, start, length = view["buffer"], view.get("byteOffset", 0), view["byteLength"]
        try:
            buffer = self._get_buffer(index)
        except InputError:
            compressed = [key for key in COMPRESSED if key in view.get("extensions", {})]
            if not compressed:
                raise
            raise make_compression_error(self.shape, compressed[0]) from None
        if start < 0 or length < 0 or start + length > len(buffer):
            raise self.shape.make_false_claim_error(f"a view of {length} bytes")
        return memoryview(buffer)[start : start + length]

    def _get_buffer(self, index: int) -> bytes:
        if index not in self._buffers:
            self._buffers[index] = self._load_buffer(self.document["buffers"][index], index)
        return self._buffers[index]

    def _load_buffer(self, buffer: dict[str, Any], index: int) -> bytes:
        shape, uri = self.shape, buffer.get("uri")
        if uri is None:
            if self.binary is None or index != 0:
                raise shape.error(f"buffer {index} has no data; export the mesh again")
            return self.binary
        if uri.startswith("data:"):
            try:
                return base64.b64decode(unquote(uri.partition(",")[2]), validate=True)
            except binascii.Error as exc:
                raise shape.error("has a damaged buffer; export it again") from exc
        folder = shape.path.resolve().parent
        target = (folder / unquote(uri)).resolve()
        if "://" in uri or not target.is_relative_to(folder):
            raise shape.error(f"points outside its folder ({uri[:80]}); put the data beside it")
        if target.exists() and not target.is_file():
            raise shape.error(f"{uri[:80]} is no regular file; put the data itself there")
        if not target.is_file():
            raise shape.error(f"{uri[:80]} is missing; put it beside the glTF")
        if target.stat().st_size > self.shape.limits.size_bytes:
            raise shape.error(f"{uri[:80]} is too large; reduce the mesh")
        return read_regular(folder / unquote(uri), shape.limits.size_bytes)
