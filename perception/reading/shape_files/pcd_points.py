"""Points of a PCD file (Point Cloud Library, version 0.7): text, binary, and compressed binary."""

import struct
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
from facetlog.perception.types import FloatArray

__all__ = ["decompress_lzf", "read_pcd_points"]

HEADER_BYTES = 1 << 14
# LZF makes at most 264 bytes of 3.
MOST_EXPANSION = 88
TYPES = {("F", 4): "<f4", ("F", 8): "<f8"} | {
    (kind, size): f"<{kind.lower()}{size}" for kind in "IU" for size in (1, 2, 4, 8)
}
# VIEWPOINT of a file without one: the origin, not rotated. Where the points are a picture's, row by
# row, they stand as the sensor measured them, so that the origin is its place.
NO_VIEWPOINT = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class _Header:
    fields: tuple[str, ...]
    types: tuple[str, ...]
    repeats: tuple[int, ...]
    count: int
    rows: int
    data: str
    viewpoint: tuple[float, ...]

    @property
    def row(self) -> "np.dtype[np.void]":
        """A row as it is packed."""
        return np.dtype(
            [(f"{k}", t, (n,)) if n != 1 else (f"{k}", t)
             for k, (t, n) in enumerate(zip(self.types, self.repeats, strict=True))]
        )  # fmt: skip


def read_pcd_points(file: BinaryIO, name: str, most: int) -> tuple[PointTable, FloatArray | None]:
    """The points of a PCD, and the sensor's place (3,), None where the file does not have it."""
    head = file.read(HEADER_BYTES)
    start = head.find(b"\nDATA")
    end = head.find(b"\n", start + 1)
    if start < 0 or end < 0:
        raise InputError(f"{name}: has no PCD header; export the cloud again")
    header = _header(head[:end].decode("ascii", "replace"), name)
    if header.count > most:
        raise InputError(f"{name}: has {header.count} points, more than {most}; thin the cloud")
    file.seek(end + 1)
    body = file.read()
    viewpoint = np.array(header.viewpoint[:3])
    known = (header.viewpoint != NO_VIEWPOINT or header.rows > 1) and len(viewpoint) == 3
    where = viewpoint if known and bool(np.isfinite(viewpoint).all()) else None
    match header.data:
        case "ascii":
            text = rows_from_text(name, body, sum(header.repeats), header.count)
            fields = tuple(
                field if n == 1 else f"{field}_{k}"
                for field, n in zip(header.fields, header.repeats, strict=True)
                for k in range(n)
            )
            return columns_of(name, fields, text), where
        case "binary":
            packed = rows_from_binary(name, body, header.row, header.count)
        case "binary_compressed":
            packed = _unpacked(body, header, name)
        case _:
            raise InputError(f"{name}: has DATA {header.data[:30]}, which is no kind of PCD")
    return columns_of(name, header.fields, packed), where


def _header(text: str, name: str) -> _Header:
    lines = (line.split() for line in text.splitlines() if not line.startswith("#"))
    entries = {words[0].upper(): words[1:] for words in lines if words}
    try:
        fields = tuple(entries["FIELDS"])
        sizes = [int(size) for size in entries["SIZE"]]
        types = tuple(TYPES[pair] for pair in zip(entries["TYPE"], sizes, strict=True))
        repeats = tuple(int(n) for n in entries.get("COUNT", ["1"] * len(fields)))
        if "POINTS" in entries:
            count = int(entries["POINTS"][0])
        else:
            count = int(entries["WIDTH"][0]) * int(entries["HEIGHT"][0])
        rows = int(entries.get("HEIGHT", ["1"])[0])
        viewpoint = tuple(float(x) for x in entries.get("VIEWPOINT", NO_VIEWPOINT))
        data = entries["DATA"][0].lower()
    except (IndexError, KeyError, ValueError) as exc:
        raise InputError(f"{name}: has a damaged PCD header; export the cloud again") from exc
    sound = len(fields) == len(types) == len(repeats) and min(repeats, default=0) > 0 <= count
    if not sound or sum(repeats) > HEADER_BYTES:
        raise InputError(f"{name}: has a damaged PCD header; export the cloud again")
    return _Header(fields, types, repeats, count, rows, data, viewpoint)


def _unpacked(
    body: bytes, header: _Header, name: str
) -> "np.ndarray[tuple[int], np.dtype[np.void]]":
    """Rows of compressed data, which is kept field by field."""
    row = header.row
    truncated = InputError(f"{name}: its compressed data is truncated or damaged")
    if len(body) < 8:
        raise truncated
    packed, size = struct.unpack("<II", body[:8])
    if packed > len(body) - 8 or size != header.count * row.itemsize:
        raise truncated
    if size > MOST_EXPANSION * (packed + 1):
        raise truncated
    try:
        data = decompress_lzf(body[8 : 8 + packed], size)
    except ValueError as exc:
        raise truncated from exc
    rows = np.zeros(header.count, row)
    start = 0
    for field in row.names or ():
        kind = row[field]
        rows[field] = np.frombuffer(data, kind, header.count, start)
        start += kind.itemsize * header.count
    return rows


def decompress_lzf(data: bytes, size: int) -> bytes:
    """`size` bytes from LZF (M. Lehmann, liblzf); ValueError where the data makes no such number.

    A control byte below 32 is followed by one more than so many bytes; any other says, in its
    upper 3 bits and the byte after these are all set, how many bytes to repeat, and in the other
    13 bits from how far back.

    >>> decompress_lzf(bytes([0, 97, 224, 0, 0]), 10)
    b'aaaaaaaaaa'
    """
    made = bytearray()
    at, end = 0, len(data)
    try:
        while at < end:
            control = data[at]
            at += 1
            if control < 32:
                made += data[at : at + control + 1]
                at += control + 1
                continue
            length = control >> 5
            if length == 7:
                length += data[at]
                at += 1
            length += 2
            back = ((control & 31) << 8) + data[at] + 1
            at += 1
            start = len(made) - back
            if start < 0:
                raise ValueError("refers to bytes before the first")
            piece = bytes(made[start : start + length])
            # what is repeated may reach into what it makes
            made += (piece * (length // len(piece) + 1))[:length]
            if len(made) > size:
                break
    except IndexError as exc:
        raise ValueError("ends in the middle of a repeat") from exc
    if at > end or len(made) != size:
        raise ValueError(f"makes {len(made)} bytes, not {size}")
    return bytes(made)
