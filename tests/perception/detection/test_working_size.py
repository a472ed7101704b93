"""Small pictures are worked on enlarged, and answered in their own pixels."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from facetlog.perception.detection.coarse_pictures import coarse_pictures, gradient
from facetlog.perception.detection.edge_maps import edge_map
from facetlog.perception.detection.segments import ENLARGED
from facetlog.perception.detection.working_size import (
    enlarge_to_working_size,
    measure_working_noises,
    to_own_pixels,
)
from facetlog.perception.surfaces.reconstruct import reconstruct
from facetlog.perception.types import Camera, Image, Observation, Track, View
from facetlog.robot.rendering.worlds import make_world
from tests.rendered import get_solid_truth, tour


def _camera(image: Image) -> Camera:
    return tour("block", 0)[0].camera.resized(image.shape[1], image.shape[0])


def _halved(view: View) -> View:
    image = cv2.resize(view.image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    camera = view.camera.resized(image.shape[1], image.shape[0])
    return View(view.name, image, camera, view.pose)


def test_a_point_enlarged_and_taken_back_is_where_it_was() -> None:
    small = _halved(tour("block", 0)[0])
    (large,), factors = enlarge_to_working_size([small])
    assert factors == (2,)
    point = np.array([25.0, 55.0, 3.0, 1.0])
    own, other = (v.projection @ point for v in (small, large))
    seen = Observation(0, other[:2] / other[2], np.eye(2))
    (back,) = to_own_pixels(Track((seen,)), factors).observations
    assert back.uv == pytest.approx(own[:2] / own[2])
    assert back.cov == pytest.approx(np.eye(2) / 4)


def _noisy(factor: int, sd: float) -> View:
    random = np.random.default_rng(0)
    image = random.normal(128, sd, (480 // factor, 640 // factor)).clip(0, 255).astype(np.uint8)
    return replace(tour("block", 0)[0], image=image, camera=_camera(image))


def _felt(image: Image) -> float:
    # The detector smooths by .75 px, shrinks to .8 and takes differences of 2 x 2 pixels.
    smooth = cv2.GaussianBlur(image.astype(np.float32), (0, 0), 0.75)
    g = cv2.resize(smooth, None, fx=0.8, fy=0.8, interpolation=cv2.INTER_LINEAR)
    return float((g[:-1, 1:] + g[1:, 1:] - g[:-1, :-1] - g[1:, :-1]).std())


@pytest.mark.parametrize("factor", [2, 4])
def test_an_enlarged_picture_is_as_noisy_as_the_detector_feels_it(factor: int) -> None:
    (large,), _ = enlarge_to_working_size([_noisy(factor, 10.0)])
    assert ENLARGED[factor] == pytest.approx(_felt(large.image) / _felt(_noisy(1, 10.0).image), 0.1)


@pytest.mark.parametrize("factor", [2, 4])
def test_the_gradients_of_an_enlarged_picture_are_as_noisy_as_its_noise_says(factor: int) -> None:
    small = _noisy(factor, 10.0)
    (large,), factors = enlarge_to_working_size([small])
    (noise,) = measure_working_noises([small], factors)
    assert noise.sd == pytest.approx(10.0, rel=0.05)
    edges = edge_map(large.image, own_noise=noise)
    assert edges.gradient_noise == pytest.approx(_spread(large.image), rel=0.1)
    for coarse in coarse_pictures(large.image, noise):
        assert coarse.grain < 0.35 * coarse.noise


def _spread(image: Image) -> float:
    slope = gradient(image)
    return float(np.stack([slope.gx, slope.gy]).std())


@pytest.mark.slow
def test_the_block_is_found_in_pictures_of_half_the_size() -> None:
    views = tuple(_halved(v) for v in tour("block", 0))
    scene = reconstruct(views, name="small")
    truth = np.array(get_solid_truth(make_world("block", 0)).vertices)
    assert len(scene.faces) == 5
    nearest = np.linalg.norm(scene.points[:, None] - truth[None], axis=-1).min(axis=1)
    assert nearest.max() < 0.1
