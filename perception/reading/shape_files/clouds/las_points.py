"""Clouds in LAS and LAZ files: their header held against the file's size, then read by laspy.

LAZ is read in a process of its own: `python -m …las_points FILE` writes rows of 64-bit x, y, z and
mark. The decompressor (lazrs) panics, aborts, and makes room for whatever a damaged chunk table
claims. There that ends nothing else, and memory and time are limited.
"""

import os
import struct
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from facetlog.errors import InputError, make_missing_extra_error
from facetlog.perception.reading.shape_files.clouds.point_cloud import Cloud
from facetlog.perception.reading.shape_files.shape_file import ShapeFile
from facetlog.perception.types import FloatArray
from facetlog.python_process import make_importing_environment, make_module_command

# LAS 1.4 R15, section 2.4: the public header block, as long as the minor version makes it.
SIGNATURE = b"LASF"
MINOR_AT = 25
SIZES_AT, SIZES = 94, "<HII"  # bytes of the header, where the points begin, how many VLRs
FORMAT_AT, COMPRESSED = 104, 0x80  # what a point has; LASzip sets the highest bit
RECORD_AT, RECORD = 105, "<HI"  # bytes of a point, how many points (before 1.4)
EXTENDED_AT, EXTENDED = 235, "<QIQ"  # from 1.4 on: where EVLRs begin, how many, how many points
LEAST_HEADER = {3: 235, 4: 375}
HEADER_BYTES, MOST_HEADER_BYTES = 227, 375
# Tables 9 and 17: low point and high noise. The second is reserved in formats 0 to 5, but written.
NOISE_CLASSES = (7, 18)
# Marks of points: what is no POINT is left out.
POINT, NOISE, WITHHELD = 0, 1, 2
# Sections 2.5 and 2.7: what a variable length record begins with.
VLR_BYTES, EVLR_BYTES = 54, 60
# Points are read so many bytes at a time: a header may claim any number of them, of any size.
CHUNK_BYTES, ROW_BYTES = 32 << 20, 32
# To read a LAZ Python, laspy and the chunks of points in work take .6 GB of addresses.
MOST_BYTES = 2 << 30
# A second is enough for 5 MB of compressed points; starting takes one.
SECONDS, BYTES_PER_SECOND = 30, 1 << 20


def read_las(shape: ShapeFile) -> Cloud:
    """Return the cloud of a LAS or LAZ file."""
    points, said = las_points(shape)
    cloud = Cloud.of(points, name=shape.name)
    return replace(cloud, warnings=(*said, *cloud.warnings))


def las_points(shape: ShapeFile) -> tuple[FloatArray, tuple[str, ...]]:
    """Return the points (n, 3) of a LAS or LAZ file, in its own frame, and a warning of others.

    Points that the file classifies as noise, or says are withheld, are left out; synthetic points
    and key points are points. Raise InputError where laspy is missing, for too many
    points, for damage, and where nothing else is left.
    """
    if find_spec("laspy") is None:  # an extra: surveys need it, nothing else does
        raise make_missing_extra_error(f"{shape.name}: LAS files", "laspy", "las")
    count, is_compressed = _check_header(shape)
    if is_compressed:
        if find_spec("lazrs") is None:
            raise make_missing_extra_error(f"{shape.name}: LAZ files", "lazrs", "las")
        rows = _read_compressed(shape)
    else:
        try:
            rows = np.concatenate([np.zeros((0, 4)), *read_las_chunks(shape.path)])
        except (OSError, MemoryError):
            raise
        except Exception as exc:  # readers raise any kind of error on a damaged file
            raise _make_damage_error(shape, _describe_fault(exc)) from exc
    if len(rows) < count:
        raise shape.make_truncation_error(f"has {len(rows)} of {count} points")
    points, marks = rows[:, :3], rows[:, 3]
    kept = marks == POINT
    if len(points) and not kept.any():
        raise shape.error(
            f"all of its {len(points)} points are marked as noise or withheld; "
            "export it without these marks"
        )
    return points[kept], tuple(
        f"{int((marks == mark).sum())} of {len(points)} points left out: {what}"
        for mark, what in ((NOISE, "classified as noise"), (WITHHELD, "marked as withheld"))
        if (marks == mark).any()
    )


def read_las_chunks(path: Path) -> Iterator[FloatArray]:
    """Yield the points of a LAS or LAZ file, as many at a time as take 32 MB.

    Rows (k, 4) of x, y, z and a mark: POINT, NOISE or WITHHELD.
    """
    laspy: Any = import_module("laspy")
    # names in a header may be in any encoding
    options = {"laz_backend": laspy.LazBackend.Lazrs, "encoding_errors": "replace"}
    with laspy.open(path, **options) as file:
        several = max(1, CHUNK_BYTES // max(file.header.point_format.size, ROW_BYTES))
        for chunk in file.chunk_iterator(several):
            with np.errstate(all="ignore"):  # what is not finite is left out later
                noise = np.isin(np.asarray(chunk.classification), NOISE_CLASSES)
                withheld = np.asarray(chunk.withheld).astype(bool)
                marks = np.where(noise, NOISE, np.where(withheld, WITHHELD, POINT))
                rows = np.column_stack([chunk.x, chunk.y, chunk.z, marks])
            yield np.asarray(rows, dtype=np.float64)


def _read_compressed(shape: ShapeFile) -> FloatArray:
    process = subprocess.run(
        make_module_command(
            "facetlog.perception.reading.shape_files.clouds.las_points", str(shape.path)
        ),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        start_new_session=True,  # a Ctrl-C of the terminal is for us
        env=make_importing_environment(),
        check=False,
    )
    if process.returncode:
        lines = process.stderr.decode("utf-8", "replace").strip().splitlines()
        died = process.returncode < 0 or not lines
        raise _make_damage_error(
            shape, "its compressed points end the reader" if died else lines[-1]
        )
    return np.frombuffer(process.stdout, dtype=np.float64).reshape(-1, 4)


def _describe_fault(exc: BaseException) -> str:
    """Return what a reader says of a fault, in one line."""
    said = " ".join(str(exc).split())
    return f"{type(exc).__name__} {said}" if isinstance(exc, KeyError) or not said else said


def _make_damage_error(shape: ShapeFile, reason: str) -> InputError:
    return shape.error(
        f"cannot be read as LAS ({reason[:200]}): it is truncated or damaged; "
        "export the cloud again"
    )


def _check_header(shape: ShapeFile) -> tuple[int, bool]:
    """Return how many points the file claims to have, and whether they are compressed.

    Raise InputError for counts that the file cannot hold: laspy makes room for any.
    """
    size = shape.path.stat().st_size
    with shape.path.open("rb") as file:
        head = file.read(MOST_HEADER_BYTES)
    if not head.startswith(SIGNATURE):
        raise shape.error("has no LAS header; export the cloud again")
    minor = head[MINOR_AT] if len(head) > MINOR_AT else 0
    least = MOST_HEADER_BYTES if minor > 4 else LEAST_HEADER.get(minor, HEADER_BYTES)
    if len(head) < least:
        raise shape.make_truncation_error("ends within its header")
    header_bytes, start, records = struct.unpack_from(SIZES, head, SIZES_AT)
    point_bytes, count = struct.unpack_from(RECORD, head, RECORD_AT)
    if not least <= header_bytes <= start <= size:
        raise shape.make_inconsistency_error(
            f"says that its points begin at byte {start} of {size}"
        )
    if records * VLR_BYTES > start - header_bytes:
        raise shape.make_false_claim_error(f"{records} records before its points")
    if minor >= 4:
        extended_at, extended, count = struct.unpack_from(EXTENDED, head, EXTENDED_AT)
        if extended and extended_at + extended * EVLR_BYTES > size:
            raise shape.make_false_claim_error(f"{extended} records after its points")
    shape.check_points(count)
    is_compressed = bool(head[FORMAT_AT] & COMPRESSED)
    if not is_compressed and count * point_bytes > size - start:
        raise shape.make_false_claim_error(f"{count} points")
    return count, is_compressed


def _write_points(path: Path) -> None:
    """Write the points of a file to the standard output, or end with the reason on the error."""
    _set_limits(path.stat().st_size)
    try:
        for rows in read_las_chunks(path):
            sys.stdout.buffer.write(rows.tobytes())
        sys.stdout.flush()
    except BaseException as exc:  # a panic is no Exception
        sys.stderr.write("\n" + _describe_fault(exc))
        sys.stderr.flush()
        os._exit(1)


def _set_limits(size: int) -> None:
    """Limit memory, and processor time by the size of the file, where the system can."""
    try:
        import resource
    except ImportError:  # not on Windows
        return
    for kind, most in (
        (resource.RLIMIT_AS, MOST_BYTES),
        (resource.RLIMIT_CPU, SECONDS + size // BYTES_PER_SECOND),
        (resource.RLIMIT_CORE, 0),
    ):
        hard = resource.getrlimit(kind)[1]
        kept = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(kind, (kept, hard))


if __name__ == "__main__":
    _write_points(Path(sys.argv[1]))
