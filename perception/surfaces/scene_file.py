"""Scenes as JSON: `facetlog-scene/1`, out and in.

pydantic reads and checks the parts (scene_json/records.py), and a number comes back with every bit
it left with.
"""

import base64
import json
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import fields
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from facetlog.errors import CalibrationError, InputError
from facetlog.perception.atomic_write import write_atomically
from facetlog.perception.scene import Scene, SeenLattice, SightLines
from facetlog.perception.surfaces.scene_json.records import (
    FORMAT,
    PosedCameraRecord,
    SceneRecord,
    SeenLatticeRecord,
    SightLinesRecord,
)
from facetlog.perception.surfaces.scene_json.scene_checks import (
    find_scene_faults,
    iter_number_faults,
)
from facetlog.perception.surfaces.scene_json.scene_fault import (
    SceneFault,
    SceneFileError,
    format_json_path,
    missing,
    repeated,
)
from facetlog.perception.types import Camera, Pose
from facetlog.safe_read import MOST_SCENE_BYTES, read_regular

__all__ = [
    "SceneFault",
    "SceneFileError",
    "decode_scene",
    "encode_scene",
    "pack_bits",
    "read_scene",
    "unpack_bits",
    "write_scene",
]

MOST_LATTICE_BITS = 1 << 24
"""Bits of all lattices of a scene that is read: five times what 32 views make."""

END = np.dtype("<f4")
"""A coordinate of an end of a line of sight."""


def write_scene(scene: Scene, path: Path) -> None:
    """Write the scene as `facetlog-scene/1`, whole or not at all."""
    write_atomically(path, encode_scene(scene).encode())


def read_scene(path: Path) -> Scene:
    """Return the scene of a `facetlog-scene/1` file; raises InputError naming the file and the
    place.
    """
    try:
        content = read_regular(path, MOST_SCENE_BYTES)
    except OSError as exc:
        raise InputError(f"{path}: cannot be read: {exc.strerror}") from exc
    return decode_scene(content, str(path))


def encode_scene(scene: Scene) -> str:
    """Return the scene as one JSON object; ValueError where a number is not finite."""
    content = {name: getattr(scene, name) for name in SceneRecord.model_fields if name != "format"}
    content["cameras"] = [
        {
            "size": (camera.width, camera.height),
            "focal": (camera.fx, camera.fy),
            "middle": (camera.cx, camera.cy),
            "rotation": pose.rotation,
            "centre": pose.centre,
        }
        for camera, pose in zip(scene.cameras, scene.poses, strict=False)
    ]
    if not scene.scale_sd > 0.0:
        del content["scale_sd"]
    content = {"schema": FORMAT, **content}
    text = json.dumps(content, default=_to_json, allow_nan=False, ensure_ascii=False)
    return text + "\n"


def _to_json(value: object) -> object:
    """Return the lists or fields that stand for an array or a part of a scene."""
    match value:
        case np.ndarray():
            return value.tolist()
        case SightLines():
            ends = base64.b64encode(value.ends.astype(END).tobytes()).decode()
            return {"origin": value.origin, "ends": ends, "view": value.view}
        case SeenLattice():
            return {
                "corner": value.corner,
                "steps": value.steps,
                "size": value.shown.shape[1:],
                "views": value.views,
                "origins": value.origins,
                "shown": base64.b64encode(pack_bits(value.shown)).decode(),
                "wrong": value.wrong,
                "ground": value.ground,
            }
    return {field.name: getattr(value, field.name) for field in fields(value)}  # type: ignore[arg-type]


def decode_scene(text: str | bytes, source: str = "scene") -> Scene:
    """Return the scene of a JSON text; `source` is what messages call it.

    Raise SceneFileError, in one line with the JSON path, if the text is no `facetlog-scene/1`.
    """
    record = _record(text, source)
    try:
        scene = _make_scene(record, source)
    except ValueError as exc:  # most often an index that names nothing
        faults = tuple(missing(record)) or (SceneFault("$", str(exc)),)
        raise SceneFileError(source, faults) from exc
    checks = (repeated(record), iter_number_faults(scene), find_scene_faults(scene))
    if faults := next(filter(None, map(tuple, checks)), ()):
        raise SceneFileError(source, faults)
    return scene


def _record(text: str | bytes, source: str) -> SceneRecord:
    """Return what a JSON text says; SceneFileError if it has another form."""
    try:
        return SceneRecord.model_validate_json(text)
    except ValidationError as exc:
        faults = tuple(
            SceneFault(format_json_path(fault["loc"]), _said(fault["type"], fault["msg"]))
            for fault in exc.errors(include_url=False)
        )
        raise SceneFileError(source, faults) from exc


def _said(kind: str, message: str) -> str:
    """Return what pydantic says on one line; of what is no JSON, also the way out."""
    if kind == "unexpected_keyword_argument":
        return "Extra inputs are not permitted"
    line = " ".join(message.split()).removeprefix("Value error, ")
    if kind != "json_invalid":
        return line
    # at the end of the text what was begun is still open
    return f"{line}: {'it is cut short, ' if 'EOF' in line else ''}write the scene again"


def _make_scene(record: SceneRecord, source: str) -> Scene:
    """Return the scene; `source` is what messages call it.

    Raise SceneFileError naming the place, or ValueError, most often for an index of nothing.
    """
    if any(seen.view >= len(record.views) for v in record.vertices for seen in v.observations):
        raise ValueError("a vertex names a view that the scene does not have")
    posed = [_posed(r, i, source) for i, r in enumerate(record.cameras)]
    others: dict[str, Any] = {
        "poses": tuple(pose for _, pose in posed),
        "sights": tuple(_sight_lines(s, i, source) for i, s in enumerate(record.sights)),
        "cameras": tuple(camera for camera, _ in posed),
        "lattices": tuple(_make_lattices(record.lattices, source)),
    }
    same = SceneRecord.model_fields.keys() - {"format"} - others.keys()
    return Scene(**{name: getattr(record, name) for name in same}, **others)


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
                shown = unpack_bits(r.shown, (len(r.views), rows, columns))
            except ValueError as exc:
                said = str(exc)
        if said:
            raise SceneFileError(source, (SceneFault(place, said),))
        yield SeenLattice(
            np.array(r.corner),
            np.array(r.steps),
            np.array(r.origins).reshape(-1, 3),
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


def pack_bits(bits: NDArray[np.bool_]) -> bytes:
    """Return the bits in their order, eight a byte, the first one highest, compressed by zlib."""
    return zlib.compress(np.packbits(bits).tobytes())


def unpack_bits(content: bytes, shape: tuple[int, ...]) -> NDArray[np.bool_]:
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
