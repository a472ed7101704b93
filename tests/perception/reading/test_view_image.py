"""Large pictures are kept reduced and read again as stored, turned by EXIF where that is asked."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import ExifTags, Image

from facetlog.perception.reading.image_sources import list_shots
from facetlog.perception.reading.lens import Distortion, Lens
from facetlog.perception.reading.pose_files.poses_file import Intrinsics, PosedPicture
from facetlog.perception.reading.video_file import VideoFrames
from facetlog.perception.reading.view_image import (
    KEPT_DIAGONAL_PX,
    ViewLoader,
    picture_of_view,
)
from facetlog.perception.types import Camera, Pose, View

LARGE = Camera(1600, 1200, 1500.0, 1500.0, 801.0, 597.0)
BENT = Lens(LARGE, Distortion.POLYNOMIAL, radial=(-0.1, 0.02, 0.0, 0.0))


def posed(path: Path) -> PosedPicture:
    size = (None, None)
    intrinsics = Intrinsics("", size, size, size, None, Distortion.NONE, (0.0,) * 4, (0.0, 0.0))
    return PosedPicture(path.name, path, intrinsics, Pose(np.eye(3), np.zeros(3)))


def smooth_picture() -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    grey = np.random.default_rng(0).integers(40, 215, (16, 21), dtype=np.uint8)
    size = (LARGE.width, LARGE.height)
    return np.asarray(cv2.resize(grey, size, interpolation=cv2.INTER_CUBIC), dtype=np.uint8)


@pytest.mark.parametrize("lens", [Lens(LARGE), BENT])
def test_a_reduced_picture_shows_what_the_stored_one_does(tmp_path: Path, lens: Lens) -> None:
    path = tmp_path / "a.png"
    cv2.imwrite(str(path), smooth_picture())
    view = picture_of_view(posed(path), smooth_picture(), lens)
    assert np.hypot(*view.image.shape) == pytest.approx(KEPT_DIAGONAL_PX, rel=0.002)
    assert view.stored is not None
    assert view.stored.camera == lens.pinhole
    assert view.stored_size == (1600, 1200)
    again = view.stored.read()
    assert again.shape == (1200, 1600)
    small = cv2.resize(again, view.image.shape[::-1], interpolation=cv2.INTER_AREA)
    assert np.abs(small.astype(float) - view.image).mean() < 0.6


def test_one_row_of_many_pixels_stays_a_row(tmp_path: Path) -> None:
    camera = Camera(5000, 1, 600.0, 600.0, 320.0, 0.0)
    view = picture_of_view(posed(tmp_path / "a.png"), np.zeros((1, 5000), np.uint8), Lens(camera))
    assert view.image.shape == (1, 1000)


SHOWN = np.tile(np.linspace(20, 220, 1200), (900, 1)).astype(np.uint8)
"""Brighter to the right."""


def stored(path: Path, orientation: int | None, turns: int) -> None:
    exif = Image.Exif()
    if orientation is not None:
        exif[ExifTags.Base.Orientation] = orientation
    Image.fromarray(np.rot90(SHOWN, turns)).save(path, exif=exif)


@pytest.mark.parametrize(("orientation", "turns"), [(None, 0), (1, 0), (3, 2), (6, 1), (8, 3)])
def test_a_picture_is_read_as_it_is_shown_or_as_stored(
    orientation: int | None, turns: int, tmp_path: Path
) -> None:
    stored(tmp_path / "a.png", orientation, turns)
    (shot,) = list_shots(tmp_path)
    videos = VideoFrames()
    assert np.array_equal(shot.read(videos), np.rot90(SHOWN, turns))
    assert shot.upright.turns == turns
    assert np.array_equal(shot.upright.read(videos), SHOWN)


def test_a_large_view_that_was_turned_is_turned_where_it_is_read_again(tmp_path: Path) -> None:
    stored(tmp_path / "a.png", 6, 1)
    camera = Camera(1200, 900, 1000.0, 1000.0, 599.5, 449.5)
    focal = camera.fx, camera.fy
    intrinsics = Intrinsics("a", (1200, 900), focal, (None, None), None, Distortion.NONE)
    pose = Pose(np.eye(3), np.zeros(3))
    picture = PosedPicture("a.png", tmp_path / "a.png", intrinsics, pose, turns=1)
    view = ViewLoader().load(picture)
    assert isinstance(view, View)
    assert view.image.shape == (600, 800)
    assert view.stored is not None
    assert np.array_equal(view.stored.read(), SHOWN)


def test_its_camera_sees_points_where_the_stored_picture_has_them(tmp_path: Path) -> None:
    view = picture_of_view(posed(tmp_path / "a.png"), smooth_picture(), BENT)
    assert view.stored is not None
    ray = np.array([0.2, -0.1, 1.0])
    small, large = view.camera.matrix @ ray, view.stored.camera.matrix @ ray
    np.testing.assert_allclose(
        (small[:2] + 0.5) * view.enlargement - 0.5, large[:2], rtol=0, atol=1e-9
    )
