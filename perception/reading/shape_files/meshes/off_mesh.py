"""OFF files (Geomview): OFF with normals, colours or texture (NOFF, COFF, STOFF), in text."""

import re
from collections.abc import Sequence

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

# [ST][C][N][4][n]OFF, then the counts, which ModelNet and others write without a blank between.
KEYWORD = re.compile(rb"\s*(ST)?(C)?(N)?(4)?(n)?(?:OFF|off)(?:\s+(BINARY))?(?=[\s\d]|$)")
# A number in text takes a digit and a blank.
LEAST_TEXT_BYTES = 2


def read_off(data: bytes, shape: ShapeFile) -> TriangleList:
    """Return the triangles of an OFF.

    Raise InputError where its rows are fewer or more than its counts, or are none.
    """
    keyword = KEYWORD.match(data[:200])
    if keyword is not None and keyword[6]:
        raise shape.error("is a binary OFF, which is not read; export it as text or PLY")
    text = without_comments(to_plain_bytes(data))
    keyword = KEYWORD.match(text)
    if keyword is not None and (keyword[4] or keyword[5]):
        raise shape.error("is a mesh in four or more dimensions; export it in three")
    # blank where the keyword was, so that lines keep their numbers
    rest = text if keyword is None else re.sub(rb"\S", b" ", keyword[0]) + text[keyword.end() :]
    rows = [(number, row) for number, row in enumerate(rest.split(b"\n"), 1) if row.strip()]
    counts = parse_numbers(rows[0][1], np.int64) if rows else None
    if counts is None or not 2 <= len(counts) <= 3 or (counts < 0).any():
        raise shape.error("has no OFF header with counts; export the mesh again")
    vertices, faces = int(counts[0]), int(counts[1])
    claim = f"{vertices} vertices and {faces} faces"
    if LEAST_TEXT_BYTES * (3 * vertices + faces) > len(text) + LEAST_TEXT_BYTES:
        raise shape.make_false_claim_error(claim)
    if faces == 0:
        raise NoTrianglesError(f"{shape.name}: has no faces; give a mesh, or read it as a cloud")
    shape.check_triangles(faces)
    rows = rows[1:]
    if len(rows) < vertices + faces:
        return _read_words(b" ".join(row for _, row in rows), vertices, faces, shape)
    if len(rows) > vertices + faces:
        more = len(rows) - vertices - faces
        raise shape.make_inconsistency_error(
            f"line {rows[vertices + faces][0]}: {more} more rows than its {claim}"
        )
    points = parse_rows(
        [row for _, row in rows[:vertices]], 3, [at for at, _ in rows[:vertices]], shape, "vertex"
    )
    return cut_polygons(points, *_parse_faces(rows[vertices:], vertices, shape), shape)


def _parse_faces(
    rows: Sequence[tuple[int, bytes]], vertices: int, shape: ShapeFile
) -> tuple[Indices, Indices]:
    """Return corners and sizes of faces: a count, as many vertices, perhaps a colour."""
    split = [row.split() for _, row in rows]
    sizes = parse_numbers(b" ".join(words[0] for words in split), np.int64)
    if sizes is not None and len(sizes) == len(rows):
        corners = parse_numbers(
            b" ".join(
                b" ".join(words[1 : 1 + size]) for words, size in zip(split, sizes, strict=True)
            ),
            np.int64,
        )
        whole = corners is not None and len(corners) == sizes.sum() and (sizes > 0).all()
        if whole and not ((corners < 0) | (corners >= vertices)).any():
            return np.asarray(corners), np.asarray(sizes)
    for (number, row), words in zip(rows, split, strict=True):
        found = parse_numbers(b" ".join(words[:1]), np.int64)
        size = -1 if found is None else int(found[0])
        corners = None if size <= 0 else parse_numbers(b" ".join(words[1 : 1 + size]), np.int64)
        place = quote_line(number, row)
        if corners is None or len(corners) != size:
            raise shape.make_inconsistency_error(f"{place}: is no face")
        if ((corners < 0) | (corners >= vertices)).any():
            raise shape.make_inconsistency_error(
                f"{place}: names a vertex beyond 0 to {vertices - 1}"
            )
    raise shape.error("has faces that are none; export the mesh again")


def _read_words(text: bytes, vertices: int, faces: int, shape: ShapeFile) -> TriangleList:
    """Read an OFF with other lines than one a row: plain vertices, and faces without colours."""
    numbers = parse_numbers(text)
    cut = shape.make_false_claim_error(f"{vertices} vertices and {faces} faces")
    if numbers is None or len(numbers) < 3 * vertices:
        raise cut
    points, words = numbers[: 3 * vertices].reshape(-1, 3), numbers[3 * vertices :].astype(np.int64)
    sizes, starts, at = list[int](), list[int](), 0
    while len(sizes) < faces and at < len(words) and words[at] >= 0:
        sizes.append(int(words[at]))
        starts.append(at + 1)
        at += 1 + sizes[-1]
    if len(sizes) < faces or at != len(words):
        raise cut
    places = [np.arange(start, start + size) for start, size in zip(starts, sizes, strict=True)]
    corners = words[np.concatenate(places)]
    if ((corners < 0) | (corners >= vertices)).any():
        raise cut
    return cut_polygons(points, corners, np.array(sizes), shape)
