"""A folder of nothing but pictures: cameras, poses, and what is left out or refused."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image as Pillow

from facetlog.errors import InputError
from facetlog.perception.length_units import Length
from facetlog.perception.reading.follow_views import FollowedViews
from facetlog.perception.reading.read_views import read_views
from facetlog.perception.types import PoseErrorKind
from tests.perception.reading.mat.mat_photos import (
    A3,
    A4,
    SMALL,
    around,
    photo,
    photos,
    write_photos,
)
from tests.perception.reading.videos import write_video
from tests.perception.reading.view_folders import transforms, write_transforms

GREY = np.full((SMALL.height, SMALL.width), 128, dtype=np.uint8)


def test_a_unit_is_refused_for_the_mat_has_its_own(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="give the side of a square"):
        read_views(write_photos(tmp_path / "a", [GREY]), unit="mm")


@pytest.mark.slow
def test_pictures_of_a_mat_have_cameras_and_poses_in_metres(tmp_path: Path) -> None:
    found = read_views(write_photos(tmp_path / "pens", photos()))
    assert (found.name, found.metric, len(found.views)) == ("pens", True, 6)
    assert found.description.startswith("mat A4 (its corners fit to 0.")
    assert found.description.endswith("px), 6 pictures")
    assert found.up == pytest.approx([0, 0, 1])
    assert found.pose_errors is not None
    assert found.pose_errors.kind is PoseErrorKind.INDEPENDENT
    for view, true, cov in zip(found.views, around(6), found.pose_errors.covariances, strict=True):
        off = view.pose.centre - true.centre
        assert np.linalg.norm(off) < 0.01
        assert off @ np.linalg.solve(cov[:3, :3], off) < 25  # of 3 degrees of freedom
        assert view.camera.fx == pytest.approx(SMALL.fx, rel=0.03)


@pytest.mark.slow
def test_a_print_of_another_scale_is_put_right_by_its_square(tmp_path: Path) -> None:
    folder = write_photos(tmp_path / "a", photos())
    usual = read_views(folder).views[2].pose.centre
    found = read_views(folder, square=Length(0.9 * A4.square_mm / 1000))
    assert found.views[2].pose.centre == pytest.approx(0.9 * usual, rel=1e-6)


@pytest.mark.slow
def test_a_print_is_as_sure_as_a_ruler_tells_or_as_is_stated(tmp_path: Path) -> None:
    folder = write_photos(tmp_path / "a", photos())
    half_a_millimetre = 0.005 / np.sqrt(3.0)
    for square, relative in (
        (None, half_a_millimetre),
        (Length(0.018), half_a_millimetre),
        (Length(0.018, 0.00009), 0.005),
    ):
        errors = read_views(folder, square=square).pose_errors
        assert errors is not None
        assert errors.scale_sd == pytest.approx(relative)
        assert errors.of([0, 2]).scale_sd == errors.scale_sd


@pytest.mark.slow
def test_pictures_without_mat_blurred_or_broken_are_named_and_left_out(tmp_path: Path) -> None:
    blurred = cv2.GaussianBlur(photos()[0], (0, 0), 4.0)
    folder = write_photos(tmp_path / "a", [*photos(), GREY, blurred])
    (folder / "08.jpg").write_bytes(b"nothing")
    (folder / "notes.txt").write_text("pens")
    found = read_views(folder)
    assert len(found.views) == 6
    assert found.description.endswith("6 pictures")
    hidden, broken, few = found.problems
    assert "06.png shows too little of the mat" in hidden
    assert "and so is 07.png" in hidden
    assert "08.jpg is not a picture" in broken
    assert few.startswith("too few: 6 can be used, take 6 more")
    assert few.endswith(f"(facetlog mat check {folder} says more)")


@pytest.mark.slow
def test_each_size_and_zoom_is_a_camera_of_its_own(tmp_path: Path) -> None:
    folder = write_photos(tmp_path / "a", photos()[:3])
    zoomed = SMALL.zoomed(1.6)
    for k, pose in enumerate(around(6, 0.5)[:3]):
        exif = Pillow.Exif()
        exif.get_ifd(0x8769).update({0x920A: 6.8, 0xA405: 51})
        picture = Pillow.fromarray(photo(A4, pose, zoomed, seed=k))
        picture.save(folder / f"z{k}.jpg", quality=95, exif=exif)
    found = read_views(folder)
    focals = [view.camera.fx for view in found.views]
    assert focals[:3] == pytest.approx([SMALL.fx] * 3, rel=0.05)
    assert focals[3:] == pytest.approx([zoomed.fx] * 3, rel=0.05)
    assert len(set(focals)) == 2


@pytest.mark.slow
def test_a_video_is_taken_by_frames_spread_over_it(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    frames = [picture for picture in photos() for _ in range(7)]
    write_video(tmp_path / "a" / "walk.avi", frames)
    found = read_views(tmp_path / "a")
    assert len(found.views) == 30
    assert found.views[0].name == "walk.avi#0"
    assert found.views[-1].name == "walk.avi#41"
    of_pictures = read_views(write_photos(tmp_path / "b", photos()))
    off = found.views[-1].pose.centre - of_pictures.views[-1].pose.centre
    assert np.linalg.norm(off) < 0.01


def test_a_poses_file_goes_before_the_mat(tmp_path: Path) -> None:
    folder = write_transforms(tmp_path / "a", transforms())
    write_photos(folder, photos()[:2], first=50)
    found = read_views(folder)
    assert found.description.startswith("nerfstudio's transforms.json, 3 pictures")
    with pytest.raises(InputError, match="square is for pictures of a mat"):
        read_views(folder, square=Length(0.018))


@pytest.mark.parametrize(
    ("pictures", "line"),
    [
        ([GREY, GREY], r"a: no mat is seen in any of 2 pictures: print one \(facetlog mat"),
        ([GREY], r"no mat is seen in the only picture \(picture .*00.png shows too little"),
        ([photo(A4, around(6)[0])], "1 usable view: give at least 2, from different places"),
        (
            [photo(A4, around(6)[0]), photo(A3, around(6, 0.45)[1])],
            "shows two mats, A4 in 00.png and A3 in 01.png: give each its own folder",
        ),
    ],
)
def test_what_cannot_be_read_is_said_in_one_line(
    pictures: list[np.ndarray], line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("facetlog.perception.reading.pose_files.register.can_map", lambda: False)
    with pytest.raises(InputError, match=line) as caught:
        read_views(write_photos(tmp_path / "a", pictures))
    assert "\n" not in str(caught.value)


def test_a_followed_folder_waits_for_its_poses_and_takes_no_mat(tmp_path: Path) -> None:
    followed = FollowedViews(write_photos(tmp_path / "a", photos()[:2]), timeout=0.0)
    with pytest.raises(InputError, match="leave out --follow"):
        list(followed)
