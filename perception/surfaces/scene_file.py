"""Scenes as JSON: `facetlog-scene/1`, out and in.

The models of scene_records.py are the border: what they let through makes a `Scene`, and a number
comes back with every bit it left with.
"""

import base64
import json
from collections.abc import Collection, Iterator, Sequence
from itertools import chain
from pathlib import Path

import numpy as np
from pydantic import ValidationError

from facetlog.errors import CalibrationError, InputError
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
from facetlog.perception.surfaces.lattice_bits import MOST_LATTICE_BITS, packed, unpacked
from facetlog.perception.surfaces.scene_checks import scene_faults
from facetlog.perception.surfaces.scene_numbers import SceneFault, number_faults
from facetlog.perception.surfaces.scene_records import (
    FORMAT,
    FaceRecord,
    ObservationRecord,
    PatchRecord,
    PosedCameraRecord,
    SceneRecord,
    SeenLatticeRecord,
    SightLinesRecord,
    VertexRecord,
)
from facetlog.perception.types import Camera, FloatArray, Observation, Pose
from facetlog.perception.whole_file import write_whole
from facetlog.regular_file import MOST_SCENE_BYTES, read_regular

__all__ = [
    "SceneFault",
    "SceneFileError",
    "read_scene",
    "scene_from_json",
    "scene_to_json",
    "write_scene",
]


MOST_COPIES = 8
"""Faces with the same corners that are read, of both sides together."""

END = np.dtype("<f4")
"""A coordinate of an end of a line of sight."""


class SceneFileError(InputError):
    """The file is no `facetlog-scene/1`: the message names the first of its `faults`."""

    def __init__(self, source: str, faults: tuple[SceneFault, ...]) -> None:
        more = f" (and {len(faults) - 1} more)" if len(faults) > 1 else ""
        super().__init__(f"{source}: {faults[0]}{more}")
        self.faults = faults


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


_Place = tuple[int | str, ...]


def _json_path(place: _Place) -> str:
    return "$" + "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in place)


def _vectors(rows: Collection[Sequence[float]], width: int) -> FloatArray:
    """The rows as one array (n, width) that is not writeable: what is cut from it is not copied.

    Number by number: numpy takes twice as long to find out how tuples are nested.
    """
    numbers = np.fromiter(chain.from_iterable(rows), np.float64, len(rows) * width)
    numbers.setflags(write=False)
    return numbers.reshape(len(rows), width)


def _squares(matrices: Collection[Sequence[Sequence[float]]], width: int) -> FloatArray:
    """The same of matrices (n, width, width)."""
    rows = tuple(chain.from_iterable(matrices))
    return _vectors(rows, width).reshape(len(matrices), width, width)


def _faces(records: Sequence[FaceRecord], source: str) -> Iterator[Face]:
    normals = _vectors([r.plane.normal for r in records], 3)
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
    points = _vectors([r.point for r in records], 3)
    covs = _squares([r.cov for r in records], 3)
    for r, point, cov in zip(records, points, covs, strict=True):
        yield Vertex(point, cov, tuple(_observations(r.observations)), r.label)


def _observations(records: Sequence[ObservationRecord]) -> Iterator[Observation]:
    if records:
        pixels = _vectors([r.uv for r in records], 2)
        covs = _squares([r.cov for r in records], 2)
        for r, uv, cov in zip(records, pixels, covs, strict=True):
            yield Observation(r.view, uv, cov)


def _references(record: SceneRecord) -> Iterator[tuple[_Place, str, int, int]]:
    """Where indices stand, of what they are, the highest of them, and how many there are of it."""
    vertices, views = len(record.vertices), len(record.views)
    for i, vertex in enumerate(record.vertices):
        for j, seen in enumerate(vertex.observations):
            yield ("vertices", i, "observations", j, "view"), "view", seen.view, views
    for i, edge in enumerate(record.edges):
        yield ("edges", i, "start"), "vertex", edge.start, vertices
        yield ("edges", i, "end"), "vertex", edge.end, vertices
    for i, face in enumerate(record.faces):
        yield ("faces", i, "outline"), "vertex", max(face.outline), vertices
        for j, hole in enumerate(face.holes):
            yield ("faces", i, "holes", j), "vertex", max(hole), vertices
        for j, sight in enumerate(face.sights):
            yield ("faces", i, "sights", j, "view"), "view", sight.view, views
            hidden = max((by for by, _ in sight.hidden), default=-1)
            yield ("faces", i, "sights", j, "hidden"), "face", hidden, len(record.faces)
    for i, patch in enumerate(record.patches):
        yield ("patches", i, "hull"), "vertex", max(patch.hull, default=-1), vertices
    for i, body in enumerate(record.bodies):
        yield ("bodies", i, "faces"), "face", max(body.faces, default=-1), len(record.faces)
        yield ("bodies", i, "edges"), "edge", max(body.edges, default=-1), len(record.edges)
        yield ("bodies", i, "patches"), "patch", max(body.patches, default=-1), len(record.patches)
    for i, lines in enumerate(record.sights):
        if lines.view is not None:
            yield ("sights", i, "view"), "view", lines.view, views
    for i, seen_by in enumerate(record.lattices):
        yield ("lattices", i, "views"), "view", max(seen_by.views, default=-1), views


def _missing(record: SceneRecord) -> Iterator[SceneFault]:
    """Faults for what indices name and the scene does not have."""
    for place, kind, highest, count in _references(record):
        if highest >= count:
            yield SceneFault(
                _json_path(place), f"{kind} {highest} does not exist, there are {count}"
            )


def _repeated(record: SceneRecord) -> Iterator[SceneFault]:
    """Faults for faces that are there over and over: of n copies n² angles would be facts.

    A few are let through, of the same vertices or of others at the same places: models that people
    draw have doubled panels.
    """
    known: dict[tuple[float, ...], int] = {}
    places = [known.setdefault(v.point, i) for i, v in enumerate(record.vertices)]
    copies: dict[frozenset[int], list[int]] = {}
    for i, face in enumerate(record.faces):
        corners = frozenset(map(places.__getitem__, face.outline))
        copies.setdefault(corners, []).append(i)
    if len(copies) == len(record.faces):
        return
    for same in copies.values():
        for i in same[MOST_COPIES:]:
            said = f"has the corners of face {same[0]}, as {len(same) - 1} others: remove them"
            yield SceneFault(f"$.faces[{i}].outline", said)


def _said(kind: str, message: str) -> str:
    """What pydantic says on one line; of what is no JSON, also the way out."""
    line = " ".join(message.split())
    if kind != "json_invalid":
        return line
    # at the end of the text what was begun is still open
    return f"{line}: {'it is cut short, ' if 'EOF' in line else ''}write the scene again"


def _record(text: str | bytes, source: str) -> SceneRecord:
    """What a JSON text says; SceneFileError if it has another form."""
    try:
        return SceneRecord.model_validate_json(text)
    except ValidationError as exc:
        faults = tuple(
            SceneFault(_json_path(fault["loc"]), _said(fault["type"], fault["msg"]))
            for fault in exc.errors(include_url=False)
        )
        raise SceneFileError(source, faults) from exc


def scene_from_json(text: str | bytes, source: str = "scene") -> Scene:
    """The scene of a JSON text; `source` is what messages call it.

    Raises SceneFileError, in one line with the JSON path, if the text is no `facetlog-scene/1`.
    """
    record = _record(text, source)
    try:
        scene = _scene(record, source)
    except ValueError as exc:  # most often an index that names nothing
        faults = tuple(_missing(record)) or (SceneFault("$", str(exc)),)
        raise SceneFileError(source, faults) from exc
    checks = (_repeated(record), number_faults(scene), scene_faults(scene))
    if faults := next(filter(None, map(tuple, checks)), ()):
        raise SceneFileError(source, faults)
    return scene


def _patch(record: PatchRecord, index: int, source: str) -> Patch:
    count = len(record.points)
    if len(record.normals) != count or len(record.areas) != count:
        said = (
            f"{count} points, {len(record.normals)} normals and {len(record.areas)} areas: "
            "give as many of each"
        )
        raise SceneFileError(source, (SceneFault(f"$.patches[{index}]", said),))
    areas = _vectors([record.areas], count)[0]
    return Patch(_vectors(record.points, 3), _vectors(record.normals, 3), areas, record.hull)


def _sight_lines(record: SightLinesRecord, index: int, source: str) -> SightLines:
    whole, left = divmod(len(record.ends), 3 * END.itemsize)
    numbers = np.frombuffer(record.ends[: whole * 3 * END.itemsize], END)
    ends = numbers.astype(np.float64).reshape(whole, 3)
    if left or not np.isfinite(ends).all():
        said = "give base64 of finite float32 numbers, three for each end"
        raise SceneFileError(source, (SceneFault(f"$.sights[{index}].ends", said),))
    return SightLines(np.array(record.origin), ends, record.view)


def _lattices(records: Sequence[SeenLatticeRecord], source: str) -> Iterator[SeenLattice]:
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
            _vectors(r.origins, 3),
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


def _scene(record: SceneRecord, source: str) -> Scene:
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
        lattices=tuple(_lattices(record.lattices, source)),
        scale_sd=record.scale_sd,
    )


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
