"""Small pictures are worked on enlarged, and answered in their own pixels."""

import cv2
import numpy as np
import pytest

from facetlog.perception.detection.working_size import at_working_size, in_own_pixels
from facetlog.perception.surfaces.reconstruct import reconstruct
from facetlog.perception.types import Camera, Observation, Track, View
from facetlog.robot.rendering.worlds import make_world
from tests.rendered import solid_truth, tour


def _halved(view: View) -> View:
    image = cv2.resize(view.image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    c = view.camera
    camera = Camera(
        image.shape[1],
        image.shape[0],
        c.fx / 2,
        c.fy / 2,
        (c.cx + 0.5) / 2 - 0.5,
        (c.cy + 0.5) / 2 - 0.5,
    )
    return View(view.name, image, camera, view.pose)


def test_a_point_enlarged_and_taken_back_is_where_it_was() -> None:
    small = _halved(tour("block", 0)[0])
    (large,), factor = at_working_size([small])
    assert factor == 2
    point = np.array([25.0, 55.0, 3.0, 1.0])
    own, other = (v.projection @ point for v in (small, large))
    seen = Observation(0, other[:2] / other[2], np.eye(2))
    (back,) = in_own_pixels(Track((seen,)), factor).observations
    assert back.uv == pytest.approx(own[:2] / own[2])
    assert back.cov == pytest.approx(np.eye(2) / 4)


def test_pictures_of_usual_size_stay_as_they_are() -> None:
    views = tour("block", 0)
    same, factor = at_working_size(views)
    assert factor == 1
    assert all(a is b for a, b in zip(views, same, strict=True))


def test_the_block_is_found_in_pictures_of_half_the_size() -> None:
    views = tuple(_halved(v) for v in tour("block", 0))
    scene = reconstruct(views, name="small")
    truth = np.array(solid_truth(make_world("block", 0)).vertices)
    assert len(scene.faces) == 5
    nearest = np.linalg.norm(scene.points[:, None] - truth[None], axis=-1).min(axis=1)
    assert nearest.max() < 0.1
