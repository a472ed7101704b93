"""Facts about the line drawings of a scene, one for each view: junctions, lines, outlines."""

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.facts import relations
from facetlog.perception.facts.fact_schema import Value
from facetlog.perception.facts.named_rows import CollectedFacts, FactRows
from facetlog.perception.facts.scene_memo import SceneMemo
from facetlog.perception.line_drawing import LineDrawing


def drawing_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add the line drawings that views show of the scene's edges; none where no camera is known."""
    scene = s.scene
    if not scene.cameras or not scene.faces:
        return
    from facetlog.perception.surfaces.visible_lines import visible_lines  # loaded on demand

    flat = find_flat_edges(s)
    for i, (camera, pose) in enumerate(zip(scene.cameras, scene.poses, strict=True), 1):
        seen = visible_lines(s.table, s.edges, s.bounds, flat, camera, pose)
        crossings = np.cumsum(seen.vertex < 0)
        points = [
            f"x{crossing}" if vertex < 0 else f"v{vertex + 1}"
            for vertex, crossing in zip(seen.vertex.tolist(), crossings.tolist(), strict=True)
        ]
        names = [f"e{k + 1}" for k in seen.edge.tolist()]
        for functor, found in drawing_rows(f"view{i}", seen.drawing, points, names).items():
            rows.add_rows(functor, found)


def drawing_rows(view: str, drawing: LineDrawing, points: list[str], lines: list[str]) -> FactRows:
    """Return the facts of one drawing, whose points and lines are called so."""
    junctions: list[tuple[Value, ...]] = []
    at: list[tuple[Value, ...]] = []
    for name, rays in zip(points, drawing.rays, strict=True):
        if rays is None:
            continue
        junctions.append((view, name, rays.type.value))
        for i, (line, far) in enumerate(zip(rays.line.tolist(), rays.far.tolist(), strict=True), 1):
            at.append((view, name, i, points[far], lines[line]))
    contour: list[tuple[Value, ...]] = [(view, points[a], points[b]) for a, b in drawing.contour()]
    return {"junction": junctions, "line_at": at, "contour": contour}


def find_flat_edges(s: SceneMemo) -> NDArray[np.intp]:
    """Return an edge and two faces along it (k, 3) that lie in one plane and face the same way."""
    along = np.zeros((len(s.edges), len(s.table)), dtype=np.bool_)
    along[s.bounds[:, 0], s.bounds[:, 1]] = True
    found = relations.find_coplanar_pairs(s.table, s.pairs, s.angles, s.offsets)
    found = found[s.angles[0][found] < np.pi / 2]
    pairs = np.column_stack([s.pairs.one[found], s.pairs.two[found]])
    edge, pair = np.nonzero(along[:, pairs[:, 0]] & along[:, pairs[:, 1]])
    return np.column_stack([edge, pairs[pair]])
