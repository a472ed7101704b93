"""The paper's camera: a pinhole on a pan-tilt head, equations (6) to (9).

Equation (9) as printed (pan about x, tilt about y, a stray 1 in the tilt matrix) does not give the
paper's own worked example; what does, to every printed digit, is the textbook head: pan A about
the vertical z axis, then tilt B about the horizontal image axis, then skew C about the optical
axis. With it the camera looks along (-sin A, cos A) over the ground: A = 0 looks to +y, 90° to -x.
B = -90° is level, B = -113° looks 23° down.
"""

import numpy as np

from facetlog.perception.types import FloatArray, Pose


def _make_rotation_x(angle: float) -> FloatArray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _make_rotation_z(angle: float) -> FloatArray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _make_world_from_image_frame(pan: float, tilt: float, skew: float) -> FloatArray:
    # The paper's frame: x to the left of the picture, y up, z along the view.
    return _make_rotation_z(pan + np.pi) @ _make_rotation_x(-tilt) @ _make_rotation_z(skew)


def pan_tilt_pose(x: float, y: float, z: float, pan: float, tilt: float, skew: float = 0.0) -> Pose:
    """Return the pose of a camera with its pinhole at (x, y, z); angles in radians, as the paper's
    A, B, C.

    >>> pose = pan_tilt_pose(0, 0, 0, pan=0.0, tilt=-np.pi / 2)
    >>> (pose.rotation @ [0, 0, 1]).round(9) + 0.0  # level, looks to +y
    array([0., 1., 0.])
    """
    # The paper's picture is u = -f X/Z, v = -f Y/Z: turned by 180° about the view it is OpenCV's.
    rotation = _make_world_from_image_frame(pan, tilt, skew) @ np.diag([-1.0, -1.0, 1.0])
    return Pose(rotation, np.array([x, y, z], dtype=np.float64))


def projection_matrix(
    x: float, y: float, z: float, pan: float, tilt: float, skew: float, focal: float
) -> FloatArray:
    """Return T of equation (9), (3, 4): world (homogeneous) to (ku, kv, k) on the image plane.

    u and v are in the unit of `focal`, from the principal point; angles in radians.
    """
    r = _make_world_from_image_frame(pan, tilt, skew).T
    c = np.array([x, y, z], dtype=np.float64)
    t = np.column_stack([r, -r @ c])
    t[2] /= -focal
    return t
