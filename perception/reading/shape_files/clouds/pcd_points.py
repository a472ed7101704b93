"""Clouds in PCD files (Point Cloud Library, version 0.7): text, binary, and compressed binary.

The place of the camera whose picture an organised cloud is comes from the points alone. Row and
column of a point are its image under some projection matrix P (3, 4), whatever frame the points
were moved into: u ~ P (X, 1). The camera's centre is the null vector of P (Hartley and Zisserman,
Multiple View Geometry, 7.1 and 6.2.4).
"""

import re
import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from facetlog.perception.reading.shape_files.clouds.point_cloud import Cloud
from facetlog.perception.reading.shape_files.clouds.point_table import (
    extract_point_columns,
    read_binary_rows,
    read_text_rows,
)
from facetlog.perception.reading.shape_files.file_text import (
    find_line_end,
    to_plain_bytes,
    without_bom,
)
from facetlog.perception.reading.shape_files.shape_file import ShapeFile
from facetlog.perception.types import FloatArray

HEADER_BYTES = 1 << 14
# The header's last line, in any case: binary data begins right after its line end.
DATA_LINE = re.compile(rb"(?:^|[\r\n])[ \t]*DATA[ \t]+\w+[^\r\n]*(?=[\r\n])", re.IGNORECASE)
# LZF makes at most 264 bytes of 3.
MOST_EXPANSION = 88
TYPES = {("F", 4): "<f4", ("F", 8): "<f8"} | {
    (kind, size): f"<{kind.lower()}{size}" for kind in "IU" for size in (1, 2, 4, 8)
}
# VIEWPOINT has a translation and a quaternion w x y z; files without one have this.
NO_VIEWPOINT = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
# Quaternions of less length are no rotation; others are brought to the length 1.
LEAST_QUATERNION = 1e-3
# The matrix has 11 unknowns, of two equations for each point; far more points show whether it fits.
LEAST_POINTS = 100
# So many points determine a centre to the resolution of the picture's pixels.
MOST_POINTS = 2_000
# A cloud of a depth camera lies on its pixels' rays, to within rounding and undistortion (pixels).
MOST_RESIDUAL = 1.0
# Centres of two halves of the points that differ by more than this share of the distance to the
# points are undetermined, as those of a picture of one plane are.
SURE_SHARE = 0.02


def find_camera_centre(points: FloatArray) -> FloatArray | None:
    """Return the place (3,) that a picture of points (rows, columns, 3) was taken from.

    Rows that are not finite have no point. None where the points are no picture of a pinhole
    camera, as of a scanner that turns, or where they do not determine its place.
    """
    rows, columns = points.shape[:2]
    flat = points.reshape(-1, 3)
    with np.errstate(invalid="ignore"):
        seen = np.flatnonzero(np.isfinite(flat).all(axis=1) & (np.abs(flat) > 0.0).any(axis=1))
    if min(rows, columns) < 2 or len(seen) < LEAST_POINTS:
        return None
    chosen = np.random.default_rng(0).permutation(seen)[:MOST_POINTS]
    places = flat[chosen]
    pixels = np.column_stack([chosen % columns, chosen // columns]).astype(np.float64)
    middle = places.mean(axis=0)
    local = places - middle
    scale = float(np.sqrt((local**2).sum(axis=1).mean()))
    if not np.isfinite(scale) or scale == 0.0:
        return None
    local = local / scale
    projection = _fit_projection(local, pixels)
    centre = _find_centre(projection)
    if centre is None or _find_residual(projection, local, pixels) > MOST_RESIDUAL:
        return None
    away = float(np.median(np.linalg.norm(local - centre, axis=1)))
    for half in (slice(None, None, 2), slice(1, None, 2)):
        other = _find_centre(_fit_projection(local[half], pixels[half]))
        if other is None or np.linalg.norm(other - centre) > SURE_SHARE * away:
            return None
    place: FloatArray = middle + scale * centre
    return place


def _fit_projection(places: FloatArray, pixels: FloatArray) -> FloatArray:
    """Return P (3, 4) that minimises the algebraic error of pixels (n, 2) of places (n, 3)."""
    shift, extent = pixels.mean(axis=0), max(float(pixels.std()), 1e-300)
    u, v = ((pixels - shift) / extent).T
    ones = np.column_stack([places, np.ones(len(places))])
    none = np.zeros_like(ones)
    equations = np.concatenate(
        [
            np.hstack([ones, none, -u[:, None] * ones]),
            np.hstack([none, ones, -v[:, None] * ones]),
        ]
    )
    fitted = np.linalg.eigh(equations.T @ equations)[1][:, 0].reshape(3, 4)
    back = np.array([[extent, 0.0, shift[0]], [0.0, extent, shift[1]], [0.0, 0.0, 1.0]])
    projection: FloatArray = back @ fitted
    return projection


def _find_centre(projection: FloatArray) -> FloatArray | None:
    """Return the centre (3,) of P, None where it is at infinity."""
    null: NDArray[np.float64] = np.linalg.svd(projection)[2][-1]
    return null[:3] / null[3] if abs(null[3]) > 1e-12 else None


def _find_residual(projection: FloatArray, places: FloatArray, pixels: FloatArray) -> float:
    """Return the rms distance in pixels; infinity where some points lie behind the camera."""
    image = places @ projection[:, :3].T + projection[:, 3]
    depth = image[:, 2]
    if not (depth > 0.0).all() and not (depth < 0.0).all():
        return np.inf
    off = image[:, :2] / depth[:, None] - pixels
    return float(np.sqrt((off**2).sum(axis=1).mean()))


@dataclass(frozen=True, eq=False, slots=True)
class Viewpoint:
    """Where the points of a file may have been seen from, in the frame of the points.

    `places` (k, 3), the likeliest first, or None: a format that leaves open whether points are in
    the world's frame or in the sensor's allows the translation of the pose and the origin.
    `camera` (3,) is the place that the rows and columns of an organised cloud determine, or None.
    `world_axes` (3, 3) turns the sensor's frame into the world's, None without a rotation.
    """

    places: FloatArray | None = None
    camera: FloatArray | None = None
    world_axes: FloatArray | None = None


@dataclass(frozen=True, slots=True)
class _Header:
    fields: tuple[str, ...]
    types: tuple[str, ...]
    repeats: tuple[int, ...]
    count: int
    shape: tuple[int, int]
    data: str
    viewpoint: tuple[float, ...]

    @property
    def row(self) -> "np.dtype[np.void]":
        """Type of a row as it is packed."""
        return np.dtype(
            [(f"{k}", t, (n,)) if n != 1 else (f"{k}", t)
             for k, (t, n) in enumerate(zip(self.types, self.repeats, strict=True))]
        )  # fmt: skip


def read_pcd(shape: ShapeFile) -> Cloud:
    """Return the cloud of a PCD file."""
    data = shape.path.read_bytes()
    head = without_bom(data[:HEADER_BYTES])
    if DATA_LINE.search(head) is None and DATA_LINE.search(to_plain_bytes(head)) is not None:
        data = to_plain_bytes(data)  # UTF-16: of a text as a whole
    data = without_bom(data)
    head = data[:HEADER_BYTES]
    found = DATA_LINE.search(head)
    if found is None:
        raise shape.error(
            f"is no PCD: no line DATA in its first {HEADER_BYTES} bytes; export the cloud again"
        )
    header = _parse_pcd_header(to_plain_bytes(head[: found.end()]).decode(), shape)
    shape.check_points(header.count)
    body = data[found.end() :].removeprefix(find_line_end(head))
    match header.data:
        case "ascii":
            rows = read_text_rows(shape, to_plain_bytes(body), sum(header.repeats), header.count)
            fields = tuple(
                field if n == 1 else f"{field}_{k}"
                for field, n in zip(header.fields, header.repeats, strict=True)
                for k in range(n)
            )
            table = extract_point_columns(shape, fields, rows)
        case "binary":
            packed = read_binary_rows(shape, body, header.row, header.count)
            table = extract_point_columns(shape, header.fields, packed)
        case "binary_compressed":
            table = extract_point_columns(shape, header.fields, _unpacked(body, header, shape))
        case _:
            raise shape.error(f"has DATA {header.data[:30]}, which is no kind of PCD")
    viewpoint = _viewpoint(header, table.points)
    return Cloud.of(
        table.points,
        normals=table.normals,
        name=shape.name,
        seen_from=None
        if viewpoint.camera is None
        else np.tile(viewpoint.camera, (len(table.points), 1)),
        sensor_places=viewpoint.places,
        world_axes=viewpoint.world_axes,
    )


def _viewpoint(header: _Header, points: FloatArray) -> Viewpoint:
    """Return the places that the header and the order of the points allow for the sensor."""
    places: list[FloatArray] = []
    axes = None
    height, width = header.shape
    is_picture = height > 1 and height * width == len(points)
    camera = find_camera_centre(points.reshape(height, width, 3)) if is_picture else None
    if camera is not None:
        places.append(camera)
    stated = len(header.viewpoint) == len(NO_VIEWPOINT) and header.viewpoint != NO_VIEWPOINT
    place, quaternion = np.array(header.viewpoint[:3]), np.array(header.viewpoint[3:])
    if stated and np.isfinite(place).all() and place.any():
        places.append(place)
    if stated and LEAST_QUATERNION < np.linalg.norm(quaternion) < np.inf:
        rotation = Rotation.from_quat(quaternion, scalar_first=True)
        axes = rotation.as_matrix() if rotation.magnitude() > 0.0 else None
    if is_picture or places or axes is not None:
        places.append(np.zeros(3))
    return Viewpoint(np.array(places) if places else None, camera, axes)


def _parse_pcd_header(text: str, shape: ShapeFile) -> _Header:
    lines = (line.partition("#")[0].split() for line in text.splitlines())
    entries = {words[0].upper(): words[1:] for words in lines if words}
    if "FIELDS" not in entries and "COLUMNS" in entries:
        entries["FIELDS"] = entries["COLUMNS"]  # version .5
    try:
        fields = tuple(entries["FIELDS"])
        sizes = [int(size) for size in entries["SIZE"]]
        kinds = [kind.upper() for kind in entries["TYPE"]]
        types = tuple(TYPES[pair] for pair in zip(kinds, sizes, strict=True))
        repeats = tuple(int(n) for n in entries.get("COUNT", ["1"] * len(fields)))
        size = (int(entries.get("HEIGHT", ["1"])[0]), int(entries.get("WIDTH", ["0"])[0]))
        count = int(entries["POINTS"][0]) if "POINTS" in entries else size[0] * size[1]
        data = entries["DATA"][0].lower()
    except KeyError as exc:
        what = exc.args[0]
        said = f"no line {what}" if isinstance(what, str) else f"a field of TYPE and SIZE {what}"
        raise shape.error(f"its PCD header has {said}; export the cloud again") from exc
    except (IndexError, ValueError) as exc:
        raise shape.error(f"has a damaged PCD header ({exc}); export it again") from exc
    sound = len(fields) == len(types) == len(repeats) and min(repeats, default=0) > 0 <= count
    if not sound or sum(repeats) > HEADER_BYTES:
        raise shape.error(
            f"its PCD header has {len(fields)} FIELDS, {len(types)} TYPEs and "
            f"{len(repeats)} COUNTs, for {count} points; export the cloud again"
        )
    try:
        viewpoint = tuple(float(x) for x in entries.get("VIEWPOINT", NO_VIEWPOINT))
    except ValueError:
        viewpoint = ()
    return _Header(fields, types, repeats, count, size, data, viewpoint)


def _unpacked(
    body: bytes, header: _Header, shape: ShapeFile
) -> "np.ndarray[tuple[int], np.dtype[np.void]]":
    """Return the rows of compressed data, which is kept field by field."""
    row = header.row
    truncated = shape.make_inconsistency_error("its compressed data is not that of its points")
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
    """Return `size` bytes from LZF (M. Lehmann, liblzf); ValueError where the data makes no such
    number.

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
