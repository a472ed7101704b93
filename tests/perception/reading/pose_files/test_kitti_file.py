"""A KITTI sequence gives the views that transforms.json of the same pictures gives."""

from pathlib import Path

import pytest

from facetlog.errors import InputError
from facetlog.perception.reading.read_views import read_views
from tests.perception.reading.pose_files.same_views import same_views
from tests.perception.reading.view_folders import write_pictures, write_transforms

# Cameras of `transforms`: OpenCV's axes turned half round the world's x; the second one of the rig
# is 0.25 to the right of the first.
CALIBRATION = (
    "P0: 50 0 24 0 0 51 16 0 0 0 1 0\n"
    "P1: 50 0 24 -12.5 0 51 16 0 0 0 1 0\n"
    "Tr: 0 -1 0 0 0 0 -1 0 1 0 0 0\n"
)


def _poses(start: float) -> str:
    return "".join(f"1 0 0 {i + start} 0 -1 0 0 0 0 -1 0\n" for i in range(3))


def write_kitti(
    folder: Path,
    poses: str | None = None,
    calibration: str = CALIBRATION,
    pictures: str = "image_0",
) -> Path:
    write_pictures(folder / pictures)
    (folder / "poses.txt").write_text(_poses(0.0) if poses is None else poses)
    (folder / "calib.txt").write_text(calibration)
    return folder


@pytest.mark.parametrize(("pictures", "start"), [("image_0", 0.0), ("image_1", -0.25)])
def test_cameras_stand_where_the_rig_has_them(tmp_path: Path, pictures: str, start: float) -> None:
    wanted = read_views(write_transforms(tmp_path / "wanted"), unit="m")
    found = read_views(write_kitti(tmp_path / "tour", _poses(start), pictures=pictures))
    same_views(found.views, wanted.views)
    assert found.description == "KITTI sequence, 3 pictures, up unknown"


@pytest.mark.parametrize("given", ["sequences/00", "poses/00.txt"])
def test_a_sequence_is_read_as_the_benchmark_unpacks_it(tmp_path: Path, given: str) -> None:
    sequence = write_kitti(tmp_path / "sequences" / "00")
    (tmp_path / "poses").mkdir()
    (sequence / "poses.txt").rename(tmp_path / "poses" / "00.txt")
    found = read_views(tmp_path / given)
    wanted = read_views(write_kitti(tmp_path / "tour"))
    same_views(found.views, wanted.views)


@pytest.mark.parametrize(
    ("poses", "calibration", "says"),
    [
        (_poses(0.0) + _poses(3.0), CALIBRATION, r"poses\.txt has 6 poses, .*image_0 3 pictures"),
        (_poses(0.0).replace("1 0 0 1.0", "1 0 0 nan"), CALIBRATION, r"poses\.txt:2 \('image_0/1"),
        (_poses(0.0).replace("1 0 0 1.0", "1 0 0"), CALIBRATION, r"poses\.txt:2 .*not 3 x 4"),
        (_poses(0.0).replace("1 0 0 1.0", "2 0 0 1.0"), CALIBRATION, r"poses\.txt:2 .*scales"),
        (_poses(0.0), CALIBRATION[34:], r"calib\.txt has no P0"),
        (_poses(0.0), CALIBRATION.replace("P0: 50", "P0: 0"), r"calib\.txt:1: fx is 0"),
        (_poses(0.0), CALIBRATION.replace("0 0 1 0", "0 0 0 0"), r"calib\.txt:1: it projects"),
        (_poses(0.0), CALIBRATION.replace("P0: 50", "P0: x"), r"calib\.txt:1: not 3 x 4"),
    ],
)
def test_faults_are_named_with_their_line(
    tmp_path: Path, poses: str, calibration: str, says: str
) -> None:
    with pytest.raises(InputError, match=says):
        read_views(write_kitti(tmp_path, poses, calibration))


@pytest.mark.parametrize("names", [("poses", "calib"), ("calib", "poses")])
def test_half_a_sequence_is_named(tmp_path: Path, names: tuple[str, str]) -> None:
    (write_kitti(tmp_path) / f"{names[0]}.txt").unlink()
    with pytest.raises(InputError, match=rf"{names[0]}\.txt is missing beside {names[1]}\.txt"):
        read_views(tmp_path)


def test_a_sequence_without_pictures_is_named(tmp_path: Path) -> None:
    write_kitti(tmp_path, pictures="image_9")
    with pytest.raises(InputError, match="has no folder image_0 of pictures"):
        read_views(tmp_path)
