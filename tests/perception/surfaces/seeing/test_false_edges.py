"""Edges in the air are no edges where views see the ground through them; a leg hides it. A solid's
own edge hides it to one side. None is seen beneath the ground.
"""

from dataclasses import replace

import numpy as np
import pytest

from facetlog.perception.scene import Edge, Scene, SeenLattice, Vertex
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
from facetlog.perception.surfaces.seeing.sights import GroundBeside, drop_false_edges
from facetlog.perception.types import FloatArray

PITCH = 0.01
ORIGINS = np.array([[1.0, 0.2, 1.5], [-1.0, 0.4, 1.2], [0.3, -1.0, 1.4]])
LEG = np.array([[0.1, 0.0, 0.7], [0.1, 0.0, 0.0]])
IN_THE_AIR = np.array([[-0.3, 0.3, 0.6], [0.2, 0.4, 0.6]])


def lattice(*hiding: FloatArray) -> SeenLattice:
    """The ground, of which each view sees all that is not right behind segments (2, 3)."""
    rows = columns = 600
    corner = np.array([-3.0, -3.0, 0.0])
    steps = PITCH * np.eye(3)[:2]
    shown = np.ones((len(ORIGINS), rows, columns), dtype=np.bool_)
    for origin, seen in zip(ORIGINS, shown, strict=True):
        share = np.linspace(0.0, 1.0, 500)[:, None]
        points = np.concatenate([a + share * (b - a) for a, b in hiding])
        met = origin + (points - origin) * (origin[2] / (origin[2] - points[:, 2]))[:, None]
        row, column = np.rint((met - corner)[:, :2] / PITCH).astype(int).T
        for wide in range(-3, 4):
            seen[row + wide, column] = seen[row, column + wide] = False
    return SeenLattice(corner, steps, ORIGINS, shown, (0, 1, 2))


def test_the_ground_shows_through_what_is_not_there_and_beside_what_is() -> None:
    both = np.array([LEG, IN_THE_AIR])
    assert GroundBeside.of(both, [lattice(LEG)]).through.tolist() == [False, True]
    assert GroundBeside.of(both, [lattice(IN_THE_AIR)]).through.tolist() == [True, False]


def test_of_a_bar_the_ground_shows_on_both_sides_of_a_solid_s_edge_on_one() -> None:
    leg = LEG[None]
    assert not GroundBeside.of(leg, [lattice(LEG)]).of_solids.any()
    # a wall that goes on from it, of which only this edge was found
    wall = [LEG + np.array([-0.02 * n, 0.02 * n, 0.0]) for n in range(20)]
    assert GroundBeside.of(leg, [lattice(*wall)]).of_solids.all()
    # what does not stand on the ground may hang before something
    hanging = leg + np.array([0.0, 0.0, 0.3])
    assert not GroundBeside.of(hanging, [lattice(*wall)]).of_solids.any()
    lying = np.array([[LEG[1], wall[-1][1]]])
    assert not GroundBeside.of(lying, [lattice(*wall)]).of_solids.any()


def test_a_scene_loses_loose_edges_with_their_vertices_and_no_sides() -> None:
    block = cuboid(0.2, 0.2, 0.4)
    count = len(block.vertices)
    vertices = tuple(Vertex(p, 1e-6 * np.eye(3)) for p in np.concatenate([LEG, IN_THE_AIR]))
    scene: Scene = replace(
        block,
        views=("a", "b", "c"),
        vertices=(*block.vertices, *vertices),
        edges=(*block.edges, Edge(count + 2, count + 3), Edge(count, count + 1)),
        lattices=(lattice(LEG),),
    )
    found = drop_false_edges(scene)
    assert len(found.vertices) == count + 2
    assert found.edges[:-1] == block.edges
    np.testing.assert_allclose(found.points[[found.edges[-1].start, found.edges[-1].end]], LEG)


@pytest.mark.parametrize(
    ("high", "aside", "sd", "kept"),
    [
        (-0.05, 0.0, 1e-3, False),
        (-0.05, 0.0, 0.02, True),  # it may lie on the ground
        (-0.5 * PITCH, 0.0, 1e-4, True),
        (-0.05, 4.0, 1e-3, True),  # the ground ends before, as a table's top
    ],
)
@pytest.mark.slow
def test_no_edge_is_seen_beneath_ground_that_shows_all_round(
    high: float, aside: float, sd: float, kept: bool
) -> None:
    ends = np.array([[aside, 0.0, high], [aside, 0.2, high]])
    block = cuboid(0.2, 0.2, 0.4)
    count = len(block.vertices)
    scene = replace(
        block,
        views=("a", "b", "c"),
        vertices=(*block.vertices, *(Vertex(p, sd**2 * np.eye(3)) for p in ends)),
        edges=(*block.edges, Edge(count, count + 1)),
        lattices=(lattice(LEG),),
    )
    assert len(drop_false_edges(scene).edges) == len(block.edges) + kept
