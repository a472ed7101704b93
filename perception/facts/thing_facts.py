"""Facts about things: what belongs to them, how large they are, where their parts are in them."""

from itertools import chain

import numpy as np

from facetlog.perception.facts import heights, measures, plan_view
from facetlog.perception.facts.filled_space import curved_share, spaces
from facetlog.perception.facts.named_rows import FactRows, named, names, rows_of
from facetlog.perception.facts.scene_memo import SceneMemo
from facetlog.perception.facts.standing_parts import at_rim
from facetlog.perception.surfaces.tolerance import SDS

__all__ = [
    "body_facts",
    "box_facts",
    "clear_facts",
    "elevation_facts",
    "gap_facts",
    "overlap_facts",
    "protrusion_facts",
    "rim_facts",
    "share_facts",
    "space_facts",
    "surface_facts",
    "thing_facts",
    "tilt_facts",
]

# On the ground is what ends within this share of its thing's height from the lowest point.
GROUND = 0.03


def thing_facts(s: SceneMemo, rows: FactRows) -> None:
    """Things and what belongs to them."""
    for i, thing in enumerate(s.things, 1):
        name = f"t{i}"
        rows["thing"].append((name,))
        rows["part_of"].extend((part, name) for part in named("f", thing.faces))
        rows["part_of"].extend((part, name) for part in named("e", thing.edges))


def box_facts(s: SceneMemo, rows: FactRows) -> None:
    """The least boxes round things: those with faces first."""
    if s.groups:
        flat = [f"t{i}" for i, thing in enumerate(s.things, 1) if thing.faces]
        boxes = measures.thing_boxes(s.table, s.groups)
        rows["thing_size"].extend((name, *box) for name, box in zip(flat, boxes, strict=True))
    for i, (thing, members) in enumerate(zip(s.things, s.members, strict=True), 1):
        if not thing.faces and len(members) > 1:
            box = measures.box_of_points(s.table.points[members])
            rows["thing_size"].append((f"t{i}", *box))


def _by_groups(functor: str, found: measures.Estimates, s: SceneMemo, rows: FactRows) -> None:
    faces = [face for group in s.groups for face in group.faces.tolist()]
    rows[functor].extend(rows_of(named("f", faces), found.values.tolist(), found.sds.tolist()))


def share_facts(s: SceneMemo, rows: FactRows) -> None:
    """How much of its thing's silhouette each face is."""
    if s.groups:
        _by_groups("share", measures.shares(s.table, s.groups), s, rows)


def protrusion_facts(s: SceneMemo, rows: FactRows) -> None:
    """How far things reach in front of their faces."""
    if s.groups:
        _by_groups("protrusion", measures.protrusions(s.table, s.groups), s, rows)


def gap_facts(s: SceneMemo, rows: FactRows) -> None:
    """How far things are from each other."""
    from facetlog.perception.facts.thing_gaps import gaps  # no model asks for them so far

    flat = [i for i, thing in enumerate(s.things) if thing.faces or thing.edges]
    for i, j, distance in gaps(s.table, s.edges, tuple(s.things[i] for i in flat)):
        one, two = f"t{flat[i] + 1}", f"t{flat[j] + 1}"
        rows["gap"].append((one, two, *distance))
        rows["gap"].append((two, one, *distance))


def tilt_facts(s: SceneMemo, rows: FactRows) -> None:
    """How faces lean, and which face up or down."""
    if s.scene.up is None or not len(s.table):
        return
    degrees = np.rad2deg(s.leaning.values).tolist(), np.rad2deg(s.leaning.sds).tolist()
    rows["tilt"].extend(rows_of(names("f", len(s.table)), *degrees))
    rows["upward"].extend(rows_of(named("f", np.flatnonzero(s.senses > 0).tolist())))
    rows["downward"].extend(rows_of(named("f", np.flatnonzero(s.senses < 0).tolist())))


def body_facts(s: SceneMemo, rows: FactRows) -> None:
    """How high things and their parts reach, and what is on the ground."""
    table, grounds = s.table, s.grounds
    if grounds is None:
        return
    ends = s.edges.tolist()
    found: list[str] = []
    things: list[int] = []
    vertices: list[int] = []
    counts: list[int] = []
    for nth, (thing, members) in enumerate(zip(s.things, s.members, strict=True)):
        own = [
            members.tolist(),
            *(table.faces[face].members for face in thing.faces),
            *(ends[edge] for edge in thing.edges),
        ]
        found += [f"t{nth + 1}", *named("f", thing.faces), *named("e", thing.edges)]
        things += [nth] * len(own)
        vertices += chain.from_iterable(own)
        counts += map(len, own)
    owners = np.array(things, dtype=np.intp)
    tops, bottoms = heights.extremes(
        np.array(vertices, dtype=np.intp), np.array(counts, dtype=np.intp), owners, grounds, table
    )
    for functor, each in (("top_of", tops), ("bottom_of", bottoms)):
        rows[functor].extend(rows_of(found, each.values.tolist(), each.sds.tolist()))
    whole = np.array([name.startswith("t") for name in found])
    least = np.maximum(GROUND * tops.values[whole], table.tolerance.finest)[owners]
    low = bottoms.values <= np.maximum(least, SDS * bottoms.sds)
    rows["on_ground"].extend((found[i],) for i in np.flatnonzero(low).tolist())


def elevation_facts(s: SceneMemo, rows: FactRows) -> None:
    """How high the middles of faces are in their things."""
    if s.grounds is None:
        return
    faces = [face for thing in s.things for face in thing.faces]
    of = np.repeat(np.arange(len(s.things)), [len(thing.faces) for thing in s.things])
    found = heights.elevations(s.table, np.array(faces, dtype=np.intp), of, s.grounds)
    rows["elevation"].extend(rows_of(named("f", faces), found.values.tolist(), found.sds.tolist()))


def overlap_facts(s: SceneMemo, rows: FactRows) -> None:
    """Pairs of faces that lie over each other, seen from above."""
    if s.plans is None:
        return
    for i, j, share in plan_view.overlaps(s.plans):
        rows["overlap"].append((f"f{i + 1}", f"f{j + 1}", share))
        rows["overlap"].append((f"f{j + 1}", f"f{i + 1}", share))


def clear_facts(s: SceneMemo, rows: FactRows) -> None:
    """The free height under most of each face."""
    if s.plans is None:
        return
    reach = s.table.points @ s.plans.up
    lowest = np.array([reach[own].min(initial=np.inf) for own in s.members])
    for index, free in plan_view.clear_below(s.plans, s.things, lowest, s.contacts, s.senses):
        rows["clear_below"].append((f"f{index + 1}", free))


def rim_facts(s: SceneMemo, rows: FactRows) -> None:
    """Parts that stand at the rim of a face about level."""
    for part, face in at_rim(s.scene, s.table.faces, s.edges, s.things):
        rows["at_rim"].append((part, f"f{face + 1}"))


def surface_facts(s: SceneMemo, rows: FactRows) -> None:
    """What is known of things' surface that is no face's."""
    for i, thing in enumerate(s.things, 1):
        if thing.whole:
            rows["whole"].append((f"t{i}",))
        elif s.scene.bodies:  # read from surface, not found in pictures
            rows["scanned"].append((f"t{i}",))
        rows["curved"].append((f"t{i}", curved_share(s.scene, s.table.faces, thing)))


def space_facts(s: SceneMemo, rows: FactRows) -> None:
    """What things fill, and what is beneath, on and above their level faces."""
    outer = [s.table.points[members] for members in s.members]
    for index, space in spaces(s.scene, s.table.faces, s.things, outer).items():
        if space.footprint is not None:
            rows["footprint"].append((f"t{index + 1}", *space.footprint))
        rows["solidity"].append((f"t{index + 1}", *space.solidity))
        for face, level in space.levels.items():
            for functor, estimate in level.measures():
                rows[functor].append((f"f{face + 1}", *estimate))
