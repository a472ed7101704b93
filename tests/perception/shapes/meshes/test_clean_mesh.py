"""Meshes put in order: welded, without doubles, wound one way, outside out."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh
from facetlog.perception.shapes.meshes.clean_mesh import clean_mesh
from facetlog.perception.shapes.regions.surface_samples import sample_triangles


def block() -> trimesh.Trimesh:
    return trimesh.creation.box((3, 2, 1)).subdivide()


def points_out(mesh: Mesh) -> bool:
    surface = clean_mesh(mesh)
    middles = surface.corners.mean(axis=1)
    return bool(((surface.normals * middles).sum(axis=1) > 0.0).all())


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), st.sampled_from([1e-9, 1.0, 1e9]))
def test_a_block_of_any_winding_order_and_scale_is_one_closed_sheet_outside_out(
    seed: int, scale: float
) -> None:
    rng = np.random.default_rng(seed)
    made = block()
    triangles = np.array(made.faces)
    turn = rng.random(len(triangles)) < rng.random()
    triangles = np.where(turn[:, None], triangles[:, ::-1], triangles)
    triangles = np.concatenate((triangles, triangles[: seed % 7, [1, 2, 0]]))
    mesh = Mesh.of(made.vertices * scale, rng.permutation(triangles))
    surface = clean_mesh(mesh)
    assert len(surface.triangles) == len(made.faces)
    assert surface.closed.all()
    assert len(set(surface.sheets.tolist())) == 1
    assert points_out(mesh)
    assert surface.areas.sum() == pytest.approx(22.0 * scale**2)


def test_corners_a_rounding_apart_are_one_and_others_are_not() -> None:
    made = block()
    soup = made.triangles.reshape(-1, 3)
    noise = np.random.default_rng(2).uniform(-1, 1, soup.shape)
    triangles = np.arange(len(soup)).reshape(-1, 3)
    assert clean_mesh(Mesh.of(soup + 3e-7 * noise, triangles)).closed.all()
    assert not clean_mesh(Mesh.of(soup + 1e-3 * noise, triangles)).closed.any()


@pytest.mark.parametrize("points", [np.zeros((3, 3)), np.outer(np.arange(3), np.ones(3))])
def test_a_mesh_without_area_is_an_input_error(points: object) -> None:
    with pytest.raises(InputError, match="export the mesh again"):
        clean_mesh(Mesh.of(np.asarray(points), [[0, 1, 2]], name="line.ply"))


@settings(max_examples=50)
@given(st.integers(0, 2**32 - 1), st.floats(0.01, 3.0))
def test_samples_stand_for_the_whole_area_and_lie_close(seed: int, spacing: float) -> None:
    rng = np.random.default_rng(seed)
    corners = rng.normal(size=(5, 3, 3))
    samples = sample_triangles(corners, spacing)
    full = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    assert np.bincount(samples.triangles, samples.areas) == pytest.approx(full)
    weights = rng.dirichlet((1, 1, 1), size=(5, 20))
    places = np.einsum("tnk,tkd->tnd", weights, corners)
    for nth in range(5):
        own = samples.points[samples.triangles == nth]
        gaps = np.linalg.norm(places[nth][:, None] - own, axis=2).min(axis=1)
        assert gaps.max() <= spacing


def slivers(count: int, width: float) -> trimesh.Trimesh:
    """Triangles 2 cm long, side by side 1 mm apart, that share no corner."""
    start = np.column_stack([np.zeros(count), np.arange(count) * 1e-3, np.zeros(count)])
    one = np.array([[0.0, 0.0, 0.0], [0.02, 0.0, 0.0], [0.01, width, 0.0]])
    corners = (start[:, None] + one).reshape(-1, 3)
    return trimesh.Trimesh(corners, np.arange(3 * count).reshape(-1, 3), process=False)


def test_of_slivers_that_are_left_out_it_says_how_many_and_what_share_they_are() -> None:
    def warnings(scale: float) -> tuple[str, ...]:
        both = trimesh.util.concatenate([block().apply_scale(scale), slivers(400, 3e-7)])
        return clean_mesh(Mesh.of(both.vertices, both.faces)).warnings

    (said,) = warnings(5e-4)
    assert said.startswith("400 of 448 triangles, 17.9% of the surface, are narrower than")
    assert warnings(5e-2) == ()  # they are nothing beside the rest


def test_a_mesh_of_which_most_is_too_narrow_is_refused_with_what_to_do() -> None:
    rain = slivers(20, 1e-9)
    with pytest.raises(InputError, match=r"^rain.ply: 20 of 20 .* 100.0% .*, remesh it, or give"):
        clean_mesh(Mesh.of(rain.vertices, rain.faces, name="rain.ply"))
