"""Numbers that no facts can be made of are refused where a scene is read, each at its place."""

from dataclasses import replace

import numpy as np
import pytest

from facetlog.perception.scene import Plane, Scene, Vertex
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
from facetlog.perception.surfaces.scene_file import SceneFileError, scene_from_json, scene_to_json
from facetlog.perception.surfaces.scene_numbers import number_faults
from facetlog.perception.types import Observation

CUBE = cuboid(0.3, 0.2, 0.1)
SURE = 1e-6 * np.eye(3)


def _with_vertex(vertex: Vertex, *, count: int = 1) -> Scene:
    """The cube with some vertices from the third on in its place."""
    return replace(CUBE, vertices=(*CUBE.vertices[:3], *[vertex] * count, *CUBE.vertices[4:]))


def _said(scene: Scene) -> list[str]:
    return [str(fault) for fault in number_faults(scene)]


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
        (np.diag([1e-6, 1e101, 1e-6]), [1, 2], "has a variance beyond 1e+100: give another unit"),
    ],
)
def test_a_matrix_that_is_no_covariance_is_told_at_its_place(
    cov: np.ndarray, axes: list[int], said: str
) -> None:
    (fault,) = number_faults(_with_vertex(Vertex(CUBE.vertices[3].point, cov)))
    assert fault.path == "$.vertices[3].cov"
    assert fault.message.startswith(said)
    seen = Observation(0, np.zeros(2), cov[np.ix_(axes, axes)])
    point = Vertex(CUBE.vertices[3].point, SURE, (Observation(0, np.zeros(2), np.eye(2)), seen))
    (fault,) = number_faults(replace(_with_vertex(point), views=("a.png",)))
    assert fault.path == "$.vertices[3].observations[1].cov"
    assert fault.message.startswith(said)


def test_rounding_makes_no_fault() -> None:
    assert _said(_with_vertex(Vertex(CUBE.vertices[3].point, _skew(1e-13)))) == []
    assert _said(_with_vertex(Vertex(CUBE.vertices[3].point, np.diag([1e-6, 1e-6, -1e-13])))) == []
    assert _said(CUBE) == []


def test_a_plane_is_told_too() -> None:
    plane = CUBE.faces[0].plane
    for changed, path in (
        (Plane(plane.normal, plane.offset, -np.eye(4)), "$.faces[0].plane.cov"),
        (Plane(plane.normal, 1e51, plane.cov), "$.faces[0].plane.offset"),
    ):
        scene = replace(CUBE, faces=(replace(CUBE.faces[0], plane=changed), *CUBE.faces[1:]))
        assert [fault.path for fault in number_faults(scene)] == [path]


@pytest.mark.parametrize(("scale", "place"), [(1e52, "$.vertices[1].point"), (1e-60, "$.vertices")])
def test_lengths_whose_volumes_no_float_holds_are_told(scale: float, place: str) -> None:
    vertices = tuple(Vertex(v.point * scale, v.cov) for v in CUBE.vertices)
    fault, *_ = number_faults(replace(CUBE, vertices=vertices))
    assert fault.path == place
    assert fault.message.endswith("give another unit")


def test_a_file_with_such_numbers_is_refused_with_all_of_them() -> None:
    scene = _with_vertex(Vertex(CUBE.vertices[3].point, -SURE), count=2)
    with pytest.raises(SceneFileError, match=r"^cube: \$\.vertices\[3\]\.cov: .*\(and 1 more\)$"):
        scene_from_json(scene_to_json(scene), "cube")
