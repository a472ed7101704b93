"""Things over a ground that views show: heights count from it, and what floats is carried."""

from dataclasses import replace

import numpy as np
import pytest

from facetlog.perception.scene import Body, Patch, Scene, Vertex
from facetlog.perception.surfaces.exact_solids.polyhedra import (
    cuboid,
    moved,
    polyhedron,
    table,
    together,
)
from tests.perception.facts.scene_values import faces_of_things, first_values, on_ground

SEAT = polyhedron([(0, 0, 0.4), (0.4, 0, 0.4), (0.4, 0.4, 0.4), (0, 0.4, 0.4)], [(0, 1, 2, 3)])
TOP = polyhedron([(0, 0, 0.7), (1, 0, 0.7), (1, 0.6, 0.7), (0, 0.6, 0.7)], [(0, 1, 2, 3)])


def leaf(low: float, high: float, width: float = 0.4, x: float = 0.0) -> Scene:
    """An upright rectangle across the x axis that looks along it."""
    corners = [(x, 0, low), (x, width, low), (x, width, high), (x, 0, high)]
    return polyhedron(corners, [(0, 1, 2, 3)])


@pytest.mark.parametrize("height", [0.0, -0.2, 0.3])
def test_heights_count_from_the_ground_that_was_seen(height: float) -> None:
    scene = on_ground(TOP, height)
    assert first_values(TOP, "elevation")["f1"] == 0.0
    assert first_values(scene, "elevation")["f1"] == pytest.approx(0.7 - height)
    assert first_values(scene, "top_of")["t1"] == pytest.approx(0.7 - height)
    assert first_values(scene, "clear_below")["f1"] == pytest.approx(0.7 - height)
    # all of its plan is taken by the top, and nothing is known to be beneath
    assert first_values(scene, "cover")["f1"] == 1.0


def test_heights_do_not_count_from_the_ground_where_another_thing_is_beneath() -> None:
    cup = moved(cuboid(0.1, 0.1, 0.1), translation=(0.5, 0.3, 0.8))
    scene = on_ground(together(table(), cup))
    assert first_values(scene, "top_of")["t2"] == pytest.approx(0.1)
    beside = on_ground(together(table(), moved(cup, translation=(2.0, 0.0, 0.0))))
    assert first_values(beside, "top_of")["t2"] == pytest.approx(0.9)


def test_a_back_that_ends_above_its_seat_is_one_thing_with_it() -> None:
    chair = together(SEAT, leaf(0.44, 0.9))
    assert faces_of_things(chair) == [(0,), (1,)]
    assert faces_of_things(on_ground(chair)) == [(0, 1)]
    # what is about as near to the ground may stand on something else
    assert faces_of_things(on_ground(chair, 0.35)) == [(0,), (1,)]


def test_what_ends_above_the_ground_by_noise_alone_stands_on_it() -> None:
    # Of two boxes that touch each is a thing: one that is turned is no part of the other.
    turn = np.deg2rad(30.0)
    c, s = np.cos(turn), np.sin(turn)
    block = cuboid(0.3, 0.2, 0.2)
    other = moved(block, [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], (0.4, -0.1, 0.0003))
    both = together(block, other)
    assert [len(own) for own in faces_of_things(on_ground(both))] == [6, 6]


def test_bodies_stay_apart_and_one_may_be_all_curved() -> None:
    around = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    normals = np.column_stack([np.cos(around), np.sin(around), np.zeros(60)])
    ring = 0.1 * normals + (0.5, 0.3, 0.8)
    hull = tuple(range(4, 64))
    vertices = (*TOP.vertices, *(Vertex(point, TOP.vertices[0].cov) for point in ring))
    scene = replace(
        TOP,
        vertices=vertices,
        patches=(Patch(ring, normals, np.full(60, 1e-3), hull),),
        bodies=(Body(faces=(0,)), Body(patches=(0,))),
    )
    scene = on_ground(scene)
    assert faces_of_things(scene) == [(0,), ()]
    chair = replace(together(SEAT, leaf(0.44, 0.9)), bodies=(Body(faces=(0,)), Body(faces=(1,))))
    assert faces_of_things(on_ground(chair)) == [(0,), (1,)]
    assert first_values(scene, "top_of")["t1"] == pytest.approx(0.7)
