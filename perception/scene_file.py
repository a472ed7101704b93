"""Scenes as JSON: `facetlog-scene/1`, out and in, with its JSON Schema.

The models here are the border: what they let through makes a `Scene`, and a number comes back
with every bit it left with.
"""

import json
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, NonNegativeInt, ValidationError

from facetlog.errors import InputError
from facetlog.perception.types import (
    Edge,
    Evidence,
    Face,
    FloatArray,
    Observation,
    Plane,
    PositionLabel,
    Scene,
    Vertex,
)
from facetlog.perception.whole_file import write_whole

__all__ = [
    "FORMAT",
    "read_scene",
    "scene_from_json",
    "scene_schema",
    "scene_to_json",
    "write_scene",
]

FORMAT = "facetlog-scene/1"
SCHEMA_DIALECT = "https://json-schema.org/draft/2020-12/schema"

Vector2 = tuple[FiniteFloat, FiniteFloat]
Vector3 = tuple[FiniteFloat, FiniteFloat, FiniteFloat]
Vector4 = tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat]
Share = Annotated[FiniteFloat, Field(ge=0.0, le=1.0)]
Ring = Annotated[tuple[NonNegativeInt, ...], Field(min_length=3)]


class _Record(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class ObservationRecord(_Record):
    """A vertex seen in a view (index), in pixels."""

    view: NonNegativeInt
    uv: Vector2
    cov: tuple[Vector2, Vector2]


class VertexRecord(_Record):
    """A 3-D vertex with its covariance."""

    point: Vector3
    cov: tuple[Vector3, Vector3, Vector3]
    observations: tuple[ObservationRecord, ...] = ()
    label: PositionLabel | None = None


class EdgeRecord(_Record):
    """A straight edge between two vertices (indices)."""

    start: NonNegativeInt
    end: NonNegativeInt
    support: Share = 1.0
    evidence: Evidence = Evidence.MEASURED


class PlaneRecord(_Record):
    """normal · x + offset = 0 with a unit normal; covariance of (normal, offset)."""

    normal: Vector3
    offset: FiniteFloat
    cov: tuple[Vector4, Vector4, Vector4, Vector4]


class FaceRecord(_Record):
    """A flat face: loops of vertices (indices), the outline counter-clockwise from outside."""

    outline: Ring
    plane: PlaneRecord
    holes: tuple[Ring, ...] = ()
    support: Share = 1.0
    coverage: Share = 1.0
    evidence: Evidence = Evidence.MEASURED


class SceneRecord(_Record):
    """A reconstructed scene: vertices, edges and flat faces with their uncertainty."""

    model_config = ConfigDict(frozen=True, extra="forbid", title=FORMAT)

    format: Literal["facetlog-scene/1"] = Field(alias="schema")
    name: str
    metric: bool = Field(
        default=False, description="lengths are metres; else their unit is unknown"
    )
    up: Vector3 | None = Field(default=None, description="unit vector upwards, if known")
    views: tuple[str, ...] = ()
    vertices: tuple[VertexRecord, ...] = ()
    edges: tuple[EdgeRecord, ...] = ()
    faces: tuple[FaceRecord, ...] = ()
    warnings: tuple[str, ...] = ()


def scene_schema() -> str:
    """The JSON Schema of `facetlog-scene/1`, as docs/scene.schema.json holds it."""
    schema = {"$schema": SCHEMA_DIALECT, **SceneRecord.model_json_schema()}
    return json.dumps(schema, indent=2) + "\n"


def _rows(array: FloatArray) -> list[object]:
    rows: list[object] = array.tolist()
    return rows


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
            }
            for face in scene.faces
        ],
        "warnings": scene.warnings,
    }
    return json.dumps(content, allow_nan=False, ensure_ascii=False) + "\n"


def _json_path(place: tuple[int | str, ...]) -> str:
    return "$" + "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in place)


def _face(record: FaceRecord, place: str) -> Face:
    try:
        plane = Plane(record.plane.normal, record.plane.offset, record.plane.cov)  # type: ignore[arg-type]
        return Face(
            record.outline, plane, record.holes, record.support, record.coverage, record.evidence
        )
    except ValueError as exc:
        raise InputError(f"{place}: {exc}") from exc


def _check_indices(record: SceneRecord, source: str) -> None:
    """Raise InputError at the first index of a vertex or view that the scene does not have."""
    vertices, views = len(record.vertices), len(record.views)
    loops: list[tuple[str, tuple[int, ...]]] = []
    for i, edge in enumerate(record.edges):
        loops += [(f"edges[{i}].start", (edge.start,)), (f"edges[{i}].end", (edge.end,))]
    for i, face in enumerate(record.faces):
        loops.append((f"faces[{i}].outline", face.outline))
        loops += [(f"faces[{i}].holes[{j}]", hole) for j, hole in enumerate(face.holes)]
    for place, loop in loops:
        if max(loop) >= vertices:
            raise InputError(
                f"{source}: $.{place}: vertex {max(loop)} does not exist, there are {vertices}"
            )
    for i, vertex in enumerate(record.vertices):
        for j, seen in enumerate(vertex.observations):
            if seen.view >= views:
                raise InputError(
                    f"{source}: $.vertices[{i}].observations[{j}].view: "
                    f"view {seen.view} does not exist, there are {views}"
                )


def scene_from_json(text: str | bytes, source: str = "scene") -> Scene:
    """The scene of a JSON text; `source` is what messages call it.

    Raises InputError, in one line with the JSON path, if the text is no `facetlog-scene/1`.
    """
    try:
        record = SceneRecord.model_validate_json(text)
    except ValidationError as exc:
        first = exc.errors(include_url=False)[0]
        more = f" (and {exc.error_count() - 1} more)" if exc.error_count() > 1 else ""
        message = " ".join(first["msg"].split())
        raise InputError(f"{source}: {_json_path(first['loc'])}: {message}{more}") from exc
    _check_indices(record, source)
    return Scene(
        record.name,
        record.views,
        tuple(
            Vertex(
                vertex.point,  # type: ignore[arg-type]
                vertex.cov,  # type: ignore[arg-type]
                tuple(
                    Observation(seen.view, seen.uv, seen.cov)  # type: ignore[arg-type]
                    for seen in vertex.observations
                ),
                vertex.label,
            )
            for vertex in record.vertices
        ),
        tuple(Edge(e.start, e.end, e.support, e.evidence) for e in record.edges),
        tuple(_face(f, f"{source}: $.faces[{i}]") for i, f in enumerate(record.faces)),
        record.up,  # type: ignore[arg-type]
        record.metric,
        record.warnings,
    )


def write_scene(scene: Scene, path: Path) -> None:
    """Write the scene as `facetlog-scene/1`, whole or not at all."""
    write_whole(path, scene_to_json(scene).encode())


def read_scene(path: Path) -> Scene:
    """The scene of a `facetlog-scene/1` file; raises InputError naming the file and the place."""
    try:
        content = path.read_bytes()
    except OSError as exc:
        raise InputError(f"{path}: cannot be read: {exc.strerror}") from exc
    return scene_from_json(content, str(path))
