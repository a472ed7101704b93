"""Pictures that show nothing, or the same at several poses, are named."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from facetlog.errors import InputError
from facetlog.perception.detection.picture_faults import (
    blur_px,
    find_picture_fault,
    find_same_pictures,
    select_usable_views,
)
from facetlog.perception.types import Camera, Image, Pose, View
from tests.rendered import tour

CAMERA = Camera(320, 240, 300.0, 300.0, 159.5, 119.5)


def step(blur: float, contrast: float = 120.0, noise: float = 2.0, seed: int = 0) -> Image:
    """A bright disc with an edge of this blur, sd in px."""
    v, u = np.mgrid[:240, :320]
    sharp = 60.0 + contrast * (np.hypot(u - 160, v - 120) < 70)
    image = cv2.GaussianBlur(sharp, (0, 0), blur) if blur else sharp
    image = image + np.random.default_rng(seed).normal(0, noise, image.shape)
    return np.clip(np.rint(image), 0, 255).astype(np.uint8)


def flat(level: float, noise: float = 3.0) -> Image:
    image = level + np.random.default_rng(1).normal(0, noise, (240, 320))
    return np.clip(np.rint(image), 0, 255).astype(np.uint8)


def views_of(*images: Image) -> tuple[View, ...]:
    return tuple(
        View(f"{k}.png", image, CAMERA, Pose(np.eye(3), np.array([float(k), 0.0, 0.0])))
        for k, image in enumerate(images)
    )


@pytest.mark.parametrize(
    ("level", "noise", "fault"),
    [
        (0, 0, "black"),
        (252, 3, "saturated"),
        (128, 12, "of one grey level"),
    ],
)
def test_a_picture_without_contrast_is_named(level: float, noise: float, fault: str) -> None:
    assert find_picture_fault(flat(level, noise)) == fault


@pytest.mark.parametrize("blur", [1.5, 5.0])
def test_blur_is_measured_in_pixels(blur: float) -> None:
    assert blur_px(step(blur)) == pytest.approx(blur, rel=0.25)


def test_a_black_picture_among_others_is_named_and_left_out() -> None:
    views = views_of(step(1.0), flat(3), step(1.0), flat(2), step(1.0), flat(254))
    left, warnings = select_usable_views(views)
    assert [v.name for v in left] == ["0.png", "2.png", "4.png"]
    assert warnings == ("1.png, 3.png: black, left out", "5.png: saturated, left out")


def test_only_black_pictures_are_an_error_that_says_so() -> None:
    with pytest.raises(InputError, match=r"all 24 pictures are black \(0\.png, 1\.png, 2\.png"):
        select_usable_views(views_of(*[flat(3)] * 24))


def test_a_picture_much_more_blurred_than_the_others_is_named_and_left_out() -> None:
    views = views_of(*(step(4.0 if k == 3 else 1.0, seed=k) for k in range(8)))
    left, (warning,) = select_usable_views(views)
    assert [v.name for v in left] == [v.name for v in views if v.name != "3.png"]
    assert warning.startswith("3.png: blurred by up to 3.5 px, the other pictures by 0.9")


def test_where_most_pictures_are_blurred_these_are_named_and_all_stay() -> None:
    views = views_of(*(step(1.0 if k < 3 else 4.0, seed=k) for k in range(10)))
    left, (warning,) = select_usable_views(views)
    assert left == views
    assert warning.startswith("7 of 10 pictures are blurred by about 3.")
    assert "(3.png, 4.png, 5.png and 4 more)" in warning


@pytest.mark.slow
def test_sharp_pictures_of_a_tour_are_not_called_blurred() -> None:
    assert select_usable_views(tour("stool"))[1] == ()


def test_the_order_does_not_matter() -> None:
    views = views_of(*(step(4.0 if k == 3 else 1.0, seed=k) for k in range(8)), flat(3))
    backwards, _ = select_usable_views(views[::-1])
    assert backwards[::-1] == select_usable_views(views)[0]


@pytest.mark.parametrize("shape", [(1, 1), (480, 8)])
def test_a_picture_of_hardly_a_pixel_is_too_small(shape: tuple[int, int]) -> None:
    image = np.random.default_rng(0).integers(0, 255, shape, dtype=np.uint8)
    assert find_picture_fault(image) == f"too small ({shape[1]} x {shape[0]})"


SMALL = Camera(64, 48, 60.0, 60.0, 31.5, 23.5)


def view(k: int, picture: int) -> View:
    image = np.random.default_rng(picture).integers(0, 255, (48, 64), dtype=np.uint8)
    return View(f"{k}.png", image, SMALL, Pose(np.eye(3), np.array([float(k), 0.0, 0.0])))


def test_pictures_that_differ_are_no_fault() -> None:
    assert find_same_pictures([view(k, k) for k in range(5)]) == ()


def test_a_picture_at_two_poses_is_named() -> None:
    views = [view(k, 1 if k in (1, 4) else 10 + k) for k in range(6)]
    (warning,) = find_same_pictures(views)
    assert warning.startswith("1.png, 4.png: one and the same picture at different poses")


def test_a_picture_given_twice_at_its_pose_contradicts_nothing() -> None:
    first = view(0, 7)
    assert find_same_pictures([first, replace(first, name="again.png"), view(1, 1)]) == ()
