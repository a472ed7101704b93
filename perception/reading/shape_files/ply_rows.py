"""Rows of PLY files: the header, and where each property of each row is, also behind lists."""

import re
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.grouped import Indices
from facetlog.perception.reading.shape_files.text_decoding import (
    find_line_end,
    to_plain_bytes,
    without_bom,
)
from facetlog.perception.types import FloatArray

__all__ = [
    "PlyBytes",
    "PlyElement",
    "PlyProperty",
    "PlyRows",
    "PlyText",
    "find_rows",
    "parse_ply_header",
]

# A header ends within this; most have some 300 bytes, comments may make it long.
HEADER_BYTES = 1 << 16
TYPES = {
    "char": "i1", "uchar": "u1", "int8": "i1", "uint8": "u1", "short": "i2", "ushort": "u2",
    "int16": "i2", "uint16": "u2", "int": "i4", "uint": "u4", "int32": "i4", "uint32": "u4",
    "int64": "i8", "uint64": "u8", "float": "f4", "float32": "f4", "double": "f8",
    "float64": "f8",
}  # fmt: skip
COMMENT = re.compile(rb"#[^\n]*")
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass(frozen=True, slots=True)
class PlyProperty:
    """A number of a row, or a list of them, whose length has the type `count_kind`."""

    name: str
    kind: np.dtype[Any]
    count_kind: np.dtype[Any] | None = None


@dataclass(frozen=True, slots=True)
class PlyElement:
    """So many rows with the same properties."""

    name: str
    count: int
    properties: tuple[PlyProperty, ...]


@dataclass(frozen=True, eq=False, slots=True)
class PlyRows:
    """Where the rows of an element are: `end`, of each property its start in every row, and of
    each list its lengths. Places count bytes, or words of text.
    """

    starts: dict[str, Indices]
    lengths: dict[str, Indices]
    end: int


class PlyText:
    """The words of a PLY in text."""

    def __init__(self, body: bytes, name: str) -> None:
        text = COMMENT.sub(b"", to_plain_bytes(body))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")  # numpy only warns of words that are no numbers
                self.numbers: FloatArray = np.fromstring(text, sep=" ")
        except (DeprecationWarning, ValueError):
            raise _is_no_number(text, name) from None

    def __len__(self) -> int:
        return len(self.numbers)

    def width(self, _kind: np.dtype[Any]) -> int:
        """Return how many places a number takes."""
        return 1

    def integer(self, place: int, _kind: np.dtype[Any]) -> int:
        """Return the whole number at a place, -1 for another."""
        value = float(self.numbers[place])
        return int(value) if value.is_integer() else -1

    def values(self, places: Indices, _kind: np.dtype[Any]) -> FloatArray:
        """Return the numbers at places."""
        found: FloatArray = self.numbers[places]
        return found


def _is_no_number(text: bytes, name: str) -> InputError:
    for number, line in enumerate(text.split(b"\n"), 1):
        for word in line.split():
            try:
                float(word)
            except ValueError:
                shown = word.decode("utf-8", "replace")
                return InputError(
                    f"{name}: has a damaged row {number} after its header ({shown:.30} is no "
                    "number); export it again"
                )
    return InputError(f"{name}: has rows that are no numbers; export it again")


class PlyBytes:
    """The bytes of a binary PLY."""

    def __init__(self, body: bytes) -> None:
        self.body = body
        self.raw = np.frombuffer(body, dtype=np.uint8)

    def __len__(self) -> int:
        return len(self.body)

    def width(self, kind: np.dtype[Any]) -> int:
        """Return how many places a number takes."""
        return kind.itemsize

    def integer(self, place: int, kind: np.dtype[Any]) -> int:
        """Return the whole number at a place."""
        if kind.itemsize == 1 and kind.kind == "u":
            return self.body[place]
        return int(np.frombuffer(self.body, dtype=kind, count=1, offset=place)[0])

    def values(self, places: Indices, kind: np.dtype[Any]) -> FloatArray:
        """Return the numbers at places."""
        step = int(places[1] - places[0]) if len(places) > 1 else 1
        if len(places) > 1 and step > 0 and (np.diff(places) == step).all():
            window = np.ndarray((len(places),), kind, self.body, int(places[0]), (step,))
            return window.astype(np.float64)
        picked = self.raw[places[:, None] + np.arange(kind.itemsize)]
        numbers: FloatArray = picked.view(kind).ravel().astype(np.float64)
        return numbers


def parse_ply_header(data: bytes, name: str) -> tuple[str, list[PlyElement], bytes]:
    """Return the byte order ("" of text), the elements, and all that follows the header."""
    if not data.startswith(b"ply"):
        plain = without_bom(data)
        data = plain if plain.startswith(b"ply") else to_plain_bytes(data)  # UTF-16
    end = data.find(b"end_header", 0, HEADER_BYTES)
    if not data.startswith(b"ply") or end < 0:
        raise InputError(f"{name}: has no PLY header; export it again")
    line_end = find_line_end(data[:end])
    start = data.find(line_end, end)
    if start < 0:
        raise InputError(f"{name}: ends with its header; it is truncated")
    order, elements = None, list[PlyElement]()
    for line in data[:end].decode("latin-1").replace("\r", "\n").split("\n"):
        try:
            match line.split():
                case ["format", kind, *_]:
                    order = ORDERS[kind]
                case ["element", element, count]:
                    elements.append(PlyElement(element, _parse_count(count), ()))
                case ["property", "list", length, kind, field] if elements:
                    new = PlyProperty(field, _type(order, kind), _type(order, length))
                    elements[-1] = _with(elements[-1], new)
                case ["property", kind, field] if elements:
                    elements[-1] = _with(elements[-1], PlyProperty(field, _type(order, kind)))
                case ["element" | "property", *_]:
                    raise ValueError
        except (KeyError, ValueError):
            raise InputError(
                f"{name}: {line.strip():.60}: is not understood in a PLY header; export it again"
            ) from None
    if order is None:
        raise InputError(f"{name}: its PLY header has no format; export it again")
    return order, elements, data[start + len(line_end) :]


def _type(order: str | None, kind: str) -> np.dtype[Any]:
    return np.dtype((order or "=") + TYPES[kind])


def _parse_count(word: str) -> int:
    count = int(word)
    if count < 0:
        raise ValueError
    return count


def _with(element: PlyElement, new: PlyProperty) -> PlyElement:
    return PlyElement(element.name, element.count, (*element.properties, new))


def find_rows(source: PlyText | PlyBytes, element: PlyElement, place: int, name: str) -> PlyRows:
    """Return where the rows of an element are that begin at a place.

    Raises InputError where the data ends before the last row does.
    """
    lists = [field for field in element.properties if field.count_kind is not None]
    least = sum(source.width(field.count_kind or field.kind) for field in element.properties)
    if element.count * least > len(source) - place:
        raise _is_cut(element, (len(source) - place) // max(least, 1), name)
    # most elements have no list, or lists of one length
    offsets, lengths, width = dict[str, int](), dict[str, int](), 0
    for field in element.properties:
        if field.count_kind is not None:
            at = place + width
            width += source.width(field.count_kind)
            is_there = element.count > 0 and place + width <= len(source)
            lengths[field.name] = source.integer(at, field.count_kind) if is_there else 0
        offsets[field.name] = width
        width += max(lengths.get(field.name, 1), 0) * source.width(field.kind)
    end = place + element.count * width
    begins = place + width * np.arange(element.count if end <= len(source) else 0)
    is_regular = len(begins) == element.count and all(
        lengths[field.name] >= 0
        and field.count_kind is not None
        and (
            source.values(
                begins + offsets[field.name] - source.width(field.count_kind), field.count_kind
            )
            == lengths[field.name]
        ).all()
        for field in lists
    )
    if not is_regular:
        return _walk_rows(source, element, place, name)
    return PlyRows(
        {key: begins + offset for key, offset in offsets.items()},
        {key: np.full(element.count, length) for key, length in lengths.items()},
        end,
    )


def _walk_rows(source: PlyText | PlyBytes, element: PlyElement, place: int, name: str) -> PlyRows:
    """Where rows are whose lists have different lengths: one after the other."""
    starts: dict[str, list[int]] = {p.name: [] for p in element.properties}
    lengths: dict[str, list[int]] = {p.name: [] for p in element.properties if p.count_kind}
    steps: Sequence[tuple[str, np.dtype[Any] | None, int, int]] = [
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
            if count_kind is not None:
                if place + head > size:
                    raise _is_cut(element, row, name)
                length = source.integer(place, count_kind)
                if length < 0:
                    raise InputError(
                        f"{name}: {element.name} {row} has a list of impossible length; its counts "
                        "do not fit, or it is damaged: export it again"
                    )
                place += head
                lengths[key].append(length)
                starts[key].append(place)
                place += length * item
            else:
                starts[key].append(place)
                place += item
        if place > size:
            raise _is_cut(element, row, name)
    return PlyRows(
        {key: np.array(found, dtype=np.int64) for key, found in starts.items()},
        {key: np.array(found, dtype=np.int64) for key, found in lengths.items()},
        place,
    )


def _is_cut(element: PlyElement, row: int, name: str) -> InputError:
    return InputError(
        f"{name}: ends after {row} of {element.count} rows of {element.name}: claims more than it "
        "holds; it is truncated or damaged"
    )
