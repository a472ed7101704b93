"""Facts of exact solids: what the schema promises, and what a reader would measure by hand."""

from collections import defaultdict
from dataclasses import replace

import numpy as np
import pytest

from facetlog.perception.facts import measures, plan_view
from facetlog.perception.facts.all_facts import _MAKERS, fact_rows, scene_facts
from facetlog.perception.facts.fact_schema import FACT_SCHEMA, Fact, Solutions, check_fact
from facetlog.perception.facts.gaps import nearest_points, thing_gaps
from facetlog.perception.scene import Body, Edge, Face, Plane, Scene, Vertex
from facetlog.perception.surfaces import contacts, convex_hulls, outline_overlap
from facetlog.perception.surfaces.exact_solids.polyhedra import (
    chair,
    cuboid,
    l_block,
    moved,
    polyhedron,
    pyramid,
    room_corner,
    stick_table,
    table,
    together,
    wedge,
)

SOLIDS = [cuboid, wedge, pyramid, l_block, room_corner, table, stick_table, chair]


def rows(scene: Scene, functor: str) -> dict[tuple[str, ...], tuple[float, ...]]:
    """Facts of one functor as names -> numbers."""
    return {
        tuple(a for a in fact.args if isinstance(a, str)): tuple(
            a for a in fact.args if not isinstance(a, str)
        )
        for fact in scene_facts(scene)
        if fact.functor == functor
    }


def test_what_is_made_is_what_the_schema_has() -> None:
    made = {functor for _, functors in _MAKERS for functor in functors}
    assert made == {kind.functor for kind in FACT_SCHEMA}


@pytest.mark.parametrize("build", SOLIDS)
def test_every_fact_keeps_to_the_schema(build: object) -> None:
    facts = scene_facts(build())  # type: ignore[operator]
    assert [fault for fact in facts if (fault := check_fact(fact))] == []
    order = [kind.functor for kind in FACT_SCHEMA]
    places = [order.index(fact.functor) for fact in facts]
    assert places == sorted(places)
    assert len(set(facts)) == len(facts)


def told_apart(*scenes: Scene) -> Scene:
    """The scenes side by side, each a body that is known from all sides."""
    scene, bodies, begin = together(*scenes), [], 0
    for each in scenes:
        end = begin + len(each.faces)
        bodies.append(Body(tuple(range(begin, end)), whole=True))
        begin = end
    return replace(scene, bodies=tuple(bodies))


TWO_THINGS = told_apart(chair(), moved(l_block(), translation=(2.0, 0.3, 0.0)))
ALL_ROWS = fact_rows(TWO_THINGS)


@pytest.mark.parametrize("kind", [k.functor for k in FACT_SCHEMA if not k.on_demand])
def test_facts_of_one_kind_are_the_same_as_among_all(kind: str) -> None:
    assert fact_rows(TWO_THINGS, {kind}) == {kind: ALL_ROWS[kind]}


def test_a_chair_and_a_block_have_facts_of_every_kind_that_needs_no_picture() -> None:
    of_pictures = {"view", "vertex_label", "observed", "viewpoint", "shows", "hides"}
    of_scans = {"scanned", "unseen_bounds"}
    assert {kind for kind, found in ALL_ROWS.items() if not found} == of_pictures | of_scans


def test_only_what_was_read_from_surface_and_is_not_whole_is_scanned() -> None:
    faces = tuple(range(len(chair().faces)))
    for body, scanned, whole in (
        (Body(faces), [("t1",)], []),
        (Body(faces, whole=True), [], [("t1",)]),
    ):
        rows = fact_rows(replace(chair(), bodies=(body,)), {"scanned", "whole"})
        assert rows == {"scanned": scanned, "whole": whole}
    assert fact_rows(chair(), {"scanned"}) == {"scanned": []}


@pytest.mark.parametrize("build", SOLIDS)
def test_keys_have_as_many_facts_as_the_schema_says(build: object) -> None:
    scene: Scene = build()  # type: ignore[operator]
    count: dict[tuple[object, ...], int] = defaultdict(int)
    keys = {kind.functor: kind.keys for kind in FACT_SCHEMA}
    for fact in scene_facts(scene):
        count[fact.functor, *fact.args[: keys[fact.functor]]] += 1
    for kind in FACT_SCHEMA:
        found = [n for key, n in count.items() if key[0] == kind.functor]
        if kind.solutions is not Solutions.ANY:
            assert all(n == 1 for n in found), kind.functor
    faces, vertices = len(scene.faces), len(scene.vertices)
    per_functor: dict[str, int] = defaultdict(int)
    for key, n in count.items():
        per_functor[str(key[0])] += n
    for functor in ("face", "plane", "plane_sd", "area", "length", "fill", "share", "protrusion"):
        assert per_functor[functor] == faces, functor
    assert per_functor["point"] == vertices
    for functor in ("angle", "offset"):
        assert per_functor[functor] == faces * (faces - 1), functor


def test_a_block_has_its_sizes_and_full_shares() -> None:
    scene = cuboid(0.3, 0.2, 0.1)
    assert rows(scene, "thing_size")["t1",] == pytest.approx((0.3, 0.2, 0.1))
    assert rows(scene, "area")["f2",][0] == pytest.approx(0.06)
    # ∂A/∂p is half a diagonal at each of the four corners: var A = σ² (l² + w²)
    assert rows(scene, "area")["f2",][1] == pytest.approx(1e-3 * (0.3**2 + 0.2**2) ** 0.5)
    assert [value for value, _ in rows(scene, "share").values()] == pytest.approx([1.0] * 6)
    assert {value for value, _ in rows(scene, "protrusion").values()} == {0.0}
    assert all(deg == pytest.approx(90) for deg, _ in rows(scene, "dihedral").values())
    assert len(rows(scene, "convex")) == 24
    assert not rows(scene, "concave")
    assert set(rows(scene, "opposite")) == {
        pair for a, b in (("f1", "f2"), ("f3", "f4"), ("f5", "f6")) for pair in ((a, b), (b, a))
    }


def test_an_l_has_one_hollow_edge_and_less_than_its_silhouette() -> None:
    scene = l_block()
    assert len(rows(scene, "concave")) == 2
    assert rows(scene, "share")["f1",][0] == pytest.approx(6 / 7)
    assert rows(scene, "fill")["f1",][0] == pytest.approx(0.75)


@pytest.mark.parametrize("build", [table, stick_table])
def test_a_table_is_one_thing_whose_rim_shows_little_of_it(build: object) -> None:
    scene: Scene = build()  # type: ignore[operator]
    assert set(rows(scene, "thing")) == {("t1",)}
    assert rows(scene, "thing_size")["t1",] == pytest.approx((1.2, 0.8, 0.74))
    shares = sorted(value for value, _ in rows(scene, "share").values())
    assert shares[-1] == pytest.approx(1.0)
    assert shares[0] < 0.06
    tops = rows(scene, "top_of")
    for (face,), (free,) in rows(scene, "clear_below").items():
        if tops[face,][0] > 0.7:
            assert free == pytest.approx(0.7), face


@pytest.mark.parametrize(("thick", "free"), [(0.1, 2.0), (0.25, 2.0), (0.4, 0.0)])
def test_posts_are_not_in_the_way_beneath_their_lintel(thick: float, free: float) -> None:
    # A gate 1.2 m broad and 20 cm deep; of posts that take more than half of it nothing is free.
    low, high = (thick, 1.2 - thick)
    ring = [(0.0, 0.0), (low, 0.0), (low, 2.0), (high, 2.0), (high, 0.0), (1.2, 0.0)]
    ring += [(1.2, 2.2), (0.0, 2.2)]
    points = [(x, y, z) for y in (0.0, 0.2) for x, z in ring]
    count = len(ring)
    front = list(range(count))
    around = [[k + count, (k + 1) % count + count, (k + 1) % count, k] for k in front]
    scene = polyhedron(points, [front, [k + count for k in reversed(front)], *around])
    top = max(rows(scene, "elevation").items(), key=lambda row: row[1][0])[0]
    assert rows(scene, "clear_below")[top] == (pytest.approx(free),)


@pytest.mark.parametrize(("boards", "free"), [((), 0.0), ((0.9,), 0.9), ((0.5, 1.4), 0.4)])
def test_a_board_seen_between_the_sides_shows_the_room_beneath_a_top(
    boards: tuple[float, ...], free: float
) -> None:
    # From above no underside is seen: but for the boards the sides could be those of a block.
    corners = [(0.0, 0.0), (0.8, 0.0), (0.8, 0.3), (0.0, 0.3)]
    points = [(x, y, z) for z in (0.0, 1.8) for x, y in corners]
    loops = [[4, 5, 6, 7], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    for z in boards:
        loops.append(list(range(len(points), len(points) + 4)))
        points += [(x, y, z) for x, y in corners]
    assert rows(polyhedron(points, loops), "clear_below")["f1",] == (pytest.approx(free),)


def test_portions_that_many_pairs_are_worked_on_in_do_not_show(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = together(table(), moved(cuboid(), translation=(2.0, 0.1, 0.0)), l_block())
    facts = scene_facts(scene)
    for module in (
        outline_overlap,
        measures,
        convex_hulls,
        plan_view,
        thing_gaps,
        nearest_points,
        contacts,
    ):
        for name in ("MOST_NUMBERS", "MOST_PRODUCTS", "PAIRS_AT_ONCE", "FEW_PAIRS"):
            if hasattr(module, name):
                monkeypatch.setattr(module, name, 1)
    assert_near(scene_facts(scene), facts)


def assert_near(found: tuple[Fact, ...], wanted: tuple[Fact, ...]) -> None:
    """Check that facts are equal but for rounding."""
    assert len(found) == len(wanted)
    for one, other in zip(found, wanted, strict=True):
        numbers = [x for x in other.args if isinstance(x, float)]
        assert [x for x in one.args if isinstance(x, float)] == pytest.approx(numbers, abs=1e-12)
        names = [x for x in other.args if not isinstance(x, float)]
        assert (one.functor, [x for x in one.args if not isinstance(x, float)]) == (
            other.functor,
            names,
        )


def test_an_empty_scene_has_only_its_name_and_scale() -> None:
    assert scene_facts(Scene("nothing")) == (
        Fact("scene", ("nothing",)),
        Fact("scale", ("unknown",)),
    )


def test_without_up_no_fact_speaks_of_heights() -> None:
    known = cuboid()
    scene = Scene("tilted", vertices=known.vertices, edges=known.edges, faces=known.faces)
    functors = {fact.functor for fact in scene_facts(scene)}
    assert not functors & {"up", "tilt", "upward", "elevation", "top_of", "clear_below", "overlap"}
    assert {"share", "angle", "convex"} <= functors


@pytest.mark.parametrize("seed", range(24))
def test_impossible_faces_still_give_finite_facts(seed: int) -> None:
    # Repeated, collinear and crossing corners, wrong planes, covariances from none to absurd.
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 12))
    points = rng.normal(size=(count, 3)) * 10.0 ** rng.integers(-3, 4)
    if seed % 4 == 1:
        points[:] = points[0]
    if seed % 4 == 2:
        points = np.outer(np.arange(count), points[0])
    if seed % 4 == 3:
        points[:, 2] = 0.0
    sd = (0.0, 1e-3, 1.0, 100.0)[seed // 4 % 4]

    def ring(most: int) -> tuple[int, ...]:
        return tuple(rng.permutation(count)[: int(rng.integers(3, most + 1))].tolist())

    def face() -> Face:
        normal = rng.normal(size=3) if seed % 4 != 3 else np.array([0.0, 0.0, 1.0])
        normal /= np.linalg.norm(normal)
        outline = ring(min(count, 6))
        root = sd * rng.normal(size=(4, 4))
        plane = Plane(normal, float(-normal @ points[outline[0]]), root @ root.T)
        return Face(outline, plane, (ring(3),) if rng.random() < 0.3 else ())

    scene = Scene(
        "impossible",
        vertices=tuple(Vertex(p, sd**2 * np.eye(3)) for p in points),
        edges=tuple(Edge(*rng.permutation(count)[:2].tolist()) for _ in range(4)),
        faces=tuple(face() for _ in range(5)),
        up=None if seed % 5 == 0 else np.array([0.0, 0.0, 1.0]),
    )
    facts = scene_facts(scene)
    assert [fault for fact in facts if (fault := check_fact(fact))] == []
    numbers = [a for fact in facts for a in fact.args if isinstance(a, float)]
    assert np.isfinite(numbers).all()
