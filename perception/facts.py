"""All facts of a scene, as docs/facts.md states them: the end of perception.

Angles leave in degrees, lengths in the scene's unit. Faces are named f1 …, edges e1 …, vertices
v1 …, views view1 …, things t1 …, in the scene's order; sides of faces that the scene lists no
edge for follow the listed ones.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import repeat

import numpy as np

from facetlog.perception import heights, measures, relations
from facetlog.perception.angles import pairwise_angles
from facetlog.perception.contacts import (
    Bend,
    SideContact,
    bends,
    edges_along_sides,
    side_contacts,
    sides,
)
from facetlog.perception.fact_schema import FACT_SCHEMA, Fact, Value
from facetlog.perception.flat_faces import FlatFace, flat_faces
from facetlog.perception.gaps import gaps
from facetlog.perception.things import Thing, find_things
from facetlog.perception.tolerance import Tolerance
from facetlog.perception.types import Evidence, FloatArray, Scene

__all__ = ["Fact", "scene_facts"]


@dataclass(frozen=True, eq=False, slots=True)
class _Survey:
    """What several facts are made from, worked out once."""

    scene: Scene
    faces: tuple[FlatFace, ...]
    edges: tuple[tuple[int, int], ...]
    bounds: tuple[tuple[int, int], ...]
    contacts: tuple[tuple[SideContact, Bend], ...]
    things: tuple[Thing, ...]
    points: FloatArray
    covs: FloatArray
    tolerance: Tolerance

    @classmethod
    def of(cls, scene: Scene) -> "_Survey":
        faces = flat_faces(scene)
        listed = [(e.start, e.end) for e in scene.edges]
        known = {frozenset(pair) for pair in listed}
        every = sides(faces)
        missing = {
            frozenset(pair): pair
            for side in every
            if frozenset(pair := (side.start, side.end)) not in known
        }
        edges = (*listed, *missing.values())
        bounds = edges_along_sides(scene, faces, edges)
        found = side_contacts(scene, faces)
        contacts = tuple(zip(found, bends(scene, found), strict=True))
        bounding = {edge for edge, _ in bounds}
        loose = tuple(i for i in range(len(listed)) if i not in bounding)
        return cls(
            scene,
            faces,
            edges,
            bounds,
            contacts,
            find_things(scene, faces, contacts, loose),
            scene.points,
            np.array([v.cov for v in scene.vertices]).reshape(-1, 3, 3),
            Tolerance.of(scene),
        )

    def members(self, thing: Thing) -> tuple[int, ...]:
        """All vertices of a thing, ascending."""
        own = {i for face in thing.faces for i in self.faces[face].members}
        own.update(i for edge in thing.edges for i in self.edges[edge])
        return tuple(sorted(own))


# What Fact(functor, args) comes to, without the call: a scene may have millions of facts.
_fact: Callable[[tuple[str, tuple[Value, ...]]], Fact] = partial(tuple.__new__, Fact)

_Rows = dict[str, list[tuple[Value, ...]]]


def _scene_facts(s: _Survey, rows: _Rows) -> None:
    scene = s.scene
    rows["scene"].append((scene.name,))
    rows["scale"].append(("metric" if scene.metric else "unknown",))
    if scene.up is not None:
        rows["up"].append(tuple(scene.up.tolist()))
    for i, name in enumerate(scene.views, 1):
        rows["view"].append((f"view{i}", name))


def _vertex_facts(s: _Survey, rows: _Rows) -> None:
    for i, vertex in enumerate(s.scene.vertices, 1):
        name = f"v{i}"
        rows["vertex"].append((name,))
        rows["point"].append((name, *vertex.point.tolist()))
        rows["point_cov"].append((name, *vertex.cov[np.triu_indices(3)].tolist()))
        if vertex.label is not None:
            rows["vertex_label"].append((name, vertex.label.value))
        for seen in vertex.observations:
            sds = np.sqrt(np.maximum(np.diag(seen.cov), 0.0))
            pixel = (*seen.uv.tolist(), *sds.tolist())
            rows["observed"].append((name, f"view{seen.view + 1}", *pixel))


def _edge_facts(s: _Survey, rows: _Rows) -> None:
    measured = {
        edge for edge, face in s.bounds if s.scene.faces[face].evidence is Evidence.MEASURED
    }
    for i, (start, end) in enumerate(s.edges):
        name = f"e{i + 1}"
        rows["edge"].append((name, f"v{start + 1}", f"v{end + 1}"))
        span = s.points[end] - s.points[start]
        length = float(np.linalg.norm(span))
        # ∂|p - q|/∂p is the unit vector from q to p
        u = span / length if length > 0.0 else np.zeros(3)
        variance = float(u @ (s.covs[start] + s.covs[end]) @ u)
        rows["edge_length"].append((name, length, float(np.sqrt(max(variance, 0.0)))))
        if i < len(s.scene.edges):
            rows["edge_support"].append((name, float(s.scene.edges[i].support)))
            evidence = s.scene.edges[i].evidence
        else:
            evidence = Evidence.MEASURED if i in measured else Evidence.IMPLIED
        rows["evidence"].append((name, evidence.value))
    rows["bounds"].extend((f"e{edge + 1}", f"f{face + 1}") for edge, face in s.bounds)


def _face_facts(s: _Survey, rows: _Rows) -> None:
    for flat, face in zip(s.faces, s.scene.faces, strict=True):
        name = f"f{flat.index + 1}"
        rows["face"].append((name,))
        rows["evidence"].append((name, face.evidence.value))
        rows["plane"].append((name, *face.plane.normal.tolist(), float(face.plane.offset)))
        _, offset_sd = measures.distances(face.plane, flat.middle[None])
        tilt_sd = float(np.rad2deg(measures.tilt_sd(face.plane)))
        rows["plane_sd"].append((name, tilt_sd, float(offset_sd[0])))
        rows["corner"].extend((name, i, f"v{v + 1}") for i, v in enumerate(flat.outline, 1))
        size = measures.face_size(flat, s.points, s.covs, s.tolerance)
        rows["area"].append((name, *size.area))
        rows["length"].append((name, *size.length))
        rows["width"].append((name, *size.width))
        rows["fill"].append((name, *size.fill))
        rows["coverage"].append((name, float(face.coverage)))


def _thing_facts(s: _Survey, rows: _Rows) -> None:
    for i, thing in enumerate(s.things, 1):
        name = f"t{i}"
        rows["thing"].append((name,))
        rows["part_of"].extend((f"f{face + 1}", name) for face in thing.faces)
        rows["part_of"].extend((f"e{edge + 1}", name) for edge in thing.edges)
        members = np.array(s.members(thing), dtype=np.intp)
        outer = measures.outer_members(members, s.points)
        own = tuple(s.faces[face] for face in thing.faces)
        rows["thing_size"].append((name, *measures.thing_box(own, outer, s.points)))
        for flat in own:
            plane = s.scene.faces[flat.index].plane
            face = f"f{flat.index + 1}"
            part = measures.share(flat, plane, outer, s.points, s.covs, s.tolerance)
            rows["share"].append((face, *part))
            reach = measures.protrusion(flat, plane, members, s.points, s.covs, s.tolerance)
            rows["protrusion"].append((face, *reach))
    for i, j, distance in gaps(s.points, s.covs, s.faces, s.edges, s.things, s.tolerance):
        rows["gap"].append((f"t{i + 1}", f"t{j + 1}", *distance))
        rows["gap"].append((f"t{j + 1}", f"t{i + 1}", *distance))


def _pair_facts(s: _Survey, rows: _Rows) -> None:
    names = [f"f{i}" for i in range(1, len(s.faces) + 1)]
    angles = pairwise_angles([face.plane for face in s.scene.faces])
    offsets = relations.offsets(s.scene, s.faces)
    n = len(names)
    others = ~np.eye(n, dtype=bool)
    tables = (("angle", (np.rad2deg(angles[0]), np.rad2deg(angles[1]))), ("offset", offsets))
    for functor, (values, sds) in tables:
        value_rows = values[others].reshape(n, max(n - 1, 0)).tolist()
        sd_rows = sds[others].reshape(n, max(n - 1, 0)).tolist()
        for i, name in enumerate(names):
            second = names[:i] + names[i + 1 :]
            # millions of rows: kept within zip
            rows[functor].extend(zip(repeat(name), second, value_rows[i], sd_rows[i], strict=False))
    for functor, pairs in (
        ("opposite", relations.opposite_pairs(s.scene, s.faces, angles)),
        ("coplanar", relations.coplanar_pairs(s.scene, angles, offsets)),
    ):
        for i, j in pairs:
            rows[functor].append((names[i], names[j]))
            rows[functor].append((names[j], names[i]))


def _contact_facts(s: _Survey, rows: _Rows) -> None:
    edge_of = {frozenset(pair): i for i, pair in reversed(tuple(enumerate(s.edges, 1)))}
    longest: dict[tuple[int, int], tuple[SideContact, Bend]] = {}
    adjoining: set[tuple[int, int, int]] = set()
    for contact, turn in s.contacts:
        pair = (contact.first.face + 1, contact.second.face + 1)
        edge = edge_of[frozenset((contact.shorter.start, contact.shorter.end))]
        adjoining.add((*pair, edge))
        if contact.against and (pair not in longest or contact.length > longest[pair][0].length):
            longest[pair] = contact, turn
    for i, j, edge in sorted(adjoining):
        rows["adjoins"].append((f"f{i}", f"f{j}", f"e{edge}"))
        rows["adjoins"].append((f"f{j}", f"f{i}", f"e{edge}"))
    for (i, j), (_, turn) in sorted(longest.items(), key=lambda item: item[0]):
        # the solid's angle is what is left of a straight line after the turn
        through = float(np.rad2deg(np.pi - turn.turn))
        way = "convex" if turn.convex else "concave" if turn.concave else None
        for a, b in ((f"f{i}", f"f{j}"), (f"f{j}", f"f{i}")):
            rows["dihedral"].append((a, b, through, float(np.rad2deg(turn.sd))))
            if way is not None:
                rows[way].append((a, b))


def _height_facts(s: _Survey, rows: _Rows) -> None:
    up = s.scene.up
    if up is None:
        return
    for flat, face in zip(s.faces, s.scene.faces, strict=True):
        name = f"f{flat.index + 1}"
        leaning = heights.tilt(face.plane, up)
        rows["tilt"].append((name, *np.rad2deg(leaning).tolist()))
        sense = heights.vertical_sense(face.plane, up)
        if sense:
            rows["upward" if sense > 0 else "downward"].append((name,))
    for i, thing in enumerate(s.things, 1):
        members = s.members(thing)
        ground = heights.Ground.under(members, s.points, s.covs, s.tolerance, up)
        bodies: list[tuple[str, tuple[int, ...]]] = [(f"t{i}", members)]
        bodies += [(f"f{face + 1}", s.faces[face].members) for face in thing.faces]
        bodies += [(f"e{edge + 1}", s.edges[edge]) for edge in thing.edges]
        for name, own in bodies:
            top, bottom = heights.extremes(own, ground)
            rows["top_of"].append((name, *top))
            rows["bottom_of"].append((name, *bottom))
        for index in thing.faces:
            middle = heights.elevation(s.faces[index], ground, s.covs)
            rows["elevation"].append((f"f{index + 1}", *middle))
    for index, free in heights.clear_below(s.scene, s.faces, s.things, s.contacts, up).items():
        rows["clear_below"].append((f"f{index + 1}", free))
    for i, j, share in heights.overlaps(s.scene, s.faces, up):
        rows["overlap"].append((f"f{i + 1}", f"f{j + 1}", share))
        rows["overlap"].append((f"f{j + 1}", f"f{i + 1}", share))


_MAKERS: tuple[Callable[[_Survey, _Rows], None], ...] = (
    _scene_facts,
    _vertex_facts,
    _edge_facts,
    _face_facts,
    _thing_facts,
    _pair_facts,
    _contact_facts,
    _height_facts,
)


def scene_facts(scene: Scene) -> tuple[Fact, ...]:
    """All facts of a scene, grouped by functor in the schema's order.

    >>> from facetlog.perception.polyhedra import cuboid
    >>> facts = scene_facts(cuboid(0.3, 0.2, 0.1))
    >>> [str(fact) for fact in facts if fact.functor in ("thing", "convex")][:3]
    ['thing(t1)', 'convex(f1, f3)', 'convex(f3, f1)']
    """
    survey = _Survey.of(scene)
    rows: _Rows = {kind.functor: [] for kind in FACT_SCHEMA}
    for maker in _MAKERS:
        maker(survey, rows)
    return tuple(
        fact for functor, found in rows.items() for fact in map(_fact, zip(repeat(functor), found))
    )
