"""Facts about the scene as such, its vertices, edges, faces, pairs of faces and line drawings."""

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.batch_linalg import compute_quadratic_forms, dots
from facetlog.perception.facts import relations
from facetlog.perception.facts.fact_schema import Value
from facetlog.perception.facts.named_rows import CollectedFacts, FactRows
from facetlog.perception.facts.scene_memo import SceneMemo
from facetlog.perception.line_drawing import LineDrawing
from facetlog.perception.ragged import Indices, unique_rows
from facetlog.perception.scene import Evidence
from facetlog.perception.types import FloatArray

# Where the upper half of a covariance stands.
UPPER = tuple(zip(*(each.tolist() for each in np.triu_indices(3)), strict=True))


def scene_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add the scene's name, unit, up and views."""
    scene = s.scene
    rows.add_rows("scene", [(scene.name,)])
    rows.add_rows("scale", [("metric" if scene.metric else "unknown",)])
    if scene.up is not None:
        rows.add_rows("up", [tuple(scene.up.tolist())])
    rows.add_rows("view", ((f"view{i}", name) for i, name in enumerate(scene.views, 1)))


def vertex_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add vertices and their positions."""
    rows.add("vertex", s.vertex_names)
    rows.add("point", s.vertex_names, *s.table.points.T)


def spread_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add covariances of vertices."""
    columns = (s.table.covs[:, i, j] for i, j in UPPER)
    rows.add("point_cov", s.vertex_names, *columns)


def view_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add labels of vertices, and the pixels at which views saw them."""
    labels, seen = [], []
    for i, vertex in enumerate(s.scene.vertices, 1):
        if vertex.label is not None:
            labels.append((f"v{i}", vertex.label.value))
        for own in vertex.observations:
            sds = np.sqrt(np.maximum(np.diag(own.cov), 0.0))
            pixel = (*own.uv.tolist(), *sds.tolist())
            seen.append((f"v{i}", f"view{own.view + 1}", *pixel))
    rows.add_rows("vertex_label", labels)
    rows.add_rows("observed", seen)


def edge_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add edges, their lengths and support, and the faces that they bound."""
    table, (start, end), found = s.table, s.edges.T, s.edge_names
    rows.add("edge", found, s.vertex_names[start], s.vertex_names[end])
    span = table.points[end] - table.points[start]
    length = np.sqrt(dots(span, span))
    # ∂|p - q|/∂p is the unit vector from q to p
    u = span / np.where(length > 0.0, length, 1.0)[:, None]
    variance = compute_quadratic_forms(u, table.covs[start] + table.covs[end])
    rows.add("edge_length", found, length, np.sqrt(np.maximum(variance, 0.0)))
    edges = s.scene.edges
    support = np.array([edge.support for edge in edges], dtype=np.float64)
    rows.add("edge_support", found[s.listed], support)
    if rows.wants("evidence"):
        seen = _collect_face_evidence(s) == Evidence.MEASURED.value
        evidence = np.full(len(found), Evidence.IMPLIED.value, dtype=np.object_)
        edge, face = s.bounds.T
        evidence[edge[seen[face]]] = Evidence.MEASURED.value
        evidence[s.listed] = [edge.evidence.value for edge in edges]
        rows.add("evidence", found, evidence)
    if rows.wants("bounds"):
        edge, face = s.bounds.T
        rows.add("bounds", found[edge], s.face_names[face])


def _collect_face_evidence(s: SceneMemo) -> NDArray[np.object_]:
    return np.array([face.evidence.value for face in s.scene.faces], dtype=np.object_)


def face_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add faces, their corners, and the share of them that was seen."""
    table, found = s.table, s.face_names
    rows.add("face", found)
    rows.add("evidence", found, _collect_face_evidence(s))
    face, place = np.nonzero(table.there)
    corner = s.vertex_names[table.outlines[face, place]]
    rows.add("corner", found[face], place + 1, corner)
    coverage = [face.coverage for face in s.scene.faces]
    rows.add("coverage", found, np.array(coverage, dtype=np.float64))


def sight_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add the places of cameras and scanners, and the share of each face that each view shows."""
    scene = s.scene
    places = [(f"view{i}", *pose.centre.tolist()) for i, pose in enumerate(scene.poses, 1)]
    scans = [lines.origin.tolist() for lines in scene.sights if lines.view is None]
    places += [(f"scan{i}", *origin) for i, origin in enumerate(scans, 1)]
    rows.add_rows("viewpoint", places)
    shown, hidden = [], []
    for i, face in enumerate(scene.faces, 1):
        for sight in face.sights:
            about = (f"view{sight.view + 1}", f"f{i}")
            shown.append((*about, sight.seen, sight.outside))
            hidden += [(*about, f"f{by + 1}", share) for by, share in sight.hidden]
    rows.add_rows("shows", shown)
    rows.add_rows("hides", hidden)


def plane_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add planes of faces and their uncertainty."""
    table, planes, found = s.table, s.table.planes, s.face_names
    rows.add("plane", found, *planes.normals.T, planes.offsets)
    levers = np.column_stack([table.middles, np.ones(len(table))])
    offset_sds = np.sqrt(np.maximum(compute_quadratic_forms(levers, planes.covs), 0.0))
    rows.add("plane_sd", found, np.rad2deg(planes.tilt_sds), offset_sds)


def size_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add areas, lengths, widths and fills of faces."""
    if not len(s.table):
        return
    sizes = s.face_sizes
    for functor, each in (
        ("area", sizes.areas),
        ("length", sizes.lengths),
        ("width", sizes.widths),
        ("fill", sizes.fills),
    ):
        rows.add(functor, s.face_names, each.values, each.sds)


def _of_all_pairs(
    functor: str, values: tuple[FloatArray, FloatArray], s: SceneMemo, rows: CollectedFacts
) -> None:
    """Add facts (face, other face, value, sd) of all pairs."""
    rows.add(functor, s.face_names[s.pairs.one], s.face_names[s.pairs.two], *values)


def angle_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add angles between normals, of all pairs of faces."""
    angles, sds = s.angles
    _of_all_pairs("angle", (np.rad2deg(angles), np.rad2deg(sds)), s, rows)


def offset_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add signed distances of faces from the planes of others, of all pairs."""
    _of_all_pairs("offset", s.offsets, s, rows)


def _add_face_pairs(functor: str, pairs: Indices, s: SceneMemo, rows: CollectedFacts) -> None:
    one, two = pairs.T
    rows.add_both_ways(functor, s.face_names[one], s.face_names[two])


def opposite_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add pairs of faces that look away from each other or at each other."""
    if len(s.table):
        found = relations.find_opposite_pairs(s.table, s.pairs, s.angles)
        _add_face_pairs("opposite", found, s, rows)


def coplanar_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add pairs of faces in one plane."""
    found = relations.find_coplanar_pairs(s.table, s.pairs, s.angles, s.offsets)
    one, two = s.pairs.one[found], s.pairs.two[found]
    _add_face_pairs("coplanar", np.column_stack([one, two]), s, rows)


def meeting_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add pairs of faces that meet, with the edge where they do."""
    contacts = s.contacts
    if not len(contacts.first):
        return
    # Of edges between the same vertices it is the first.
    count = len(s.table.points)
    ends = np.concatenate((s.edges, s.table.sides.ends[contacts.shorter]))
    keys = ends.min(axis=1) * count + ends.max(axis=1)
    _, first, place = np.unique(keys, return_index=True, return_inverse=True)
    edge = first[place[len(s.edges) :]]
    found = unique_rows(np.column_stack([contacts.faces, edge]))
    one, two, edge = found.T
    rows.add_both_ways("adjoins", s.face_names[one], s.face_names[two], s.edge_names[edge])


def dihedral_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add the solid's angles where two faces meet, and whether it is convex or concave there."""
    # Of each pair that run against each other the longest contact, the first of equals.
    bent = s.contacts.take(s.contacts.against)
    order = np.lexsort((-bent.length, bent.faces[:, 1], bent.faces[:, 0]))
    faces = bent.faces[order]
    new = np.ones(len(faces), dtype=np.bool_)
    new[1:] = (faces[1:] != faces[:-1]).any(axis=1)
    bent = bent.take(order[new])
    # the solid's angle is what is left of a straight line after the turn
    through, sds = np.rad2deg(np.pi - bent.turn), np.rad2deg(bent.sd)
    one, two = (s.face_names[each] for each in bent.faces.T)
    rows.add_both_ways("dihedral", one, two, through, sds)
    for functor, bulges in (("convex", bent.convex), ("concave", bent.concave)):
        _add_face_pairs(functor, bent.faces[bulges], s, rows)


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
