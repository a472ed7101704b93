"""Small pictures of scenes: something to see of whatever there is."""

import cv2
import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh
from facetlog.perception.scene import Patch, Scene, Vertex
from facetlog.perception.shapes.meshes.mesh_scene import make_mesh_scene
from facetlog.perception.surfaces.drawing.thumbnail import contact_sheet, thumbnail
from facetlog.perception.surfaces.exact_solids.polyhedra import (
    chair,
    cuboid,
    moved,
    room_corner,
    table,
)


def _picture(scene: Scene) -> NDArray[np.uint8]:
    data = np.frombuffer(thumbnail(scene, 120), dtype=np.uint8)
    return np.asarray(cv2.imdecode(data, cv2.IMREAD_UNCHANGED), dtype=np.uint8)


def _ball(radius: float = 1.0) -> Scene:
    points = np.random.default_rng(0).normal(size=(2000, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    areas = np.full(2000, 4 * np.pi * radius**2 / 2000)
    return Scene("ball", patches=(Patch(points * radius, points, areas),))


@pytest.mark.parametrize("make", [cuboid, table, chair, room_corner])
def test_flat_faces_are_seen_in_several_shades(make: object) -> None:
    picture = _picture(make())  # type: ignore[operator]
    assert picture.shape == (120, 120, 4)
    solid = picture[picture[..., 3] == 255][:, :3]
    assert 0.05 < len(solid) / 120**2 < 0.9
    assert len(np.unique(solid // 16, axis=0)) >= 3


def test_the_unit_of_length_and_the_place_do_not_matter() -> None:
    far = moved(table(), np.eye(3), [1e4, -1e4, 5e3])
    assert np.abs(_picture(far).astype(int) - _picture(table())).mean() < 0.5
    assert np.abs(_picture(_ball(1e6)).astype(int) - _picture(_ball(1e-6))).mean() < 0.5


def _dark(scene: Scene) -> int:
    """Pixels of outlines."""
    picture = _picture(scene)
    return int(((picture[..., :3].max(axis=2) < 80) & (picture[..., 3] > 200)).sum())


@pytest.mark.parametrize("seed", range(4))
def test_of_a_sheet_only_the_side_is_drawn_that_is_looked_at(seed: int) -> None:
    made = trimesh.creation.box((3.0, 2.0, 1.0))
    turned = np.array(Rotation.random(rng=seed).apply(made.vertices)) + 0.1
    whole = make_mesh_scene(Mesh.of(turned, made.faces), up=[0, 0, 1])
    # far from closed: each side of the block is a sheet with two sides
    sheets = make_mesh_scene(Mesh.of(turned, made.faces[:8]), up=[0, 0, 1])
    assert len(sheets.faces) > len(whole.faces)
    # no zigzags: outlines are as long as those of the whole, or less
    assert 0 < _dark(sheets) < 1.5 * _dark(whole)


@pytest.mark.parametrize(
    "scene", [Scene("empty"), Scene("dot", vertices=(Vertex(np.zeros(3), np.eye(3)),))]
)
def test_a_scene_without_anything_is_an_empty_picture(scene: Scene) -> None:
    assert (_picture(scene)[..., 3] == 0).all()


def _sheet(*captions: str, across: int = 10) -> NDArray[np.uint8]:
    png = contact_sheet([(cuboid(), caption) for caption in captions], 120, across)
    data = np.frombuffer(png, dtype=np.uint8)
    return np.asarray(cv2.imdecode(data, cv2.IMREAD_UNCHANGED), dtype=np.uint8)


def test_a_caption_is_wrapped_and_a_long_word_made_smaller_so_that_all_of_it_shows() -> None:
    sheet = _sheet("near box: fails " + "much_longer_than_wide" * 2, "box")
    columns = (sheet[120:] < 128).all(axis=2).any(axis=0)

    assert columns[:120].any()
    assert not columns[114:126].any()
