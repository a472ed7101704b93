"""One reader for whatever file holds a shape: kind by suffix, up and unit as they are told."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from facetlog.errors import InputError
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.read_shape import ShapeOptions, read_shape
from facetlog.perception.shapes.shape_options import parse_sensor, parse_unit, parse_up
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
from facetlog.perception.surfaces.mesh_export import write_mesh
from facetlog.perception.surfaces.scene_file import write_scene
from tests.perception.shapes.sampled_shapes import box_points


def _size(scene: Scene) -> list[float]:
    return sorted(np.ptp(scene.points, axis=0).round(6).tolist())


@pytest.fixture
def stl(tmp_path: Path) -> Path:
    trimesh.creation.box((300.0, 200.0, 100.0)).export(tmp_path / "block.STL")
    return tmp_path / "block.STL"


def test_a_scene_says_itself_where_up_is(tmp_path: Path) -> None:
    write_scene(cuboid(0.3, 0.2, 0.1), tmp_path / "a.json")
    scene = read_shape(tmp_path / "a.json", ShapeOptions(parse_up("x"), unit="mm"))
    assert scene.up is not None
    assert scene.up.tolist() == [0.0, 0.0, 1.0]
    assert _size(scene) == [0.1, 0.2, 0.3]


def test_options_say_it_of_a_mesh(stl: Path) -> None:
    scene = read_shape(stl, ShapeOptions(parse_up("-y"), unit="mm"))
    assert len(scene.faces) == 6
    assert scene.up is not None
    assert scene.up.tolist() == [0.0, -1.0, 0.0]
    assert scene.metric
    assert _size(scene) == [0.1, 0.2, 0.3]


def test_what_a_format_says_counts_unless_up_is_to_be_unknown(tmp_path: Path) -> None:
    write_mesh(cuboid(0.3, 0.2, 0.1), tmp_path / "a.glb")
    found = read_shape(tmp_path / "a.glb", ShapeOptions(find_floor=True))
    assert found.metric
    assert found.up is not None
    assert found.up.tolist() == [0.0, 1.0, 0.0]
    assert read_shape(tmp_path / "a.glb", ShapeOptions()).up is None


@pytest.mark.slow
def test_points_alone_become_a_cloud_in_metres_as_their_unit_says(tmp_path: Path) -> None:
    points = np.random.default_rng(3).uniform(-1.0, 1.0, (6000, 3))
    side = np.arange(6000) % 6
    points[np.arange(6000), side % 3] = np.where(side < 3, 1.0, -1.0)
    points *= [150.0, 100.0, 50.0]
    trimesh.PointCloud(points).export(tmp_path / "a.ply")
    np.savetxt(tmp_path / "a.xyz", points)
    for name in ("a.ply", "a.xyz"):
        scene = read_shape(tmp_path / name, ShapeOptions(parse_up("z"), unit="mm"))
        assert scene.metric
        assert _size(scene) == pytest.approx([0.1, 0.2, 0.3], rel=0.03)
        assert len(scene.faces) == 6
    assert read_shape(tmp_path / "a.ply", ShapeOptions()).up is None


@pytest.mark.parametrize("name", ["a.doc", "a"])
def test_a_file_of_another_kind_is_refused(name: str) -> None:
    with pytest.raises(InputError, match=rf"{name}: .*files that can be read are \.json"):
        read_shape(Path(name), ShapeOptions())


def test_words_for_axes_and_units_are_checked() -> None:
    assert (parse_up("auto"), parse_up("none"), parse_unit("none")) == (None, None, None)
    assert parse_unit("ft") == "ft"
    assert parse_sensor("none") is None
    for word in ("1,2", "1,2,3,4", "a,b,c", "1,2,nan", ""):
        with pytest.raises(InputError, match="give three numbers x,y,z"):
            parse_sensor(word)
    for word, check in (("w", parse_up), ("mile", parse_unit)):
        with pytest.raises(InputError, match=f"{word}.*use one of"):
            check(word)


def test_a_sensor_is_a_place_in_the_clouds_own_unit(tmp_path: Path) -> None:
    path = tmp_path / "a.xyz"
    np.savetxt(path, 1000.0 * box_points((0.4, 0.3, 0.2), 2000, sides=("+x", "+y", "+z")))
    options = ShapeOptions(up=(0.0, 0.0, 1.0), unit="mm", sensor=(1500.0, 1200.0, 1000.0))
    (lines,) = read_shape(path, options).sights
    np.testing.assert_allclose(lines.origin, [1.5, 1.2, 1.0])
    assert read_shape(path, replace(options, sensor=None)).sights == ()
