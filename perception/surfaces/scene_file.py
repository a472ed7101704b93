"""Scenes as JSON: `facetlog-scene/1`, out and in.

The models of scene_json/records.py are the border: what they let through makes a `Scene`, and a
number comes back with every bit it left with.
"""

import base64
import json
from dataclasses import fields
from pathlib import Path

import numpy as np
from pydantic import ValidationError

from facetlog.errors import InputError
from facetlog.perception.atomic_write import write_atomically
from facetlog.perception.scene import Scene, SeenLattice, SightLines
from facetlog.perception.surfaces.scene_json.records import FORMAT, SceneRecord
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
from facetlog.perception.surfaces.scene_json.scene_of_record import END, packed, scene_of_record
from facetlog.safe_read import MOST_SCENE_BYTES, read_regular

__all__ = [
    "SceneFault",
    "SceneFileError",
    "decode_scene",
    "encode_scene",
    "read_scene",
    "write_scene",
]


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
    posed = zip(scene.cameras, scene.poses, strict=False)
    content = {
        "schema": FORMAT,
        "name": scene.name,
        "metric": scene.metric,
        "up": scene.up,
        "views": scene.views,
        "vertices": scene.vertices,
        "edges": scene.edges,
        "faces": scene.faces,
        "warnings": scene.warnings,
        "patches": scene.patches,
        "bodies": scene.bodies,
        "sights": scene.sights,
        "cameras": [
            {
                "size": (camera.width, camera.height),
                "focal": (camera.fx, camera.fy),
                "middle": (camera.cx, camera.cy),
                "rotation": pose.rotation,
                "centre": pose.centre,
            }
            for camera, pose in posed
        ],
        "lattices": scene.lattices,
        **({"scale_sd": scene.scale_sd} if scene.scale_sd > 0.0 else {}),
    }
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
                "shown": base64.b64encode(packed(value.shown)).decode(),
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
        scene = scene_of_record(record, source)
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
    line = " ".join(message.split())
    if kind != "json_invalid":
        return line
    # at the end of the text what was begun is still open
    return f"{line}: {'it is cut short, ' if 'EOF' in line else ''}write the scene again"
