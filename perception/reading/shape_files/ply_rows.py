"""Rows of PLY files: the header, and the numbers and lists of each row, in text or binary."""

import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.ragged import Indices
from facetlog.perception.reading.shape_files.file_text import (
    find_line_end,
    parse_numbers,
    to_plain_bytes,
    without_bom,
    without_comments,
)
from facetlog.perception.reading.shape_files.shape_file import ShapeFile
from facetlog.perception.types import FloatArray

# A header ends within this; most have some 300 bytes, comments may make it long.
HEADER_BYTES = 1 << 16
TYPES = {
    "char": "i1", "uchar": "u1", "int8": "i1", "uint8": "u1", "short": "i2", "ushort": "u2",
    "int16": "i2", "uint16": "u2", "int": "i4", "uint": "u4", "int32": "i4", "uint32": "u4",
    "int64": "i8", "uint64": "u8", "float": "f4", "float32": "f4", "double": "f8",
    "float64": "f8",
}  # fmt: skip
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
FORMAT = re.compile(rb"^[ \t]*format[ \t]+(\w+)", re.MULTILINE)
# What may follow the last row of a binary one.
FILL = b"\0 \t\r\n"


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
    properties: tuple[PlyProperty, ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class PlyHeader:
    """Elements in their order, and the `body` after the header, which begins in a `line`."""

    is_text: bool
    elements: tuple[PlyElement, ...]
    body: bytes
    line: int

    def count(self, element: str) -> int:
        """Return how many rows an element has; 0 where the file has no such element."""
        return sum(each.count for each in self.elements if each.name == element)


@dataclass(frozen=True, eq=False, slots=True)
class PlyRows:
    """The rows of an element.

    Of each property `starts` are its places in every row and `lengths` those of its lists, None of
    a number; the rows end at the place `end`. Places count bytes, or words of text.
    """

    element: PlyElement
    source: "_Bytes"
    starts: Sequence[Indices]
    lengths: Sequence[Indices | None]
    end: int

    def stack_numbers(self, names: Sequence[str]) -> FloatArray | None:
        """Return the numbers (rows, names) of properties; None where one is missing."""
        at = [self._find(name, is_list=False) for name in names]
        if None in at:
            return None
        return np.column_stack(
            [
                self.source.values(self.starts[k], self.element.properties[k].kind)
                for k in at
                if k is not None
            ]
        )

    def read_lists(self, names: Sequence[str]) -> tuple[FloatArray, Indices] | None:
        """Return the numbers in all lists of the first property of these names that is there, and
        how many each row has.
        """
        at = next((k for k in (self._find(n, is_list=True) for n in names) if k is not None), None)
        lengths = None if at is None else self.lengths[at]
        if at is None or lengths is None:
            return None
        kind = self.element.properties[at].kind
        starts, width = self.starts[at], kind.itemsize
        if len(lengths) and (lengths == lengths[0]).all():
            columns = [self.source.values(starts + width * k, kind) for k in range(int(lengths[0]))]
            return (np.stack(columns, axis=1).ravel() if columns else np.zeros(0)), lengths
        within = np.arange(int(lengths.sum())) - np.repeat(np.cumsum(lengths) - lengths, lengths)
        return self.source.values(np.repeat(starts, lengths) + width * within, kind), lengths

    def _find(self, name: str, *, is_list: bool) -> int | None:
        for k, field in enumerate(self.element.properties):
            if field.name.lower() == name and (field.count_kind is not None) == is_list:
                return k
        return None


def parse_ply_header(data: bytes, shape: ShapeFile) -> PlyHeader:
    """Return the header of a PLY with all that follows it."""
    if not data.startswith(b"ply"):
        plain = without_bom(data)
        data = plain if plain.startswith(b"ply") else to_plain_bytes(data)  # UTF-16
    end = data.find(b"end_header", 0, HEADER_BYTES)
    if not data.startswith(b"ply") or end < 0:
        raise shape.error("has no PLY header; export it again")
    line_end = find_line_end(data[:end])
    start = data.find(line_end, end)
    if start < 0:
        raise shape.make_truncation_error("ends with its header")
    lines = data[:end].splitlines()
    found = FORMAT.search(b"\n".join(lines))
    order = ORDERS.get(found[1].decode()) if found else None
    if order is None:
        raise shape.error("its PLY header has no known format; export it again")
    elements = list[PlyElement]()
    for line in (line.decode("latin-1") for line in lines):
        try:
            match line.split():
                case ["element", element, count]:
                    if int(count) < 0:
                        raise ValueError
                    elements.append(PlyElement(element, int(count)))
                    continue
                case ["property", "list", length, kind, field] if elements:
                    new = PlyProperty(
                        field, _make_ply_dtype(order, kind), _make_ply_dtype(order, length)
                    )
                case ["property", kind, field] if elements:
                    new = PlyProperty(field, _make_ply_dtype(order, kind))
                case ["element" | "property", *_]:
                    raise ValueError
                case _:
                    continue
        except (KeyError, ValueError):
            raise shape.error(
                f"{line.strip():.60}: is not understood in a PLY header; export it again"
            ) from None
        last = elements[-1]
        elements[-1] = replace(last, properties=(*last.properties, new))
    body = data[start + len(line_end) :]
    return PlyHeader(not order, tuple(elements), body, len(lines) + 2)


def _make_ply_dtype(order: str, kind: str) -> np.dtype[Any]:
    found = TYPES[kind]
    return np.dtype(order + found if order else "f8")  # of text see _pack_text


def read_ply_rows(
    header: PlyHeader, shape: ShapeFile
) -> tuple[dict[str, PlyRows], tuple[str, ...]]:
    """Return the rows of each element, and warnings.

    Raise InputError where the file ends before its last row, or has more than its header counts.
    """
    if not header.is_text:
        return _find_all_rows(_Bytes(header.body), header.elements, shape), ()
    text = without_comments(to_plain_bytes(header.body))
    try:
        return _find_all_rows(_pack_text(text, header, shape), header.elements, shape), ()
    except InputError:
        trimmed = _trim_rows(text, header.elements)
        if trimmed is None:
            raise
    longer = "rows have more words than its header says; those at their ends are left out"
    return _find_all_rows(_pack_text(trimmed, header, shape), header.elements, shape), (longer,)


def _trim_rows(text: bytes, elements: Sequence[PlyElement]) -> bytes | None:
    """Return the rows of a text, a line each, without words that the header does not have; None
    where no row has any, or one is too short.
    """
    lines = [line.split() for line in text.split(b"\n") if line.strip()]
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


class _Bytes:
    """The bytes of the rows; text is kept as 64-bit numbers, of which zeros are no filling."""

    def __init__(self, body: bytes, fill: bytes = FILL) -> None:
        self.body, self.fill = body, fill
        self.raw = np.frombuffer(body, dtype=np.uint8)

    def __len__(self) -> int:
        return len(self.body)

    def integer(self, place: int, kind: np.dtype[Any]) -> int:
        if kind.itemsize == 1 and kind.kind == "u":
            return self.body[place]
        value = np.frombuffer(self.body, dtype=kind, count=1, offset=place)[0]
        return int(value) if kind.kind in "iu" or float(value).is_integer() else -1

    def values(self, places: Indices, kind: np.dtype[Any]) -> FloatArray:
        step = int(places[1] - places[0]) if len(places) > 1 else 1
        if len(places) > 1 and step > 0 and (np.diff(places) == step).all():
            window = np.ndarray((len(places),), kind, self.body, int(places[0]), (step,))
            return window.astype(np.float64)
        picked = self.raw[places[:, None] + np.arange(kind.itemsize)]
        numbers: FloatArray = picked.view(kind).ravel().astype(np.float64)
        return numbers


def _pack_text(text: bytes, header: PlyHeader, shape: ShapeFile) -> _Bytes:
    """Return the words of a PLY in text as 64-bit numbers; InputError with the line of others."""
    numbers = parse_numbers(text)
    if numbers is None:
        rows = enumerate(text.split(b"\n"), header.line)
        number, row = next((k, row) for k, row in rows if parse_numbers(row) is None)
        raise shape.make_bad_row_error(number, row, "row of numbers")
    return _Bytes(np.asarray(numbers, dtype=np.float64).tobytes(), b"")


def _find_all_rows(
    source: _Bytes, elements: Sequence[PlyElement], shape: ShapeFile
) -> dict[str, PlyRows]:
    found, place = dict[str, PlyRows](), 0
    for element in elements:
        found[element.name] = rows = _find_rows(source, element, place, shape)
        place = rows.end
    if elements and source.body[place:].strip(source.fill):
        counts = " and ".join(f"{element.count} rows of {element.name}" for element in elements)
        raise shape.make_inconsistency_error(
            f"more follows than the {counts} that its header counts"
        )
    return found


def _find_rows(source: _Bytes, element: PlyElement, place: int, shape: ShapeFile) -> PlyRows:
    """Return the rows of an element that begin at a place."""
    fields = element.properties
    if not fields or not element.count:
        none = np.zeros(0, dtype=np.int64)
        lengths = [none if field.count_kind is not None else None for field in fields]
        return PlyRows(element, source, [none] * len(fields), lengths, place)
    least = sum((field.count_kind or field.kind).itemsize for field in fields)
    if element.count * least > len(source) - place:
        held = (len(source) - place) // least
        if held == 0 or any(field.count_kind is not None for field in fields):
            raise shape.make_false_claim_error(f"{element.count} rows of {element.name}")
        raise _make_truncation_error(element, held, shape)
    # most elements have no list, or lists of one length
    offsets, firsts, width = list[int](), list[int | None](), 0
    for field in fields:
        first = None
        if field.count_kind is not None:
            head = field.count_kind.itemsize
            is_there = place + width + head <= len(source)
            first = source.integer(place + width, field.count_kind) if is_there else -1
            width += head
        firsts.append(first)
        offsets.append(width)
        width += field.kind.itemsize * (1 if first is None else max(first, 0))
    end = place + element.count * width
    if end > len(source) or any(first is not None and first < 0 for first in firsts):
        return _walk_rows(source, element, place, shape)
    begins = place + width * np.arange(element.count)
    for field, offset, first in zip(fields, offsets, firsts, strict=True):
        if field.count_kind is not None:
            heads = begins + offset - field.count_kind.itemsize
            if (source.values(heads, field.count_kind) != first).any():
                return _walk_rows(source, element, place, shape)
    return PlyRows(
        element,
        source,
        [begins + offset for offset in offsets],
        [None if first is None else np.full(element.count, first) for first in firsts],
        end,
    )


def _walk_rows(source: _Bytes, element: PlyElement, place: int, shape: ShapeFile) -> PlyRows:
    """Find the rows of an element whose lists have different lengths: one after the other."""
    steps = [
        (
            list[int](),
            list[int](),
            field.count_kind,
            field.count_kind.itemsize if field.count_kind is not None else 0,
            field.kind.itemsize,
        )
        for field in element.properties
    ]
    size = len(source)
    for row in range(element.count):
        for starts, lengths, count_kind, head, item in steps:
            if count_kind is None:
                starts.append(place)
                place += item
                continue
            if place + head > size:
                raise _make_truncation_error(element, row, shape)
            length = source.integer(place, count_kind)
            if length < 0:
                raise shape.make_inconsistency_error(
                    f"{element.name} {row} has a list of impossible length"
                )
            place += head
            starts.append(place)
            lengths.append(length)
            place += length * item
        if place > size:
            raise _make_truncation_error(element, row, shape)
    return PlyRows(
        element,
        source,
        [np.array(starts, dtype=np.int64) for starts, *_ in steps],
        [None if kind is None else np.array(found, np.int64) for _, found, kind, *_ in steps],
        place,
    )


def _make_truncation_error(element: PlyElement, row: int, shape: ShapeFile) -> InputError:
    rows = f"{row} of {element.count} rows of {element.name}"
    return shape.make_truncation_error(f"ends after {rows}: claims more than it holds")
