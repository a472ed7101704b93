"""Numbers that no facts can be made of are refused where a scene is read, each at its place."""

from dataclasses import replace

import numpy as np
import pytest

from facetlog.perception.scene import (
    Body,
    Patch,
    Plane,
    Scene,
    SeenLattice,
    SightLines,
    Vertex,
)
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
from facetlog.perception.surfaces.scene_json.scene_checks import LARGEST, LEAST, iter_number_faults
from facetlog.perception.types import Camera, Observation, Pose

CUBE = cuboid(0.3, 0.2, 0.1)
SURE = 1e-6 * np.eye(3)


def _with_vertex(vertex: Vertex, *, count: int = 1) -> Scene:
    """The cube with some vertices from the third on in its place."""
    return replace(CUBE, vertices=(*CUBE.vertices[:3], *[vertex] * count, *CUBE.vertices[4:]))


def _said(scene: Scene) -> list[str]:
    return [str(fault) for fault in iter_number_faults(scene)]


def _skew(off: float) -> np.ndarray:
    cov = SURE.copy()
    cov[0, 1] = off
    return cov


@pytest.mark.parametrize(
    ("cov", "axes", "said"),
    [
        (_skew(1e-7), [0, 1], "is not symmetric: it is no covariance"),
        (
            np.diag([1e-6, 1e-6, -1e-8]),
            [1, 2],
            "has the negative variance -1e-08 one way: it is no cov",
        ),
        (np.diag([1e-6, 1e41, 1e-6]), [1, 2], "has a variance beyond 1e+40: give another unit"),
    ],
)
def test_a_matrix_that_is_no_covariance_is_told_at_its_place(
    cov: np.ndarray, axes: list[int], said: str
) -> None:
    (fault,) = iter_number_faults(_with_vertex(Vertex(CUBE.vertices[3].point, cov)))
    assert fault.path == "$.vertices[3].cov"
    assert fault.message.startswith(said)
    seen = Observation(0, np.zeros(2), cov[np.ix_(axes, axes)])
    point = Vertex(CUBE.vertices[3].point, SURE, (Observation(0, np.zeros(2), np.eye(2)), seen))
    (fault,) = iter_number_faults(replace(_with_vertex(point), views=("a.png",)))
    assert fault.path == "$.vertices[3].observations[1].cov"
    assert fault.message.startswith(said)


def test_rounding_is_no_fault_and_planes_are_checked_too() -> None:
    for cov in (_skew(1e-13), np.diag([1e-6, 1e-6, -1e-13])):
        assert _said(_with_vertex(Vertex(CUBE.vertices[3].point, cov))) == []
    plane = CUBE.faces[0].plane
    for changed, path in (
        (Plane(plane.normal, plane.offset, -np.eye(4)), "$.faces[0].plane.cov"),
        (Plane(plane.normal, 1e51, plane.cov), "$.faces[0].plane.offset"),
    ):
        scene = replace(CUBE, faces=(replace(CUBE.faces[0], plane=changed), *CUBE.faces[1:]))
        assert [fault.path for fault in iter_number_faults(scene)] == [path]


@pytest.mark.parametrize("length", [0.0, 2.0, 1e300])
def test_up_and_normals_of_patches_are_unit_vectors(length: float) -> None:
    far = np.array([0.0, 0.0, length])
    assert _said(replace(CUBE, up=far)) == [
        f"$.up: is {length:.6g} long: give a unit vector, or null"
    ]
    patch = Patch(np.zeros((2, 3)), np.array([[0.0, 0.0, 1.0], far]), np.ones(2))
    found = _said(replace(CUBE, patches=(patch,), bodies=(Body(patches=(0,)),)))
    assert [line.split(":")[0] for line in found] == ["$.patches[0].normals[1]"] * (length > 0)


@pytest.mark.parametrize(("scale", "place"), [(1e52, "$.vertices[1].point"), (1e-60, "$.vertices")])
def test_lengths_whose_volumes_no_float_holds_are_told(scale: float, place: str) -> None:
    vertices = tuple(Vertex(v.point * scale, v.cov) for v in CUBE.vertices)
    fault, *_ = iter_number_faults(replace(CUBE, vertices=vertices))
    assert fault.path == place
    assert fault.message.endswith("give another unit")


def test_what_is_far_off_is_told_wherever_it_stands() -> None:
    beyond = 10.0 * LARGEST
    far = np.array([0.0, beyond, 0.0])
    seen = Vertex(CUBE.vertices[3].point, SURE, (Observation(0, far[:2], np.eye(2)),))
    scene = replace(
        _with_vertex(seen),
        views=("a.png",),
        patches=(Patch(far[None], np.zeros((1, 3)), np.full(1, beyond**2)),),
        sights=(SightLines(far, far[None]),),
        lattices=(SeenLattice(far, np.full((2, 3), LARGEST), far[None], np.ones((1, 2, 2)), (0,)),),
        cameras=(Camera(640, 480, beyond, 500.0, 320.0, beyond),),
        poses=(Pose(np.eye(3), far),),
    )
    assert [fault.path for fault in iter_number_faults(scene)] == [
        "$.vertices[3].observations[0].uv",
        "$.patches[0].points[0]",
        "$.patches[0].areas[0]",
        "$.sights[0].origin",
        "$.sights[0].ends",
        "$.lattices[0].corner",
        "$.lattices[0].steps",
        "$.lattices[0].origins",
        "$.cameras[0].centre",
        "$.cameras[0].focal",
        "$.cameras[0].middle",
    ]
    near = Camera(640, 480, LEAST / 10.0, 500.0, 320.0, 240.0)
    posed = replace(CUBE, views=("a.png",), cameras=(near,), poses=(Pose(np.eye(3), np.zeros(3)),))
    assert [fault.path for fault in iter_number_faults(posed)] == ["$.cameras[0].focal"]
