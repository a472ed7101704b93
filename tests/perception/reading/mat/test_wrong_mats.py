"""Boards, prints and pictures that look like those of a mat: allowed for, or named."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import cv2
import numpy as np
import pytest

from facetlog.errors import InputError
from facetlog.perception.reading.mat.mat_poses import MatSet, find_mat_pictures
from facetlog.perception.reading.mat.mats import Mat, MirroredError, OtherBoardError, sighting
from facetlog.perception.types import Image
from facetlog.robot.tour import make_ring_poses
from tests.perception.reading.mat.mat_photos import A4, SMALL, photo, write_photos

LARGER = SMALL.resized(960, 720)
POSES = make_ring_poses((0, 0, 0), 0.3, (0.2, 0.3), 8, jitter=0.1, rng=np.random.default_rng(3))


@cache
def pictures(stretch: float = 1.0) -> tuple[Image, ...]:
    """The mat from all poses."""
    return tuple(photo(A4, pose, seed=k, stretch=stretch) for k, pose in enumerate(POSES))


def bent(picture: Image, k1: float) -> Image:
    """The picture through a lens with this distortion."""
    columns, rows = np.meshgrid(np.arange(SMALL.width), np.arange(SMALL.height))
    pixels = np.stack([columns, rows], axis=-1).reshape(-1, 1, 2).astype(np.float64)
    straight = cv2.undistortPoints(
        pixels, SMALL.matrix, np.array([k1, 0.0, 0.0, 0.0]), P=SMALL.matrix
    )
    at = straight.reshape(SMALL.height, SMALL.width, 2).astype(np.float32)
    seen = cv2.remap(picture, at[..., 0], at[..., 1], cv2.INTER_CUBIC, borderValue=(120,))
    return np.asarray(seen, dtype=np.uint8)


def enlarged(picture: Image, zoom: float, aside: float = 0.0) -> Image:
    """The middle of the picture at its full size; by a share of the width aside."""
    height, width = picture.shape
    across, down = round(width / zoom), round(height / zoom)
    left, top = (width - across) // 2 + round(aside * width), (height - down) // 2
    part = picture[top : top + down, left : left + across]
    return np.asarray(cv2.resize(part, (width, height), interpolation=cv2.INTER_CUBIC))


def worst_distance(found: MatSet) -> float:
    """How far the cameras are off, at most, as a share of their distance."""
    off = []
    for each in found.pictures:
        true = POSES[int(each.picture.shot.path.stem)].centre
        off.append(np.linalg.norm(each.placed.pose.centre - true) / np.linalg.norm(true))
    return float(max(off))


@pytest.mark.parametrize("k1", [0.0, -0.2])
@pytest.mark.slow
def test_a_sound_set_has_no_fault_whatever_its_lens(k1: float, tmp_path: Path) -> None:
    found = find_mat_pictures(write_photos(tmp_path / "a", [bent(p, k1) for p in pictures()]))
    assert (len(found.pictures), found.faults) == (8, ())
    assert worst_distance(found) < 0.01


@pytest.mark.parametrize(
    ("columns", "rows", "square_mm", "share"),
    [(8, 6, 30.0, 0.75), (7, 5, 35.0, 0.75), (5, 7, 25.0, 0.6), (14, 10, 18.0, 0.75)],
)
@pytest.mark.slow
def test_a_board_of_another_layout_is_named(
    columns: int, rows: int, square_mm: float, share: float
) -> None:
    board = Mat("A4", 297.0, 210.0, columns, rows, square_mm, share * square_mm, first_marker=0)
    for pose in POSES[:3]:
        with pytest.raises(OtherBoardError, match="another board than facetlog's mat A4"):
            sighting(photo(board, pose, LARGER))


@pytest.mark.parametrize("share", [0.5, 0.65, 0.85])
def test_a_board_with_larger_or_smaller_markers_is_named(share: float) -> None:
    board = replace(A4, marker_mm=share * A4.square_mm)
    for pose in POSES[:3]:
        with pytest.raises(OtherBoardError):
            sighting(photo(board, pose, LARGER))


def test_no_picture_of_another_board_is_used(tmp_path: Path) -> None:
    board = Mat("A4", 297.0, 210.0, 8, 6, 30.0, 22.5, first_marker=0)
    folder = write_photos(tmp_path / "a", [photo(board, pose) for pose in POSES[:3]])
    with pytest.raises(InputError, match="each of 3 pictures shows another board") as caught:
        find_mat_pictures(folder)
    assert "\n" not in str(caught.value)


@pytest.mark.slow
def test_mirrored_pictures_are_named_and_left_out(tmp_path: Path) -> None:
    mirrored = [np.ascontiguousarray(p[:, ::-1]) for p in pictures()]
    with pytest.raises(MirroredError):
        sighting(mirrored[0])
    folder = write_photos(tmp_path / "some", [*pictures()[:6], *mirrored[6:]])
    found = find_mat_pictures(folder)
    assert len(found.pictures) == 6
    assert all("is mirrored" in each.line for each in found.left_out)
    assert worst_distance(found) < 0.01
    with pytest.raises(InputError, match="each of 3 pictures is mirrored"):
        find_mat_pictures(write_photos(tmp_path / "all", mirrored[:3]))


@pytest.mark.parametrize(("zoom", "every"), [(1.2, 2), (2.0, 8)])
@pytest.mark.slow
def test_zoomed_pictures_have_a_camera_of_their_own(
    zoom: float, every: int, tmp_path: Path
) -> None:
    mixed = [enlarged(p, zoom) if k % every == 1 else p for k, p in enumerate(pictures())]
    found = find_mat_pictures(write_photos(tmp_path / "a", mixed))
    assert worst_distance(found) < 0.01
    (fault,) = found.faults
    assert "are zoomed or cropped" in fault or "is zoomed or cropped" in fault
    focals = sorted({each.camera.focal for each in found.pictures})
    assert focals == pytest.approx([SMALL.fx, zoom * SMALL.fx], rel=0.02)


@pytest.mark.slow
def test_pictures_that_were_cropped_aside_are_named(tmp_path: Path) -> None:
    aside = [enlarged(p, 1.3, 0.11) for p in pictures()]
    found = find_mat_pictures(write_photos(tmp_path / "a", aside))
    assert any("off the middle" in fault for fault in found.faults)


@pytest.mark.parametrize("stretch", [0.97, 1.01])
@pytest.mark.slow
def test_a_print_that_is_longer_one_way_is_named_and_allowed_for(
    stretch: float, tmp_path: Path
) -> None:
    found = find_mat_pictures(write_photos(tmp_path / "a", pictures(stretch)))
    (fault,) = found.faults
    assert ("% longer" if stretch > 1 else "% shorter") in fault
    assert worst_distance(found) < 0.01
