"""Faults of scenes that the schema cannot say: each at its place; sound scenes have none."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.perception.scene import Body, Face, Patch, Plane, Scene, Vertex
from facetlog.perception.surfaces.exact_solids.builders import BUILDERS, build
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid, moved
from facetlog.perception.surfaces.scene_json.scene_checks import find_scene_faults

CUBE = cuboid(0.3, 0.2, 0.1)


def _said(scene: Scene) -> list[str]:
    return [str(fault) for fault in find_scene_faults(scene)]


def _with_vertex(index: int, vertex: Vertex) -> Scene:
    return replace(CUBE, vertices=(*CUBE.vertices[:index], vertex, *CUBE.vertices[index + 1 :]))


@pytest.mark.parametrize("name", BUILDERS)
def test_what_builders_make_is_sound(name: str) -> None:
    assert _said(build(name, {})) == []


@settings(max_examples=30)
@given(
    st.floats(1e-3, 1e6),
    st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3),
    st.integers(0, 2**32 - 1),
)
def test_soundness_does_not_depend_on_unit_place_or_direction(
    unit: float, shift: list[float], seed: int
) -> None:
    rotation, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    rotation *= np.sign(np.linalg.det(rotation))
    scene = moved(CUBE, rotation, shift)
    vertices = tuple(Vertex(v.point * unit, v.cov * unit**2) for v in scene.vertices)
    levers = np.diag([1.0, 1.0, 1.0, unit])
    faces = tuple(
        replace(
            f, plane=Plane(f.plane.normal, f.plane.offset * unit, levers @ f.plane.cov @ levers)
        )
        for f in scene.faces
    )
    scene = replace(scene, vertices=vertices, faces=faces)
    assert _said(scene) == []
    pushed = vertices[0].point + 0.2 * unit * faces[0].plane.normal
    moved_one = replace(scene, vertices=(Vertex(pushed, vertices[0].cov), *vertices[1:]))
    assert any("off the face's plane" in said for said in _said(moved_one))


def test_vertices_without_use_are_told_in_one_line() -> None:
    scene = replace(CUBE, vertices=(*CUBE.vertices, *CUBE.vertices))
    assert _said(scene) == [
        "$.vertices: no edge, face or patch uses 8 of 16 (8, 9, 10, 11, 12, …): remove them"
    ]
    reached = Patch(np.zeros((1, 3)), np.zeros((1, 3)), np.ones(1), hull=tuple(range(8, 16)))
    assert _said(replace(scene, patches=(reached,), bodies=(Body(patches=(0,)),))) == []


def _flat(*corners: tuple[float, float]) -> Scene:
    points = [(x, y, 0.0) for x, y in corners]
    plane = Plane(np.array([0.0, 0.0, 1.0]), 0.0, 1e-6 * np.eye(4))
    vertices = tuple(Vertex(np.array(p), 1e-6 * np.eye(3)) for p in points)
    return Scene("flat", vertices=vertices, faces=(Face(tuple(range(len(points))), plane),))


@pytest.mark.parametrize(
    ("scene", "said"),
    [
        (_flat((0, 0), (3, 0), (3, 1), (1, -1), (0, 2)), "crosses itself: give its vertices in "),
        (_flat((0, 0), (1, 1), (1, 0), (0, 1)), "crosses itself and has no area"),
        (_flat((0, 0), (0, 1), (1, 1), (1, 0)), "runs clockwise seen from outside: reverse it"),
        (_flat((0, 0), (1, 1), (2, 2)), "has no area"),
    ],
)
def test_a_wrong_outline_is_told(scene: Scene, said: str) -> None:
    (fault,) = _said(scene)
    assert fault.startswith(f"$.faces[0].outline: {said}")


def test_an_outline_that_only_touches_itself_is_sound() -> None:
    two_squares = ((0, 0), (1, 0), (1, 1), (2, 1), (2, 2), (1, 2), (1, 1), (0, 1))
    assert _said(_flat(*two_squares)) == []
    touching_side = ((0, 0), (4, 0), (4, 4), (2, 0), (0, 4))
    assert _said(_flat(*touching_side)) == []


def test_a_hole_outside_its_outline_is_told() -> None:
    corners = CUBE.points[list(CUBE.faces[0].outline)]
    beyond = corners + 2.0 * (corners[2] - corners[0])
    start = len(CUBE.vertices)
    vertices = (*CUBE.vertices, *(Vertex(p, 1e-6 * np.eye(3)) for p in beyond))
    face = replace(CUBE.faces[0], holes=((start, start + 3, start + 2, start + 1),))
    scene = replace(CUBE, vertices=vertices, faces=(face, *CUBE.faces[1:]))
    assert _said(scene) == ["$.faces[0].holes: lie outside the outline, or cross it or each other"]


def test_a_vertex_off_a_plane_is_told_only_beyond_its_noise() -> None:
    face = CUBE.faces[0]
    index = face.outline[2]
    extent = np.linalg.norm(np.ptp(CUBE.points[list(face.outline)], axis=0))
    off = CUBE.vertices[index].point + 0.3 * extent * face.plane.normal
    said = _said(_with_vertex(index, Vertex(off, 1e-6 * np.eye(3))))
    # The vertex stays in the other two planes, which hold this normal.
    assert said == [
        f"$.faces[0].outline[2]: vertex {index} is {0.3 * extent:.3g} off the face's plane, "
        f"where the face is {np.hypot(extent, 0.3 * extent):.3g} wide"
    ]
    assert _said(_with_vertex(index, Vertex(off, 1e-2 * np.eye(3)))) == []


def _star(points: int, step: int) -> tuple[tuple[float, float], ...]:
    angles = 2.0 * np.pi * step * np.arange(points) / points
    return tuple((float(np.cos(a)), float(np.sin(a))) for a in angles)


def test_a_loop_that_turns_left_everywhere_and_goes_round_twice_is_told() -> None:
    assert _said(_flat(*_star(5, 1))) == []
    (said,) = _said(_flat(*_star(5, 2)))
    assert said.startswith("$.faces[0].outline: crosses itself")


def test_holes_that_touch_and_slivers_that_cross_are_sound() -> None:
    scene = _flat((0, 0), (4, 0), (4, 4), (0, 4), (1, -1e-4), (3, 1), (3, 3), (1, 3))
    face = replace(scene.faces[0], outline=(0, 1, 2, 3), holes=((4, 7, 6, 5),))
    assert _said(replace(scene, faces=(face,))) == []
