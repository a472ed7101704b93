"""Places at which a recording draws the things of a scene."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from facetlog.kb.explaining.verdict_text import NO_MODEL
from facetlog.perception.types import FloatArray

if TYPE_CHECKING:
    from facetlog.kb.explaining.verdict import Recognition
    from facetlog.perception.scene import Face, Scene


def iter_face_loops(scene: "Scene") -> "Iterator[tuple[Face, FloatArray]]":
    """Yield each face of a scene with the points (n, 3) of its outline."""
    points = scene.points
    for face in scene.faces:
        yield face, points[list(face.outline)]


def outlined(
    scene: "Scene", recognition: "Recognition"
) -> tuple[tuple[str, tuple[FloatArray, ...]], ...]:
    """Return what holds, in a line each, and the outlines (n, 3) of the faces that play parts in
    it.

    Of a verdict without such faces those of all faces.
    """
    loops = {f"f{i}": loop for i, (_, loop) in enumerate(iter_face_loops(scene), start=1)}
    found = []
    for verdict in recognition.best:
        named = {f: loops[f] for part in verdict.parts for f in part.faces if f in loops}
        if corners := tuple((named or loops).values()):
            found.append((verdict.summary, corners))
    return tuple(found)


def find_verdict_places(
    scene: "Scene", recognition: "Recognition"
) -> tuple[tuple[str, FloatArray], ...]:
    """Return what holds, in a line each, and the middle (3,) of its faces' corners.

    Where nothing does it says so, at the middle of the corners of what was asked about; nothing of
    a scene without corners.
    """
    found = outlined(scene, recognition)
    if found:
        return tuple((said, np.concatenate(loops).mean(axis=0)) for said, loops in found)
    corners = _asked_about(scene, recognition)
    return ((NO_MODEL, corners.mean(axis=0)),) if len(corners) else ()


def _asked_about(scene: "Scene", recognition: "Recognition") -> FloatArray:
    """Return the corners (n, 3) of the things of the verdicts; of the whole scene if there
    is none.
    """
    from facetlog.perception.facts.scene_memo import SceneMemo

    memo = SceneMemo.of(scene)
    asked = {verdict.thing for verdict in recognition.verdicts}
    own = [k for k, name in enumerate(memo.thing_names) if str(name) in asked]
    corners = [k for thing in own for k in memo.members[thing]]
    return scene.points[corners] if corners else scene.points
