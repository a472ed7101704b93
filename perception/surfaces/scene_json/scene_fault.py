"""Faults of a scene file, and those of its records that no single one shows."""

from collections.abc import Iterator
from typing import NamedTuple

from facetlog.errors import InputError
from facetlog.perception.surfaces.scene_json.records import SceneRecord

__all__ = [
    "MOST_COPIES",
    "SceneFault",
    "SceneFileError",
    "format_json_path",
    "missing",
    "repeated",
]

MOST_COPIES = 8
"""Faces with the same corners that are read, of both sides together."""

Place = tuple[int | str, ...]
"""Keys and indices, from the top down to what is meant."""


class SceneFault(NamedTuple):
    """A fault of a scene file and its place: a JSON path as $.faces[3].outline."""

    path: str
    message: str

    def __str__(self) -> str:
        return f"{self.path}: {self.message}"


class SceneFileError(InputError):
    """The file is no `facetlog-scene/1`: the message names the first of its `faults`."""

    def __init__(self, source: str, faults: tuple[SceneFault, ...]) -> None:
        more = f" (and {len(faults) - 1} more)" if len(faults) > 1 else ""
        super().__init__(f"{source}: {faults[0]}{more}")
        self.faults = faults


def format_json_path(place: Place) -> str:
    """Return the JSON path of a place, as $.faces[3].outline."""
    return "$" + "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in place)


def missing(record: SceneRecord) -> Iterator[SceneFault]:
    """Return faults for what indices name and the scene does not have."""
    for place, kind, highest, count in _references(record):
        if highest >= count:
            yield SceneFault(
                format_json_path(place), f"{kind} {highest} does not exist, there are {count}"
            )


def repeated(record: SceneRecord) -> Iterator[SceneFault]:
    """Return faults for faces that are there over and over: of n copies n² angles would be facts.

    A few are let through, of the same vertices or of others at the same places: models that people
    draw have doubled panels.
    """
    known: dict[tuple[float, ...], int] = {}
    places = [known.setdefault(tuple(v.point.tolist()), i) for i, v in enumerate(record.vertices)]
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


def _references(record: SceneRecord) -> Iterator[tuple[Place, str, int, int]]:
    """Yield where indices stand, of what they are, the highest of them, and how many there are of
    it.
    """
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
