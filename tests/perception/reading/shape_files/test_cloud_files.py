"""Files of point clouds: every form gives the same points, and damage is one clear line."""

import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.clouds.cloud_files import read_cloud
from facetlog.perception.reading.shape_files.clouds.pcd_points import decompress_lzf
from facetlog.perception.reading.shape_files.clouds.point_cloud import Cloud
from facetlog.perception.reading.shape_files.shape_file import Limits
from facetlog.perception.types import FloatArray
from tests.perception.reading.view_folders import write_colmap_binary, write_colmap_text

COUNT = 40


@pytest.fixture
def points() -> FloatArray:
    """Points that single precision holds exactly."""
    return np.random.default_rng(0).normal(size=(COUNT, 3)).astype(np.float32).astype(np.float64)


def ply(points: FloatArray, form: str, normals: FloatArray | None = None) -> bytes:
    names = ["x", "y", "z"] + (["nx", "ny", "nz"] if normals is not None else [])
    rows = points if normals is None else np.hstack([points, normals])
    head = ["ply", f"format {form} 1.0", "comment made by a test", f"element vertex {len(rows)}"]
    head += [*(f"property float {name}" for name in names), "end_header", ""]
    if form == "ascii":
        body = "\n".join(" ".join(repr(x) for x in row) for row in rows.tolist()).encode()
    else:
        body = rows.astype("<f4" if "little" in form else ">f4").tobytes()
    return "\n".join(head).encode() + body


def pcd(
    points: FloatArray, form: str, viewpoint: str = "0 0 0 1 0 0 0", rows_of_picture: int = 1
) -> bytes:
    head = (
        "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z label\nSIZE 4 4 4 2\nTYPE F F F U\nCOUNT 1 1 1 1\n"
        f"WIDTH {len(points) // rows_of_picture}\nHEIGHT {rows_of_picture}\n"
        f"VIEWPOINT {viewpoint}\nPOINTS {len(points)}\nDATA {form}\n"
    ).encode()
    rows = np.zeros(len(points), [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("label", "<u2")])
    for nth, name in enumerate("xyz"):
        rows[name] = points[:, nth]
    if form == "ascii":
        return head + "\n".join(" ".join(map(repr, [*p, 7])) for p in points.tolist()).encode()
    if form == "binary":
        return head + rows.tobytes()
    fields = b"".join(rows[name].tobytes() for name in rows.dtype.names or ())
    packed = lzf(fields)
    return head + struct.pack("<II", len(packed), len(fields)) + packed


def lzf(data: bytes) -> bytes:
    """Compressed data: literals, and repeats of what was there up to 300 bytes before."""
    made, at, start = bytearray(), 0, 0

    def add_literals() -> None:
        for first in range(start, at, 32):
            piece = data[first : min(first + 32, at)]
            made.extend([len(piece) - 1, *piece])

    while at < len(data):
        best, back = 0, 0
        for distance in range(1, min(at, 300) + 1):
            length = 0
            while at + length < len(data) and length < 264:
                if data[at + length] != data[at - distance + length]:
                    break
                length += 1
            if length > best:
                best, back = length, distance
        if best < 3:
            at += 1
            continue
        add_literals()
        high = (back - 1) >> 8
        made.extend([(min(best - 2, 7) << 5) | high, *([best - 9] if best > 8 else [])])
        made.append((back - 1) & 255)
        at += best
        start = at
    add_literals()
    return bytes(made)


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_every_form_of_ply_gives_points_and_normals(
    tmp_path: Path, points: FloatArray, form: str
) -> None:
    path = tmp_path / "a.ply"
    path.write_bytes(ply(points, form, 2.0 * points))
    cloud = read_cloud(path)
    np.testing.assert_array_equal(cloud.points, points)
    assert cloud.normals is not None
    unit = points / np.linalg.norm(points, axis=1)[:, None]
    np.testing.assert_allclose(cloud.normals, unit, atol=1e-7)


@pytest.mark.parametrize("form", ["ascii", "binary", "binary_compressed"])
def test_every_form_of_pcd_gives_the_points(tmp_path: Path, points: FloatArray, form: str) -> None:
    points[:, 2] = np.repeat(points[:8, 2], 5)  # so that there is something to compress
    path = tmp_path / "a.pcd"
    path.write_bytes(pcd(points, form))
    cloud = read_cloud(path)
    np.testing.assert_array_equal(cloud.points, points)
    assert cloud.seen_from is None


@pytest.mark.parametrize(
    ("viewpoint", "rows", "places", "turned"),
    [
        ("0 0 0 1 0 0 0", 1, None, False),
        ("0 0 0 1 0 0 0", 2, [[0, 0, 0]], False),
        ("0 0 0 1", 1, None, False),
        ("0 0 0 0 0 0 0", 1, None, False),
        ("a b c", 1, None, False),
        ("nan 0 0 1 0 0 0", 1, None, False),
        ("1 2 3 1 0 0 0", 1, [[1, 2, 3], [0, 0, 0]], False),
        ("1 2 3 nan 0 0 0", 1, [[1, 2, 3], [0, 0, 0]], False),
        ("1 2 3 5 0 0 5", 1, [[1, 2, 3], [0, 0, 0]], True),
        ("0 0 0 1 0 0 1", 1, [[0, 0, 0]], True),
    ],
)
def test_viewpoint_of_a_pcd_allows_its_place_or_the_origin(
    tmp_path: Path,
    points: FloatArray,
    viewpoint: str,
    rows: int,
    places: list[list[float]] | None,
    turned: bool,
) -> None:
    path = tmp_path / "a.pcd"
    path.write_bytes(pcd(points, "binary", viewpoint=viewpoint, rows_of_picture=rows))
    cloud = read_cloud(path)
    assert cloud.seen_from is None
    assert (None if cloud.sensor_places is None else cloud.sensor_places.tolist()) == places
    assert (cloud.world_axes is not None) == turned
    if cloud.world_axes is not None:  # a quarter turn about z
        np.testing.assert_allclose(cloud.world_axes @ [1, 0, 0], [0, 1, 0], atol=1e-12)


@given(st.binary(max_size=400), st.integers(1, 40))
def test_lzf_comes_back_as_it_was(data: bytes, times: int) -> None:
    assert decompress_lzf(lzf(data * times), len(data) * times) == data * times


@given(st.binary(max_size=60), st.integers(0, 300))
def test_damaged_lzf_is_refused_or_has_the_given_size(data: bytes, size: int) -> None:
    try:
        made = decompress_lzf(data, size)
    except ValueError:
        return
    assert len(made) == size


def with_lists(points: FloatArray, order: str, lengths: list[int]) -> bytes:
    """A PLY with an element before its vertices, and a list within and after the place of each."""
    ends = {"<": "binary_little_endian", ">": "binary_big_endian", "": "ascii"}
    head = (
        f"ply\nformat {ends[order]} 1.0\nelement camera 2\nproperty list uchar float pose\n"
        f"element vertex {len(points)}\nproperty float x\nproperty list uchar int64 views\n"
        "property float y\nproperty float z\nproperty uint64 id\nproperty list uint short w\n"
        "end_header\n"
    ).encode()
    rows = [[(2, "u1"), (0.5, "f4"), (1.5, "f4")], [(0, "u1")]]
    for (x, y, z), n in zip(points.tolist(), lengths, strict=True):
        views = [(n, "u1"), *[(k, "i8") for k in range(n)]]
        rows.append([(x, "f4"), *views, (y, "f4"), (z, "f4"), (2**40, "u8"), (1, "u4"), (7, "i2")])
    if not order:
        return head + "\n".join(" ".join(str(v) for v, _ in row) for row in rows).encode()
    return head + b"".join(np.array(v, order + kind).tobytes() for row in rows for v, kind in row)


@pytest.mark.parametrize("order", ["", "<", ">"])
@pytest.mark.parametrize("lengths", [[3] * COUNT, [k % 4 for k in range(COUNT)]])
def test_vertices_of_a_ply_may_have_lists(
    tmp_path: Path, points: FloatArray, order: str, lengths: list[int]
) -> None:
    path = tmp_path / "a.ply"
    whole = with_lists(points, order, lengths)
    path.write_bytes(whole)
    np.testing.assert_array_equal(read_cloud(path).points, points)
    path.write_bytes(whole[: -len(whole) // 4])
    with pytest.raises(InputError, match=r"of 40 rows of vertex: claims more than it holds"):
        read_cloud(path)


def test_remarks_and_numbers_that_are_none_in_a_ply(tmp_path: Path, points: FloatArray) -> None:
    path = tmp_path / "a.ply"
    lines = ply(points, "ascii").split(b"\n")
    lines[-COUNT:-COUNT] = [b"# a remark", b"1.#QNAN -1.#IND 0 # another"]
    path.write_bytes(b"\n".join(lines).replace(b"vertex 40", b"vertex 41"))
    np.testing.assert_array_equal(read_cloud(path).points, points)


@pytest.mark.parametrize(("end", "mark"), [("\r", b""), ("\r\n", b"\xef\xbb\xbf")])
@pytest.mark.parametrize("kind", ["ply", "pcd"])
@pytest.mark.parametrize("form", ["ascii", "binary"])
def test_headers_may_have_other_line_ends_and_a_mark(
    tmp_path: Path, points: FloatArray, form: str, kind: str, end: str, mark: bytes
) -> None:
    points[0, 0] = np.array([10, 13, 10, 66], "u1").view("<f4")[0]  # begins as a line end does
    binary = "binary_little_endian" if form == "binary" else form
    data = ply(points, binary) if kind == "ply" else pcd(points, form)
    last = b"end_header\n" if kind == "ply" else f"DATA {form}\n".encode()
    head, found, body = data.partition(last)
    path = tmp_path / f"a.{kind}"
    if form == "ascii":
        body = body.replace(b"\n", end.encode())
    path.write_bytes(mark + (head + found).replace(b"\n", end.encode()) + body)
    np.testing.assert_array_equal(read_cloud(path).points, points)


@pytest.mark.parametrize("kind", ["ply", "pcd"])
def test_text_may_be_utf_16(tmp_path: Path, points: FloatArray, kind: str) -> None:
    pcd_in_lower_case = pcd(points, "ascii").replace(b"TYPE F F F U", b"TYPE f f f u")
    data = ply(points, "ascii") if kind == "ply" else pcd_in_lower_case
    path = tmp_path / f"a.{kind}"
    path.write_bytes(data.decode().encode("utf-16"))
    np.testing.assert_array_equal(read_cloud(path).points, points)


def test_points_not_finite_or_there_twice_are_dropped_and_said(points: FloatArray) -> None:
    bad = np.array([[np.nan, 0.0, 0.0], [np.inf, 0.0, 0.0], [1e100, 0.0, 0.0]])
    cloud = Cloud.of(np.vstack([points, bad, points[:5]]), name="a")
    np.testing.assert_array_equal(cloud.points, points)
    assert cloud.warnings == (
        f"3 of {COUNT + 8} points left out: not finite",
        f"5 of {COUNT + 8} points left out: there twice",
    )


def test_normals_without_length_are_unknown(points: FloatArray) -> None:
    normals = np.zeros_like(points)
    assert Cloud.of(points, normals=normals).normals is None
    normals[3] = [0.0, 3.0, 4.0]
    cloud = Cloud.of(points, normals=normals)
    assert cloud.normals is not None
    np.testing.assert_allclose(cloud.normals[3], [0.0, 0.6, 0.8])
    assert not cloud.normals[4].any()


def damaged(points: FloatArray) -> dict[str, tuple[str, bytes, str]]:
    little = ply(points, "binary_little_endian")
    compressed = pcd(points, "binary_compressed")
    return {
        "no bytes": ("a.ply", b"", "is empty"),
        "no header": ("a.ply", b"hello", "no PLY header"),
        "header only": ("a.ply", b"ply\nformat ascii 1.0\nend_header", "ends with its header"),
        "more": ("a.ply", little.replace(b"x 40", b"x 30"), "more follows than the 30 rows of ve"),
        "no vertices": ("a.ply", b"ply\nformat ascii 1.0\nend_header\n", "no vertices"),
        "truncated": ("a.ply", little[:-5], "after 39 of 40 rows"),
        "a lie": ("a.ply", little.replace(b"vertex 40", b"vertex 4000000000"), "more than 5"),
        "negative": ("a.ply", little.replace(b"vertex 40", b"vertex -4"), "is not understood"),
        "no x": ("a.ply", little.replace(b"float x", b"float q"), "no x, y and z"),
        "text": ("a.ply", ply(points, "ascii").rsplit(b"\n", 2)[0], "of 40 rows"),
        "word": ("a.ply", ply(points, "ascii")[:-3] + b"zzz", "line 48: .* is no row of numbers"),
        "cut pcd": ("a.pcd", pcd(points, "binary")[:-1], "claims 40 points"),
        "cut lzf": ("a.pcd", compressed[:-1], "compressed data"),
        "wrong lzf": ("a.pcd", compressed[:-2] + b"\xff\xff", "compressed data"),
        "pcd header": ("a.pcd", b"VERSION 0.7\nFIELDS x\nDATA ascii\n1\n", "no line SIZE"),
        "pcd kind": ("a.pcd", pcd(points, "ascii").replace(b"DATA a", b"DATA b"), "no kind of PCD"),
        "prose": ("a.xyz", b"1 2 3\nonce upon a time\n", "no table of numbers"),
        "only a remark": ("a.xyz", b"# nothing\n", "no x, y, z"),
        "two columns": ("a.xyz", b"1 2\n" * 40, "no x, y, z"),
        "few": ("a.xyz", b"1 2 3\n4 5 6\n", "at least 16"),
        "one place": ("a.xyz", b"1 2 3\n" * 400, "at least 16"),
        "other kind": ("a.jpg", b"x", "is no point cloud"),
    }


@pytest.mark.parametrize("case", damaged(np.ones((COUNT, 3))))
def test_bad_files_are_refused_in_one_line_that_names_them(
    tmp_path: Path, points: FloatArray, case: str
) -> None:
    name, content, message = damaged(points)[case]
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(InputError, match=message) as caught:
        read_cloud(path, Limits(points=50 if case == "a lie" else 10**6))
    assert str(caught.value).startswith(name)
    assert "\n" not in str(caught.value)


def test_missing_and_too_large_files_are_refused(tmp_path: Path, points: FloatArray) -> None:
    with pytest.raises(InputError, match=r"gone\.ply: cannot be read"):
        read_cloud(tmp_path / "gone.ply")
    path = tmp_path / "a.ply"
    path.write_bytes(ply(points, "ascii"))
    with pytest.raises(InputError, match="more than 100; thin"):
        read_cloud(path, Limits(size_bytes=100))
    with pytest.raises(InputError, match=r"no points3D\.bin.*; of pictures facetlog recognize"):
        read_cloud(tmp_path)


# two cameras at (0, 0, -10) and (4, 0, -10), both upright: y down
ROWS: list[tuple[str, list[float]]] = [
    ("a.jpg", [1, 0, 0, 0, 0, 0, 10]),
    ("b.jpg", [1, 0, 0, 0, -4, 0, 10]),
]
COLMAP_CAMERA = "SIMPLE_PINHOLE", 0, (500.0, 24.0, 16.0)


def colmap_text(folder: Path, points: FloatArray) -> None:
    write_colmap_text(folder, ROWS, COLMAP_CAMERA)
    rows = [
        f"{n} {x!r} {y!r} {z!r} 9 9 9 0.5 1 0 2 0" for n, (x, y, z) in enumerate(points.tolist())
    ]
    (folder / "points3D.txt").write_text("\n".join(rows) + "\n")


def colmap_binary(folder: Path, points: FloatArray) -> None:
    write_colmap_binary(folder, ROWS, COLMAP_CAMERA)
    body = b"".join(
        struct.pack("<Q3d3BdQ4I", n, *p, 9, 9, 9, 0.5, 2, 1, 0, 2, 0)
        for n, p in enumerate(points.tolist())
    )
    (folder / "points3D.bin").write_bytes(struct.pack("<Q", len(points)) + body)


@pytest.mark.parametrize("write", [colmap_text, colmap_binary])
def test_colmap_models_give_points_viewpoints_ups_and_errors(
    tmp_path: Path, points: FloatArray, write: Callable[[Path, FloatArray], None]
) -> None:
    write(tmp_path / "tour" / "sparse" / "0", points)
    cloud = read_cloud(tmp_path / "tour")
    np.testing.assert_array_equal(cloud.points, points)
    assert cloud.seen_from is not None
    np.testing.assert_allclose(cloud.seen_from, np.tile([2.0, 0.0, -10.0], (COUNT, 1)))
    assert cloud.camera_ups is not None
    np.testing.assert_allclose(cloud.camera_ups, np.tile([0.0, -1.0, 0.0], (2, 1)), atol=1e-12)
    assert cloud.errors is not None
    distance = np.linalg.norm(np.array([[0, 0, -10], [4, 0, -10]])[:, None] - points, axis=2)
    np.testing.assert_allclose(cloud.errors, 0.5 * distance.mean(axis=0) / 500.0)


@pytest.mark.parametrize("file", ["cameras.bin", "images.bin", "points3D.bin"])
def test_truncated_colmap_models_are_refused(tmp_path: Path, points: FloatArray, file: str) -> None:
    folder = tmp_path / "model"
    colmap_binary(folder, points)
    (folder / file).write_bytes((folder / file).read_bytes()[:-3])
    with pytest.raises(InputError, match="truncated or damaged"):
        read_cloud(folder)
    (folder / file).unlink()
    with pytest.raises(InputError, match=r"cannot be read|no points3D"):
        read_cloud(folder)
