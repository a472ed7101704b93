"""Points of LAS and LAZ files: their header held against the file's size, then read by laspy."""

import struct
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from facetlog.errors import InputError, missing_extra
from facetlog.perception.types import FloatArray

__all__ = ["las_points"]

# LAS 1.4 R15, section 2.4: the public header block, as long as the minor version makes it.
SIGNATURE = b"LASF"
MINOR_AT = 25
SIZES_AT, SIZES = 94, "<HII"  # bytes of the header, where the points begin, how many VLRs
RECORD_AT, RECORD = 105, "<HI"  # bytes of a point, how many points (before 1.4)
EXTENDED_AT, EXTENDED = 235, "<QIQ"  # from 1.4 on: where EVLRs begin, how many, how many points
LEAST_HEADER = {3: 235, 4: 375}
HEADER_BYTES, MOST_HEADER_BYTES = 227, 375
# Tables 9 and 17: low point and high noise. The second is reserved in formats 0 to 5, but written.
NOISE_CLASSES = (7, 18)
# Sections 2.5 and 2.7: what a variable length record begins with.
VLR_BYTES, EVLR_BYTES = 54, 60


def las_points(path: Path, most: int) -> tuple[FloatArray, tuple[str, ...]]:
    """Return the points (n, 3) of a LAS or LAZ file, in its own frame, and a warning of others.

    Points that the file classifies as noise, or says are withheld, are left out; synthetic points
    and key points are points. Raises InputError where laspy is missing, for more than `most`
    points, for damage, and where nothing else is left.
    """
    try:
        laspy: Any = import_module("laspy")  # an extra: surveys need it, nothing else does
    except ImportError as exc:
        raise missing_extra(f"{path.name}: LAS files", "laspy", "las") from exc
    _check_header(path, most)
    try:
        with laspy.open(path) as file:
            table = file.read()
            points = np.array(table.xyz, dtype=np.float64)
            noise = np.isin(np.asarray(table.classification), NOISE_CLASSES)
            withheld = np.asarray(table.withheld).astype(bool) & ~noise
    except (OSError, MemoryError):
        raise
    except Exception as exc:  # readers raise any kind of error on a damaged file
        said = " ".join(str(exc).split()) or type(exc).__name__
        raise InputError(
            f"{path.name}: cannot be read as LAS ({said[:200]}); export the cloud again"
        ) from exc
    kept = ~(noise | withheld)
    if len(points) and not kept.any():
        raise InputError(
            f"{path.name}: all of its {len(points)} points are marked as noise or withheld; "
            "export it without these marks"
        )
    return points[kept], tuple(
        f"{int(left.sum())} of {len(points)} points left out: {what}"
        for left, what in ((noise, "classified as noise"), (withheld, "marked as withheld"))
        if left.any()
    )


def _check_header(path: Path, most: int) -> None:
    """Raises InputError for counts that the file cannot hold: laspy makes room for any."""
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(MOST_HEADER_BYTES)
    if not head.startswith(SIGNATURE):
        raise InputError(f"{path.name}: has no LAS header; export the cloud again")
    minor = head[MINOR_AT] if len(head) > MINOR_AT else 0
    least = MOST_HEADER_BYTES if minor > 4 else LEAST_HEADER.get(minor, HEADER_BYTES)
    if len(head) < least:
        raise InputError(f"{path.name}: ends within its header; it is truncated")
    header_bytes, start, records = struct.unpack_from(SIZES, head, SIZES_AT)
    point_bytes, count = struct.unpack_from(RECORD, head, RECORD_AT)
    if not least <= header_bytes <= start <= size:
        raise InputError(
            f"{path.name}: says that its points begin at byte {start} of {size}; "
            "it is truncated or damaged"
        )
    if records * VLR_BYTES > start - header_bytes:
        raise _claims_too_much(path.name, records, "records before its points")
    if minor >= 4:
        extended_at, extended, count = struct.unpack_from(EXTENDED, head, EXTENDED_AT)
        if extended and extended_at + extended * EVLR_BYTES > size:
            raise _claims_too_much(path.name, extended, "records after its points")
    if count > most:
        raise InputError(f"{path.name}: has {count} points, more than {most}; thin the cloud")
    if path.suffix.lower() == ".las" and count * point_bytes > size - start:
        raise _claims_too_much(path.name, count, "points")


def _claims_too_much(name: str, count: int, what: str) -> InputError:
    return InputError(
        f"{name}: claims {count} {what}, more than it holds; it is truncated or damaged"
    )
