"""Bundler's files give the views that transforms.json of the same pictures gives."""

from pathlib import Path

import pytest

from facetlog.errors import InputError
from facetlog.perception.reading.read_views import read_views
from tests.perception.reading.pose_files.same_views import same_views
from tests.perception.reading.view_folders import (
    HEIGHT,
    WIDTH,
    transforms,
    write_pictures,
    write_transforms,
)

NAMES = "images/0.png 0 50\nimages/lost.png\nimages/1.png\nimages/2.png\n"


def _camera(x: int) -> str:
    """A camera at (x, 0, 0) that looks along -z with y up, as those of `transforms`."""
    return f"50 0.01 -0.002\n1 0 0\n0 1 0\n0 0 1\n{-x} 0 0\n"


LOST = "0 0 0\n" * 5
BUNDLE = f"# Bundle file v0.3\n4 1\n{_camera(0)}{LOST}{_camera(1)}{_camera(2)}1 2 3\n9 9 9\n0\n"


def write_bundler(folder: Path, bundle: str = BUNDLE, names: str = NAMES) -> Path:
    write_pictures(folder / "images")
    (folder / "bundle").mkdir(exist_ok=True)
    (folder / "bundle" / "bundle.out").write_text(bundle)
    (folder / "list.txt").write_text(names)
    return folder


def test_bundlers_axes_and_middle_are_those_of_transforms_json(tmp_path: Path) -> None:
    middle = {"fl_x": 50.0, "fl_y": 50.0, "cx": WIDTH / 2, "cy": HEIGHT / 2}
    wanted = write_transforms(
        tmp_path / "wanted", transforms() | middle | {"k1": 0.01, "k2": -0.002}
    )
    found = read_views(write_bundler(tmp_path / "tour"))
    same_views(found.views, read_views(wanted).views)
    assert found.name == "tour"
    (problem,) = found.problems
    assert "images/lost.png has no pose: it was not registered; left out" in problem
    assert found.description == "Bundler model, 3 pictures, up unknown, unit unknown"


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        (_camera(2) + "1 2 3\n9 9 9\n0\n", "50 0 0\n", r"bundle\.out ends before camera 4: it is"),
        ("4 1\n", "5 1\n", r"has 5 cameras, .*list\.txt 4 pictures"),
        ("4 1\n", "four\n", "no number of cameras"),
        ("-2 0 0", "-2 nan 0", r"bundle\.out:22: not 3 finite numbers"),
        ("50 0.01", "-50 0.01", r"bundle\.out:3 \('images/0\.png'\): the focal length is -50"),
        ("1 0 0\n0 1 0", "1 0 0\n0 2 0", r"bundle\.out:3 .*the rotation is not one, it scales"),
    ],
)
def test_faults_are_named_with_their_line(tmp_path: Path, old: str, new: str, says: str) -> None:
    assert old in BUNDLE
    with pytest.raises(InputError, match=says):
        read_views(write_bundler(tmp_path, BUNDLE.replace(old, new)))


def test_a_list_that_is_missing_is_named(tmp_path: Path) -> None:
    (write_bundler(tmp_path / "tour") / "list.txt").unlink()
    with pytest.raises(InputError, match=r"bundle\.out has no list\.txt beside or above it"):
        read_views(tmp_path / "tour")
