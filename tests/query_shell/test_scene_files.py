"""Which arguments are scenes, and what scenes are called."""

from pathlib import Path

import pytest
import trimesh

from facetlog.errors import InputError
from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.surfaces.exact_solids.polyhedra import boxes
from facetlog.perception.surfaces.scene_file import read_scene, write_scene
from facetlog.query_shell.scene_files import (
    is_raw_shape,
    scene_file,
    scenes_and_goal,
    with_distinct_names,
)

from .scenes import write_block


def test_the_last_argument_is_a_goal_unless_there_is_such_a_file(scene: Path) -> None:
    assert scenes_and_goal([str(scene), "face(F)"]) == ((scene,), "face(F)")
    assert scenes_and_goal([str(scene), str(scene)]) == ((scene, scene), None)
    assert scenes_and_goal([str(scene), "X is 1/2"])[1] == "X is 1/2"
    assert scenes_and_goal([str(scene), "x" * 5000])[1] == "x" * 5000


@pytest.mark.parametrize("missing", ["other.json", "out/other", "./other"])
def test_a_file_that_is_not_there_is_no_goal(scene: Path, missing: str) -> None:
    with pytest.raises(InputError, match="does not exist"):
        scenes_and_goal([str(scene), missing])
    with pytest.raises(InputError, match="does not exist"):
        scenes_and_goal([missing, "face(F)"])


def test_a_goal_alone_has_nothing_to_be_asked_of() -> None:
    with pytest.raises(InputError, match="before the goal"):
        scenes_and_goal(["face(F)"])


def test_a_folder_and_its_scene_file_are_the_same(scene: Path) -> None:
    assert scene_file(scene) == scene_file(scene / "scene.json")
    assert scene_file(scene).name == "block"


@pytest.mark.parametrize("path", ["absent", "empty", "loop"])
def test_what_is_no_scene_is_refused(tmp_path: Path, path: str) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(InputError):
        scene_file(tmp_path / path)


def test_facts_of_a_file_that_is_no_scene_are_refused_with_its_name(tmp_path: Path) -> None:
    path = tmp_path / "odd.json"
    path.write_text('{"name": 3}')
    file = scene_file(path)
    assert file.name == "odd"
    with pytest.raises(InputError, match=r"odd\.json"):
        next(file.facts())


@pytest.mark.parametrize("name", ["block.stl", "block.PLY"])
def test_a_mesh_is_a_scene(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    trimesh.creation.box((0.3, 0.2, 0.1)).export(path)
    file = scene_file(path)
    assert (file.name, file.key) == ("block", None)
    assert sum(fact[0] == "face" for fact in file.facts()) == 6


def test_a_damaged_mesh_is_told_as_one(tmp_path: Path) -> None:
    path = tmp_path / "odd.stl"
    path.write_bytes(b"x")
    with pytest.raises(InputError, match=r"odd\.stl: is no STL"):
        next(scene_file(path).facts())


def test_the_folder_of_a_colmap_model_is_a_raw_shape_without_a_scene(tmp_path: Path) -> None:
    (tmp_path / "points3D.txt").touch()
    assert is_raw_shape(tmp_path)
    (tmp_path / "scene.json").touch()
    assert not is_raw_shape(tmp_path)
    assert not is_raw_shape(tmp_path / "absent.stl")
    assert not is_raw_shape(tmp_path / ("x" * 5000 + ".stl"))


def test_scenes_of_one_name_are_told_apart_by_their_folders(tmp_path: Path) -> None:
    files = [scene_file(write_block(tmp_path / place)) for place in ("a/x", "b/x", "c")]
    other = scene_file(write_block(tmp_path / "d", name="lone"))
    names = [file.name for file in with_distinct_names([*files, other])]
    assert names == ["block@x", "block@b/x", "block@c", "lone"]


def test_a_scene_that_comes_later_makes_way(scene: Path) -> None:
    (file,) = with_distinct_names([scene_file(scene)], taken=["block"])
    assert file.name == "block@block"


def test_the_key_follows_the_content(tmp_path: Path) -> None:
    first, second = write_block(tmp_path / "a"), write_block(tmp_path / "b")
    assert scene_file(first).key == scene_file(second).key
    write_block(second, name="other")
    assert scene_file(first).key != scene_file(second).key


def test_a_scene_has_another_key_once_the_code_that_makes_facts_is_another(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "scene.json"
    path.write_text('{"name": "s"}')
    before = scene_file(path).key
    monkeypatch.setattr("facetlog.perception.facts.facts_code.facts_code_hash", lambda: "other")
    assert scene_file(path).key != before


def test_a_scene_nested_too_deeply_is_named_with_its_file(tmp_path: Path) -> None:
    path = tmp_path / "scene.json"
    path.write_text("[" * 100_000)
    with pytest.raises(InputError, match=r"scene\.json: .*recursion"):
        list(scene_file(path).facts())


def test_facts_are_those_of_the_scene_in_their_order(scene: Path) -> None:
    file = scene_file(scene)
    known = [fact.row for fact in scene_facts(read_scene(file.path))]
    assert list(file.facts()) == known
    assert list(file.facts()) == known  # nothing was taken from what is kept


def test_a_scene_of_too_many_faces_is_refused_in_one_line_and_little_memory(tmp_path: Path) -> None:
    boxes_there = [((x, y, 0.0), (x + 0.3, y + 0.2, 0.1)) for x in range(20) for y in range(17)]
    write_scene(boxes(boxes_there, 0.001, "many"), tmp_path / "many.json")
    with pytest.raises(InputError, match=r"many\.json: has 2,040 faces, of at most 2,000 facts"):
        list(scene_file(tmp_path / "many.json").facts())
