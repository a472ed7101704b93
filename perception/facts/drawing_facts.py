"""Facts about the line drawings of a scene, one for each view: junctions, lines, outlines."""

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.facts import relations
from facetlog.perception.facts.named_rows import FactRows
from facetlog.perception.facts.scene_memo import SceneMemo
from facetlog.perception.line_drawing import LineDrawing

__all__ = ["drawing_facts", "drawing_rows", "flat_along"]


def drawing_facts(s: SceneMemo, rows: FactRows) -> None:
    """What the views show of the scene's edges, as drawings; nothing where no camera is known."""
    scene = s.scene
    if not scene.cameras or not len(s.table):
        return
    from facetlog.perception.surfaces.visible_lines import visible_lines  # loaded on demand

    flat = flat_along(s)
    for i, (camera, pose) in enumerate(zip(scene.cameras, scene.poses, strict=True), 1):
        seen = visible_lines(s.table, s.edges, s.bounds, flat, camera, pose)
        crossings = np.cumsum(seen.vertex < 0)
        points = [
            f"x{crossing}" if vertex < 0 else f"v{vertex + 1}"
            for vertex, crossing in zip(seen.vertex.tolist(), crossings.tolist(), strict=True)
        ]
        names = [f"e{k + 1}" for k in seen.edge.tolist()]
        drawing_rows(f"view{i}", seen.drawing, points, names, rows)


def drawing_rows(
    view: str, drawing: LineDrawing, points: list[str], lines: list[str], rows: FactRows
) -> None:
    """Adds the facts of one drawing, whose points and lines are called so."""
    for name, rays in zip(points, drawing.rays, strict=True):
        if rays is None:
            continue
        rows["junction"].append((view, name, rays.type.value))
        for i, (line, far) in enumerate(zip(rays.line.tolist(), rays.far.tolist(), strict=True), 1):
            rows["line_at"].append((view, name, i, points[far], lines[line]))
    rows["contour"].extend((view, points[a], points[b]) for a, b in drawing.contour())


def flat_along(s: SceneMemo) -> NDArray[np.intp]:
    """An edge and two faces along it (k, 3) that lie in one plane and face the same way."""
    along = np.zeros((len(s.edges), len(s.table)), dtype=np.bool_)
    along[s.bounds[:, 0], s.bounds[:, 1]] = True
    pairs = relations.coplanar_pairs(s.table, s.angles, s.offsets)
    pairs = pairs[s.angles[0][pairs[:, 0], pairs[:, 1]] < np.pi / 2]
    edge, pair = np.nonzero(along[:, pairs[:, 0]] & along[:, pairs[:, 1]])
    return np.column_stack([edge, pairs[pair]])
