"""Meshes in glTF 2.0, where its scene shows them: nodes, instances, skins and morph targets.

What moves, repeats or hides geometry is applied or refused by name; materials are not read.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from facetlog.errors import InputError
from facetlog.perception.ragged import Indices
from facetlog.perception.reading.shape_files.file_damage import describe_inconsistency
from facetlog.perception.reading.shape_files.meshes.gltf_data import (
    COMPRESSED,
    GltfData,
    is_compressed,
    read_document,
)
from facetlog.perception.reading.shape_files.meshes.mesh_checks import (
    Limits,
    NoTrianglesError,
    TriangleList,
    check_triangles,
    merge_parts,
)
from facetlog.perception.reading.shape_files.meshes.polygons import fan_triangles, strip_triangles
from facetlog.perception.reading.shape_files.meshes.skinning import skin_points
from facetlog.perception.types import FloatArray

__all__ = ["read_gltf"]

# glTF 2.0, section 3.4: right-handed, +y is up, metres.
UP = (0.0, 1.0, 0.0)
# Section 3.7.2.1; points and lines have no surface.
TRIANGLES, STRIP, FAN = 4, 5, 6
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


def read_gltf(path: Path, data: bytes, kind: str, limits: Limits) -> TriangleList:
    """Return the triangles of the scene that a glTF or GLB shows, in metres, +y up.

    Raises InputError where it needs what is not read, or claims more than it holds.
    """
    name = path.name
    document, binary = read_document(path, data, kind)
    try:
        _check_asset(document, name)
        scene = _Scene(GltfData(document, path, binary, limits))
        scene.check_size()
        vertices, triangles = merge_parts(scene.iter_parts(), name, limits)
    except KeyError as exc:
        raise InputError(
            f"{name}: is no sound glTF (it lacks {exc!s:.40}); export it again"
        ) from exc
    except IndexError as exc:
        raise InputError(
            f"{name}: is no sound glTF (it refers to a part that is missing); export it again"
        ) from exc
    except (AttributeError, TypeError, ValueError) as exc:
        raise InputError(f"{name}: is no sound glTF ({exc!s:.80}); export it again") from exc
    if not len(triangles):
        raise NoTrianglesError(f"{name}: shows no triangles; export the mesh with its scene")
    return TriangleList(vertices, triangles, UP, 1.0, scene.warnings, scene.step)


def _check_asset(document: dict[str, Any], name: str) -> None:
    """Raise InputError where the document is of another version, or requires what is not read."""
    asset = document.get("asset", {})
    version = str(asset.get("minVersion", asset.get("version", "1.0")))
    if version.split(".")[0] != "2" or ("minVersion" in asset and version != "2.0"):
        raise InputError(f"{name}: is glTF {version}, which is not read; convert it to glTF 2.0")
    for extension in map(str, document.get("extensionsRequired", ())):
        if extension in COMPRESSED:
            raise is_compressed(name, extension)
        if extension not in KNOWN and not extension.startswith(MATERIALS):
            raise InputError(
                f"{name}: requires the extension {extension:.60}, which is not read; export it "
                "without"
            )


class _Scene:
    """The nodes that a glTF shows, and their meshes."""

    def __init__(self, data: GltfData) -> None:
        self.data = data
        self.name = data.path.name
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
            self.places[number] = above @ _local_matrix(node)
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
            check_triangles(count, self.name, self.data.limits)

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
                    yield _moved(points, triangles, place)

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
        """Points and triangles of a primitive, morphed; None where it has no surface."""
        mode = primitive.get("mode", TRIANGLES)
        if mode not in (TRIANGLES, STRIP, FAN) or "POSITION" not in primitive["attributes"]:
            return None
        position = primitive["attributes"]["POSITION"]
        accessor = self.document["accessors"][position]
        compressed = DRACO in primitive.get("extensions", {})
        if compressed and "bufferView" not in accessor and "sparse" not in accessor:
            raise is_compressed(self.name, DRACO)
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
            raise describe_inconsistency(
                self.name, f"a face names vertex {corners.max()} of {len(points)}"
            )
        if mode == TRIANGLES:
            if len(corners) % 3:
                raise describe_inconsistency(
                    self.name, f"has triangles of {len(corners)} corners, no multiple of three"
                )
            return points, corners.reshape(-1, 3)
        return points, strip_triangles(corners) if mode == STRIP else fan_triangles(corners)

    def _iter_instances(self, node: dict[str, Any]) -> Iterator[FloatArray]:
        """Matrices of a node's instances in its frame; itself where it has none."""
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
            yield _compose(
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


def _local_matrix(node: dict[str, Any]) -> FloatArray:
    if "matrix" in node:
        return np.asarray(node["matrix"], dtype=np.float64).reshape(4, 4).T
    return _compose(
        node.get("translation", (0.0, 0.0, 0.0)),
        node.get("rotation", (0.0, 0.0, 0.0, 1.0)),
        node.get("scale", (1.0, 1.0, 1.0)),
    )


def _compose(
    translation: Sequence[float] | FloatArray,
    rotation: Sequence[float] | FloatArray,
    scale: Sequence[float] | FloatArray,
) -> FloatArray:
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_quat(rotation).as_matrix() * np.asarray(scale, dtype=np.float64)
    matrix[:3, 3] = translation
    return matrix


def _moved(
    points: FloatArray, triangles: Indices, matrix: FloatArray
) -> tuple[FloatArray, Indices]:
    if np.array_equal(matrix, np.eye(4)):
        return points, triangles
    moved = points @ matrix[:3, :3].T + matrix[:3, 3]
    mirrored = np.linalg.det(matrix[:3, :3]) < 0.0
    return moved, triangles[:, ::-1] if mirrored else triangles
