"""Pictures: what the renderer shows from there, smeared by motion, with noise of their own."""

import math

import numpy as np
import pytest

from facetlog.robot.rendering.render import render
from facetlog.robot.simulator.camera.process import Exposures
from facetlog.robot.simulator.camera.viewpoint import Viewpoint, make_camera
from facetlog.robot.simulator.world_file import CameraSetup, MountSetup, SceneSetup, make_scene

SCENE, MOUNT = make_scene(SceneSetup()), MountSetup().mount
SMALL = CameraSetup(width=160, height=120, noise=0.0, blur=0.5)
# looks at the block from 0.9 m
THERE = Viewpoint(0.59, 0.5, math.pi / 2, 0.0, math.radians(-35))


def turned(degrees: float) -> Viewpoint:
    return Viewpoint(THERE.x, THERE.y, THERE.heading, math.radians(degrees), THERE.tilt)


def exposures(setup: CameraSetup = SMALL) -> Exposures:
    return Exposures(SCENE, MOUNT, setup, np.random.default_rng(0))


def test_at_rest_it_is_the_renderers_picture() -> None:
    picture = exposures().expose(THERE, THERE)
    pose, rng = THERE.camera_pose(MOUNT), np.random.default_rng(0)
    expected = render(SCENE, make_camera(SMALL), pose, noise_sd=0.0, blur_px=0.5, rng=rng)
    assert np.array_equal(picture, expected)
    assert picture.max() > 200, "the block is in sight"


def test_each_exposure_has_noise_of_its_own() -> None:
    noisy = exposures(CameraSetup(width=160, height=120, noise=4.0))
    first, second = noisy.expose(THERE, THERE), noisy.expose(THERE, THERE)
    difference = first.astype(float) - second
    dark = first < 200  # not clipped at white
    assert difference[dark].std() == pytest.approx(4.0 * math.sqrt(2), rel=0.05)


@pytest.mark.parametrize(
    ("degrees", "limit"),
    [(0.8, 1.0), (2.0, 5.0), (6.0, 6.0)],
    ids=["whole size", "half size", "quarter size"],
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
