"""COLLADA documents: XML without a document type, and the numbers that its elements hold."""

from dataclasses import dataclass, field
from typing import Any
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.file_text import parse_numbers
from facetlog.perception.reading.shape_files.shape_file import ShapeFile
from facetlog.perception.types import FloatArray

__all__ = ["DaeDocument", "parse_xml"]


class _NoDocumentType(ElementTree.TreeBuilder):
    """Entities of a document type can unfold without end; no exporter writes any."""

    def doctype(self, *_: str | None) -> None:
        raise InputError("has a document type; export the DAE without one")


def parse_xml(data: bytes, shape: ShapeFile) -> ElementTree.Element:
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
        start, count = (
            self.parse_integer(accessor, "offset", 0),
            self.parse_integer(accessor, "count", 0),
        )
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
