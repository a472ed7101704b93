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
from facetlog.perception.ragged import Indices
from facetlog.perception.reading.shape_files.file_text import parse_numbers
from facetlog.perception.reading.shape_files.meshes.mesh_checks import (
    NoTrianglesError,
    TriangleList,
    merge_parts,
    move_part,
    skin_points,
)
from facetlog.perception.reading.shape_files.meshes.polygons import (
    Triangulation,
    fan_triangles,
    strip_triangles,
    triangulate,
    triangulate_rings,
)
from facetlog.perception.reading.shape_files.shape_file import ShapeFile
from facetlog.perception.types import FloatArray

UP = {"X_UP": (1.0, 0.0, 0.0), "Y_UP": (0.0, 1.0, 0.0), "Z_UP": (0.0, 0.0, 1.0)}
# Nodes that show nodes can multiply without end.
MAX_NODES = 1_000_000
MAX_DEPTH = 500


class _NoDocumentType(ElementTree.TreeBuilder):
    """Entities of a document type can unfold without end; no exporter writes any."""

    def doctype(self, *_: str | None) -> None:
        raise InputError("has a document type; export the DAE without one")


def _parse_xml(data: bytes, shape: ShapeFile) -> ElementTree.Element:
    parser = ElementTree.XMLParser(target=_NoDocumentType())  # noqa: S314 - see there
    try:
        parser.feed(data)
        root: ElementTree.Element = parser.close()
    except InputError as exc:
        raise shape.error(f"{exc}") from None
    except (ElementTree.ParseError, LookupError, ValueError) as exc:
        raise shape.error(f"its XML is truncated or damaged ({exc}); export it again") from exc
    for element in root.iter():
        if isinstance(element.tag, str):
            element.tag = element.tag.rpartition("}")[2]  # without its namespace
    version = root.get("version", "")
    if root.tag != "COLLADA":
        raise shape.error(f"is no COLLADA document but <{root.tag:.30}>; export it again")
    if version.startswith(("1.0", "1.1", "1.2", "1.3")):
        raise shape.error(f"is COLLADA {version:.10}, which is not read; convert it to 1.4")
    return root


@dataclass(slots=True)
class DaeDocument:
    """Elements by their ids, and their numbers; errors are InputError."""

    root: ElementTree.Element
    shape: ShapeFile
    ids: dict[str, ElementTree.Element] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.ids = {e.get("id", ""): e for e in self.root.iter() if e.get("id")}

    @property
    def up_axis(self) -> str:
        """Return the name of the axis that is up, as the document has it."""
        return (self.root.findtext("asset/up_axis") or "Y_UP").strip()

    @property
    def unit_metres(self) -> float | None:
        """Return the length of the unit in metres; None where the document does not say."""
        unit = self.root.find("asset/unit")
        words = None if unit is None else unit.get("meter")
        if words is None:
            return None
        found = self.parse_numbers(words, "the unit's meter")
        if len(found) != 1 or not 0.0 < found[0] < np.inf:
            raise self.shape.error(f"has a unit of {words:.20} m; export it again")
        return float(found[0])

    def follow(self, element: ElementTree.Element, key: str = "url") -> ElementTree.Element:
        """Return the element of this document that a url refers to."""
        url = element.get(key, "")
        if not url.startswith("#"):
            raise self.shape.error(f"refers to another file ({url:.60}); export all into one DAE")
        found = self.ids.get(url[1:])
        if found is None:
            raise self.shape.error(f"refers to {url:.60}, which is missing; export it again")
        return found

    def parse_numbers(self, text: str | None, what: str, kind: Any = np.float64) -> Any:
        """Return the numbers of a text; `what` says in errors whose it is."""
        found = parse_numbers((text or "").encode("utf-8", "replace"), kind)
        if found is None:
            if "," in (text or ""):
                raise self.shape.error(f"{what} has decimal commas; export with decimal points")
            raise self.shape.error(f"{what} is no list of numbers; export the DAE again")
        return found

    def parse_integer(self, element: ElementTree.Element, key: str, default: int) -> int:
        """Return an attribute that is a count."""
        try:
            found = int(element.get(key, default))
        except ValueError:
            found = -1
        if found < 0:
            raise self.shape.error(
                f"{element.tag} has a {key} of {element.get(key):.20}; export it again"
            )
        return found

    def find_matrix(self, node: ElementTree.Element) -> FloatArray:
        """Return the matrix (4, 4) of a node's transformations, in their order."""
        matrix = np.eye(4)
        for step in node:
            if step.tag in _TRANSFORMS:
                matrix = matrix @ _make_transform(
                    step.tag, self.parse_numbers(step.text, f"a {step.tag}"), self.shape
                )
        return matrix

    def parse_matrix(self, numbers: FloatArray) -> FloatArray:
        """Return sixteen numbers as a matrix (4, 4)."""
        if len(numbers) != 16:
            raise self.shape.error(f"a matrix has {len(numbers)} numbers; export it again")
        return numbers.reshape(4, 4)

    def read_coordinates(self, source: ElementTree.Element) -> FloatArray:
        """Return the X, Y and Z (n, 3) of a source."""
        values, accessor = self.read_values(source)
        stride = self.parse_integer(accessor, "stride", 1)
        names = [param.get("name") for param in accessor.findall("param")]
        axes = [names.index(axis) for axis in "XYZ" if axis in names]
        if len(axes) != 3:
            axes = [0, 1, 2]
        if stride < 3:
            raise self.shape.error(f"has positions of {stride} numbers; export it again")
        rows = self.read_rows(values, accessor, stride)
        return np.asarray(rows[:, axes], dtype=np.float64)

    def read_rows(self, values: Any, accessor: ElementTree.Element, stride: int) -> Any:
        """Return an accessor's rows (count, stride) of the numbers of its array."""
        start = self.parse_integer(accessor, "offset", 0)
        count = self.parse_integer(accessor, "count", 0)
        if start + count * stride > len(values):
            raise self.shape.make_false_claim_error(
                f"{count} rows of {stride} numbers in an array of {len(values)}"
            )
        return values[start : start + count * stride].reshape(count, stride)

    def read_values(self, source: ElementTree.Element) -> tuple[FloatArray, ElementTree.Element]:
        """Return the numbers of a source's array, and the accessor that says how to take them."""
        accessor = source.find("technique_common/accessor")
        array = source.find("float_array")
        if accessor is None:
            raise self.shape.error("a source has no accessor; export it again")
        if array is None:
            array = self.follow(accessor, "source")
        return self.parse_numbers(array.text, f"the array {array.get('id', '')}"), accessor


_TRANSFORMS = {"matrix": 16, "translate": 3, "rotate": 4, "scale": 3, "lookat": 9, "skew": 7}


def _make_transform(kind: str, numbers: FloatArray, shape: ShapeFile) -> FloatArray:
    """Return the matrix (4, 4) of a transformation element."""
    if len(numbers) != _TRANSFORMS[kind]:
        raise shape.error(
            f"a {kind} has {len(numbers)} numbers, not {_TRANSFORMS[kind]}; export it again"
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


def read_dae(data: bytes, shape: ShapeFile) -> TriangleList:
    """Return the triangles of the scene that a COLLADA document shows.

    Raise InputError where it is no sound XML or says less than it counts.
    """
    scene = _Scene(_parse_xml(data, shape), shape)
    vertices, triangles = merge_parts(scene.iter_parts(), shape)
    if not len(triangles):
        raise NoTrianglesError(f"{shape.name}: shows no triangles; export the mesh with its scene")
    warnings = Triangulation(triangles, scene.narrow, scene.crossing).warnings
    return TriangleList(
        vertices,
        triangles,
        UP.get(scene.up_axis),
        scene.unit_metres,
        (*dict.fromkeys(scene.warnings), *warnings),
    )


@dataclass(slots=True)
class _Scene(DaeDocument):
    """Scene of a COLLADA document; `narrow` and `crossing` count faces, as in Triangulation."""

    warnings: list[str] = field(default_factory=list)
    narrow: int = 0
    crossing: int = 0
    _geometries: dict[str, tuple[FloatArray, Indices]] = field(default_factory=dict)
    _joints: dict[str, list[tuple[ElementTree.Element, FloatArray]]] = field(default_factory=dict)

    def iter_parts(self) -> Iterator[tuple[FloatArray, Indices]]:
        """Yield points and triangles of all that the scene shows, in its frame."""
        shown = self.root.find("scene/instance_visual_scene")
        if shown is None:
            raise NoTrianglesError(
                f"{self.shape.name}: shows no object; export the mesh with its scene"
            )
        scene = self.follow(shown)
        placed = list(self._iter_nodes(scene))
        for node, world in placed:
            for key in ("sid", "id", "name"):
                if node.get(key):
                    self._joints.setdefault(node.get(key, ""), []).append((node, world))
        for node, world in placed:
            for child in node:
                if child.tag == "instance_geometry":
                    points, triangles = self._get_geometry(self.follow(child))
                    yield move_part(points, triangles, world)
                elif child.tag == "instance_controller":
                    yield self._read_controller(child, world)

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
                raise self.shape.error("its nodes show each other without end; export it again")
            world = above @ self.find_matrix(node)
            yield node, world
            below = [
                self.follow(child) if child.tag == "instance_node" else child
                for child in node
                if child.tag in ("node", "instance_node")
            ]
            waiting += [(child, world, depth + 1) for child in reversed(below)]

    def _get_geometry(self, geometry: ElementTree.Element) -> tuple[FloatArray, Indices]:
        """Return points and triangles of a geometry in its own frame."""
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
            raise self.shape.error("a mesh has no positions; export it again")
        points = self.read_coordinates(self.follow(position, "source"))
        triangles = [self._triangles(e, points) for e in mesh if e.tag in _PRIMITIVES]
        return points, np.concatenate((np.zeros((0, 3), dtype=np.int64), *triangles))

    def _triangles(self, primitive: ElementTree.Element, points: FloatArray) -> Indices:
        inputs = primitive.findall("input")
        offsets = [self.parse_integer(e, "offset", 0) for e in inputs]
        stride = max(offsets, default=0) + 1
        at = next(
            (o for e, o in zip(inputs, offsets, strict=True) if e.get("semantic") == "VERTEX"), None
        )
        if at is None:
            raise self.shape.error(f"{primitive.tag} have no VERTEX; export it again")

        def corners(element: ElementTree.Element) -> Indices:
            found = self.parse_numbers(element.text, f"a list of {primitive.tag}", np.int64)
            if len(found) % stride:
                raise self._make_inconsistency_error(
                    primitive, f"{len(found)} indices for {stride} inputs"
                )
            found = found[at::stride]
            if len(found) and not 0 <= int(found.min()) <= int(found.max()) < len(points):
                raise self._make_inconsistency_error(
                    primitive, f"a vertex that is none of {len(points)}"
                )
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
        """Return triangles (m, 3) of a primitive whose elements <p> hold lists of corners."""
        none = np.zeros((0, 3), dtype=np.int64)
        together = np.concatenate((none.ravel(), *lists))
        count = self.parse_integer(primitive, "count", 0)
        match primitive.tag:
            case "triangles":
                if len(together) % 3:
                    raise self._make_inconsistency_error(primitive, f"{len(together)} corners")
                self._compare(primitive, count, len(together) // 3)
                return together.reshape(-1, 3)
            case "tristrips":
                return np.concatenate((none, *map(strip_triangles, lists)))
            case "trifans":
                return np.concatenate((none, *map(fan_triangles, lists)))
            case "polylist":
                sizes = self.parse_numbers(primitive.findtext("vcount"), "a vcount", np.int64)
                if (sizes < 0).any() or sizes.sum() != len(together):
                    raise self._make_inconsistency_error(
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
            raise self._make_inconsistency_error(primitive, f"{held} of the {count} that it counts")
        if held > count and primitive.get("count") is not None:
            self.warnings.append(f"{primitive.tag} counts {count} and holds {held}: all are read")

    def _make_inconsistency_error(self, primitive: ElementTree.Element, what: str) -> InputError:
        return self.shape.make_inconsistency_error(f"{primitive.tag} has {what}")

    def _read_controller(
        self, instance: ElementTree.Element, world: FloatArray
    ) -> tuple[FloatArray, Indices]:
        """Return points and triangles of an instance of a controller, in the scene's frame."""
        controller = self.follow(instance)
        skin = controller.find("skin")
        if skin is None:
            return move_part(*self._shape(controller), world)
        points, triangles = self._shape(self.follow(skin, "source"))
        bind = self.parse_numbers(skin.findtext("bind_shape_matrix"), "a bind_shape_matrix")
        if len(bind):
            points, triangles = move_part(points, triangles, self.parse_matrix(bind))
        names, inverse = self._skin_joints(skin)
        places = [self._find_joint_matrix(name, instance) for name in names]
        missing = [name for name, place in zip(names, places, strict=True) if place is None]
        if missing:
            self.warnings.append(
                f"the joint {missing[0]:.40} of a skin is missing: it is read as it was bound"
            )
            return move_part(points, triangles, world)
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
            raise self.shape.error(f"has {exc}; export it again") from exc

    def _shape(self, element: ElementTree.Element) -> tuple[FloatArray, Indices]:
        """Return points and triangles of a geometry, or of a controller that morphs one."""
        if element.tag == "geometry":
            return self._get_geometry(element)
        morph = element.find("morph")
        if morph is None:
            raise self.shape.error(f"a {element.tag} is neither skin nor morph; export it again")
        points, triangles = self._shape(self.follow(morph, "source"))
        targets, weights = list[str](), np.zeros(0)
        for entry in morph.findall("targets/input"):
            source = self.follow(entry, "source")
            if entry.get("semantic") == "MORPH_TARGET":
                targets = (
                    source.findtext("IDREF_array") or source.findtext("Name_array") or ""
                ).split()
            elif entry.get("semantic") == "MORPH_WEIGHT":
                weights = self.read_values(source)[0]
        if len(targets) != len(weights):
            raise self.shape.error("a morph has no weight for each target; export it again")
        base = 1.0 if morph.get("method") == "RELATIVE" else 1.0 - float(weights.sum())
        moved = base * points
        for target, weight in zip(targets, weights, strict=True):
            if weight:
                other = self.ids.get(target)
                if other is None or other.tag != "geometry":
                    raise self.shape.error(f"a morph's target {target:.40} is missing")
                shape = self._get_geometry(other)[0]
                if len(shape) != len(points):
                    raise self.shape.error("a morph's target has other vertices")
                moved = moved + weight * shape
        return moved, triangles

    def _skin_joints(self, skin: ElementTree.Element) -> tuple[list[str], Any]:
        names, inverse = list[str](), np.zeros((0, 4, 4))
        for entry in skin.findall("joints/input"):
            source = self.follow(entry, "source")
            if entry.get("semantic") == "JOINT":
                text = source.findtext("Name_array") or source.findtext("IDREF_array") or ""
                names = text.split()
            elif entry.get("semantic") == "INV_BIND_MATRIX":
                values, accessor = self.read_values(source)
                inverse = self.read_rows(values, accessor, 16).reshape(-1, 4, 4)
        if len(names) != len(inverse):
            raise self.shape.error("a skin has not a matrix for each joint; export it again")
        return names, inverse

    def _find_joint_matrix(self, name: str, instance: ElementTree.Element) -> FloatArray | None:
        """Return a joint's world matrix: in the instance's skeletons if several have its name."""
        found = self._joints.get(name, [])
        if len(found) > 1:
            words = ((e.text or "").strip().lstrip("#") for e in instance.findall("skeleton"))
            roots = [self.ids[word] for word in words if word in self.ids]
            inside = {id(node) for root in roots for node in root.iter("node")}
            found = [entry for entry in found if id(entry[0]) in inside] or found
        return found[0][1] if found else None

    def _skin_weights(self, skin: ElementTree.Element, count: int) -> tuple[Indices, FloatArray]:
        """Return joints and weights (count, k) of vertices; weight 0 where a vertex has fewer."""
        block = skin.find("vertex_weights")
        inputs = {} if block is None else {e.get("semantic"): e for e in block.findall("input")}
        if block is None or not {"JOINT", "WEIGHT"} <= inputs.keys():
            raise self.shape.error("a skin has no weights; export it again")
        at = {key: self.parse_integer(e, "offset", 0) for key, e in inputs.items()}
        stride = max(at.values()) + 1
        sizes = self.parse_numbers(block.findtext("vcount"), "a vcount", np.int64)
        flat = self.parse_numbers(block.findtext("v"), "a list of weights", np.int64)
        values = self.read_values(self.follow(inputs["WEIGHT"], "source"))[0]
        if len(sizes) != count or (sizes < 0).any() or sizes.sum() * stride != len(flat):
            raise self.shape.make_inconsistency_error(
                f"a skin has weights for {len(sizes)} of {count} vertices, or not those that it "
                "counts",
            )
        rows = flat.reshape(-1, stride)
        which = rows[:, at["WEIGHT"]]
        if len(which) and not 0 <= int(which.min()) <= int(which.max()) < len(values):
            raise self.shape.error("a skin names a weight that there is not; export it again")
        most = max(int(sizes.max(initial=0)), 1)
        owners, weights = np.zeros((count, most), dtype=np.int64), np.zeros((count, most))
        owner = np.repeat(np.arange(count), sizes)
        slot = np.arange(len(rows)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
        owners[owner, slot] = rows[:, at["JOINT"]]
        weights[owner, slot] = values[which]
        return owners, weights


_PRIMITIVES = frozenset({"triangles", "polylist", "polygons", "tristrips", "trifans"})
