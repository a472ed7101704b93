"""Meshes in PLY files: text or binary of either byte order, faces of any number of corners."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.grouped import Indices
from facetlog.perception.reading.shape_files.mesh_checks import (
    Limits,
    NoTrianglesError,
    TriangleList,
    check_triangles,
    claims_too_much,
    cut_polygons,
)
from facetlog.perception.reading.shape_files.number_text import describe_bad_row, parse_numbers
from facetlog.perception.reading.shape_files.text_decoding import (
    find_line_end,
    to_plain_bytes,
    without_bom,
)
from facetlog.perception.reading.shape_files.triangle_strips import strip_triangles
from facetlog.perception.types import FloatArray

__all__ = ["read_ply"]

# A header ends within this; most have some 300 bytes, comments may make it long.
HEADER_BYTES = 1 << 16
TYPES = {
    "char": "i1", "uchar": "u1", "int8": "i1", "uint8": "u1", "short": "i2", "ushort": "u2",
    "int16": "i2", "uint16": "u2", "int": "i4", "uint": "u4", "int32": "i4", "uint32": "u4",
    "int64": "i8", "uint64": "u8", "float": "f4", "float32": "f4", "double": "f8",
    "float64": "f8",
}  # fmt: skip
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
# What may follow the last row of a binary one.
FILL = b"\0 \t\r\n"
# Names in use for the list of a face.
CORNERS = ("vertex_indices", "vertex_index")


@dataclass(frozen=True, slots=True)
class _Property:
    name: str
    kind: np.dtype[Any]
    count_kind: np.dtype[Any] | None = None
    """Of a list: the type of its length."""


@dataclass(frozen=True, slots=True)
class _Element:
    name: str
    count: int
    properties: tuple[_Property, ...]


@dataclass(frozen=True, eq=False, slots=True)
class _Rows:
    """Where the rows of an element are: `end`, of each property its start in every row, and of
    each list its lengths. Places count bytes, or words of text.
    """

    starts: dict[str, Indices]
    lengths: dict[str, Indices]
    end: int


def read_ply(data: bytes, name: str, limits: Limits) -> TriangleList:
    """Return the triangles of a PLY.

    Raises NoTrianglesError for a PLY without faces, InputError where it ends before its last row
    or has more rows than its header counts.
    """
    order, elements, body, line = _parse_header(data, name)
    counts = {element.name: element.count for element in elements}
    if not counts.get("face") and not counts.get("tristrips"):
        raise NoTrianglesError(f"{name}: has no faces; read it as a cloud, or export the faces too")
    check_triangles(counts.get("face", 0), name, limits)
    if order:
        return _read_rows(_Bytes(body), elements, name, limits)
    try:
        return _read_rows(_Text(body, name, line), elements, name, limits)
    except InputError:
        trimmed = _trim_rows(body, elements)
        if trimmed is None:
            raise
    found = _read_rows(_Text(trimmed, name, line), elements, name, limits)
    longer = "rows have more words than its header says; those at their ends are left out"
    return replace(found, warnings=(*found.warnings, longer))


def _trim_rows(body: bytes, elements: Sequence[_Element]) -> bytes | None:
    """The rows of a text, a line each, without words that the header does not have; None where no
    row has any, or one is too short.
    """
    lines = [line.split() for line in to_plain_bytes(body).split(b"\n") if line.strip()]
    if len(lines) != sum(element.count for element in elements):
        return None
    kept, words_of = list[bytes](), iter(lines)
    for element in elements:
        for words in itertools.islice(words_of, element.count):
            at = 0
            for field in element.properties:
                if field.count_kind is None:
                    at += 1
                elif at < len(words) and words[at].isdigit():
                    at += 1 + int(words[at])
                else:
                    return None
            if at > len(words):
                return None
            kept += words[:at]
    return b" ".join(kept) if len(kept) < sum(map(len, lines)) else None


def _read_rows(
    source: "_Text | _Bytes", elements: Sequence[_Element], name: str, limits: Limits
) -> TriangleList:
    points, place = None, 0
    corners, sizes, strips = _NONE, _NONE, list[Indices]()
    for element in elements:
        rows = _find_rows(source, element, place, name)
        place = rows.end
        match element.name:
            case "vertex":
                points = _coordinates(source, element, rows, name)
            case "face":
                corners, sizes = _lists(source, element, rows, name)
            case "tristrips":
                flat, lengths = _lists(source, element, rows, name)
                strips = np.split(flat, np.cumsum(lengths)[:-1])
    _check_rest(source, elements[-1], place, name)
    if points is None:
        raise InputError(f"{name}: has no vertices; export the mesh again")
    if (sizes < 2).any():
        row = int(np.flatnonzero(sizes < 2)[0])
        raise InputError(
            f"{name}: face {row} has {sizes[row]} corners; it is inconsistent or "
            "damaged, export it again"
        )
    stripped = _strip_corners(strips)
    corners = np.concatenate((corners, stripped.ravel()))
    sizes = np.concatenate((sizes, np.full(len(stripped), 3)))
    beyond = np.flatnonzero((corners < 0) | (corners >= len(points)))
    if len(beyond):
        raise InputError(
            f"{name}: a face names vertex {corners[beyond[0]]}, its vertices are 0 to "
            f"{len(points) - 1}; it is inconsistent or damaged, export it again"
        )
    return cut_polygons(points, corners, sizes, name, limits)


_NONE: Indices = np.zeros(0, dtype=np.int64)


def _strip_corners(strips: Sequence[Indices]) -> Indices:
    """Triangles (m, 3) of strips, which -1 cuts into several."""
    pieces = [
        strip_triangles(piece[piece >= 0])
        for strip in strips
        for piece in np.split(strip, np.flatnonzero(strip == -1))
    ]
    return np.concatenate((np.zeros((0, 3), dtype=np.int64), *pieces))


def _parse_header(data: bytes, name: str) -> tuple[str, list[_Element], bytes, int]:
    """Byte order ("" of text), elements, all that follows the header, and in which line."""
    data = without_bom(data) if data[:4].lstrip(b"\xef\xbb\xbf")[:3] == b"ply" else data
    if not data.startswith(b"ply"):
        data = to_plain_bytes(data)  # UTF-16
    end = data.find(b"end_header", 0, HEADER_BYTES)
    if not data.startswith(b"ply") or end < 0:
        raise InputError(f"{name}: has no PLY header; export the mesh again")
    line_end = find_line_end(data[:end])
    start = data.find(line_end, end)
    body = b"" if start < 0 else data[start + len(line_end) :]
    lines = data[:end].decode("latin-1").replace("\r", "\n").split("\n")
    formats = [ORDERS.get(words[1]) for words in map(str.split, lines) if _is_format(words)]
    if not formats or formats[0] is None:
        raise InputError(f"{name}: its PLY header has no known format; export the mesh again")
    order, elements = formats[0], list[_Element]()
    for line in lines:
        try:
            match line.split():
                case ["element", element, count]:
                    elements.append(_Element(element, _parse_count(count), ()))
                case ["property", "list", length, kind, field] if elements:
                    new = _Property(field, _type(order, kind), _type(order, length))
                    elements[-1] = _with(elements[-1], new)
                case ["property", kind, field] if elements:
                    elements[-1] = _with(elements[-1], _Property(field, _type(order, kind)))
                case ["element" | "property", *_]:
                    raise ValueError
        except (KeyError, ValueError):
            raise InputError(
                f"{name}: {line.strip():.60}: is not understood in a PLY header; export it again"
            ) from None
    return order, elements, body, len(lines) + 1


def _is_format(words: Sequence[str]) -> bool:
    return len(words) > 1 and words[0] == "format"


def _type(order: str, kind: str) -> np.dtype[Any]:
    return np.dtype((order or "=") + TYPES[kind])


def _parse_count(word: str) -> int:
    count = int(word)
    if count < 0:
        raise ValueError
    return count


def _with(element: _Element, new: _Property) -> _Element:
    return _Element(element.name, element.count, (*element.properties, new))


class _Text:
    """The words of a PLY in text, which begin in a line."""

    def __init__(self, body: bytes, name: str, line: int) -> None:
        numbers = parse_numbers(body)
        if numbers is None:
            plain = to_plain_bytes(body)
            numbers = parse_numbers(plain)
            if numbers is None:
                raise _is_no_number(plain, name, line)
        self.numbers: FloatArray = numbers

    def __len__(self) -> int:
        return len(self.numbers)

    def width(self, _kind: np.dtype[Any]) -> int:
        return 1

    def integer(self, place: int, _kind: np.dtype[Any]) -> int:
        value = float(self.numbers[place])
        return int(value) if value.is_integer() else -1

    def values(self, places: Indices, _kind: np.dtype[Any]) -> FloatArray:
        found: FloatArray = self.numbers[places]
        return found


class _Bytes:
    """The bytes of a binary PLY."""

    def __init__(self, body: bytes) -> None:
        self.body = body
        self.raw = np.frombuffer(body, dtype=np.uint8)

    def __len__(self) -> int:
        return len(self.body)

    def width(self, kind: np.dtype[Any]) -> int:
        return kind.itemsize

    def integer(self, place: int, kind: np.dtype[Any]) -> int:
        if kind.itemsize == 1 and kind.kind == "u":
            return self.body[place]
        return int(np.frombuffer(self.body, dtype=kind, count=1, offset=place)[0])

    def values(self, places: Indices, kind: np.dtype[Any]) -> FloatArray:
        step = places[1] - places[0] if len(places) > 1 else 1
        if len(places) > 1 and step > 0 and (np.diff(places) == step).all():
            window = np.ndarray((len(places),), kind, self.body, int(places[0]), (int(step),))
            return window.astype(np.float64)
        picked = self.raw[places[:, None] + np.arange(kind.itemsize)]
        numbers: FloatArray = picked.view(kind).ravel().astype(np.float64)
        return numbers


def _is_no_number(body: bytes, name: str, line: int) -> InputError:
    for number, row in enumerate(body.split(b"\n"), line):
        if parse_numbers(row) is None:
            return describe_bad_row(name, number, row, "row of numbers")
    return InputError(f"{name}: has rows that are no numbers; export the mesh again")


def _find_rows(source: _Text | _Bytes, element: _Element, place: int, name: str) -> _Rows:
    """Where the rows of an element are that begin at a place."""
    lists = {p.name for p in element.properties if p.count_kind is not None}
    # most elements have no list, or lists of one length
    offsets, lengths, width = dict[str, int](), dict[str, int](), 0
    for field in element.properties:
        if field.count_kind is not None:
            at = place + width
            width += source.width(field.count_kind)
            first = (
                source.integer(at, field.count_kind)
                if element.count and place + width <= len(source)
                else 0
            )
            lengths[field.name] = first
            offsets[field.name] = width
            width += first * source.width(field.kind) if first > 0 else 0
        else:
            offsets[field.name] = width
            width += source.width(field.kind)
    if width == 0:
        return _Rows({}, {}, place)  # no memory for the rows of an element without properties
    end = place + element.count * width
    if not lists and end > len(source):
        raise _is_cut(source, element, (len(source) - place) // width, name)
    begins = None
    if end <= len(source) and all(first >= 0 for first in lengths.values()):
        begins = place + width * np.arange(element.count)
        for field in element.properties:
            if field.count_kind is not None and element.count:
                heads = begins + offsets[field.name] - source.width(field.count_kind)
                if (source.values(heads, field.count_kind) != lengths[field.name]).any():
                    begins = None
                    break
    if begins is not None:
        return _Rows(
            {key: begins + offset for key, offset in offsets.items()},
            {key: np.full(element.count, first) for key, first in lengths.items()},
            end,
        )
    return _walk_rows(source, element, place, name)


def _walk_rows(source: _Text | _Bytes, element: _Element, place: int, name: str) -> _Rows:
    """Where rows are whose lists have different lengths: one after the other."""
    starts: dict[str, list[int]] = {p.name: [] for p in element.properties}
    lengths: dict[str, list[int]] = {p.name: [] for p in element.properties if p.count_kind}
    steps = [
        (
            p.name,
            p.count_kind,
            source.width(p.count_kind) if p.count_kind else 0,
            source.width(p.kind),
        )
        for p in element.properties
    ]
    size = len(source)
    for row in range(element.count):
        for key, count_kind, head, item in steps:
            if count_kind is None:
                starts[key].append(place)
                place += item
                continue
            if place + head > size:
                raise _is_cut(source, element, row, name)
            length = source.integer(place, count_kind)
            if length < 0:
                raise InputError(
                    f"{name}: {element.name} {row} has a list of impossible length; it is "
                    "inconsistent or damaged, export it again"
                )
            place += head
            starts[key].append(place)
            lengths[key].append(length)
            place += length * item
        if place > size:
            raise _is_cut(source, element, row, name)
    return _Rows(
        {key: np.array(found, dtype=np.int64) for key, found in starts.items()},
        {key: np.array(found, dtype=np.int64) for key, found in lengths.items()},
        place,
    )


def _is_cut(source: _Text | _Bytes, element: _Element, row: int, name: str) -> InputError:
    if row == 0 and element.count > len(source):
        return claims_too_much(name, f"{element.count} rows of {element.name}")
    return InputError(
        f"{name}: ends after {row} of {element.count} rows of {element.name}: claims more than it "
        "holds; it is truncated or inconsistent: export or copy it again"
    )


def _check_rest(source: _Text | _Bytes, element: _Element, place: int, name: str) -> None:
    """Raise InputError where more than blanks and zeros follows the last row."""
    if place == len(source) or (isinstance(source, _Bytes) and not source.body[place:].strip(FILL)):
        return
    raise InputError(
        f"{name}: more follows than the {element.count} rows of {element.name} that its header "
        "counts; it is inconsistent, export it again"
    )


def _coordinates(source: _Text | _Bytes, element: _Element, rows: _Rows, name: str) -> FloatArray:
    kinds = {p.name: p.kind for p in element.properties if p.count_kind is None}
    if not {"x", "y", "z"} <= kinds.keys():
        raise InputError(f"{name}: its vertices have no x, y and z; export the mesh again")
    return np.column_stack([source.values(rows.starts[key], kinds[key]) for key in "xyz"])


def _lists(
    source: _Text | _Bytes, element: _Element, rows: _Rows, name: str
) -> tuple[Indices, Indices]:
    """The numbers in the lists of vertices of all rows, and how many each row has."""
    kinds = {p.name: p.kind for p in element.properties if p.count_kind is not None}
    key = next((key for key in CORNERS if key in kinds), None)
    if key is None:
        if element.count == 0:
            return _NONE, _NONE
        raise InputError(
            f"{name}: its {element.name} rows have no list vertex_indices; export the mesh again"
        )
    lengths, width = rows.lengths[key], source.width(kinds[key])
    if len(lengths) and (lengths == lengths[0]).all():
        columns = [
            source.values(rows.starts[key] + width * k, kinds[key]) for k in range(int(lengths[0]))
        ]
        return _to_integers(np.stack(columns, axis=1).ravel() if columns else _NONE), lengths
    total = int(lengths.sum())
    ends = np.cumsum(lengths)
    within = np.arange(total) - np.repeat(ends - lengths, lengths)
    places = np.repeat(rows.starts[key], lengths) + width * within
    return _to_integers(source.values(places, kinds[key])), lengths


def _to_integers(values: FloatArray | Indices) -> Indices:
    """Indices of vertices; -1, which none has, for what is no index."""
    with np.errstate(invalid="ignore"):
        found: Indices = values.astype(np.int64)
    return np.where(found == values, found, -1)
