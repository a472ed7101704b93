"""Facts about a scene as such, its vertices, edges and faces, and pairs of faces."""

from collections.abc import Sequence
from itertools import repeat

import numpy as np

from facetlog.perception.facts import measures, relations
from facetlog.perception.facts.named_rows import FactRows, both_ways, named, names, rows_of
from facetlog.perception.facts.scene_memo import SceneMemo
from facetlog.perception.scene import Evidence
from facetlog.perception.types import FloatArray

__all__ = [
    "angle_facts",
    "coplanar_facts",
    "dihedral_facts",
    "edge_facts",
    "face_facts",
    "meeting_facts",
    "offset_facts",
    "opposite_facts",
    "plane_facts",
    "scene_facts",
    "size_facts",
    "spread_facts",
    "vertex_facts",
    "view_facts",
]

# Where the upper half of a covariance stands.
UPPER = tuple(zip(*(each.tolist() for each in np.triu_indices(3)), strict=True))


def scene_facts(s: SceneMemo, rows: FactRows) -> None:
    """The scene's name, unit, up and views."""
    scene = s.scene
    rows["scene"].append((scene.name,))
    rows["scale"].append(("metric" if scene.metric else "unknown",))
    if scene.up is not None:
        rows["up"].append(tuple(scene.up.tolist()))
    for i, name in enumerate(scene.views, 1):
        rows["view"].append((f"view{i}", name))


def vertex_facts(s: SceneMemo, rows: FactRows) -> None:
    """Vertices and where they are."""
    found = names("v", len(s.table.points))
    rows["vertex"].extend(rows_of(found))
    rows["point"].extend(rows_of(found, *s.table.points.T.tolist()))


def spread_facts(s: SceneMemo, rows: FactRows) -> None:
    """Covariances of vertices."""
    covs = s.table.covs
    columns = (covs[:, i, j].tolist() for i, j in UPPER)
    rows["point_cov"].extend(rows_of(names("v", len(covs)), *columns))


def view_facts(s: SceneMemo, rows: FactRows) -> None:
    """What views say of vertices."""
    for i, vertex in enumerate(s.scene.vertices, 1):
        if vertex.label is not None:
            rows["vertex_label"].append((f"v{i}", vertex.label.value))
        for seen in vertex.observations:
            sds = np.sqrt(np.maximum(np.diag(seen.cov), 0.0))
            pixel = (*seen.uv.tolist(), *sds.tolist())
            rows["observed"].append((f"v{i}", f"view{seen.view + 1}", *pixel))


def edge_facts(s: SceneMemo, rows: FactRows) -> None:
    """Edges, how long they are, what supports them, and which faces they bound."""
    table, (start, end) = s.table, s.edges.T
    found = names("e", len(s.edges))
    vertex_names = names("v", len(table.points))
    ends = ([vertex_names[i] for i in each] for each in s.edges.T.tolist())
    rows["edge"].extend(rows_of(found, *ends))
    span = table.points[end] - table.points[start]
    length = np.sqrt((span * span).sum(axis=1))
    # ∂|p - q|/∂p is the unit vector from q to p
    u = span / np.where(length > 0.0, length, 1.0)[:, None]
    variance = ((u[:, None] @ (table.covs[start] + table.covs[end]))[:, 0] * u).sum(axis=1)
    sds = np.sqrt(np.maximum(variance, 0.0))
    rows["edge_length"].extend(rows_of(found, length.tolist(), sds.tolist()))
    edges = s.scene.edges
    rows["edge_support"].extend(rows_of(found[: len(edges)], [float(e.support) for e in edges]))
    seen = {i for i, face in enumerate(s.scene.faces) if face.evidence is Evidence.MEASURED}
    measured = {edge for edge, face in s.bounds.tolist() if face in seen}
    evidence = [edge.evidence for edge in edges] + [
        Evidence.MEASURED if i in measured else Evidence.IMPLIED
        for i in range(len(edges), len(found))
    ]
    rows["evidence"].extend(rows_of(found, [each.value for each in evidence]))
    edge, face = s.bounds.T.tolist()
    rows["bounds"].extend(rows_of(named("e", edge), named("f", face)))


def face_facts(s: SceneMemo, rows: FactRows) -> None:
    """Faces, their corners, and how much of them was seen."""
    faces = s.scene.faces
    found = names("f", len(faces))
    rows["face"].extend(rows_of(found))
    rows["evidence"].extend(rows_of(found, [face.evidence.value for face in faces]))
    for name, face in zip(found, s.table.faces, strict=True):
        corners = enumerate(named("v", face.outline), 1)
        rows["corner"].extend((name, i, corner) for i, corner in corners)
    rows["coverage"].extend(rows_of(found, [float(face.coverage) for face in faces]))


def plane_facts(s: SceneMemo, rows: FactRows) -> None:
    """Planes of faces and how sure they are."""
    table, planes = s.table, s.table.planes
    found = names("f", len(table))
    rows["plane"].extend(rows_of(found, *planes.normals.T.tolist(), planes.offsets.tolist()))
    levers = np.column_stack([table.middles, np.ones(len(table))])
    variance = ((levers[:, None] @ planes.covs)[:, 0] * levers).sum(axis=1)
    offset_sds = np.sqrt(np.maximum(variance, 0.0)).tolist()
    tilt_sds = np.rad2deg(planes.tilt_sds).tolist()
    rows["plane_sd"].extend(rows_of(found, tilt_sds, offset_sds))


def size_facts(s: SceneMemo, rows: FactRows) -> None:
    """How large faces are, and of what shape."""
    found = names("f", len(s.table))
    if not found:
        return
    sizes = measures.face_sizes(s.table)
    for functor, each in (
        ("area", sizes.areas),
        ("length", sizes.lengths),
        ("width", sizes.widths),
        ("fill", sizes.fills),
    ):
        rows[functor].extend(rows_of(found, each.values.tolist(), each.sds.tolist()))


def _of_all_pairs(
    functor: str, tables: tuple[FloatArray, FloatArray], count: int, rows: FactRows
) -> None:
    """Rows (face, other face, value, sd) of tables (f, f) without their diagonals."""
    found = names("f", count)
    values, sds = tables[0].tolist(), tables[1].tolist()
    for i, name in enumerate(found):
        # millions of rows: kept within zip
        for own in (slice(None, i), slice(i + 1, None)):
            pairs = zip(repeat(name), found[own], values[i][own], sds[i][own], strict=False)
            rows[functor].extend(pairs)


def angle_facts(s: SceneMemo, rows: FactRows) -> None:
    """Angles between normals, of all pairs of faces."""
    angles, sds = s.angles
    _of_all_pairs("angle", (np.rad2deg(angles), np.rad2deg(sds)), len(s.table), rows)


def offset_facts(s: SceneMemo, rows: FactRows) -> None:
    """How far faces are in front of the planes of others, of all pairs."""
    _of_all_pairs("offset", s.offsets, len(s.table), rows)


def _faces_both_ways(functor: str, pairs: Sequence[Sequence[int]], rows: FactRows) -> None:
    one, two = pairs
    both_ways(rows[functor], named("f", one), named("f", two))


def opposite_facts(s: SceneMemo, rows: FactRows) -> None:
    """Pairs of faces that look away from each other or at each other."""
    if len(s.table):
        pairs = relations.opposite_pairs(s.table, s.angles)
        _faces_both_ways("opposite", pairs.T.tolist(), rows)


def coplanar_facts(s: SceneMemo, rows: FactRows) -> None:
    """Pairs of faces in one plane."""
    pairs = relations.coplanar_pairs(s.table, s.angles, s.offsets)
    _faces_both_ways("coplanar", pairs.T.tolist(), rows)


def meeting_facts(s: SceneMemo, rows: FactRows) -> None:
    """Pairs of faces that meet, with the edge where they do."""
    contacts = s.contacts
    edge_of = {frozenset(pair): i for i, pair in reversed(tuple(enumerate(s.edges.tolist())))}
    shorter = s.table.sides.ends[contacts.shorter].tolist()
    adjoining = {
        (*pair, edge_of[frozenset(ends)])
        for pair, ends in zip(contacts.faces.tolist(), shorter, strict=True)
    }
    if adjoining:
        one, two, edge = zip(*sorted(adjoining), strict=True)
        both_ways(rows["adjoins"], named("f", one), named("f", two), named("e", edge))


def dihedral_facts(s: SceneMemo, rows: FactRows) -> None:
    """The solid's angles where two faces meet, and whether it bulges there or is hollow."""
    # Of each pair that run against each other the longest contact, the first of equals.
    bent = s.contacts.take(s.contacts.against)
    order = np.lexsort((-bent.length, bent.faces[:, 1], bent.faces[:, 0]))
    faces = bent.faces[order]
    new = np.ones(len(faces), dtype=np.bool_)
    new[1:] = (faces[1:] != faces[:-1]).any(axis=1)
    bent = bent.take(order[new])
    # the solid's angle is what is left of a straight line after the turn
    through, sds = np.rad2deg(np.pi - bent.turn).tolist(), np.rad2deg(bent.sd).tolist()
    one, two = bent.faces.T.tolist()
    both_ways(rows["dihedral"], named("f", one), named("f", two), through, sds)
    for functor, bulges in (("convex", bent.convex), ("concave", bent.concave)):
        _faces_both_ways(functor, bent.faces[bulges].T.tolist(), rows)
