"""Flat regions as a scene: shared corners, objects, and what is too much."""

import numpy as np
import pytest

from facetlog.perception.scene import Scene
from facetlog.perception.shapes.regions.flat_region import FlatRegion, Rest
from facetlog.perception.shapes.regions.scene_from_regions import MOST_FACES, assemble_scene
from facetlog.perception.surfaces.exact_solids.polyhedra import fit_plane_through_loop

NOTHING = Rest(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0))


def square(x: float, y: float, side: float = 1.0, *, body: int = 0, sd: float = 0.0) -> FlatRegion:
    corners = [(x, y, 0.0), (x + side, y, 0.0), (x + side, y + side, 0.0), (x, y + side, 0.0)]
    return FlatRegion(
        fit_plane_through_loop(corners, max(sd, 1e-6)), np.array(corners), (), sd, body
    )


def assembled(*regions: FlatRegion, rest: Rest = NOTHING) -> Scene:
    return assemble_scene("s", regions, rest, up=(0, 0, 2), metric=True, whole=True)


def test_corners_within_three_sd_are_one_vertex_and_others_are_not() -> None:
    near = assembled(square(0, 0, sd=0.01), square(1.03, 0.0, sd=0.01))
    assert (len(near.vertices), len(near.edges)) == (6, 7)
    assert near.up is not None
    assert near.up.tolist() == [0.0, 0.0, 1.0]
    far = assembled(square(0, 0, sd=0.01), square(1.06, 0.0, sd=0.01))
    assert (len(far.vertices), len(far.edges)) == (8, 8)


def test_the_surer_of_two_corners_counts_for_more() -> None:
    scene = assembled(square(0, 0, sd=0.001), square(1.02, 0.0, sd=0.01))
    shared = next(v for v in scene.vertices if 0.9 < v.point[0] < 1.1)
    assert shared.point[0] == pytest.approx(1.0 + 0.02 / 101)
    assert shared.cov[0, 0] > 0.001**2


def test_objects_keep_their_own_corners_and_a_floor_is_of_none() -> None:
    floor = square(-3, -3, 8, body=-1)
    scene = assembled(square(0, 0), square(1, 0, body=1), floor)
    assert len(scene.vertices) == 12
    assert [body.faces for body in scene.bodies] == [(1,), (2,)]
    assert scene.faces[0].outline == (0, 1, 2, 3)


def test_more_faces_than_are_kept_become_a_patch_with_a_warning() -> None:
    count = MOST_FACES + 6
    regions = [square(2 * (i % 18), 2 * (i // 18), 1 + i / 1000) for i in range(count)]
    scene = assembled(*regions)
    assert len(scene.bodies[0].faces) == MOST_FACES
    assert scene.bodies[0].patches == (0,)
    lost = sum((1 + i / 1000) ** 2 for i in range(6))
    assert scene.patches[0].areas.sum() == pytest.approx(lost)
    assert f"the rest (6 of {count}, " in scene.warnings[0]


def test_the_rest_is_a_patch_of_its_object() -> None:
    points = np.array([[0.0, 0, 1], [0, 0, 2], [0, 0, 3]])
    rest = Rest(points, np.zeros((3, 3)), np.ones(3), np.array([0.0, 1.0, 0.0]))
    scene = assembled(square(0, 0), rest=rest)
    assert [len(patch.points) for patch in scene.patches] == [2, 1]
    assert [(body.faces, body.patches) for body in scene.bodies] == [((0,), (0,)), ((), (1,))]
