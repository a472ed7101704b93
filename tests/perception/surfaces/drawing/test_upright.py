"""Pictures that lie on their side are turned, and the scene in them with it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from facetlog.perception.surfaces.drawing.upright import turn_pixel, upright
from facetlog.perception.types import Camera, FloatArray, View
from facetlog.robot.tour import make_pose_looking_at

UP = np.array([0.0, 0.0, 1.0])
CAMERA = Camera(40, 30, 31.0, 29.0, 18.0, 15.5)


def held(quarters: int, roll_deg: float = 0.0) -> View:
    """A view from the side whose camera is rotated about its line of sight, clockwise."""
    pose = make_pose_looking_at([3.0, 1.0, 1.5], [0.0, 0.0, 0.5])
    about = Rotation.from_euler("z", 90 * quarters + roll_deg, degrees=True).as_matrix()
    image = np.arange(30 * 40, dtype=np.uint16).reshape(30, 40).astype(np.uint8)
    return View("a.png", image, CAMERA, replace(pose, rotation=pose.rotation @ about))


def pixel(view: View, point: FloatArray) -> FloatArray:
    """Where a point (3,) is in the picture, (2,)."""
    u, v, depth = view.projection @ [*point, 1.0]
    return np.array([u, v]) / depth


@given(st.integers(-4, 4), st.floats(-40, 40), st.lists(st.floats(-1, 1), min_size=3, max_size=3))
def test_up_is_up_and_all_lies_where_it_lay(
    quarters: int, roll_deg: float, place: list[float]
) -> None:
    view = held(quarters, roll_deg)
    shown, turns = upright(view, UP)
    x, y, _ = shown.pose.rotation.T @ UP
    assert y < -abs(x)
    point = np.array(place)
    np.testing.assert_allclose(
        pixel(shown, point), turn_pixel(pixel(view, point), view, turns), atol=1e-9
    )
    column, row = turn_pixel(np.array([7.0, 11.0]), view, turns).astype(int)
    assert shown.image[row, column] == view.image[11, 7]


@pytest.mark.parametrize("up", [None, UP])
def test_what_is_not_known_to_lie_is_left_as_it_is(up: FloatArray | None) -> None:
    above = replace(held(0), pose=make_pose_looking_at([0.01, 0.0, 3.0], [0.0, 0.0, 0.0]))
    assert upright(above, up) == (above, 0)
