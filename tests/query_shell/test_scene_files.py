"""Which arguments are scenes, and what scenes are called."""

import pytest

from facetlog.errors import InputError
from facetlog.perception.surfaces.exact_solids.polyhedra import boxes
from facetlog.perception.surfaces.scene_file import write_scene
from facetlog.query_shell.scene_files import (
    is_raw_shape,
    make_names_distinct,
    scene_file,
    split_scenes_and_goal,
)

from .scenes import write_block


def test_the_last_argument_is_a_goal_unless_there_is_such_a_file(scene):
    assert split_scenes_and_goal([str(scene), "face(F)"]) == ((scene,), "face(F)")
    assert split_scenes_and_goal([str(scene), str(scene)]) == ((scene, scene), None)
    assert split_scenes_and_goal([str(scene), "X is 1/2"])[1] == "X is 1/2"
    assert split_scenes_and_goal([str(scene), "x" * 5000])[1] == "x" * 5000


@pytest.mark.parametrize("missing", ["other.json", "out/other", "./other"])
def test_a_file_that_is_not_there_is_no_goal(scene, missing):
    with pytest.raises(InputError, match="does not exist"):
        split_scenes_and_goal([str(scene), missing])
    with pytest.raises(InputError, match="does not exist"):
        split_scenes_and_goal([missing, "face(F)"])


@pytest.mark.parametrize("path", ["absent", "empty", "loop"])
def test_what_is_no_scene_is_refused(tmp_path, path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(InputError):
        scene_file(tmp_path / path)


def test_the_folder_of_a_colmap_model_is_a_raw_shape_without_a_scene(tmp_path):
    (tmp_path / "points3D.txt").touch()
    assert is_raw_shape(tmp_path)
    (tmp_path / "scene.json").touch()
    assert not is_raw_shape(tmp_path)
    assert not is_raw_shape(tmp_path / "absent.stl")
    assert not is_raw_shape(tmp_path / ("x" * 5000 + ".stl"))


def test_scenes_of_one_name_are_told_apart_by_their_folders(tmp_path):
    files = [scene_file(write_block(tmp_path / place)) for place in ("a/x", "b/x", "c")]
    other = scene_file(write_block(tmp_path / "d", name="lone"))
    names = [file.name for file in make_names_distinct([*files, other])]
    assert names == ["block@x", "block@b/x", "block@c", "lone"]


def test_a_scene_has_another_key_once_the_code_that_makes_facts_is_another(tmp_path, monkeypatch):
    path = tmp_path / "scene.json"
    path.write_text('{"name": "s"}')
    before = scene_file(path).kept.key
    monkeypatch.setattr("facetlog.kept_scenes.facts_code_hash", lambda **_: "other")
    assert scene_file(path).kept.key != before


def test_a_scene_of_too_many_faces_is_refused_in_one_line_and_little_memory(tmp_path):
    boxes_there = [((x, y, 0.0), (x + 0.3, y + 0.2, 0.1)) for x in range(20) for y in range(17)]
    write_scene(boxes(boxes_there, 0.001, "many"), tmp_path / "many.json")
    with pytest.raises(InputError, match=r"many\.json: has 2,040 faces, of at most 2,000 facts"):
        list(scene_file(tmp_path / "many.json").facts())
