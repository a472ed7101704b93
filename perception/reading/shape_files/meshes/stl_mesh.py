"""STL files: binary by its size, or text of facets with any number of corners."""

import re
import struct

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.file_text import parse_rows, to_plain_bytes
from facetlog.perception.reading.shape_files.meshes.mesh_checks import (
    NoTrianglesError,
    TriangleList,
    cut_polygons,
)
from facetlog.perception.reading.shape_files.shape_file import ShapeFile, quote_line

HEADER_BYTES = 84
# Comments and names before the first solid or facet of text end within this.
SEEN = 1 << 12
TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
# Of text with several of them in a line.
KEYWORD = re.compile(rb"(?i)[ \t]+(?=(?:outer|vertex|endloop|endfacet|facet|endsolid)\b)")
# Random bytes are numbers of any power of ten: no mesh reaches beyond this.
MAX_COORDINATE = 1e9
# A stated normal is that of the corners within this sine: single precision of small triangles.
NORMAL_ERROR = 0.1
# What has to follow what; names of solids may be any words.
NEXT = {
    b"solid": (b"facet", b"endsolid"),
    b"facet": (b"outer",),
    b"outer": (b"vertex",),
    b"vertex": (b"vertex", b"endloop"),
    b"endloop": (b"endfacet", b"outer"),
    b"endfacet": (b"facet", b"endsolid"),
    b"endsolid": (b"solid",),
}


def read_stl(data: bytes, shape: ShapeFile) -> TriangleList:
    """Return the triangles of an STL.

    Raise InputError where it ends within a solid, or has fewer or more triangles than it counts.
    """
    head = data[: HEADER_BYTES + TRIANGLE.itemsize]
    start = to_plain_bytes(data[:SEEN]) if b"\0" in head else data[:SEEN]
    # a binary one has zeros: in numbers of triangles below 2^24, and in the two bytes after each
    if b"\0" not in start[: len(head)]:
        if re.search(rb"(?i)\b(?:solid|facet)\b", start) is None:
            shown = start.strip().decode("utf-8", "replace").partition("\n")[0]
            raise shape.error(f"is no STL: it begins with {shown:.30}; export it again")
        return _read_text(to_plain_bytes(data), shape)
    if len(data) < HEADER_BYTES:
        raise shape.error("is shorter than an STL header (84 bytes); export the mesh again")
    (count,) = struct.unpack("<I", data[80:84])
    held = (len(data) - HEADER_BYTES) // TRIANGLE.itemsize
    if count > held:
        raise shape.make_false_claim_error(f"{count} triangles")
    shape.check_triangles(count)
    rest = data[HEADER_BYTES + count * TRIANGLE.itemsize :]
    if held > count and _is_triangle_data(rest):
        raise shape.make_inconsistency_error(f"counts {count} triangles but holds {held}")
    if count == 0:
        raise NoTrianglesError(f"{shape.name}: has no triangles; export the mesh again")
    rows = np.frombuffer(data, dtype=TRIANGLE, count=count, offset=HEADER_BYTES)
    points = rows["corners"].reshape(-1, 3).astype(np.float64)
    return TriangleList(points, np.arange(3 * count).reshape(-1, 3))


def _is_triangle_data(data: bytes) -> bool:
    """Return whether bytes after the counted triangles are more of them: each with corners that
    differ and a normal at right angles to its sides.
    """
    count = len(data) // TRIANGLE.itemsize
    rows = np.frombuffer(data, dtype=TRIANGLE, count=count)
    corners = rows["corners"].astype(np.float64)
    with np.errstate(all="ignore"):
        size = np.abs(corners).max(axis=(1, 2))
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        length = np.linalg.norm(normals, axis=1)
        stated = rows["normal"].astype(np.float64)
        along = np.einsum("ij,ij->i", normals, stated) / length
        unit = np.linalg.norm(stated, axis=1)
        sound = (length > 0.0) & (size < MAX_COORDINATE)
        sound &= (unit == 0.0) | (
            (np.abs(unit - 1.0) < NORMAL_ERROR) & (np.abs(along) > 1.0 - NORMAL_ERROR)
        )
    return bool(count and sound.mean() > 0.5)


def _read_text(text: bytes, shape: ShapeFile) -> TriangleList:
    try:
        rows, numbers, sizes = _find_facets(text, shape)
    except InputError:
        one_each = KEYWORD.sub(b"\n", text)
        if one_each.count(b"\n") == text.count(b"\n"):
            raise
        rows, numbers, sizes = _find_facets(one_each, shape)
    if not sizes:
        raise NoTrianglesError(f"{shape.name}: has no facets; export the mesh again")
    points = parse_rows(rows, 3, numbers, shape, "vertex")
    return cut_polygons(points, np.arange(len(points)), np.array(sizes), shape)


def _find_facets(text: bytes, shape: ShapeFile) -> tuple[list[bytes], list[int], list[int]]:
    """Return the texts of all vertices, their lines, and how many each loop has."""
    rows, numbers, sizes = list[bytes](), list[int](), list[int]()
    last, start = b"endsolid", 0
    lines = text.rstrip().split(b"\n")
    for number, line in enumerate(lines, 1):
        words = line.split(None, 1)
        word = words[0].lower() if words else b""
        if word == b"vertex" and last in (b"outer", b"vertex"):
            rows.append(words[1] if len(words) > 1 else b"")
            numbers.append(number)
        elif not words or (last == b"endsolid" and word not in NEXT):
            continue  # text between solids
        elif word not in NEXT[last]:
            if number == len(lines):
                break  # within a word
            raise shape.make_inconsistency_error(
                f"{quote_line(number, line)}: cannot follow {last.decode()} in an STL"
            )
        elif word == b"endloop":
            sizes.append(len(rows) - start)
            start = len(rows)
        last = word
    if last != b"endsolid":
        raise shape.make_truncation_error(
            f"ends within a solid (line {len(lines)}, after {last.decode()})"
        )
    return rows, numbers, sizes
