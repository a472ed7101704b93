"""All facts of a scene, as docs/facts.md states them: the end of perception.

Angles leave in degrees, lengths in the scene's unit. Faces are named f1 …, edges e1 …, vertices
v1 …, views view1 …, things t1 …, in the scene's order; sides of faces that the scene lists no
edge for follow the listed ones.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import repeat
from typing import TypeAlias

import numpy as np

from facetlog.perception import heights, measures, plans, relations
from facetlog.perception.angles import pairwise_angles
from facetlog.perception.contacts import SideContacts, edges_along_sides, side_contacts
from facetlog.perception.face_table import FaceTable
from facetlog.perception.fact_schema import FACT_SCHEMA, Fact, Value
from facetlog.perception.gaps import gaps
from facetlog.perception.row_table import Indices
from facetlog.perception.space import curved_share, spaces
from facetlog.perception.standing import at_rim
from facetlog.perception.things import Thing, find_things
from facetlog.perception.tolerance import SDS
from facetlog.perception.types import Evidence, FloatArray, Scene

__all__ = ["Fact", "FactRows", "fact_rows", "scene_facts"]

# On the ground is what ends within this share of its thing's height from the lowest point.
GROUND = 0.03


@dataclass(frozen=True, eq=False, slots=True)
class _Survey:
    """What several facts are made from, worked out once.

    `edges` (e, 2) are vertices, `bounds` (b, 2) an edge and a face each, `members` all vertices of
    each thing, ascending.
    """

    scene: Scene
    table: FaceTable
    edges: Indices
    bounds: Indices
    contacts: SideContacts
    things: tuple[Thing, ...]
    members: tuple[Indices, ...]

    @classmethod
    def of(cls, scene: Scene) -> "_Survey":
        table = FaceTable.of(scene)
        edges = _edges(scene, table)
        bounds = edges_along_sides(table, edges)
        contacts = side_contacts(table)
        bounding = set(bounds[:, 0].tolist())
        loose = tuple(i for i in range(len(scene.edges)) if i not in bounding)
        things = find_things(scene, table, contacts, loose)
        members = tuple(
            np.unique(
                np.concatenate(
                    (
                        table.rows_of(thing.faces)[1],
                        edges[list(thing.edges)].ravel(),
                        *(np.array(scene.patches[i].hull, dtype=np.intp) for i in thing.patches),
                    )
                )
            )
            for thing in things
        )
        return cls(scene, table, edges, bounds, contacts, things, members)


def _edges(scene: Scene, table: FaceTable) -> Indices:
    """The scene's edges (e, 2) and, after these, sides that it has no edge for."""
    listed = [(edge.start, edge.end) for edge in scene.edges]
    known = {frozenset(pair) for pair in listed}
    missing = {
        key: (start, end)
        for start, end in table.sides.ends.tolist()
        if (key := frozenset((start, end))) not in known
    }
    return np.array([*listed, *missing.values()], dtype=np.intp).reshape(-1, 2)


# What Fact(functor, args) comes to, without the call: a scene may have millions of facts.
_fact: Callable[[tuple[str, tuple[Value, ...]]], Fact] = partial(tuple.__new__, Fact)

# Where the upper half of a covariance stands.
UPPER = np.triu_indices(3)

FactRows: TypeAlias = dict[str, list[tuple[Value, ...]]]


def _scene_facts(s: _Survey, rows: FactRows) -> None:
    scene = s.scene
    rows["scene"].append((scene.name,))
    rows["scale"].append(("metric" if scene.metric else "unknown",))
    if scene.up is not None:
        rows["up"].append(tuple(scene.up.tolist()))
    for i, name in enumerate(scene.views, 1):
        rows["view"].append((f"view{i}", name))


def _names(letter: str, count: int) -> list[str]:
    return [f"{letter}{i}" for i in range(1, count + 1)]


def _named(letter: str, indices: Iterable[int]) -> list[str]:
    return [f"{letter}{i + 1}" for i in indices]


def _rows(names: Iterable[str], *columns: Iterable[Value]) -> Iterable[tuple[Value, ...]]:
    """A row for each name."""
    return zip(names, *columns, strict=True)


def _both_ways(
    rows: list[tuple[Value, ...]],
    one: Sequence[str],
    two: Sequence[str],
    *columns: Iterable[Value],
) -> None:
    """Adds a row for each pair of names, and after it that for the two in the other order."""
    for first, second, *rest in zip(one, two, *columns, strict=True):
        rows.append((first, second, *rest))
        rows.append((second, first, *rest))


def _vertex_facts(s: _Survey, rows: FactRows) -> None:
    table, vertices = s.table, s.scene.vertices
    names = _names("v", len(vertices))
    rows["vertex"].extend(_rows(names))
    rows["point"].extend(_rows(names, *table.points.T.tolist()))
    rows["point_cov"].extend(
        _rows(names, *(table.covs[:, i, j].tolist() for i, j in zip(*UPPER, strict=True)))
    )
    for name, vertex in zip(names, vertices, strict=True):
        if vertex.label is not None:
            rows["vertex_label"].append((name, vertex.label.value))
        for seen in vertex.observations:
            sds = np.sqrt(np.maximum(np.diag(seen.cov), 0.0))
            pixel = (*seen.uv.tolist(), *sds.tolist())
            rows["observed"].append((name, f"view{seen.view + 1}", *pixel))


def _edge_facts(s: _Survey, rows: FactRows) -> None:
    table, (start, end) = s.table, s.edges.T
    names = _names("e", len(s.edges))
    vertex_names = _names("v", len(table.points))
    ends = ([vertex_names[i] for i in each] for each in s.edges.T.tolist())
    rows["edge"].extend(_rows(names, *ends))
    span = table.points[end] - table.points[start]
    length = np.sqrt((span * span).sum(axis=1))
    # ∂|p - q|/∂p is the unit vector from q to p
    u = span / np.where(length > 0.0, length, 1.0)[:, None]
    variance = ((u[:, None] @ (table.covs[start] + table.covs[end]))[:, 0] * u).sum(axis=1)
    sds = np.sqrt(np.maximum(variance, 0.0))
    rows["edge_length"].extend(_rows(names, length.tolist(), sds.tolist()))
    edges = s.scene.edges
    rows["edge_support"].extend(_rows(names[: len(edges)], [float(e.support) for e in edges]))
    seen = {i for i, face in enumerate(s.scene.faces) if face.evidence is Evidence.MEASURED}
    measured = {edge for edge, face in s.bounds.tolist() if face in seen}
    evidence = [edge.evidence for edge in edges] + [
        Evidence.MEASURED if i in measured else Evidence.IMPLIED
        for i in range(len(edges), len(names))
    ]
    rows["evidence"].extend(_rows(names, [each.value for each in evidence]))
    edge, face = s.bounds.T.tolist()
    rows["bounds"].extend(_rows(_named("e", edge), _named("f", face)))


def _face_facts(s: _Survey, rows: FactRows) -> None:
    table, faces, planes = s.table, s.scene.faces, s.table.planes
    if not len(table):
        return
    names = _names("f", len(table))
    rows["face"].extend(_rows(names))
    rows["evidence"].extend(_rows(names, [face.evidence.value for face in faces]))
    rows["plane"].extend(_rows(names, *planes.normals.T.tolist(), planes.offsets.tolist()))
    levers = np.column_stack([table.middles, np.ones(len(table))])
    variance = ((levers[:, None] @ planes.covs)[:, 0] * levers).sum(axis=1)
    offset_sds = np.sqrt(np.maximum(variance, 0.0)).tolist()
    tilt_sds = np.rad2deg(planes.tilt_sds()).tolist()
    rows["plane_sd"].extend(_rows(names, tilt_sds, offset_sds))
    for name, face in zip(names, table.faces, strict=True):
        corners = enumerate(_named("v", face.outline), 1)
        rows["corner"].extend((name, i, corner) for i, corner in corners)
    sizes = measures.face_sizes(table)
    for functor, found in (
        ("area", sizes.areas),
        ("length", sizes.lengths),
        ("width", sizes.widths),
        ("fill", sizes.fills),
    ):
        rows[functor].extend(_rows(names, found.values.tolist(), found.sds.tolist()))
    rows["coverage"].extend(_rows(names, [float(face.coverage) for face in faces]))


def _thing_facts(s: _Survey, rows: FactRows) -> None:
    table = s.table
    groups = [
        measures.Group.of(thing.faces, members, table.points)
        for thing, members in zip(s.things, s.members, strict=True)
        if thing.faces
    ]
    for i, thing in enumerate(s.things, 1):
        name = f"t{i}"
        rows["thing"].append((name,))
        rows["part_of"].extend((part, name) for part in _named("f", thing.faces))
        rows["part_of"].extend((part, name) for part in _named("e", thing.edges))
    if groups:
        named = [f"t{i}" for i, thing in enumerate(s.things, 1) if thing.faces]
        boxes = measures.thing_boxes(table, groups)
        rows["thing_size"].extend((name, *box) for name, box in zip(named, boxes, strict=True))
        names = _named("f", np.concatenate([group.faces for group in groups]).tolist())
        for functor, found in (
            ("share", measures.shares(table, groups)),
            ("protrusion", measures.protrusions(table, groups)),
        ):
            rows[functor].extend(_rows(names, found.values.tolist(), found.sds.tolist()))
    bent = [i for i, thing in enumerate(s.things) if not thing.faces and len(s.members[i]) > 1]
    for i in bent:
        rows["thing_size"].append(
            (f"t{i + 1}", *measures.box_of_points(table.points[s.members[i]]))
        )
    flat = [i for i, thing in enumerate(s.things) if thing.faces or thing.edges]
    for i, j, distance in gaps(table, s.edges, tuple(s.things[i] for i in flat)):
        one, two = f"t{flat[i] + 1}", f"t{flat[j] + 1}"
        rows["gap"].append((one, two, *distance))
        rows["gap"].append((two, one, *distance))


def _pair_facts(s: _Survey, rows: FactRows) -> None:
    table, n = s.table, len(s.table)
    if not n:
        return
    names = _names("f", n)
    angles = pairwise_angles([face.plane for face in s.scene.faces])
    offsets = relations.offsets(table)
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
        ("opposite", relations.opposite_pairs(table, angles)),
        ("coplanar", relations.coplanar_pairs(table, angles, offsets)),
    ):
        one, two = pairs.T.tolist()
        _both_ways(rows[functor], _named("f", one), _named("f", two))


def _contact_facts(s: _Survey, rows: FactRows) -> None:
    contacts = s.contacts
    edge_of = {frozenset(pair): i for i, pair in reversed(tuple(enumerate(s.edges.tolist())))}
    shorter = s.table.sides.ends[contacts.shorter].tolist()
    adjoining = {
        (*pair, edge_of[frozenset(ends)])
        for pair, ends in zip(contacts.faces.tolist(), shorter, strict=True)
    }
    if adjoining:
        one, two, edge = zip(*sorted(adjoining), strict=True)
        names = _named("f", one), _named("f", two), _named("e", edge)
        _both_ways(rows["adjoins"], *names)
    # Of each pair that run against each other the longest contact, the first of equals.
    bent = contacts.take(contacts.against)
    order = np.lexsort((-bent.length, bent.faces[:, 1], bent.faces[:, 0]))
    faces = bent.faces[order]
    new = np.ones(len(faces), dtype=np.bool_)
    new[1:] = (faces[1:] != faces[:-1]).any(axis=1)
    bent = bent.take(order[new])
    # the solid's angle is what is left of a straight line after the turn
    through, sds = np.rad2deg(np.pi - bent.turn).tolist(), np.rad2deg(bent.sd).tolist()
    one, two = bent.faces.T.tolist()
    _both_ways(rows["dihedral"], _named("f", one), _named("f", two), through, sds)
    for functor, bulges in (("convex", bent.convex), ("concave", bent.concave)):
        one, two = bent.faces[bulges].T.tolist()
        _both_ways(rows[functor], _named("f", one), _named("f", two))


def _height_facts(s: _Survey, rows: FactRows) -> None:
    up, table = s.scene.up, s.table
    if up is None or not len(table):
        return
    names = _names("f", len(table))
    leaning = heights.tilts(table.planes, up)
    degrees = np.rad2deg(leaning.values).tolist(), np.rad2deg(leaning.sds).tolist()
    rows["tilt"].extend(_rows(names, *degrees))
    senses = heights.vertical_senses(table.planes, up)
    rows["upward"].extend(_rows(_named("f", np.flatnonzero(senses > 0).tolist())))
    rows["downward"].extend(_rows(_named("f", np.flatnonzero(senses < 0).tolist())))
    if s.things:
        _thing_heights(s, rows, up)
    for i, j, share in plans.overlaps(seen := plans.Plans.of(table, up)):
        rows["overlap"].append((f"f{i + 1}", f"f{j + 1}", share))
        rows["overlap"].append((f"f{j + 1}", f"f{i + 1}", share))
    lowest = np.array([(table.points[own] @ up).min(initial=np.inf) for own in s.members])
    for index, free in plans.clear_below(seen, s.things, lowest, s.contacts):
        rows["clear_below"].append((f"f{index + 1}", free))


def _thing_heights(s: _Survey, rows: FactRows, up: FloatArray) -> None:
    table = s.table
    grounds = heights.Grounds.under(s.members, table, up)
    bodies: list[tuple[str, int, Indices]] = []
    for nth, (thing, members) in enumerate(zip(s.things, s.members, strict=True)):
        bodies.append((f"t{nth + 1}", nth, members))
        own = ((face, table.faces[face].members) for face in thing.faces)
        bodies += [(f"f{face + 1}", nth, np.array(members)) for face, members in own]
        bodies += [(f"e{edge + 1}", nth, s.edges[edge]) for edge in thing.edges]
    names, things, vertices = zip(*bodies, strict=True)
    owners = np.array(things, dtype=np.intp)
    tops, bottoms = heights.extremes(vertices, owners, grounds, table)
    for functor, found in (("top_of", tops), ("bottom_of", bottoms)):
        rows[functor].extend(_rows(names, found.values.tolist(), found.sds.tolist()))
    whole = np.array([name.startswith("t") for name in names])
    least = np.maximum(GROUND * tops.values[whole], table.tolerance.finest)[owners]
    low = bottoms.values <= np.maximum(least, SDS * bottoms.sds)
    rows["on_ground"].extend((names[i],) for i in np.flatnonzero(low).tolist())
    faces = [face for thing in s.things for face in thing.faces]
    of = np.repeat(np.arange(len(s.things)), [len(thing.faces) for thing in s.things])
    middles = heights.elevations(table, np.array(faces, dtype=np.intp), of, grounds)
    rows["elevation"].extend(
        _rows(_named("f", faces), middles.values.tolist(), middles.sds.tolist())
    )


def _space_facts(s: _Survey, rows: FactRows) -> None:
    faces, points = s.table.faces, s.table.points
    edges = [(start, end) for start, end in s.edges.tolist()]
    for part, face in at_rim(s.scene, faces, edges, s.things):
        rows["at_rim"].append((part, f"f{face + 1}"))
    for i, thing in enumerate(s.things, 1):
        if thing.whole:
            rows["whole"].append((f"t{i}",))
        elif s.scene.bodies:  # read from surface, not found in pictures
            rows["scanned"].append((f"t{i}",))
        rows["curved"].append((f"t{i}", curved_share(s.scene, faces, thing)))
    outer = [points[members] for members in s.members]
    for index, space in spaces(s.scene, faces, s.things, outer).items():
        if space.footprint is not None:
            rows["footprint"].append((f"t{index + 1}", *space.footprint))
        rows["solidity"].append((f"t{index + 1}", *space.solidity))
        for face, level in space.levels.items():
            for functor, estimate in level.measures():
                rows[functor].append((f"f{face + 1}", *estimate))


_MAKERS: tuple[Callable[[_Survey, FactRows], None], ...] = (
    _scene_facts,
    _vertex_facts,
    _edge_facts,
    _face_facts,
    _thing_facts,
    _pair_facts,
    _contact_facts,
    _height_facts,
    _space_facts,
)


def fact_rows(scene: Scene) -> FactRows:
    """Arguments of all facts of a scene by functor, in the schema's order.

    Functors without a fact have an empty list. This is what `scene_facts` is made of, for callers
    that need no `Fact` objects.

    >>> from facetlog.perception.polyhedra import cuboid
    >>> rows = fact_rows(cuboid(0.3, 0.2, 0.1))
    >>> rows["thing"], rows["convex"][:2]
    ([('t1',)], [('f1', 'f3'), ('f3', 'f1')])
    """
    survey = _Survey.of(scene)
    rows: FactRows = {kind.functor: [] for kind in FACT_SCHEMA}
    for maker in _MAKERS:
        maker(survey, rows)
    return rows


def scene_facts(scene: Scene) -> tuple[Fact, ...]:
    """All facts of a scene, grouped by functor in the schema's order.

    >>> from facetlog.perception.polyhedra import cuboid
    >>> facts = scene_facts(cuboid(0.3, 0.2, 0.1))
    >>> [str(fact) for fact in facts if fact.functor in ("thing", "convex")][:3]
    ['thing(t1)', 'convex(f1, f3)', 'convex(f3, f1)']
    """
    return tuple(
        fact
        for functor, found in fact_rows(scene).items()
        for fact in map(_fact, zip(repeat(functor), found))
    )
