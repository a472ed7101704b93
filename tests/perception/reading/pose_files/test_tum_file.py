"""A TUM trajectory gives the views that transforms.json of the same pictures gives."""

from pathlib import Path

import pytest

from facetlog.errors import InputError
from facetlog.perception.reading.read_views import read_views
from tests.perception.reading.pose_files.same_views import same_views
from tests.perception.reading.view_folders import CAMERA, write_pictures, write_transforms

# Cameras of `transforms`: OpenCV's axes turned half round the world's x.
TRAJECTORY = (
    "# time tx ty tz qx qy qz qw\n"
    "5.000 9 9 9 0 0 0 1\n"
    "10.010 0 0 0 1 0 0 0\n"
    "12.000 2 0 0 2 0 0 0\n"
    "10.985 1 0 0 1 0 0 0\n"
    "11.050 7 7 7 0 0 0 1\n"
)
PICTURES = "# time picture\n10.0 rgb/0.png\n11.0 rgb/1.png\n12.0 rgb/2.png\n20.0 rgb/late.png\n"


def write_tum(folder: Path, trajectory: str = TRAJECTORY, pictures: str = PICTURES) -> Path:
    write_pictures(folder / "rgb")
    (folder / "groundtruth.txt").write_text(trajectory)
    (folder / "rgb.txt").write_text(pictures)
    camera = CAMERA.replace('unit = "in"\n', "")
    camera = camera.replace("cx = 23.5\ncy = 15.5", "cx = 24\ncy = 16")  # as of `transforms`
    (folder / "camera.toml").write_text(camera)
    return folder


def test_each_picture_has_the_pose_nearest_in_time(tmp_path: Path) -> None:
    wanted = read_views(write_transforms(tmp_path / "wanted"), unit="m")
    found = read_views(write_tum(tmp_path / "tour"))
    same_views(found.views, wanted.views)
    assert found.description == "TUM trajectory, 3 pictures, up unknown"
    (problem,) = found.problems
    assert problem.endswith("('rgb/late.png'): groundtruth.txt has no pose within 0.02 s; left out")
    assert read_views(tmp_path / "tour", unit="cm").views[2].pose.centre[0] == 0.02


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("12.000 2 0 0 2 0 0 0", "12.000 2 0 0 0 0 0 0", r"groundtruth\.txt:4 .* of length 0"),
        ("12.000 2 0 0", "12.000 nan 0 0", r"groundtruth\.txt:4 .*'rgb/2\.png'.* not finite"),
        ("12.000 2 0 0", "12.000 two 0 0", r"groundtruth\.txt:4: .* seven numbers"),
        ("12.000 2 0 0", "12.000 2 0", r"groundtruth\.txt:4: not TIME TX"),
        ("12.000 2 0 0", "noon 2 0 0", r"groundtruth\.txt:4: not TIME TX"),
    ],
)
def test_faults_are_named_with_their_line(tmp_path: Path, old: str, new: str, says: str) -> None:
    assert old in TRAJECTORY
    with pytest.raises(InputError, match=says):
        read_views(write_tum(tmp_path, TRAJECTORY.replace(old, new)))


@pytest.mark.parametrize("names", [("rgb", "groundtruth"), ("groundtruth", "rgb")])
def test_half_a_recording_is_named(tmp_path: Path, names: tuple[str, str]) -> None:
    (write_tum(tmp_path) / f"{names[0]}.txt").unlink()
    with pytest.raises(InputError, match=rf"{names[0]}\.txt is missing beside {names[1]}\.txt"):
        read_views(tmp_path)


def test_a_missing_camera_is_asked_for_with_the_unit_of_the_trajectory(tmp_path: Path) -> None:
    (write_tum(tmp_path) / "camera.toml").unlink()
    with pytest.raises(InputError, match=r'the unit of the poses, as unit = "m"'):
        read_views(tmp_path)


def test_times_of_two_clocks_and_a_missing_camera_are_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no pose is within 0\.02 s .* one clock"):
        read_views(write_tum(tmp_path, pictures="1e9 rgb/0.png\n"))
    (tmp_path / "camera.toml").unlink()
    with pytest.raises(InputError, match=r"camera\.toml is missing: write it"):
        read_views(tmp_path)
