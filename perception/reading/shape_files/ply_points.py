"""Points of a PLY file without faces: text, or binary of either byte order."""

from dataclasses import dataclass
from typing import BinaryIO

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.point_table import (
    PointTable,
    columns_of,
    rows_from_binary,
    rows_from_text,
)

__all__ = ["read_ply_points"]

# A header ends within this; most have some 300 bytes, comments may make it long.
HEADER_BYTES = 1 << 16
TYPES = {
    "char": "i1", "uchar": "u1", "int8": "i1", "uint8": "u1", "short": "i2", "ushort": "u2",
    "int16": "i2", "uint16": "u2", "int": "i4", "uint": "u4", "int32": "i4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
ORDERS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass(frozen=True, slots=True)
class _Element:
    name: str
    count: int
    properties: tuple[tuple[str, str], ...]


def read_ply_points(file: BinaryIO, name: str, most: int) -> PointTable:
    """The vertices of a PLY; InputError where it is damaged or has more than `most`."""
    head = file.read(HEADER_BYTES)
    before, ended, _ = head.partition(b"end_header")
    if not head.startswith(b"ply") or not ended:
        raise InputError(f"{name}: has no PLY header; export the cloud again")
    start = head.find(b"\n", len(before)) + 1
    if start == 0:
        raise InputError(f"{name}: ends with its header; it is truncated")
    order, elements = _header(before, name)
    file.seek(start)
    skipped = 0
    for element in elements:
        if element.name == "vertex":
            break
        skipped += _skipped(element, order, name)
    else:
        raise InputError(f"{name}: has no vertices; export the cloud again")
    if element.count > most:
        raise InputError(f"{name}: has {element.count} points, more than {most}; thin the cloud")
    fields = tuple(field for field, _ in element.properties)
    if order == "=":
        lines = file.read().split(b"\n", skipped)
        rows = rows_from_text(name, lines[skipped], len(fields), element.count)
        return columns_of(name, fields, rows)
    file.seek(skipped, 1)
    dtype = np.dtype([(f"{k}", order + kind) for k, (_, kind) in enumerate(element.properties)])
    packed = rows_from_binary(name, file.read(), dtype, element.count)
    return columns_of(name, fields, packed)


def _header(text: bytes, name: str) -> tuple[str, tuple[_Element, ...]]:
    """Byte order and elements of a header."""
    order, elements = "", list[_Element]()
    try:
        for words in (line.split() for line in text.decode("ascii", "replace").splitlines()):
            match words:
                case ["format", kind, *_]:
                    order = ORDERS[kind]
                case ["element", element, count]:
                    elements.append(_Element(element, int(count), ()))
                case ["property", "list", *_, field]:
                    elements[-1] = _with(elements[-1], field, "list")
                case ["property", kind, field]:
                    elements[-1] = _with(elements[-1], field, TYPES[kind])
    except (IndexError, KeyError, ValueError) as exc:
        raise InputError(f"{name}: has a damaged PLY header; export the cloud again") from exc
    vertices = [element for element in elements if element.name == "vertex"]
    if (
        not order
        or any(element.count < 0 for element in elements)
        or any(kind == "list" for element in vertices for _, kind in element.properties)
    ):
        raise InputError(f"{name}: has a damaged PLY header; export the cloud again")
    return order, tuple(elements)


def _with(element: _Element, field: str, kind: str) -> _Element:
    return _Element(element.name, element.count, (*element.properties, (field, kind)))


def _skipped(element: _Element, order: str, name: str) -> int:
    """Lines, or bytes, of an element before the vertices."""
    if order == "=":
        return element.count
    if any(kind == "list" for _, kind in element.properties):
        raise InputError(
            f"{name}: has lists before its vertices; export the cloud with vertices first"
        )
    return element.count * sum(np.dtype(kind).itemsize for _, kind in element.properties)
