"""Scores of scenes against true solids: exact scenes score perfectly, faults are counted."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.pictures.recognition import Shape, get_true_block, score
from facetlog.perception.scene import Edge, Face, Plane, Scene, Vertex
from facetlog.perception.types import FloatArray
from facetlog.robot.rendering.views import Similarity, draw_similarity
from facetlog.robot.rendering.worlds import make_world
from facetlog.robot.tour import tour_poses

SHAPE = get_true_block(make_world("block"))
CENTRES = np.array([pose.centre for pose in tour_poses()])
SD = 0.01


def scene_of(shape: Shape, centres: FloatArray = CENTRES, sd: float = SD) -> Scene:
    """The shape's seen faces as a scene, with vertices that are as unsure as `sd`."""
    faces = []
    for index in shape.seen_faces(centres):
        loop = shape.faces[index]
        normal = shape.normal(index)
        plane = Plane(normal, float(-normal @ shape.vertices[loop[0]]), 1e-6 * np.eye(4))
        faces.append(Face(loop, plane))
    return Scene(
        "block",
        vertices=tuple(Vertex(p, sd**2 * np.eye(3)) for p in shape.vertices),
        edges=tuple(Edge(a, b) for a, b in shape.edges),
        faces=tuple(faces),
    )


def test_an_exact_scene_has_everything_and_no_error() -> None:
    found = score(scene_of(SHAPE), SHAPE, CENTRES)
    assert found.rms == 0.0
    assert len(found.vertex_errors) == 8
    assert len(found.edge_errors) == 12
    assert max(map(abs, found.edge_errors)) < 1e-12
    assert len(found.angle_errors) == 8  # of the 10 pairs of 5 faces, two are parallel
    assert max(map(abs, found.angle_errors)) < 1e-9
    assert (found.extra_vertices, found.missing_faces, found.extra_faces) == (0, 0, 0)


@settings(max_examples=25)  # the time of an example depends on what else runs
@given(st.integers(0, 2**31), st.sampled_from([1e-3, 1.0, 1e3]))
def test_a_score_does_not_depend_on_frame_or_scale(seed: int, scale: float) -> None:
    frame: Similarity = draw_similarity(np.random.default_rng(seed), scale=scale, reach=scale)
    rng = np.random.default_rng(seed)
    off = replace(SHAPE, vertices=SHAPE.vertices + SD * rng.normal(size=SHAPE.vertices.shape))

    def there(points: FloatArray) -> FloatArray:
        return scale * points @ frame.rotation.T + frame.shift

    here = score(scene_of(off), SHAPE, CENTRES)
    moved = score(
        scene_of(replace(off, vertices=there(off.vertices)), there(CENTRES), scale * SD),
        replace(SHAPE, vertices=there(SHAPE.vertices)),
        there(CENTRES),
        unit=scale,
    )
    assert np.allclose(here.vertex_errors, moved.vertex_errors)
    assert np.allclose(here.vertex_nees, moved.vertex_nees)
    assert np.allclose(sorted(here.edge_errors), sorted(moved.edge_errors), atol=1e-9)


def test_a_corner_far_off_is_extra_and_takes_its_edges_and_faces_along() -> None:
    scene = scene_of(SHAPE)
    top = max(range(8), key=lambda i: SHAPE.vertices[i][2])
    moved = Vertex(SHAPE.vertices[top] + np.array([3.0, 0.0, 0.0]), SD**2 * np.eye(3))
    vertices = tuple(moved if i == top else v for i, v in enumerate(scene.vertices))
    found = score(replace(scene, vertices=vertices), SHAPE, CENTRES)
    assert found.extra_vertices == 1
    assert len(found.edge_errors) == 12 - 3
    assert (found.missing_faces, found.extra_faces) == (3, 3)
