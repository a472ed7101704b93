"""Meshes out: what another program loads has the faces' areas, colours and names."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from facetlog.errors import InputError
from facetlog.perception.scene import Face, Scene, Vertex
from facetlog.perception.surfaces.exact_solids.polyhedra import (
    cuboid,
    fit_plane_through_loop,
    l_block,
    pyramid,
)
from facetlog.perception.surfaces.face_table import flat_faces
from facetlog.perception.surfaces.mesh_export import triangulate_face, write_mesh


def with_hole() -> Scene:
    outer = [(0, 0, 1), (4, 0, 1), (4, 4, 1), (0, 4, 1)]
    inner = [(1, 1, 1), (1, 2, 1), (2, 2, 1), (2, 1, 1)]
    return Scene(
        "plate",
        vertices=tuple(Vertex(np.array(p), 1e-6 * np.eye(3)) for p in (*outer, *inner)),
        faces=(Face((0, 1, 2, 3), fit_plane_through_loop(outer, 1e-3), holes=((4, 5, 6, 7),)),),
    )


@pytest.mark.parametrize("build", [cuboid, l_block, pyramid, with_hole])
def test_triangles_fill_each_face_and_look_outwards(build: object) -> None:
    scene: Scene = build()  # type: ignore[operator]
    for face in flat_faces(scene):
        triangles = triangulate_face(face, scene.points)
        crosses = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        assert 0.5 * np.linalg.norm(crosses, axis=1).sum() == pytest.approx(face.area)
        assert (crosses @ face.normal > 0).all()
        corners = {tuple(p) for p in triangles.reshape(-1, 3).tolist()}
        assert corners == {tuple(scene.points[i].tolist()) for i in face.members}


def test_a_ply_loads_as_a_closed_solid_with_colours(tmp_path: Path) -> None:
    scene = l_block()
    write_mesh(scene, tmp_path / "scene.ply")
    mesh = trimesh.load_mesh(tmp_path / "scene.ply")
    assert mesh.is_watertight
    assert mesh.volume > 0
    assert mesh.area == pytest.approx(sum(f.area for f in flat_faces(scene)), rel=1e-5)
    assert len(np.unique(mesh.visual.face_colors, axis=0)) == len(scene.faces)


@pytest.mark.parametrize(
    ("suffix", "up"),
    [(".gltf", (0, 0, 1)), (".glb", (0, -1, 0)), (".glb", (0.6, 0, -0.8)), (".glb", None)],
)
def test_a_gltf_has_a_node_per_face_and_the_formats_up(
    suffix: str, up: tuple[float, float, float] | None, tmp_path: Path
) -> None:
    scene = replace(cuboid(0.3, 0.2, 0.1), up=None if up is None else np.array(up))
    write_mesh(scene, tmp_path / f"scene{suffix}")
    graph = trimesh.load_scene(tmp_path / f"scene{suffix}")
    for face in flat_faces(scene):
        _, name = graph.graph[f"f{face.index + 1}"]
        assert graph.geometry[name].area == pytest.approx(face.area, rel=1e-5)
    mesh = graph.to_mesh()
    along = (0.0, 1.0, 0.0)
    expected = np.ptp(scene.points @ (along if up is None else up))
    assert np.ptp(mesh.vertices @ along) == pytest.approx(expected, rel=1e-6)
    assert mesh.volume == pytest.approx(0.006, rel=1e-6)


def test_what_cannot_be_written_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"\.stl: meshes are written as"):
        write_mesh(cuboid(), tmp_path / "scene.stl")
    with pytest.raises(InputError, match="no face"):
        write_mesh(Scene("empty"), tmp_path / "scene.ply")
