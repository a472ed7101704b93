"""Small pictures are worked on enlarged, and answered in their own pixels."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from facetlog.perception.detection.picture_noise import working_noise
from facetlog.perception.detection.working_size import at_working_size, in_own_pixels, segment_noise
from facetlog.perception.surfaces.reconstruct import reconstruct
from facetlog.perception.types import Camera, Image, Observation, Track, View
from facetlog.robot.rendering.worlds import make_world
from tests.rendered import solid_truth, tour


def _camera(image: Image) -> Camera:
    return tour("block", 0)[0].camera.resized(image.shape[1], image.shape[0])


def _halved(view: View) -> View:
    image = cv2.resize(view.image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    camera = view.camera.resized(image.shape[1], image.shape[0])
    return View(view.name, image, camera, view.pose)


def test_a_point_enlarged_and_taken_back_is_where_it_was() -> None:
    small = _halved(tour("block", 0)[0])
    (large,), factors = at_working_size([small])
    assert factors == (2,)
    point = np.array([25.0, 55.0, 3.0, 1.0])
    own, other = (v.projection @ point for v in (small, large))
    seen = Observation(0, other[:2] / other[2], np.eye(2))
    (back,) = in_own_pixels(Track((seen,)), factors).observations
    assert back.uv == pytest.approx(own[:2] / own[2])
    assert back.cov == pytest.approx(np.eye(2) / 4)


def test_pictures_of_usual_size_stay_as_they_are() -> None:
    views = tour("block", 0)
    same, factors = at_working_size(views)
    assert set(factors) == {1}
    assert all(a is b for a, b in zip(views, same, strict=True))


def test_each_picture_is_enlarged_as_it_needs() -> None:
    large = tour("block", 0)[0]
    small = _halved(large)
    _, factors = at_working_size([large, small, _halved(small)])
    assert factors == (1, 2, 4)


@pytest.mark.parametrize("factor", [2, 4])
def test_an_enlarged_picture_is_as_noisy_as_the_detector_feels_it(factor: int) -> None:
    random = np.random.default_rng(0)
    noisy = random.normal(128, 10, (480 // factor, 640 // factor)).clip(0, 255).astype(np.uint8)
    small = replace(tour("block", 0)[0], image=noisy, camera=_camera(noisy))
    (large,), factors = at_working_size([small])
    assert factors == (factor,)

    def slope(image: Image) -> float:
        # The detector smooths by .75 px, shrinks to .8 and takes differences of 2 x 2 pixels.
        smooth = cv2.GaussianBlur(image.astype(np.float32), (0, 0), 0.75)
        g = cv2.resize(smooth, None, fx=0.8, fy=0.8, interpolation=cv2.INTER_LINEAR)
        return float((g[:-1, 1:] + g[1:, 1:] - g[:-1, :-1] - g[1:, :-1]).std())

    usual = random.normal(128, 10, (480, 640)).clip(0, 255).astype(np.uint8)
    expected = working_noise(usual) * slope(large.image) / slope(usual)
    assert segment_noise(small, factor) == pytest.approx(expected, rel=0.1)


def test_the_block_is_found_in_pictures_of_half_the_size() -> None:
    views = tuple(_halved(v) for v in tour("block", 0))
    scene = reconstruct(views, name="small")
    truth = np.array(solid_truth(make_world("block", 0)).vertices)
    assert len(scene.faces) == 5
    nearest = np.linalg.norm(scene.points[:, None] - truth[None], axis=-1).min(axis=1)
    assert nearest.max() < 0.1
