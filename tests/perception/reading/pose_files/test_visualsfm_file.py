"""VisualSFM's files give the views that transforms.json of the same pictures gives."""

from pathlib import Path

import numpy as np
import pytest

from facetlog.errors import InputError
from facetlog.perception.reading.lens import Distortion
from facetlog.perception.reading.pose_files.pose_reader import PoseOptions
from facetlog.perception.reading.pose_files.register import read_poses
from facetlog.perception.reading.read_views import read_views
from tests.perception.reading.pose_files.same_views import same_views
from tests.perception.reading.view_folders import (
    HEIGHT,
    WIDTH,
    transforms,
    write_pictures,
    write_transforms,
)


def _camera(name: str, x: int, radial: float = 0.0) -> str:
    """A camera at (x, 0, 0) as those of `transforms`: OpenCV's axes turned half round x."""
    return f"{name}\t50 0 1 0 0 {x} 0 0 {radial:g} 0\n"


SMALL = f"2\n{_camera('images/0.png', 0)}{_camera('images/1.png', 1)}1\n1 2 3 9 9 9 0\n"
CAMERAS = "".join(_camera(f"images/{i}.png", i) for i in range(3))
NVM = (
    f"NVM_V3 \n\n{SMALL}\n3\n{CAMERAS}\n2\n1 2 3 9 9 9 1 0 0 1 1\n4 5 6 9 9 9 0\n\n0\n\n# plys\n0\n"
)


def write_visualsfm(folder: Path, text: str = NVM) -> Path:
    write_pictures(folder / "images")
    (folder / "model.nvm").write_text(text)
    return folder


def test_the_largest_model_gives_the_views_of_transforms_json(tmp_path: Path) -> None:
    middle = {"fl_x": 50.0, "fl_y": 50.0, "cx": WIDTH / 2, "cy": HEIGHT / 2}
    wanted = write_transforms(tmp_path / "wanted", transforms() | middle)
    found = read_views(write_visualsfm(tmp_path / "tour"))
    same_views(found.views, read_views(wanted).views)
    assert found.description == "VisualSFM model, 3 pictures, up unknown, unit unknown"
    assert read_views(tmp_path / "tour", unit="cm").views[2].pose.centre[0] == 0.02


def test_a_calibration_in_the_first_line_and_a_distortion_are_of_each_lens(tmp_path: Path) -> None:
    text = NVM.replace("NVM_V3 ", "NVM_V3 FixedK 60 25 61 17").replace("2 0 0 0 0", "2 0 0 -0.05 0")
    *_, last = read_poses(write_visualsfm(tmp_path, text) / "model.nvm", PoseOptions()).pictures
    lens = last.intrinsics.lens(WIDTH, HEIGHT)
    np.testing.assert_array_equal(lens.camera.matrix, [[60, 0, 24.5], [0, 61, 16.5], [0, 0, 1]])
    assert (lens.distortion, lens.projection) == (Distortion.INVERSE, (-0.05,))


def test_of_two_models_one_is_to_be_named_even_beside_pictures(tmp_path: Path) -> None:
    write_pictures(write_visualsfm(tmp_path))
    (tmp_path / "other.nvm").write_text("NVM_V3\n")
    with pytest.raises(InputError, match=r"name the one to use of \w+\.nvm and \w+\.nvm; to go"):
        read_views(tmp_path)


def test_names_with_spaces_are_written_with_quotation_marks(tmp_path: Path) -> None:
    write_visualsfm(tmp_path, NVM.replace("images/2.png", 'images\\my"third.png'))
    (tmp_path / "images" / "2.png").rename(tmp_path / "images" / "my third.png")
    assert [view.name for view in read_views(tmp_path).views][-1] == "images/my third.png"


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("NVM_V3 ", "NVM_V2 ", r"model\.nvm:1: the first word is not NVM_V3"),
        ("NVM_V3 ", "NVM_V3 FixedK 60 25", r"model\.nvm:1: not 4 finite numbers"),
        ("\n3\n", "\nthree\n", r"model\.nvm:9: not a number of cameras or points"),
        ("4 5 6 9 9 9 0\n\n0\n\n# plys\n0\n", "", r"model\.nvm ends after 1 of 2 lines"),
        ("png\t50 0 1 0 0 2", "png\t50 0 nan 0 0 2", r":12 \('images/2\.png'\): not 10 finite"),
        ("png\t50 0 1 0 0 2", "png\t0 0 1 0 0 2", r":12 \('images/2\.png'\): the focal length"),
        ("png\t50 0 1 0 0 2", "png\t50 0 0 0 0 2", r":12 \('images/2\.png'\): .*of length 0"),
    ],
)
def test_faults_are_named_with_their_line(tmp_path: Path, old: str, new: str, says: str) -> None:
    assert old in NVM
    with pytest.raises(InputError, match=says):
        read_views(write_visualsfm(tmp_path, NVM.replace(old, new)))
