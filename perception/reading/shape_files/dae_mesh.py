"""Meshes in COLLADA (DAE) 1.4 and 1.5, where its scene shows them: nodes, their instances,
polygons with holes, skins and morphs.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from facetlog.errors import InputError
from facetlog.perception.grouped import Indices
from facetlog.perception.reading.shape_files.mesh_checks import (
    Limits,
    NoTrianglesError,
    TriangleList,
    merge_parts,
)
from facetlog.perception.reading.shape_files.number_text import parse_numbers
from facetlog.perception.reading.shape_files.polygons import (
    Triangulation,
    triangulate,
    triangulate_rings,
)
from facetlog.perception.reading.shape_files.skinning import skin_points
from facetlog.perception.reading.shape_files.triangle_strips import fan_triangles, strip_triangles
from facetlog.perception.types import FloatArray

__all__ = ["read_dae"]

UP = {"X_UP": (1.0, 0.0, 0.0), "Y_UP": (0.0, 1.0, 0.0), "Z_UP": (0.0, 0.0, 1.0)}
# Nodes that show nodes can multiply without end.
MAX_NODES = 1_000_000
MAX_DEPTH = 500


def read_dae(data: bytes, name: str, limits: Limits) -> TriangleList:
    """Return the triangles of the scene that a COLLADA document shows.

    Raises InputError where it is no sound XML or says less than it counts.
    """
    document = _Document(_parse_xml(data, name), name)
    vertices, triangles = merge_parts(document.iter_parts(), name, limits)
    if not len(triangles):
        raise NoTrianglesError(f"{name}: shows no triangles; export the mesh with its scene")
    warnings = Triangulation(triangles, document.narrow, document.crossing).warnings
    return TriangleList(
        vertices,
        triangles,
        UP.get(document.up_axis),
        document.unit_metres,
        (*dict.fromkeys(document.warnings), *warnings),
    )


class _NoDocumentType(ElementTree.TreeBuilder):
    """Entities of a document type can unfold without end; no exporter writes any."""

    def doctype(self, *_: str | None) -> None:
        raise InputError("has a document type; export the DAE without one")


def _parse_xml(data: bytes, name: str) -> ElementTree.Element:
    parser = ElementTree.XMLParser(target=_NoDocumentType())  # noqa: S314 - see there
    try:
        parser.feed(data)
        root: ElementTree.Element = parser.close()
    except InputError as exc:
        raise InputError(f"{name}: {exc}") from None
    except (ElementTree.ParseError, LookupError, ValueError) as exc:
        raise InputError(
            f"{name}: its XML is truncated or damaged ({exc}); export it again"
        ) from exc
    for element in root.iter():
        if isinstance(element.tag, str):
            element.tag = element.tag.rpartition("}")[2]  # without its namespace
    version = root.get("version", "")
    if root.tag != "COLLADA":
        raise InputError(f"{name}: is no COLLADA document but <{root.tag:.30}>; export it again")
    if version.startswith(("1.0", "1.1", "1.2", "1.3")):
        raise InputError(f"{name}: is COLLADA {version:.10}, which is not read; convert it to 1.4")
    return root


@dataclass(slots=True)
class _Document:
    """A COLLADA document; `narrow` and `crossing` count faces, as in Triangulation."""

    root: ElementTree.Element
    name: str
    warnings: list[str] = field(default_factory=list)
    narrow: int = 0
    crossing: int = 0
    _ids: dict[str, ElementTree.Element] = field(default_factory=dict)
    _geometries: dict[str, tuple[FloatArray, Indices]] = field(default_factory=dict)
    _joints: dict[str, list[tuple[ElementTree.Element, FloatArray]]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._ids = {e.get("id", ""): e for e in self.root.iter() if e.get("id")}

    @property
    def up_axis(self) -> str:
        return (self.root.findtext("asset/up_axis") or "Y_UP").strip()

    @property
    def unit_metres(self) -> float | None:
        unit = self.root.find("asset/unit")
        words = None if unit is None else unit.get("meter")
        if words is None:
            return None
        found = self._numbers(words, "the unit's meter")
        if len(found) != 1 or not 0.0 < found[0] < np.inf:
            raise InputError(f"{self.name}: has a unit of {words:.20} m; export it again")
        return float(found[0])

    def iter_parts(self) -> Iterator[tuple[FloatArray, Indices]]:
        """Yield points and triangles of all that the scene shows, in its frame."""
        shown = self.root.find("scene/instance_visual_scene")
        if shown is None:
            raise NoTrianglesError(f"{self.name}: shows no object; export the mesh with its scene")
        scene = self._referred(shown)
        placed = list(self._iter_nodes(scene))
        for node, world in placed:
            for key in ("sid", "id", "name"):
                if node.get(key):
                    self._joints.setdefault(node.get(key, ""), []).append((node, world))
        for node, world in placed:
            for child in node:
                if child.tag == "instance_geometry":
                    points, triangles = self._geometry(self._referred(child))
                    yield _moved(points, triangles, world)
                elif child.tag == "instance_controller":
                    yield self._controlled(child, world)

    def _iter_nodes(
        self, scene: ElementTree.Element
    ) -> Iterator[tuple[ElementTree.Element, FloatArray]]:
        """Yield each node as often as it is shown, with its world matrix."""
        waiting = [(node, np.eye(4), 0) for node in reversed(scene.findall("node"))]
        count = 0
        while waiting:
            node, above, depth = waiting.pop()
            count += 1
            if depth > MAX_DEPTH or count > MAX_NODES:
                raise InputError(
                    f"{self.name}: its nodes show each other without end; export it again"
                )
            world = above @ self._local_matrix(node)
            yield node, world
            below = [
                self._referred(child) if child.tag == "instance_node" else child
                for child in node
                if child.tag in ("node", "instance_node")
            ]
            waiting += [(child, world, depth + 1) for child in reversed(below)]

    def _local_matrix(self, node: ElementTree.Element) -> FloatArray:
        matrix = np.eye(4)
        for step in node:
            if step.tag in _TRANSFORMS:
                matrix = matrix @ _transform(
                    step.tag, self._numbers(step.text, f"a {step.tag}"), self.name
                )
        return matrix

    def _referred(self, element: ElementTree.Element, key: str = "url") -> ElementTree.Element:
        url = element.get(key, "")
        if not url.startswith("#"):
            raise InputError(
                f"{self.name}: refers to another file ({url:.60}); export all into one DAE"
            )
        found = self._ids.get(url[1:])
        if found is None:
            raise InputError(f"{self.name}: refers to {url:.60}, which is missing; export it again")
        return found

    def _numbers(self, text: str | None, what: str, kind: Any = np.float64) -> Any:
        found = parse_numbers((text or "").encode("utf-8", "replace"), kind)
        if found is None:
            if "," in (text or ""):
                raise InputError(
                    f"{self.name}: {what} has decimal commas; export with decimal points"
                )
            raise InputError(f"{self.name}: {what} is no list of numbers; export the DAE again")
        return found

    def _geometry(self, geometry: ElementTree.Element) -> tuple[FloatArray, Indices]:
        """Points and triangles of a geometry in its own frame."""
        key = geometry.get("id", "")
        if key not in self._geometries:
            self._geometries[key] = self._read_geometry(geometry)
        return self._geometries[key]

    def _read_geometry(self, geometry: ElementTree.Element) -> tuple[FloatArray, Indices]:
        mesh = geometry.find("mesh")
        if mesh is None:
            kind = next((e.tag for e in geometry if e.tag not in ("asset", "extra")), "nothing")
            self.warnings.append(f"a geometry of {kind:.30} is left out; export it as a mesh")
            return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
        position = mesh.find("vertices/input[@semantic='POSITION']")
        if position is None:
            if not any(e.tag in _PRIMITIVES for e in mesh):
                return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
            raise InputError(f"{self.name}: a mesh has no positions; export it again")
        points = self._coordinates(self._referred(position, "source"))
        triangles = [self._triangles(e, points) for e in mesh if e.tag in _PRIMITIVES]
        return points, np.concatenate((np.zeros((0, 3), dtype=np.int64), *triangles))

    def _coordinates(self, source: ElementTree.Element) -> FloatArray:
        """The X, Y and Z (n, 3) of a source."""
        values, accessor = self._source_values(source)
        stride = self._integer(accessor, "stride", 1)
        names = [param.get("name") for param in accessor.findall("param")]
        axes = [names.index(axis) for axis in "XYZ" if axis in names]
        if len(axes) != 3:
            axes = [0, 1, 2]
        if stride < 3:
            raise InputError(f"{self.name}: has positions of {stride} numbers; export it again")
        rows = self._rows(values, accessor, stride)
        return np.asarray(rows[:, axes], dtype=np.float64)

    def _rows(self, values: Any, accessor: ElementTree.Element, stride: int) -> Any:
        """An accessor's rows (count, stride) of the numbers of its array."""
        start, count = self._integer(accessor, "offset", 0), self._integer(accessor, "count", 0)
        if start + count * stride > len(values):
            raise InputError(
                f"{self.name}: claims {count} rows of {stride} numbers, more than it holds "
                f"({len(values)}); it is truncated or inconsistent, export it again"
            )
        return values[start : start + count * stride].reshape(count, stride)

    def _source_values(self, source: ElementTree.Element) -> tuple[FloatArray, ElementTree.Element]:
        accessor = source.find("technique_common/accessor")
        array = source.find("float_array")
        if accessor is None:
            raise InputError(f"{self.name}: a source has no accessor; export it again")
        if array is None:
            array = self._referred(accessor, "source")
        return self._numbers(array.text, f"the array {array.get('id', '')}"), accessor

    def _integer(self, element: ElementTree.Element, key: str, default: int) -> int:
        try:
            found = int(element.get(key, default))
        except ValueError:
            found = -1
        if found < 0:
            raise InputError(
                f"{self.name}: {element.tag} has a {key} of {element.get(key):.20}; export it again"
            )
        return found

    def _triangles(self, primitive: ElementTree.Element, points: FloatArray) -> Indices:
        inputs = primitive.findall("input")
        offsets = [self._integer(e, "offset", 0) for e in inputs]
        stride = max(offsets, default=0) + 1
        at = next(
            (o for e, o in zip(inputs, offsets, strict=True) if e.get("semantic") == "VERTEX"), None
        )
        if at is None:
            raise InputError(f"{self.name}: {primitive.tag} have no VERTEX; export it again")

        def corners(element: ElementTree.Element) -> Indices:
            found = self._numbers(element.text, f"a list of {primitive.tag}", np.int64)
            if len(found) % stride:
                raise self._is_inconsistent(primitive, f"{len(found)} indices for {stride} inputs")
            found = found[at::stride]
            if len(found) and not 0 <= int(found.min()) <= int(found.max()) < len(points):
                raise self._is_inconsistent(primitive, f"a vertex that is none of {len(points)}")
            return np.asarray(found, dtype=np.int64)

        lists = [corners(p) for p in primitive.findall("p")]
        return self._cut(primitive, lists, corners, points)

    def _cut(
        self,
        primitive: ElementTree.Element,
        lists: Sequence[Indices],
        corners: Any,
        points: FloatArray,
    ) -> Indices:
        """Triangles (m, 3) of a primitive whose elements <p> hold lists of corners."""
        none = np.zeros((0, 3), dtype=np.int64)
        together = np.concatenate((none.ravel(), *lists))
        count = self._integer(primitive, "count", 0)
        match primitive.tag:
            case "triangles":
                if len(together) % 3:
                    raise self._is_inconsistent(primitive, f"{len(together)} corners")
                self._compare(primitive, count, len(together) // 3)
                return together.reshape(-1, 3)
            case "tristrips":
                return np.concatenate((none, *map(strip_triangles, lists)))
            case "trifans":
                return np.concatenate((none, *map(fan_triangles, lists)))
            case "polylist":
                sizes = self._numbers(primitive.findtext("vcount"), "a vcount", np.int64)
                if (sizes < 0).any() or sizes.sum() != len(together):
                    raise self._is_inconsistent(
                        primitive, f"{len(together)} corners for a vcount of {sizes.sum()}"
                    )
                self._compare(primitive, count, len(sizes))
                return self._count(triangulate(points, together, sizes))
        sizes = np.array([len(ring) for ring in lists], dtype=np.int64)
        found = [self._count(triangulate(points, together, sizes)) if lists else none]
        holed = primitive.findall("ph")
        for polygon in holed:
            rings = [corners(e) for e in (*polygon.findall("p"), *polygon.findall("h"))]
            found.append(self._count(triangulate_rings(points, rings)))
        self._compare(primitive, count, len(lists) + len(holed))
        return np.concatenate(found)

    def _count(self, cut: Triangulation) -> Indices:
        self.narrow += cut.narrow
        self.crossing += cut.crossing
        return cut.triangles

    def _compare(self, primitive: ElementTree.Element, count: int, held: int) -> None:
        if held < count:
            raise self._is_inconsistent(primitive, f"{held} of the {count} that it counts")
        if held > count and primitive.get("count") is not None:
            self.warnings.append(f"{primitive.tag} counts {count} and holds {held}: all are read")

    def _is_inconsistent(self, primitive: ElementTree.Element, what: str) -> InputError:
        return InputError(
            f"{self.name}: {primitive.tag} has {what}; it is truncated or inconsistent, export it "
            "again"
        )

    def _controlled(
        self, instance: ElementTree.Element, world: FloatArray
    ) -> tuple[FloatArray, Indices]:
        """Points and triangles of an instance of a controller, in the scene's frame."""
        controller = self._referred(instance)
        skin = controller.find("skin")
        if skin is None:
            return _moved(*self._shape(controller), world)
        points, triangles = self._shape(self._referred(skin, "source"))
        bind = self._numbers(skin.findtext("bind_shape_matrix"), "a bind_shape_matrix")
        if len(bind):
            points, triangles = _moved(points, triangles, self._matrix(bind))
        names, inverse = self._skin_joints(skin)
        places = [self._joint_place(name, instance) for name in names]
        missing = [name for name, place in zip(names, places, strict=True) if place is None]
        if missing:
            self.warnings.append(
                f"the joint {missing[0]:.40} of a skin is missing: it is read as it was bound"
            )
            return _moved(points, triangles, world)
        matrices = [place @ matrix for place, matrix in zip(places, inverse, strict=True)]
        owners, weights = self._skin_weights(skin, len(points))
        # joint -1 is the shape as it was bound, for points without weights, too
        matrices.append(world)
        free = weights.sum(axis=1) == 0.0
        weights[free, 0] = 1.0
        owners[free, 0] = -1
        owners = np.where(owners < 0, len(matrices) - 1, owners)
        try:
            return skin_points(points, np.stack(matrices), owners, weights), triangles
        except ValueError as exc:
            raise InputError(f"{self.name}: has {exc}; export it again") from exc

    def _matrix(self, numbers: FloatArray) -> FloatArray:
        if len(numbers) != 16:
            raise InputError(f"{self.name}: a matrix has {len(numbers)} numbers; export it again")
        return numbers.reshape(4, 4)

    def _shape(self, element: ElementTree.Element) -> tuple[FloatArray, Indices]:
        """Points and triangles of a geometry, or of a controller that morphs one."""
        if element.tag == "geometry":
            return self._geometry(element)
        morph = element.find("morph")
        if morph is None:
            raise InputError(
                f"{self.name}: a {element.tag} is neither skin nor morph; export it again"
            )
        points, triangles = self._shape(self._referred(morph, "source"))
        targets, weights = list[str](), np.zeros(0)
        for entry in morph.findall("targets/input"):
            source = self._referred(entry, "source")
            if entry.get("semantic") == "MORPH_TARGET":
                targets = (
                    source.findtext("IDREF_array") or source.findtext("Name_array") or ""
                ).split()
            elif entry.get("semantic") == "MORPH_WEIGHT":
                weights = self._source_values(source)[0]
        if len(targets) != len(weights):
            raise InputError(f"{self.name}: a morph has no weight for each target; export it again")
        base = 1.0 if morph.get("method") == "RELATIVE" else 1.0 - float(weights.sum())
        moved = base * points
        for target, weight in zip(targets, weights, strict=True):
            if weight:
                other = self._ids.get(target)
                if other is None or other.tag != "geometry":
                    raise InputError(f"{self.name}: a morph's target {target:.40} is missing")
                shape = self._geometry(other)[0]
                if len(shape) != len(points):
                    raise InputError(f"{self.name}: a morph's target has other vertices")
                moved = moved + weight * shape
        return moved, triangles

    def _skin_joints(self, skin: ElementTree.Element) -> tuple[list[str], Any]:
        names, inverse = list[str](), np.zeros((0, 4, 4))
        for entry in skin.findall("joints/input"):
            source = self._referred(entry, "source")
            if entry.get("semantic") == "JOINT":
                text = source.findtext("Name_array") or source.findtext("IDREF_array") or ""
                names = text.split()
            elif entry.get("semantic") == "INV_BIND_MATRIX":
                values, accessor = self._source_values(source)
                inverse = self._rows(values, accessor, 16).reshape(-1, 4, 4)
        if len(names) != len(inverse):
            raise InputError(
                f"{self.name}: a skin has not a matrix for each joint; export it again"
            )
        return names, inverse

    def _joint_place(self, name: str, instance: ElementTree.Element) -> FloatArray | None:
        """World matrix of a joint: in the instance's skeletons where several have its name."""
        found = self._joints.get(name, [])
        if len(found) > 1:
            roots = [
                self._ids[word]
                for word in (
                    (e.text or "").strip().lstrip("#") for e in instance.findall("skeleton")
                )
                if word in self._ids
            ]
            inside = {id(node) for root in roots for node in root.iter("node")}
            found = [entry for entry in found if id(entry[0]) in inside] or found
        return found[0][1] if found else None

    def _skin_weights(self, skin: ElementTree.Element, count: int) -> tuple[Indices, FloatArray]:
        """Joints and weights (count, k) of the vertices; weight 0 where a vertex has fewer."""
        block = skin.find("vertex_weights")
        if block is None:
            raise InputError(f"{self.name}: a skin has no weights; export it again")
        inputs = {e.get("semantic"): e for e in block.findall("input")}
        if not {"JOINT", "WEIGHT"} <= inputs.keys():
            raise InputError(f"{self.name}: a skin has no weights; export it again")
        at = {key: self._integer(e, "offset", 0) for key, e in inputs.items()}
        stride = max(at.values()) + 1
        sizes = self._numbers(block.findtext("vcount"), "a vcount", np.int64)
        flat = self._numbers(block.findtext("v"), "a list of weights", np.int64)
        values = self._source_values(self._referred(inputs["WEIGHT"], "source"))[0]
        if len(sizes) != count or (sizes < 0).any() or sizes.sum() * stride != len(flat):
            raise InputError(
                f"{self.name}: a skin has weights for {len(sizes)} of {count} vertices, or not "
                "those that it counts; it is inconsistent, export it again"
            )
        rows = flat.reshape(-1, stride)
        which = rows[:, at["WEIGHT"]]
        if len(which) and not 0 <= int(which.min()) <= int(which.max()) < len(values):
            raise InputError(
                f"{self.name}: a skin names a weight that there is not; export it again"
            )
        most = max(int(sizes.max(initial=0)), 1)
        owners, weights = np.zeros((count, most), dtype=np.int64), np.zeros((count, most))
        owner = np.repeat(np.arange(count), sizes)
        slot = np.arange(len(rows)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
        owners[owner, slot] = rows[:, at["JOINT"]]
        weights[owner, slot] = values[which]
        return owners, weights


_PRIMITIVES = frozenset({"triangles", "polylist", "polygons", "tristrips", "trifans"})
_TRANSFORMS = {"matrix": 16, "translate": 3, "rotate": 4, "scale": 3, "lookat": 9, "skew": 7}


def _transform(kind: str, numbers: FloatArray, name: str) -> FloatArray:
    """The matrix (4, 4) of a transformation element."""
    if len(numbers) != _TRANSFORMS[kind]:
        raise InputError(
            f"{name}: a {kind} has {len(numbers)} numbers, not {_TRANSFORMS[kind]}; export it again"
        )
    matrix = np.eye(4)
    match kind:
        case "matrix":
            return numbers.reshape(4, 4)
        case "translate":
            matrix[:3, 3] = numbers
        case "scale":
            matrix[[0, 1, 2], [0, 1, 2]] = numbers
        case "rotate":
            length = float(np.linalg.norm(numbers[:3]))
            if length > 0.0:
                turn = np.radians(numbers[3]) * numbers[:3] / length
                matrix[:3, :3] = Rotation.from_rotvec(turn).as_matrix()
        case "lookat":
            eye, target, up = numbers.reshape(3, 3)
            back = (eye - target) / np.linalg.norm(eye - target)
            right = np.cross(up, back) / np.linalg.norm(np.cross(up, back))
            matrix[:3] = np.column_stack((right, np.cross(back, right), back, eye))
        case "skew":
            # angle, the axis that is turned, the axis along which it moves
            turned, along = (axis / np.linalg.norm(axis) for axis in (numbers[1:4], numbers[4:]))
            matrix[:3, :3] += np.tan(np.radians(numbers[0])) * np.outer(along, turned)
    return matrix


def _moved(
    points: FloatArray, triangles: Indices, matrix: FloatArray
) -> tuple[FloatArray, Indices]:
    moved = points @ matrix[:3, :3].T + matrix[:3, 3]
    return moved, triangles[:, ::-1] if np.linalg.det(matrix[:3, :3]) < 0.0 else triangles
