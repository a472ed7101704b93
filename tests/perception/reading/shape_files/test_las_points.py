"""Points of LAS files: read by laspy, after the header was held against the file's size."""

import struct
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.clouds import las_points
from facetlog.perception.reading.shape_files.shape_file import Limits, ShapeFile

POINTS = np.random.default_rng(0).normal(size=(40, 3))
needs_laspy = pytest.mark.skipif(find_spec("laspy") is None, reason="laspy is not installed")


def read(path: Path, most: int) -> tuple[np.ndarray, tuple[str, ...]]:
    return las_points.las_points(ShapeFile(path, "cloud", Limits(points=most)))


def las(path: Path, version: str = "1.4") -> bytes:
    laspy = import_module("laspy")
    made = laspy.create(point_format=6 if version == "1.4" else 1, file_version=version)
    made.header.scales = [1e-4] * 3
    made.x, made.y, made.z = POINTS.T
    made.write(path)
    return path.read_bytes()


@needs_laspy
@pytest.mark.parametrize(
    ("name", "version"), [("a.las", "1.2"), ("a.las", "1.3"), ("a.laz", "1.4")]
)
def test_points_come_back_as_they_were_written(tmp_path: Path, name: str, version: str) -> None:
    path = tmp_path / name
    las(path, version)
    np.testing.assert_allclose(read(path, 100)[0], POINTS, atol=1e-4)
    with pytest.raises(InputError, match=r"has 40 points, more than 39; thin"):
        read(path, 39)
    again = path.rename(tmp_path / "b.las")  # compressed or not is in the header
    np.testing.assert_allclose(read(again, 100)[0], POINTS, atol=1e-4)


@needs_laspy
@pytest.mark.parametrize("version", ["1.2", "1.4"])
def test_noise_and_withheld_points_are_left_out_and_counted(tmp_path: Path, version: str) -> None:
    path = tmp_path / "a.las"
    las(path, version)
    laspy = import_module("laspy")
    made = laspy.read(path)
    classes = np.full(40, 2)
    classes[:3], classes[3] = 7, 18
    made.classification = classes
    made.withheld = (np.arange(40) == 5).astype(np.uint8)
    made.synthetic = made.key_point = np.ones(40, dtype=np.uint8)
    made.write(path)
    points, said = read(path, 100)
    np.testing.assert_allclose(points, np.delete(POINTS, [0, 1, 2, 3, 5], axis=0), atol=1e-4)
    assert said == (
        "4 of 40 points left out: classified as noise",
        "1 of 40 points left out: marked as withheld",
    )
    made.withheld = np.ones(40, dtype=np.uint8)
    made.write(path)
    with pytest.raises(InputError, match="all of its 40 points are marked"):
        read(path, 100)


@needs_laspy
@pytest.mark.parametrize(
    ("at", "form", "value", "message"),
    [
        (0, "<I", 0, "has no LAS header"),
        (94, "<H", 9, "says that its points begin"),
        (94, "<H", 0xFFF0, "says that its points begin"),
        (96, "<I", 0xFFFFFFF0, "says that its points begin"),
        (100, "<I", 0xFFFFFFF0, "claims 4294967280 records before its points"),
        (243, "<I", 0xFFFFFFF0, "claims 4294967280 records after its points"),
    ],
)
def test_counts_that_cannot_be_are_refused_before_anything_is_read(
    tmp_path: Path, at: int, form: str, value: int, message: str
) -> None:
    path = tmp_path / "a.las"
    data = bytearray(las(path))
    struct.pack_into("<Q", data, 235, len(data))  # where extended records would begin
    struct.pack_into(form, data, at, value)
    for damaged in (path, path.with_suffix(".laz")):
        damaged.write_bytes(data)
        with pytest.raises(InputError, match=f"^{damaged.name}: {message}"):
            read(damaged, 10**9)


@needs_laspy
def test_truncated_files_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.las"
    whole = las(path)
    for kept in (len(whole) - 200, 300, 30, 5):
        path.write_bytes(whole[:kept])
        with pytest.raises(InputError, match="truncated"):
            read(path, 100)


@needs_laspy
def test_damaged_laz_ends_nothing_but_its_own_process(tmp_path: Path) -> None:
    """A chunk table that claims 4 billion chunks, cut and overwritten points: one line each."""
    path = tmp_path / "a.laz"
    whole = las(path)
    (start,) = struct.unpack_from("<I", whole, 96)
    (table,) = struct.unpack_from("<q", whole, start)
    chunks, far, points = bytearray(whole), bytearray(whole), bytearray(whole)
    struct.pack_into("<I", chunks, table + 4, 0xFFFFFFFF)
    struct.pack_into("<q", far, start, 2**40)
    points[start + 8 :] = b"\xff" * (len(whole) - start - 8)
    for damaged in (chunks, far, points, whole[: start + 30]):
        path.write_bytes(damaged)
        with pytest.raises(InputError, match=r"^a\.laz: [^\n]*truncated"):
            read(path, 100)


@needs_laspy
@pytest.mark.parametrize("name", ["a.las", "a.laz"])
def test_names_in_the_header_may_be_in_any_encoding(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    data = bytearray(las(path))
    data[26:29] = b"M\xfcn"  # the system identifier, in Latin-1
    path.write_bytes(data)
    np.testing.assert_allclose(read(path, 100)[0], POINTS, atol=1e-4)
