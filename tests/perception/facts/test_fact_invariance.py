"""Facts do not depend on where the world's frame is, on scale, or on the order of anything."""

from collections.abc import Callable, Mapping

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from facetlog.perception.facts.all_facts import LEVEL_KINDS, scene_facts
from facetlog.perception.facts.fact_schema import FACT_SCHEMA, ArgumentKind, Fact
from facetlog.perception.scene import Edge, Face, Scene
from facetlog.perception.surfaces.exact_solids.polyhedra import (
    chair,
    cuboid,
    l_block,
    moved,
    pyramid,
    room_corner,
    stick_table,
    table,
    together,
    wedge,
)

KINDS = {kind.functor: kind for kind in FACT_SCHEMA}
# What says where the world's frame is, or how rings start.
FRAME = {"up", "point", "point_cov", "plane", "corner", "scene", "scale"}
# What is counted in cells is the same to a cell, not to a digit (tests/perception/space).
SPACE = {"footprint", "solidity", "hollow_side", "unseen_bounds", *LEVEL_KINDS}


def two_blocks() -> Scene:
    return together(cuboid(), moved(cuboid(), translation=(0.5, 0.1, 0.0)))


SOLIDS: list[Callable[[], Scene]] = [
    cuboid,
    wedge,
    pyramid,
    l_block,
    room_corner,
    table,
    stick_table,
    chair,
    two_blocks,
]
angles = st.floats(-3.1, 3.1)
rotations = st.builds(lambda a, b, c: Rotation.from_euler("zyx", [a, b, c]).as_matrix(),
                      angles, angles, angles)  # fmt: skip
shifts = st.tuples(*[st.floats(-5.0, 5.0)] * 3)
orders = st.randoms(use_true_random=False)
quick = settings(
    max_examples=2,
    phases=[Phase.generate],
    suppress_health_check=[HealthCheck.too_slow],
)


Table = dict[tuple[str, ...], tuple[tuple[float, ArgumentKind], ...]]


def table_of(scene: Scene, names: Mapping[str, str] | None = None) -> Table:
    """Facts as (functor, names) -> numbers with their kinds, names replaced where given."""
    rows: Table = {}
    for fact in scene_facts(scene):
        if fact.functor not in FRAME | SPACE:
            key = [fact.functor]
            numbers = []
            for argument, value in zip(KINDS[fact.functor].arguments, fact.args, strict=True):
                if isinstance(value, str):
                    key.append((names or {}).get(value, value))
                else:
                    numbers.append((float(value), argument.kind))
            rows[tuple(key)] = tuple(numbers)
    return rows


def assert_same(first: Table, second: Table, scale: float = 1.0) -> None:
    assert set(first) == set(second)
    power = {ArgumentKind.LENGTH: 1, ArgumentKind.AREA: 2}
    for key, row in first.items():
        wanted = [value * scale ** power.get(kind, 0) for value, kind in row]
        slack = max(1.0, scale) ** 2 * 1e-6
        assert [v for v, _ in second[key]] == pytest.approx(wanted, rel=1e-5, abs=slack), key


@pytest.mark.parametrize("build", SOLIDS)
@quick
@given(rotation=rotations, shift=shifts, scale=st.floats(0.01, 100.0))
def test_rigid_motion_and_scale_change_only_lengths(
    build: Callable[[], Scene],
    rotation: np.ndarray,
    shift: tuple[float, float, float],
    scale: float,
) -> None:
    scene = build()
    changed = moved(scene, rotation, scale * np.array(shift), scale)
    assert_same(table_of(scene), table_of(changed), scale)


def shuffled(scene: Scene, random: object) -> tuple[Scene, dict[str, str]]:
    """The scene in another order, rings started elsewhere, edges turned; and new name -> old."""
    shuffle = random.shuffle  # type: ignore[attr-defined]
    vertices, edges, faces = (
        list(range(len(x))) for x in (scene.vertices, scene.edges, scene.faces)
    )
    for order in (vertices, edges, faces):
        shuffle(order)
    place = {old: new for new, old in enumerate(vertices)}

    def face(old: Face) -> Face:
        ring = tuple(place[i] for i in old.outline)
        start = random.randrange(len(ring))  # type: ignore[attr-defined]
        return Face((*ring[start:], *ring[:start]), old.plane, (), old.support, old.coverage)

    def edge(old: Edge) -> Edge:
        return Edge(place[old.end], place[old.start], old.support, old.evidence)

    changed = Scene(
        scene.name,
        scene.views,
        tuple(scene.vertices[i] for i in vertices),
        tuple(edge(scene.edges[i]) for i in edges),
        tuple(face(scene.faces[i]) for i in faces),
        scene.up,
        scene.metric,
    )
    names = {
        f"{letter}{new + 1}": f"{letter}{old + 1}"
        for letter, order in (("v", vertices), ("e", edges), ("f", faces))
        for new, old in enumerate(order)
    }
    return changed, names


def things(scene: Scene, names: Mapping[str, str] | None = None) -> dict[str, str]:
    """Thing -> its first part by old name, which names it whatever the order."""
    found: dict[str, str] = {}
    for functor, args in scene_facts(scene):
        if functor == "part_of":
            part, thing = ((names or {}).get(str(a), str(a)) for a in args)
            found[thing] = min(part, found.get(thing, "z"))
    return found


def unordered(rows: Table) -> Table:
    """With the ends of edges in alphabetical order; of two equal sides that meet, either."""
    known = {}
    for key, row in rows.items():
        if key[0] == "edge":
            key = (*key[:2], *sorted(key[2:]))
        known[key[:3] if key[0] == "adjoins" else key] = row
    return known


@pytest.mark.parametrize("build", SOLIDS)
@quick
@given(random=orders)
@pytest.mark.slow
def test_order_changes_only_names(build: Callable[[], Scene], random: object) -> None:
    scene = build()
    changed, names = shuffled(scene, random)
    before = unordered(table_of(scene, things(scene)))
    after = unordered(table_of(changed, {**names, **things(changed, names)}))
    assert_same(before, after)


@pytest.mark.parametrize("build", [cuboid, l_block, table])
def test_relations_hold_for_both_orders(build: Callable[[], Scene]) -> None:
    facts = set(scene_facts(build()))
    for fact in facts:
        if fact.functor in {"convex", "concave", "opposite", "coplanar", "adjoins", "dihedral",
                            "angle", "overlap"}:  # fmt: skip
            first, second, *rest = fact.args
            assert Fact(fact.functor, (second, first, *rest)) in facts
