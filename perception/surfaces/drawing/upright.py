"""Views as a person looks at them: of pictures that a camera took lying on its side, turned."""

from dataclasses import replace

import numpy as np

from facetlog.perception.types import Camera, FloatArray, Pose, View

# Looked at from straight above a picture has no way up: that is asked for from this sine of the
# angle between up and the line of sight on (20 degrees).
LEAST_SINE = 0.34


def upright(view: View, up: FloatArray | None) -> tuple[View, int]:
    """Return the view turned by quarters of a circle until `up` (3,), in the world, is about up in
    it, and by how many, clockwise: 0 where up is not known, or is along the line of sight.

    Camera and pose are turned with the picture, so that all of the scene lies in it as before;
    `stored` is left out.
    """
    turns = 0 if up is None else _turns(view.pose.rotation.T @ up)
    shown = view
    for _ in range(turns):
        shown = _turn_by_quarter(shown)
    return shown, turns


def turn_pixel(uv: FloatArray, view: View, turns: int) -> FloatArray:
    """Return where a pixel (2,) of a view is when its picture is turned by so many quarters,
    clockwise.
    """
    height, width = view.image.shape
    for _ in range(turns):
        uv, height, width = np.array([height - 1.0 - uv[1], uv[0]]), width, height
    return uv


def _turns(up: FloatArray) -> int:
    """Return by how many quarters to turn, clockwise; `up` (3,) is in the camera's frame: right,
    down, forward.
    """
    if float(np.hypot(up[0], up[1])) < LEAST_SINE * float(np.linalg.norm(up)):
        return 0
    # The angle, clockwise, from the picture's up to the direction in which up is.
    angle = float(np.arctan2(up[0], -up[1]))
    return round(-angle / (np.pi / 2)) % 4


def _turn_by_quarter(view: View) -> View:
    """Turn the picture clockwise by a quarter: what is right comes to lie below."""
    c, rotation = view.camera, view.pose.rotation
    height, width = view.image.shape
    camera = Camera(height, width, c.fy, c.fx, height - 1.0 - c.cy, c.cx)
    right, down, forward = rotation.T
    pose = Pose(np.column_stack([-down, right, forward]), view.pose.centre)
    image = np.ascontiguousarray(np.rot90(view.image, -1))
    return replace(view, image=image, camera=camera, pose=pose, stored=None, pose_cov=None)
