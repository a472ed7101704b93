"""Pictures of a folder that are read as their EXIF says that they are shown, or as stored."""

from pathlib import Path

import numpy as np
import pytest
from PIL import ExifTags, Image

from facetlog.perception.reading.lens import Distortion, Lens
from facetlog.perception.reading.picture_of_view import picture_as_stored, picture_of_view
from facetlog.perception.reading.pose_files.poses_file import Intrinsics, PosedPicture
from facetlog.perception.reading.shots import shots_in
from facetlog.perception.reading.video_file import VideoFrames
from facetlog.perception.types import Camera, Pose

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
    (shot,) = shots_in(tmp_path)
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
    image = picture_as_stored(picture, VideoFrames())
    view = picture_of_view(picture, image, Lens(camera))
    assert view.image.shape == (600, 800)
    assert view.stored is not None
    assert np.array_equal(view.stored.read(), SHOWN)
