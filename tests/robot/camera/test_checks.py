"""Blur and exposure, on rendered views of the paper's tour."""

import math

import cv2
import numpy as np
import pytest

from facetlog.perception.types import Image
from facetlog.robot.camera.checks import CLIPPED_SHARE, Quality, faults_of, measure_quality
from facetlog.robot.rendering.views import views_of
from facetlog.robot.rendering.worlds import make_world
from facetlog.robot.tour import tour_camera, tour_poses

SHARP = tuple(
    view.image for view in views_of(make_world("block", 1), tour_poses()[::5], tour_camera())
)
QUALITIES = tuple(measure_quality(image) for image in SHARP)


def _others(index: int) -> tuple[Quality, ...]:
    return (*QUALITIES[:index], *QUALITIES[index + 1 :])


def _blurred(image: Image, size: tuple[int, int], *, noise_sd: float = 5.0) -> Image:
    """As a motion by so many pixels across or down makes it, with the sensor's noise after it."""
    rng = np.random.default_rng(2)
    smooth = cv2.blur(image.astype(np.float64), size)
    return np.clip(smooth + rng.normal(0.0, noise_sd, image.shape), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("index", range(len(SHARP)))
def test_sharp_views_of_a_tour_pass(index: int) -> None:
    assert faults_of(QUALITIES[index], _others(index)) == ()


@pytest.mark.parametrize("index", [0, 3])
@pytest.mark.parametrize("size", [(9, 1), (1, 9)])
def test_a_motion_by_nine_pixels_is_found_in_every_view(index: int, size: tuple[int, int]) -> None:
    found = faults_of(measure_quality(_blurred(SHARP[index], size)), _others(index))
    assert len(found) == 1
    assert found[0].startswith("blurred across by " if size[0] > 1 else "blurred down by ")


@pytest.mark.parametrize(
    ("length", "contrast", "noise_sd"), [(9, 20.0, 2.0), (9, 120.0, 8.0), (15, 120.0, 0.0)]
)
def test_the_blur_of_an_edge_is_that_of_the_motion_whatever_its_contrast(
    length: int, contrast: float, noise_sd: float
) -> None:
    step = np.full((240, 320), 60.0)
    step[:, 160:] += contrast
    rng = np.random.default_rng(3)
    moved = cv2.blur(step, (length, 1)) + rng.normal(0.0, noise_sd, step.shape)
    found = measure_quality(np.clip(np.rint(moved), 0, 255).astype(np.uint8))
    # A motion at constant speed: the standard deviation of what is even over its length.
    assert found.across == pytest.approx(length / math.sqrt(12.0), rel=0.25)
    assert found.down is None


def test_noise_is_neither_an_edge_nor_blur() -> None:
    noisy = SHARP[0] + np.random.default_rng(0).normal(0, 12, SHARP[0].shape)
    louder = measure_quality(np.clip(noisy, 0, 255).astype(np.uint8))
    assert louder.across == pytest.approx(QUALITIES[0].across, abs=0.4)
    assert louder.down == pytest.approx(QUALITIES[0].down, abs=0.4)
    flat = np.full((480, 640), 120.0) + np.random.default_rng(1).normal(0, 12, (480, 640))
    assert measure_quality(flat.astype(np.uint8)) == Quality(None, None, 0.0)


@pytest.mark.parametrize("speckles", [0.0, 0.15])
def test_a_view_of_plain_floor_is_not_blurred_among_views_of_things(speckles: float) -> None:
    """Nor is one of print without end among views of edges, or the other way round."""
    rng = np.random.default_rng(7)
    print_ = np.where(rng.random((480, 640)) < speckles, 90.0, 130.0)
    floor = cv2.GaussianBlur(print_, (0, 0), 0.6) + rng.normal(0.0, 4.0, print_.shape)
    plain = measure_quality(np.clip(floor, 0, 255).astype(np.uint8))
    assert faults_of(plain, QUALITIES) == ()
    for index, quality in enumerate(QUALITIES):
        assert faults_of(quality, (*_others(index), *[plain] * 6)) == ()


def test_of_fewer_than_three_others_nothing_follows() -> None:
    poor = Quality(3.0, 0.6, 0.0)
    assert faults_of(poor, QUALITIES[:2]) == ()
    assert faults_of(poor, QUALITIES[:3])
    # Nor do pictures without edges tell how sharp one with edges may be.
    bare = Quality(None, None, 0.0)
    assert faults_of(poor, (*QUALITIES[:2], bare, bare)) == ()
    assert faults_of(bare, QUALITIES) == ()


@pytest.mark.parametrize("grey", [0, 255])
def test_a_picture_clipped_by_more_than_a_fifth_is_reported(grey: int) -> None:
    image = SHARP[0].copy()
    rows = round(image.shape[0] * (CLIPPED_SHARE + 0.05))
    image[:rows] = grey
    assert any(
        fault.startswith("badly exposed: 2") for fault in faults_of(measure_quality(image), ())
    )
    assert faults_of(QUALITIES[0], ()) == ()
