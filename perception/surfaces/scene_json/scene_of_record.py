"""Scenes of records: each number with every bit it was written with."""

import zlib
from collections.abc import Collection, Iterator, Sequence
from itertools import chain
from math import prod

import numpy as np
from numpy.typing import NDArray

from facetlog.errors import CalibrationError
from facetlog.perception.scene import (
    Body,
    Edge,
    Face,
    FaceSight,
    Patch,
    Plane,
    Scene,
    SeenLattice,
    SightLines,
    Vertex,
)
from facetlog.perception.surfaces.scene_json.records import (
    FaceRecord,
    ObservationRecord,
    PatchRecord,
    PosedCameraRecord,
    SceneRecord,
    SeenLatticeRecord,
    SightLinesRecord,
    VertexRecord,
)
from facetlog.perception.surfaces.scene_json.scene_fault import SceneFault, SceneFileError
from facetlog.perception.types import Camera, FloatArray, Observation, Pose

__all__ = ["END", "MOST_LATTICE_BITS", "packed", "scene_of_record", "unpacked"]

MOST_LATTICE_BITS = 1 << 24
"""Bits of all lattices of a scene that is read: five times what 32 views make."""

END = np.dtype("<f4")
"""A coordinate of an end of a line of sight."""


def scene_of_record(record: SceneRecord, source: str) -> Scene:
    """Return the scene; `source` is what messages call it.

    Raise SceneFileError naming the place, or ValueError, most often for an index of nothing.
    """
    posed = [_posed(r, i, source) for i, r in enumerate(record.cameras)]
    return Scene(
        record.name,
        record.views,
        tuple(_vertices(record.vertices, len(record.views))),
        tuple(Edge(e.start, e.end, e.support, e.evidence) for e in record.edges),
        tuple(_faces(record.faces, source)),
        record.up,  # type: ignore[arg-type]
        record.metric,
        record.warnings,
        tuple(_patch(p, i, source) for i, p in enumerate(record.patches)),
        tuple(Body(b.faces, b.edges, b.patches, b.whole) for b in record.bodies),
        poses=tuple(pose for _, pose in posed),
        sights=tuple(_sight_lines(s, i, source) for i, s in enumerate(record.sights)),
        cameras=tuple(camera for camera, _ in posed),
        lattices=tuple(_make_lattices(record.lattices, source)),
        scale_sd=record.scale_sd,
    )


def _make_vectors(rows: Collection[Sequence[float]], width: int) -> FloatArray:
    """Return the rows as one array (n, width) that is not writeable: what is cut from it is not
    copied.

    Number by number: numpy takes twice as long to find out how tuples are nested.
    """
    numbers = np.fromiter(chain.from_iterable(rows), np.float64, len(rows) * width)
    numbers.setflags(write=False)
    return numbers.reshape(len(rows), width)


def _squares(matrices: Collection[Sequence[Sequence[float]]], width: int) -> FloatArray:
    """Return matrices as one array (n, width, width) that is not writeable."""
    rows = tuple(chain.from_iterable(matrices))
    return _make_vectors(rows, width).reshape(len(matrices), width, width)


def _faces(records: Sequence[FaceRecord], source: str) -> Iterator[Face]:
    normals = _make_vectors([r.plane.normal for r in records], 3)
    covs = _squares([r.plane.cov for r in records], 4)
    for i, (r, normal, cov) in enumerate(zip(records, normals, covs, strict=True)):
        try:
            plane = Plane(normal, r.plane.offset, cov)
            sights = tuple(FaceSight(s.view, s.seen, s.hidden, s.outside) for s in r.sights)
            yield Face(r.outline, plane, r.holes, r.support, r.coverage, r.evidence, sights)
        except ValueError as exc:
            raise SceneFileError(source, (SceneFault(f"$.faces[{i}]", str(exc)),)) from exc


def _vertices(records: Sequence[VertexRecord], views: int) -> Iterator[Vertex]:
    if any(seen.view >= views for r in records for seen in r.observations):
        raise ValueError("a vertex names a view that the scene does not have")
    points = _make_vectors([r.point for r in records], 3)
    covs = _squares([r.cov for r in records], 3)
    for r, point, cov in zip(records, points, covs, strict=True):
        yield Vertex(point, cov, tuple(_make_observations(r.observations)), r.label)


def _make_observations(records: Sequence[ObservationRecord]) -> Iterator[Observation]:
    if records:
        pixels = _make_vectors([r.uv for r in records], 2)
        covs = _squares([r.cov for r in records], 2)
        for r, uv, cov in zip(records, pixels, covs, strict=True):
            yield Observation(r.view, uv, cov)


def _patch(record: PatchRecord, index: int, source: str) -> Patch:
    count = len(record.points)
    if len(record.normals) != count or len(record.areas) != count:
        said = (
            f"{count} points, {len(record.normals)} normals and {len(record.areas)} areas: "
            "give as many of each"
        )
        raise SceneFileError(source, (SceneFault(f"$.patches[{index}]", said),))
    areas = _make_vectors([record.areas], count)[0]
    return Patch(
        _make_vectors(record.points, 3), _make_vectors(record.normals, 3), areas, record.hull
    )


def _sight_lines(record: SightLinesRecord, index: int, source: str) -> SightLines:
    whole, left = divmod(len(record.ends), 3 * END.itemsize)
    numbers = np.frombuffer(record.ends[: whole * 3 * END.itemsize], END)
    ends = numbers.astype(np.float64).reshape(whole, 3)
    if left or not np.isfinite(ends).all():
        said = "give base64 of finite float32 numbers, three for each end"
        raise SceneFileError(source, (SceneFault(f"$.sights[{index}].ends", said),))
    return SightLines(np.array(record.origin), ends, record.view)


def _make_lattices(records: Sequence[SeenLatticeRecord], source: str) -> Iterator[SeenLattice]:
    bits = 0
    for i, r in enumerate(records):
        rows, columns = r.size
        bits += len(r.views) * rows * columns
        place, said = f"$.lattices[{i}].shown", ""
        if len(r.origins) != len(r.views):
            place = f"$.lattices[{i}].origins"
            said = f"{len(r.origins)} origins and {len(r.views)} views: give as many of each"
        elif bits > MOST_LATTICE_BITS:
            said = f"there are more than {MOST_LATTICE_BITS} bits in all lattices"
        else:
            try:
                shown = unpacked(r.shown, (len(r.views), rows, columns))
            except ValueError as exc:
                said = str(exc)
        if said:
            raise SceneFileError(source, (SceneFault(place, said),))
        yield SeenLattice(
            np.array(r.corner),
            np.array(r.steps),
            _make_vectors(r.origins, 3),
            shown,
            r.views,
            r.wrong,
            r.ground,
        )


def _posed(record: PosedCameraRecord, index: int, source: str) -> tuple[Camera, Pose]:
    try:
        camera = Camera(*record.size, *record.focal, *record.middle)
        return camera, Pose(np.array(record.rotation), np.array(record.centre))
    except CalibrationError as exc:
        raise SceneFileError(source, (SceneFault(f"$.cameras[{index}]", str(exc)),)) from exc


def packed(bits: NDArray[np.bool_]) -> bytes:
    """Return the bits in their order, eight a byte, the first one highest, compressed by zlib."""
    return zlib.compress(np.packbits(bits).tobytes())


def unpacked(content: bytes, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Return the bits that were packed, in that shape.

    ValueError if there are others than so many, or none. No more is unpacked than these take.
    """
    count = prod(shape)
    size = -(-count // 8)
    stream = zlib.decompressobj()
    try:
        raw = stream.decompress(content, size + 1)
    except zlib.error as exc:
        raise ValueError("is not compressed by zlib") from exc
    if len(raw) != size or not stream.eof or stream.unused_data:
        raise ValueError(f"does not hold {count} bits")
    return np.unpackbits(np.frombuffer(raw, np.uint8), count=count).view(np.bool_).reshape(shape)
