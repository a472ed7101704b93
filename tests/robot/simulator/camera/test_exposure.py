"""Pictures: what the renderer shows from there, smeared by motion, with noise of their own."""

import math

import numpy as np
import pytest

from facetlog.robot.rendering.render import render
from facetlog.robot.simulator.camera.process import Exposures, measure_smear_px
from facetlog.robot.simulator.camera.viewpoint import Viewpoint, camera_pose, make_camera
from facetlog.robot.simulator.world_file import CameraSetup, MountSetup, SceneSetup, make_scene

SCENE, MOUNT = make_scene(SceneSetup()), MountSetup()
SMALL = CameraSetup(width=160, height=120, noise=0.0, blur=0.5)
# looks at the block from 0.9 m
THERE = Viewpoint(0.59, 0.5, math.pi / 2, 0.0, math.radians(-35))


def turned(degrees: float) -> Viewpoint:
    return Viewpoint(THERE.x, THERE.y, THERE.heading, math.radians(degrees), THERE.tilt)


def exposures(setup: CameraSetup = SMALL) -> Exposures:
    return Exposures(SCENE, MOUNT, setup, np.random.default_rng(0))


def test_at_rest_it_is_the_renderers_picture() -> None:
    picture = exposures().expose(THERE, THERE)
    pose, rng = camera_pose(THERE, MOUNT), np.random.default_rng(0)
    expected = render(SCENE, make_camera(SMALL), pose, noise_sd=0.0, blur_px=0.5, rng=rng)
    assert np.array_equal(picture, expected)
    assert picture.max() > 200, "the block is in sight"


def test_each_exposure_has_noise_of_its_own() -> None:
    noisy = exposures(CameraSetup(width=160, height=120, noise=4.0))
    first, second = noisy.expose(THERE, THERE), noisy.expose(THERE, THERE)
    difference = first.astype(float) - second
    dark = first < 200  # not clipped at white
    assert difference[dark].std() == pytest.approx(4.0 * math.sqrt(2), rel=0.05)


def test_after_a_move_the_picture_shows_the_new_place() -> None:
    camera = exposures()
    before = camera.expose(THERE, THERE)
    after = camera.expose(turned(5), turned(5))
    assert not np.array_equal(before, after)
    assert np.array_equal(camera.expose(THERE, THERE), before)


@pytest.mark.parametrize(
    ("degrees", "limit"),
    [(0.5, 1.0), (0.8, 1.0), (2.0, 5.0), (6.0, 6.0)],
    ids=["whole size", "whole size, more", "half size", "quarter size"],
)
def test_a_moving_camera_takes_the_mean_of_what_it_passes(degrees: float, limit: float) -> None:
    camera = exposures()
    picture = camera.expose(turned(-degrees / 2), turned(degrees / 2)).astype(float)
    shares = (np.arange(30) + 0.5) / 30 - 0.5
    passed = [camera.expose(turned(degrees * s), turned(degrees * s)) for s in shares]
    expected = np.mean(passed, axis=0)
    inner = np.s_[15:-15, 15:-15]
    off = picture[inner] - expected[inner]
    assert np.sqrt((off**2).mean()) < limit, "of 255 grey levels"


def test_smear_is_what_turning_moves_the_middle_of_the_picture() -> None:
    camera = make_camera(SMALL)
    start, end = camera_pose(turned(0), MOUNT), camera_pose(turned(1), MOUNT)
    moved = measure_smear_px(camera, start, end)
    assert moved == pytest.approx(camera.fx * math.radians(1), rel=0.5)
    assert measure_smear_px(camera, start, start) == pytest.approx(0.0, abs=1e-9)


def test_motion_blurs_edges_across_it() -> None:
    still = exposures().expose(THERE, THERE).astype(float)
    moving = exposures().expose(turned(-1.5), turned(1.5)).astype(float)
    assert np.abs(np.diff(moving, axis=1)).max() < 0.6 * np.abs(np.diff(still, axis=1)).max()
