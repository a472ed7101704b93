"""OBJ files: vertices and faces of any number of corners, by absolute or relative indices."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from facetlog.perception.ragged import Indices
from facetlog.perception.reading.shape_files.file_text import (
    parse_numbers,
    parse_rows,
    to_plain_bytes,
    without_comments,
)
from facetlog.perception.reading.shape_files.meshes.mesh_checks import (
    NoTrianglesError,
    TriangleList,
    cut_polygons,
)
from facetlog.perception.reading.shape_files.shape_file import ShapeFile, quote_line

# Corners are v, v/vt, v//vn or v/vt/vn.
OTHER_INDICES = re.compile(rb"/[-+\d/]*")
FREE_FORM = (b"curv", b"curv2", b"surf")
# Elements other than faces that use vertices.
LINES_AND_POINTS = (b"l", b"p")
# Vertices after all that faces name: fewer, or a smaller share, are left over from editing.
LEAST_LEFT = 4
LEAST_LEFT_SHARE = 0.01


def read_obj(data: bytes, shape: ShapeFile) -> TriangleList:
    """Return the triangles of an OBJ.

    Raise InputError with the line of a vertex or face that is none.
    """
    text = to_plain_bytes(data)
    if b"\0" in text:
        raise shape.error("is no text, so no OBJ; export the mesh again")
    vertices, faces = list[bytes](), list[bytes]()
    vertex_lines, face_lines, before = list[int](), list[int](), list[int]()
    free_form = drawn = False
    for number, line in _join_continued_lines(text):
        match line[:2]:
            case b"v ":
                vertices.append(line[2:])
                vertex_lines.append(number)
                continue
            case b"f ":
                faces.append(line[2:])
                face_lines.append(number)
                before.append(len(vertices))
                continue
            case b"vn" | b"vt" | b"# " | b"" | b"g " | b"s " | b"o " | b"us":
                continue
        words = line.split(None, 1)
        match words[:1]:
            case [b"v"]:
                vertices.append(words[1] if len(words) > 1 else b"")
                vertex_lines.append(number)
            case [b"f" | b"fo"]:  # fo: of the first versions
                faces.append(words[1] if len(words) > 1 else b"")
                face_lines.append(number)
                before.append(len(vertices))
            case [word]:
                free_form |= word in FREE_FORM
                drawn |= word in LINES_AND_POINTS
    if not faces and free_form:
        raise shape.error("has free-form surfaces only; export it as polygons")
    if not faces and not vertices:
        raise shape.error("has neither vertices nor faces, so it is no OBJ with a surface")
    if not faces:
        raise NoTrianglesError(f"{shape.name}: has no faces; give a mesh, or read it as a cloud")
    points = parse_rows(_without_comments(vertices), 3, vertex_lines, shape, "vertex")
    corners, sizes = _parse_faces(_without_comments(faces), face_lines, shape)
    if sizes[-1] < 3 and not text.endswith(b"\n") and text.endswith(faces[-1]):
        raise shape.make_truncation_error("ends within a face")
    corners = _to_absolute(corners, sizes, before, face_lines, len(points), shape)
    found = cut_polygons(points, corners, sizes, shape)
    if not free_form:
        said = () if drawn else _warn_of_cut(corners, len(points))
        return replace(found, warnings=(*found.warnings, *said))
    left_out = "free-form surfaces are left out; export them as polygons"
    return replace(found, warnings=(*found.warnings, left_out))


def _warn_of_cut(corners: Indices, count: int) -> tuple[str, ...]:
    """Warn where faces name all vertices up to one, and none of many after it."""
    named = int(corners.max()) + 1
    left = count - named
    if left < max(LEAST_LEFT, LEAST_LEFT_SHARE * count) or len(np.unique(corners)) < named:
        return ()
    return (
        f"no face names the last {left:,} of {count:,} vertices: if the file was cut off, export "
        "or copy it again",
    )


def _join_continued_lines(text: bytes) -> Iterator[tuple[int, bytes]]:
    r"""Yield lines by the number of their first, those that end in \ with the next; comments never
    do.
    """
    if b"\\" not in text:
        yield from enumerate(text.split(b"\n"), 1)
        return
    start, held = 0, b""
    for number, line in enumerate(text.split(b"\n"), 1):
        start = start if held else number
        whole = held + line
        if line.rstrip().endswith(b"\\") and not whole.lstrip().startswith(b"#"):
            held = whole.rstrip()[:-1] + b" "
            continue
        held = b""
        yield start, whole
    if held:
        yield start, held


def _without_comments(rows: Sequence[bytes]) -> Sequence[bytes]:
    return without_comments(b"\n".join(rows)).split(b"\n")


def _parse_faces(
    rows: Sequence[bytes], lines: Sequence[int], shape: ShapeFile
) -> tuple[Indices, Indices]:
    """Return the vertices of all corners as written, and how many corners each face has."""
    text = b"\n".join(rows)
    if b"/" in text:
        text = OTHER_INDICES.sub(b"", text)
        rows = text.split(b"\n")
    sizes = np.fromiter((len(row.split()) for row in rows), dtype=np.int64, count=len(rows))
    corners = parse_numbers(text, np.int64)
    if corners is None or len(corners) != sizes.sum():
        for number, row in zip(lines, rows, strict=True):
            found = parse_numbers(row, np.int64)
            if found is None or len(found) != len(row.split()):
                raise shape.error(
                    f"{quote_line(number, b'f ' + row)}: is no face; export the mesh again"
                )
        raise shape.error("has faces that are none; export the mesh again")
    return np.asarray(corners, dtype=np.int64), sizes


def _to_absolute(
    corners: Indices,
    sizes: Indices,
    before: Sequence[int],
    lines: Sequence[int],
    count: int,
    shape: ShapeFile,
) -> Indices:
    """Return corners counted from 0; files count from 1, or back from the vertices so far."""
    so_far = np.repeat(np.asarray(before, dtype=np.int64), sizes)
    found = np.where(corners > 0, corners - 1, so_far + corners)
    wrong = np.flatnonzero((corners == 0) | (found < 0) | (found >= count))
    if not len(wrong):
        return found
    at = int(wrong[0])
    value = int(corners[at])
    line = lines[int(np.searchsorted(np.cumsum(sizes), at, side="right"))]
    place = f"line {line}: vertex {value}"
    if value == 0:
        raise shape.error(f"{place}: indices of an OBJ begin at 1; export the mesh again")
    if value < 0:
        raise shape.error(f"{place}: there are {so_far[at]} before it; export the mesh again")
    raise shape.make_inconsistency_error(f"{place}: there are {count}")
