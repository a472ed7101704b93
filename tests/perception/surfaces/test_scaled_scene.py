"""All that a scene has is scaled with its lengths."""

from dataclasses import replace

import numpy as np
import pytest

from facetlog.perception.scene import Patch, Scene, SeenLattice, SightLines
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
from facetlog.perception.surfaces.scaled_scene import in_metres
from facetlog.perception.surfaces.scene_file import encode_scene
from facetlog.perception.types import Camera, Pose


def _scene() -> Scene:
    block = cuboid(3.0, 2.0, 1.0)
    vertices = tuple(replace(v, cov=np.diag([1e-4, 4e-4, 9e-4])) for v in block.vertices)
    planes = [replace(face.plane, cov=np.diag([1e-6, 1e-6, 0.0, 1e-4])) for face in block.faces]
    faces = tuple(
        replace(face, plane=plane) for face, plane in zip(block.faces, planes, strict=True)
    )
    return replace(
        block,
        metric=False,
        vertices=vertices,
        faces=faces,
        views=("a.png",),
        cameras=(Camera(64, 48, 50.0, 50.0, 31.5, 23.5),),
        poses=(Pose(np.eye(3), np.array([1.0, 2.0, -8.0])),),
        patches=(Patch(np.ones((2, 3)), np.tile([0.0, 0.0, 1.0], (2, 1)), np.array([0.5, 0.25])),),
        sights=(SightLines(np.array([1.0, 2.0, -8.0]), np.ones((4, 3)), 0),),
        lattices=(
            SeenLattice(
                *(np.zeros(3), np.eye(3)[:2], np.array([[1.0, 2.0, -8.0]])),
                *(np.ones((1, 2, 2), dtype=np.bool_), (0,)),
            ),
        ),
    )


def test_all_lengths_are_scaled_and_areas_twice() -> None:
    scene, scaled = _scene(), in_metres(_scene(), 0.5)
    assert scaled.metric
    np.testing.assert_array_equal(scaled.points, scene.points / 2)
    np.testing.assert_array_equal(scaled.vertices[0].cov, scene.vertices[0].cov / 4)
    plane = scaled.faces[0].plane
    assert plane.offset == scene.faces[0].plane.offset / 2
    np.testing.assert_array_equal(plane.cov, np.diag([1e-6, 1e-6, 0.0, 1e-4 / 4]))
    np.testing.assert_array_equal(scaled.patches[0].points, np.full((2, 3), 0.5))
    np.testing.assert_array_equal(scaled.patches[0].areas, [0.125, 0.0625])
    camera = np.array([0.5, 1.0, -4.0])
    np.testing.assert_array_equal(scaled.poses[0].centre, camera)
    np.testing.assert_array_equal(scaled.sights[0].origin, camera)
    np.testing.assert_array_equal(scaled.sights[0].ends, np.full((4, 3), 0.5))
    np.testing.assert_array_equal(scaled.lattices[0].origins[0], camera)
    np.testing.assert_array_equal(scaled.lattices[0].steps, np.eye(3)[:2] / 2)


def test_there_and_back_is_the_same_scene() -> None:
    scene = _scene()
    back = replace(in_metres(in_metres(scene, 0.25), 4.0), metric=False)
    assert encode_scene(back) == encode_scene(scene)


def test_an_unsure_scale_is_stated_beside_what_was_measured() -> None:
    scene = _scene()
    scaled = in_metres(scene, 1.0, 0.03)
    assert in_metres(scaled, 1.0, 0.04).scale_sd == pytest.approx(0.05)
    for before, after in zip(scene.vertices, scaled.vertices, strict=True):
        np.testing.assert_array_equal(after.cov, before.cov)
