"""Scenes as JSON: `facetlog-scene/1`, out and in.

The models of scene_json/records.py are the border: what they let through makes a `Scene`, and a
number comes back with every bit it left with.
"""

import base64
import json
from pathlib import Path

from pydantic import ValidationError

from facetlog.errors import InputError
from facetlog.perception.atomic_write import write_whole
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.scene_json.lattice_bits import packed
from facetlog.perception.surfaces.scene_json.record_faults import missing, repeated
from facetlog.perception.surfaces.scene_json.records import FORMAT, SceneRecord
from facetlog.perception.surfaces.scene_json.scene_checks import scene_faults
from facetlog.perception.surfaces.scene_json.scene_fault import (
    SceneFault,
    SceneFileError,
    json_path,
)
from facetlog.perception.surfaces.scene_json.scene_numbers import number_faults
from facetlog.perception.surfaces.scene_json.scene_of_record import END, scene_of_record
from facetlog.perception.types import FloatArray
from facetlog.regular_file import MOST_SCENE_BYTES, read_regular

__all__ = [
    "SceneFault",
    "SceneFileError",
    "read_scene",
    "scene_from_json",
    "scene_to_json",
    "write_scene",
]


def write_scene(scene: Scene, path: Path) -> None:
    """Write the scene as `facetlog-scene/1`, whole or not at all."""
    write_whole(path, scene_to_json(scene).encode())


def read_scene(path: Path) -> Scene:
    """The scene of a `facetlog-scene/1` file; raises InputError naming the file and the place."""
    try:
        content = read_regular(path, MOST_SCENE_BYTES)
    except OSError as exc:
        raise InputError(f"{path}: cannot be read: {exc.strerror}") from exc
    return scene_from_json(content, str(path))


def scene_to_json(scene: Scene) -> str:
    """The scene as one JSON object; raises ValueError where a number is not finite."""
    content = {
        "schema": FORMAT,
        "name": scene.name,
        "metric": scene.metric,
        "up": None if scene.up is None else _rows(scene.up),
        "views": scene.views,
        "vertices": [
            {
                "point": _rows(vertex.point),
                "cov": _rows(vertex.cov),
                "observations": [
                    {"view": seen.view, "uv": _rows(seen.uv), "cov": _rows(seen.cov)}
                    for seen in vertex.observations
                ],
                "label": vertex.label,
            }
            for vertex in scene.vertices
        ],
        "edges": [
            {
                "start": edge.start,
                "end": edge.end,
                "support": edge.support,
                "evidence": edge.evidence,
            }
            for edge in scene.edges
        ],
        "faces": [
            {
                "outline": face.outline,
                "plane": {
                    "normal": _rows(face.plane.normal),
                    "offset": face.plane.offset,
                    "cov": _rows(face.plane.cov),
                },
                "holes": face.holes,
                "support": face.support,
                "coverage": face.coverage,
                "evidence": face.evidence,
                "sights": [
                    {
                        "view": sight.view,
                        "seen": sight.seen,
                        "hidden": sight.hidden,
                        "outside": sight.outside,
                    }
                    for sight in face.sights
                ],
            }
            for face in scene.faces
        ],
        "warnings": scene.warnings,
        "patches": [
            {
                "points": _rows(patch.points),
                "normals": _rows(patch.normals),
                "areas": _rows(patch.areas),
                "hull": patch.hull,
            }
            for patch in scene.patches
        ],
        "bodies": [
            {
                "faces": body.faces,
                "edges": body.edges,
                "patches": body.patches,
                "whole": body.whole,
            }
            for body in scene.bodies
        ],
        "sights": [
            {
                "origin": _rows(lines.origin),
                "ends": base64.b64encode(lines.ends.astype(END).tobytes()).decode(),
                "view": lines.view,
            }
            for lines in scene.sights
        ],
        "cameras": [
            {
                "size": (camera.width, camera.height),
                "focal": (camera.fx, camera.fy),
                "middle": (camera.cx, camera.cy),
                "rotation": _rows(pose.rotation),
                "centre": _rows(pose.centre),
            }
            for camera, pose in zip(scene.cameras, scene.poses, strict=False)
        ],
        "lattices": [
            {
                "corner": _rows(seen.corner),
                "steps": _rows(seen.steps),
                "size": seen.shown.shape[1:],
                "views": seen.views,
                "origins": _rows(seen.origins),
                "shown": base64.b64encode(packed(seen.shown)).decode(),
                "wrong": seen.wrong,
                "ground": seen.ground,
            }
            for seen in scene.lattices
        ],
        **({"scale_sd": scene.scale_sd} if scene.scale_sd > 0.0 else {}),
    }
    return json.dumps(content, allow_nan=False, ensure_ascii=False) + "\n"


def scene_from_json(text: str | bytes, source: str = "scene") -> Scene:
    """The scene of a JSON text; `source` is what messages call it.

    Raises SceneFileError, in one line with the JSON path, if the text is no `facetlog-scene/1`.
    """
    record = _record(text, source)
    try:
        scene = scene_of_record(record, source)
    except ValueError as exc:  # most often an index that names nothing
        faults = tuple(missing(record)) or (SceneFault("$", str(exc)),)
        raise SceneFileError(source, faults) from exc
    checks = (repeated(record), number_faults(scene), scene_faults(scene))
    if faults := next(filter(None, map(tuple, checks)), ()):
        raise SceneFileError(source, faults)
    return scene


def _rows(array: FloatArray) -> list[object]:
    rows: list[object] = array.tolist()
    return rows


def _record(text: str | bytes, source: str) -> SceneRecord:
    """What a JSON text says; SceneFileError if it has another form."""
    try:
        return SceneRecord.model_validate_json(text)
    except ValidationError as exc:
        faults = tuple(
            SceneFault(json_path(fault["loc"]), _said(fault["type"], fault["msg"]))
            for fault in exc.errors(include_url=False)
        )
        raise SceneFileError(source, faults) from exc


def _said(kind: str, message: str) -> str:
    """What pydantic says on one line; of what is no JSON, also the way out."""
    line = " ".join(message.split())
    if kind != "json_invalid":
        return line
    # at the end of the text what was begun is still open
    return f"{line}: {'it is cut short, ' if 'EOF' in line else ''}write the scene again"
