"""All facts of a scene, as fact_schema.py states them.

Angles leave in degrees, lengths in the scene's unit. Faces are named f1 …, edges e1 …, vertices
v1 …, views view1 …, things t1 …, in the scene's order; sides of faces that the scene lists no
edge for follow the listed ones.
"""

import logging
from collections.abc import Callable, Collection
from functools import partial
from itertools import repeat

import numpy as np

from facetlog.perception.facts import part_facts, thing_facts
from facetlog.perception.facts.fact_kinds import ArgumentKind
from facetlog.perception.facts.fact_schema import FACT_SCHEMA, ON_DEMAND, Fact, Value
from facetlog.perception.facts.named_rows import (
    CollectedFacts,
    FactColumns,
    FactRows,
    convert_to_rows,
)
from facetlog.perception.facts.pieces import piece_facts
from facetlog.perception.facts.pieces.kinds import PIECE_KINDS
from facetlog.perception.facts.scene_memo import SceneMemo
from facetlog.perception.scene import Scene

__all__ = [
    "LEVEL_KINDS",
    "Fact",
    "FactColumns",
    "FactRows",
    "fact_columns",
    "fact_rows",
    "facts_on_demand",
    "scene_facts",
]

# All lengths share the error of a scene's unit, and areas have it twice. It moves no two faces
# against each other, so it is in no covariance of theirs; each measure has it beside its own error,
# which it does not depend on.
_SD = "Sd"
_POWERS = {ArgumentKind.LENGTH: 1.0, ArgumentKind.AREA: 2.0}


def add_scale_error(facts: FactColumns, scale_sd: float) -> FactColumns:
    """Return the facts of a scene whose unit has this relative standard deviation.

    Where one deviation is stated of several lengths it has the error of the longest.

    >>> facts = {"length": (["f1"], np.array([2.0]), np.array([0.03]))}
    >>> add_scale_error(facts, 0.02)["length"][-1].tolist()
    [0.05]
    """
    if not scale_sd > 0.0:
        return facts
    found = dict(facts)
    for kind in FACT_SCHEMA:
        last, columns = kind.arguments[-1], facts.get(kind.functor, ())
        if last.name == _SD and last.kind in _POWERS and columns:
            values = np.abs([c for c in columns[:-1] if isinstance(c, np.ndarray)]).max(axis=0)
            sd = np.hypot(np.asarray(columns[-1]), _POWERS[last.kind] * scale_sd * values)
            found[kind.functor] = (*columns[:-1], sd)
    return found


_LOG = logging.getLogger(__name__)

# What Fact(functor, args) comes to, without the call: a scene may have millions of facts.
_fact: Callable[[tuple[str, tuple[Value, ...]]], Fact] = partial(tuple.__new__, Fact)

LEVEL_KINDS = (
    "cover",
    "level_length",
    "level_width",
    "built_over",
    "room_below",
    "room_width",
    "room_above",
    "free_below",
    "see_through",
    "see_across",
    "open_from_two_sides",
    "enclosed",
    "closed_behind",
    "closed_in_front",
    "side_behind",
    "rise_side",
    "rise_off_middle",
    "rise_span",
)

# What makes which kinds of facts, in the order in which facts of one kind stand.
_MAKERS: tuple[tuple[Callable[[SceneMemo, CollectedFacts], None], tuple[str, ...]], ...] = (
    (part_facts.scene_facts, ("scene", "scale", "up", "view")),
    (part_facts.vertex_facts, ("vertex", "point")),
    (part_facts.spread_facts, ("point_cov",)),
    (part_facts.view_facts, ("vertex_label", "observed")),
    (part_facts.edge_facts, ("edge", "edge_length", "edge_support", "evidence", "bounds")),
    (part_facts.face_facts, ("face", "evidence", "corner", "coverage")),
    (part_facts.sight_facts, ("viewpoint", "shows", "hides")),
    (part_facts.plane_facts, ("plane", "plane_sd")),
    (part_facts.size_facts, ("area", "length", "width", "fill")),
    (thing_facts.thing_facts, ("thing", "part_of")),
    (thing_facts.box_facts, ("thing_size",)),
    (thing_facts.share_facts, ("share",)),
    (thing_facts.protrusion_facts, ("protrusion",)),
    (thing_facts.reach_facts, ("reach_behind",)),
    (thing_facts.gap_facts, ("gap",)),
    (part_facts.angle_facts, ("angle",)),
    (part_facts.offset_facts, ("offset",)),
    (part_facts.opposite_facts, ("opposite",)),
    (part_facts.coplanar_facts, ("coplanar",)),
    (part_facts.meeting_facts, ("adjoins",)),
    (part_facts.dihedral_facts, ("dihedral", "convex", "concave")),
    (thing_facts.tilt_facts, ("tilt", "upward", "downward")),
    (thing_facts.body_facts, ("top_of", "bottom_of", "on_ground")),
    (thing_facts.elevation_facts, ("elevation",)),
    (thing_facts.overlap_facts, ("overlap",)),
    (thing_facts.clear_facts, ("clear_below",)),
    (thing_facts.rim_facts, ("at_rim",)),
    (thing_facts.surface_facts, ("whole", "scanned", "curved")),
    (
        thing_facts.space_facts,
        ("footprint", "solidity", "hollow_side", *LEVEL_KINDS, "unseen_bounds"),
    ),
    (thing_facts.front_facts, ("front_width", "front_depth")),
    (thing_facts.assumed_facts, ("assumed_full",)),
    (thing_facts.unseen_facts, ("unseen_towards",)),
    (thing_facts.shelf_facts, ("shelves_below", "shelves_unseen")),
    (piece_facts.piece_facts, tuple(kind.functor for kind in PIECE_KINDS)),
    (part_facts.drawing_facts, ("junction", "line_at", "contour")),
)


def fact_columns(scene: Scene, kinds: Collection[str] | None = None) -> FactColumns:
    """Return arguments of all facts of a scene by functor, in the schema's order, column by column.

    With `kinds` there are only those functors, on demand or not, and what nobody asks for is not
    worked out; else all but those on demand.
    """
    wanted = _wanted(kinds)
    memo, facts = SceneMemo.of(scene, wanted), CollectedFacts(wanted)
    for maker, made in _MAKERS:
        if not wanted.keys().isdisjoint(made):
            maker(memo, facts)
    return add_scale_error(facts.to_columns(), scene.scale_sd)


def _wanted(kinds: Collection[str] | None) -> dict[str, None]:
    every = (kind.functor for kind in FACT_SCHEMA)
    return dict.fromkeys(f for f in every if (f not in ON_DEMAND if kinds is None else f in kinds))


def fact_rows(scene: Scene, kinds: Collection[str] | None = None) -> FactRows:
    """Return the facts of one scene row by row; functors without a fact have an empty list.

    >>> from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
    >>> rows = fact_rows(cuboid(0.3, 0.2, 0.1))
    >>> rows["thing"], rows["convex"][:2]
    ([('t1',)], [('f1', 'f3'), ('f3', 'f1')])
    >>> fact_rows(cuboid(), {"thing"})
    {'thing': [('t1',)]}
    """
    found = fact_columns(scene, kinds)
    return {functor: convert_to_rows(columns) for functor, columns in found.items()}


def scene_facts(scene: Scene) -> tuple[Fact, ...]:
    """Return all facts of a scene but those on demand, grouped by functor in the schema's order.

    >>> from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
    >>> facts = scene_facts(cuboid(0.3, 0.2, 0.1))
    >>> [str(fact) for fact in facts if fact.functor in ("thing", "convex")][:3]
    ['thing(t1)', 'convex(f1, f3)', 'convex(f3, f1)']
    """
    return _facts(fact_rows(scene))


def facts_on_demand(scene: Scene) -> tuple[Fact, ...]:
    """Return the facts of a scene that `scene_facts` leaves out; they take as long as all others.

    Most of them only explain. Kinds whose maker fails are left out, with a warning in the log: they
    are unknown.
    """
    memo = SceneMemo.of(scene)
    found: FactColumns = {}
    for maker, made in _MAKERS:
        kinds = _wanted(ON_DEMAND.intersection(made))
        if not kinds:
            continue
        facts = CollectedFacts(kinds)
        try:
            maker(memo, facts)
        except Exception as exc:
            fault = f"{type(exc).__name__}: {exc}"
            _LOG.warning(
                "%s: %s are unknown, as working them out failed (%s)",
                scene.name,
                ", ".join(kinds),
                fault,
            )
            _LOG.debug("%s failed", maker.__name__, exc_info=True)
            continue
        found |= add_scale_error(facts.to_columns(), scene.scale_sd)
    return _facts({kind: convert_to_rows(found[kind]) for kind in _wanted(found)})


def _facts(rows: FactRows) -> tuple[Fact, ...]:
    return tuple(
        fact for functor, found in rows.items() for fact in map(_fact, zip(repeat(functor), found))
    )
