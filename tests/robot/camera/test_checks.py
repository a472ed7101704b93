"""Blur and exposure, on rendered views of the paper's tour."""

import cv2
import numpy as np
import pytest

from facetlog.perception.types import Image
from facetlog.robot.camera.checks import CLIPPED_SHARE, Quality, faults_of, quality_of
from facetlog.robot.rendering.views import views_of
from facetlog.robot.rendering.worlds import make_world
from facetlog.robot.tour import tour_camera, tour_poses

SHARP = tuple(
    view.image for view in views_of(make_world("block", 1), tour_poses()[::5], tour_camera())
)
QUALITIES = tuple(quality_of(image) for image in SHARP)


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


@pytest.mark.parametrize("index", range(len(SHARP)))
@pytest.mark.parametrize("size", [(9, 1), (1, 9)])
def test_a_motion_by_nine_pixels_is_found_in_every_view(index: int, size: tuple[int, int]) -> None:
    found = faults_of(quality_of(_blurred(SHARP[index], size)), _others(index))
    assert len(found) == 1
    assert found[0].startswith("blurred: ")


def test_noise_does_not_pass_for_sharpness() -> None:
    noisy = SHARP[0] + np.random.default_rng(0).normal(0, 12, SHARP[0].shape)
    louder = quality_of(np.clip(noisy, 0, 255).astype(np.uint8))
    assert louder.across == pytest.approx(QUALITIES[0].across, rel=0.5)
    assert louder.down == pytest.approx(QUALITIES[0].down, rel=0.5)
    flat = np.full((480, 640), 120.0) + np.random.default_rng(1).normal(0, 12, (480, 640))
    assert quality_of(flat.astype(np.uint8)).sharpness < QUALITIES[0].sharpness


def test_colour_is_judged_as_grey_is() -> None:
    colour = cv2.cvtColor(SHARP[0], cv2.COLOR_GRAY2BGR)
    assert quality_of(np.asarray(colour, dtype=np.uint8)) == QUALITIES[0]


def test_of_fewer_than_three_others_nothing_follows() -> None:
    poor = Quality(1e-3, 1.0, 0.0)
    assert faults_of(poor, QUALITIES[:2]) == ()
    assert faults_of(poor, QUALITIES[:3])


def test_pictures_without_any_edge_are_compared_without_error() -> None:
    flat = quality_of(np.full((60, 80), 100, np.uint8))
    assert faults_of(flat, (flat, flat, flat)) == ()


@pytest.mark.parametrize("grey", [0, 255])
def test_a_picture_clipped_by_more_than_a_fifth_is_reported(grey: int) -> None:
    image = SHARP[0].copy()
    rows = round(image.shape[0] * (CLIPPED_SHARE + 0.05))
    image[:rows] = grey
    assert any(fault.startswith("badly exposed: 2") for fault in faults_of(quality_of(image), ()))
    assert faults_of(QUALITIES[0], ()) == ()
