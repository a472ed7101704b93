"""PLY meshes: polygons of any sizes in each encoding, and counts that do not fit."""

import codecs
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from facetlog.errors import InputError
from tests.perception.reading.shape_files.mesh_measures import AREA, area, read

ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": None}
BLOCK = np.array([(x, y, z) for x in (0.0, 3.0) for y in (0.0, 2.0) for z in (0.0, 1.0)])
# quadrilaterals and a side of two triangles
FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7, 3)]


def packed(values: object, kind: str, order: str | None) -> bytes:
    array = np.atleast_1d(np.asarray(values))
    if order is None:
        return (" ".join(str(v) for v in array) + " ").encode()
    return array.astype(np.dtype(kind).newbyteorder(order)).tobytes()  # type: ignore[arg-type]


def ply(
    encoding: str,
    *,
    faces: object = FACES,
    counts: tuple[int, int] | None = None,
    list_types: tuple[str, str] = ("uchar", "int"),
    kinds: tuple[str, str] = ("u1", "i4"),
    more: bool = False,
    key: str = "vertex_indices",
    end: bytes = b"\n",
) -> bytes:
    order = ORDERS[encoding]
    rows = [tuple(face) for face in faces]  # type: ignore[attr-defined]
    said = counts or (len(BLOCK), len(rows))
    head = ["ply", f"format {encoding} 1.0", "comment f\xfcr", f"element vertex {said[0]}"]
    head += ["property double x", "property float y", "property float z"]
    head += ["element camera 1", "property list uchar float lens"] if more else []
    head += [f"element face {said[1]}"]
    head += ["property uchar flags"] if more else []
    head += [f"property list {list_types[0]} {list_types[1]} {key}"]
    head += ["property list uchar float texcoord", "property short part"] if more else []
    row_end = end if order is None else b""
    body = b""
    for x, y, z in BLOCK:
        body += packed(x, "f8", order) + packed([y, z], "f4", order) + row_end
    if more:
        body += packed(2, "u1", order) + packed([0.5, 0.25], "f4", order) + row_end
    for row in rows:
        body += packed(7, "u1", order) if more else b""
        body += packed(len(row), kinds[0], order) + packed(row, kinds[1], order)
        if more:
            body += packed(len(row) - 2, "u1", order) + packed([0.5] * (len(row) - 2), "f4", order)
            body += packed(-3, "i2", order)
        body += row_end
    return end.join(line.encode("latin-1") for line in [*head, "end_header"]) + end + body


@pytest.mark.parametrize("encoding", ORDERS)
@pytest.mark.parametrize(("more", "end"), [(False, b"\n"), (True, b"\r\n"), (True, b"\r")])
def test_faces_of_different_sizes(tmp_path: Path, encoding: str, *, more: bool, end: bytes) -> None:
    mesh = read(tmp_path, "made.ply", ply(encoding, more=more, end=end))
    assert area(mesh) == pytest.approx(AREA)
    assert len(mesh.triangles) == 12
    assert mesh.warnings == ()


@pytest.mark.parametrize(
    ("encoding", "types", "kinds"),
    [
        ("ascii", ("uint8", "uint32"), ("u1", "u4")),
        ("binary_little_endian", ("int", "uint64"), ("i4", "u8")),
        ("binary_big_endian", ("ushort", "short"), ("u2", "i2")),
        ("binary_big_endian", ("char", "float"), ("i1", "f4")),
    ],
)
def test_types_and_names_of_lists(
    tmp_path: Path, encoding: str, types: tuple[str, str], kinds: tuple[str, str]
) -> None:
    content = ply(encoding, list_types=types, kinds=kinds, key="vertex_index")
    assert area(read(tmp_path, "made.ply", content)) == pytest.approx(AREA)


@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_the_same_faces_in_each_encoding(tmp_path: Path, data: st.DataObject) -> None:
    faces = data.draw(
        st.lists(st.lists(st.integers(0, 7), min_size=3, max_size=7), min_size=1, max_size=9)
    )
    more = data.draw(st.booleans())
    found = [read(tmp_path, "made.ply", ply(order, faces=faces, more=more)) for order in ORDERS]
    for mesh in found[1:]:
        assert np.array_equal(mesh.triangles, found[0].triangles)
        assert np.array_equal(mesh.vertices, found[0].vertices)


@pytest.mark.parametrize("encoding", ["binary_big_endian", "ascii"])
@pytest.mark.parametrize("counts", [(8, 6), (8, 8), (7, 7), (9, 7)])
@pytest.mark.parametrize("faces", [FACES, [(a, b, c) for a, b, c, *_ in FACES]])
def test_counts_that_do_not_fit_are_refused(
    tmp_path: Path, encoding: str, counts: tuple[int, int], faces: object
) -> None:
    with pytest.raises(InputError, match=r"truncated|inconsistent"):
        read(tmp_path, "made.ply", ply(encoding, faces=faces, counts=counts))


@pytest.mark.parametrize("end", [b"\n", b"\r\n"])
def test_a_mark_before_a_binary_one(tmp_path: Path, end: bytes) -> None:
    content = codecs.BOM_UTF8 + ply("binary_little_endian", end=end)
    for fill in (b"\r\n", b"\0" * 512):
        assert area(read(tmp_path, "made.ply", content + fill)) == pytest.approx(AREA)


def test_a_word_among_the_numbers_is_shown_with_its_line(tmp_path: Path) -> None:
    content = ply("ascii").replace(b"\n3.0 0.0 0.0", b"\n3,0 0.0 0.0", 1)
    with pytest.raises(InputError, match=r"line 15: 3,0 0.* decimal commas"):
        read(tmp_path, "made.ply", content)


def test_rows_longer_than_the_header_says_are_read_by_their_lines(tmp_path: Path) -> None:
    content = ply("ascii").replace(b" \n", b" 9 1 1 1\n")
    mesh = read(tmp_path, "made.ply", content)
    assert area(mesh) == pytest.approx(AREA)
    assert "more words" in mesh.warnings[0]
