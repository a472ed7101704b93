"""Things are cut from what they stand on, and keep what is part of them."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.scene import Edge, Scene, Vertex
from facetlog.perception.surfaces.exact_solids.polyhedra import (
    chair,
    cuboid,
    l_block,
    moved,
    polyhedron,
    room_corner,
    seen_from,
    stick_table,
    table,
    together,
)

EYE = (4.0, -3.0, 3.0)


def floor(size: float = 4.0, height: float = 0.0) -> Scene:
    half = size / 2
    points = [(-half, -half, height), (half, -half, height), (half, half, height)]
    return polyhedron([*points, (-half, half, height)], [(0, 1, 2, 3)], name="floor")


def without_up(scene: Scene) -> Scene:
    return replace(scene, up=None)


def sizes(scene: Scene) -> list[int]:
    """Return how many parts each of the scene's things has, ascending."""
    of = Counter(fact.args[1] for fact in scene_facts(scene) if fact.functor == "part_of")
    return sorted(of.values())


@pytest.mark.parametrize("known_up", [True, False])
@pytest.mark.parametrize(
    ("solid", "parts"),
    [
        (cuboid(), 6),
        (l_block(), 8),
        (table(), 26),
        (chair(), 31),
        (stick_table(), 9),
        (seen_from(cuboid(), EYE), 3),
    ],
)
def test_a_solid_is_one_thing_without_the_floor_that_it_stands_on(
    solid: Scene, parts: int, known_up: bool
) -> None:
    for scene, found in ((solid, [parts]), (together(solid, floor()), [1, parts])):
        assert sizes(scene if known_up else without_up(scene)) == found


def test_a_floor_cut_out_round_a_block_is_cut_all_the_same() -> None:
    # The floor's hole is the block's base, vertex by vertex, as a mesh of the scene would have it.
    both = together(seen_from(cuboid(), EYE), floor())
    *sides, ground = both.faces
    assert sizes(replace(both, faces=(*sides, replace(ground, holes=((0, 2, 3, 1),))))) == [1, 3]


def test_what_stands_on_or_at_another_thing_is_a_thing_of_its_own() -> None:
    beside = moved(cuboid(), translation=(0.6, 0.0, 0.0))
    wall = polyhedron([(-2, 0, 0), (2, 0, 0), (2, 0, 3), (-2, 0, 3)], [(3, 2, 1, 0)])
    on_top = moved(cuboid(), translation=(0.4, 0.3, 0.74))
    assert sizes(together(cuboid(), beside, floor())) == [1, 6, 6]
    assert sizes(together(cuboid(), beside, wall)) == [1, 6, 6]
    assert sizes(together(table(), on_top)) == [6, 26]
    assert sizes(together(room_corner(), cuboid())) == [3, 6]


def test_what_is_put_beside_a_block_any_way_round_is_a_thing_of_its_own() -> None:
    # Its corner touches the other's side; what is square to that is built on.
    block = cuboid()
    for degrees, found in ((30.0, [6, 6]), (0.0, [12])):
        turn = np.deg2rad(degrees)
        c, s = np.cos(turn), np.sin(turn)
        rotation = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]
        width = float(max(v.point[0] for v in block.vertices))
        corners = np.array([v.point for v in block.vertices]) @ np.array(rotation).T
        shift = (width - float(corners[:, 0].min()), -0.1, 0.0)
        both = together(block, moved(block, rotation, shift))
        assert sizes(both) == found
        assert sizes(without_up(both)) == [12]


def test_a_sheet_with_legs_below_is_a_table_even_on_a_floor() -> None:
    top = floor(1.0, 0.7)
    legs = [
        seen_from(moved(cuboid(0.05, 0.05, 0.7), translation=(x, y, 0.0)), (5, 4, 1), (-5, -4, 0.5))
        for x in (-0.45, 0.4)
        for y in (-0.45, 0.4)
    ]
    legs = [Scene("leg", (), s.vertices, s.edges, s.faces[1:], s.up) for s in legs]
    faces = 1 + sum(len(s.faces) for s in legs)
    assert sizes(together(top, *legs)) == [faces]
    assert sizes(together(top, *legs, floor())) == [1, faces]


def test_sheets_that_share_a_side_and_labels_belong_together() -> None:
    points = [(0, 0, 0), (0.4, 0, 0), (0.4, 0.4, 0), (0, 0.4, 0), (0.4, 0.4, 0.5), (0, 0.4, 0.5)]
    assert sizes(polyhedron(points, [(0, 1, 2, 3), (3, 2, 4, 5)])) == [2]
    corners = [(0.05, 0, 0.05), (0.1, 0, 0.05), (0.1, 0, 0.1), (0.05, 0, 0.1)]
    assert sizes(together(cuboid(), polyhedron(corners, [(0, 1, 2, 3)]))) == [7]


def with_back_of_bars(sat_on: Scene, foot: tuple[float, float, float]) -> Scene:
    """The scene with loose edges: two posts of .4 m, from a foot on along x, and a rail on them."""
    x, y, z = foot
    posts = [(x, y, z), (x, y, z + 0.4), (x + 0.4, y, z), (x + 0.4, y, z + 0.4)]
    rail = [(x + 0.01, y, z + 0.38), (x + 0.39, y, z + 0.38)]
    added = tuple(Vertex(np.array(p), 1e-6 * np.eye(3)) for p in (*posts, *rail))
    n = len(sat_on.vertices)
    bars = tuple(Edge(n + i, n + i + 1) for i in (0, 2, 4))
    return replace(sat_on, vertices=(*sat_on.vertices, *added), edges=(*sat_on.edges, *bars))


def test_a_back_of_bars_rises_from_the_rim_of_its_seat() -> None:
    seat = floor(0.5, 0.5)
    on_rim = with_back_of_bars(seat, (-0.2, 0.23, 0.51))
    assert sizes(on_rim) == [4]
    assert sizes(without_up(on_rim)) == [1]
    assert sizes(with_back_of_bars(seat, (-0.2, 0.23, 0.8))) == [1]  # in the air
    assert sizes(with_back_of_bars(floor(1.0, 0.5), (-0.2, 0.0, 0.51))) == [1]  # not at the rim
    assert sizes(with_back_of_bars(cuboid(), (3.0, 0.0, 0.0))) == [6]  # reaches no face


def pictured_table(gap: float) -> Scene:
    """A top seen from above, and one end that begins so far below it, as pictures show them."""
    top = [(-0.7, -0.3, 0.72), (0.7, -0.3, 0.72), (0.7, 0.3, 0.72), (-0.7, 0.3, 0.72)]
    high = 0.72 - gap
    end = [(0.65, -0.25, 0.0), (0.65, 0.25, 0.0), (0.65, 0.25, high), (0.65, -0.25, high)]
    scene = polyhedron([*top, *end], [(0, 1, 2, 3), (4, 5, 6, 7)])
    return replace(scene, views=("view1", "view2"))


@pytest.mark.parametrize(("gap", "parts"), [(0.03, [2]), (0.1, [2]), (0.3, [1, 1])])
def test_what_begins_a_boards_thickness_below_a_top_is_part_of_it(
    gap: float, parts: list[int]
) -> None:
    assert sizes(pictured_table(gap)) == parts


def test_a_leg_that_touches_its_seat_at_a_corner_is_part_of_it() -> None:
    seat = [(0.0, 0.0, 0.4), (0.4, 0.0, 0.4), (0.4, 0.4, 0.4), (0.0, 0.4, 0.4)]
    inner = [(0.0, 0.0, 0.0), (0.06, 0.0, 0.0), (0.06, 0.0, 0.3)]
    scene = polyhedron([*seat, *inner], [(0, 1, 2, 3), (0, 6, 5, 4)])
    assert scene.faces[1].plane.normal[1] > 0.9  # the seat lies before it
    assert sizes(replace(scene, views=("view1", "view2"))) == [2]
