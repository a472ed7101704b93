"""From the robot's place and the head's angles to the camera's pose, and back.

The chain is the paper's: pinhole = robot ∘ mount ∘ pan-tilt ∘ pinhole offset. Its angles A and B
(perception/pan_tilt.py) are those of a level mount: A = heading + yaw + pan - 90°, B = tilt - 90°.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation

from facetlog.perception.types import FloatArray, Pose
from facetlog.robot.mount.mount import Mount
from facetlog.robot.pose2 import Pose2

# From OpenCV's camera (x right, y down, z along the view) to a frame with x along it and z up.
AHEAD_FROM_CAMERA = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
# Fixed-point iteration: the angles depend on the pinhole's place, and that on the angles through an
# offset of centimetres over metres of distance. Each round leaves about that ratio of the error,
# ten leave nothing.
ROUNDS = 10
# For numerical derivatives, metres and radians: the cube root of the precision of a double.
STEP = 6e-6


@dataclass(frozen=True, slots=True)
class Gaze:
    """Pan and tilt of the head, radians: pan to the left and tilt up are positive."""

    pan: float
    tilt: float


def _about(axis: int, angle: ArrayLike) -> FloatArray:
    """Return rotation(s) (..., 3, 3) about x (0), y (1) or z (2) by angle(s) (...)."""
    turned = np.asarray(angle, dtype=np.float64)
    c, s = np.cos(turned), np.sin(turned)
    matrix = np.zeros((*turned.shape, 3, 3))
    first, second = (axis + 1) % 3, (axis + 2) % 3
    matrix[..., axis, axis] = 1.0
    matrix[..., first, first] = matrix[..., second, second] = c
    matrix[..., first, second], matrix[..., second, first] = -s, s
    return matrix


def _rotate_robot_from_head(mount: Mount) -> FloatArray:
    return _about(2, mount.yaw) @ _about(1, mount.pitch) @ _about(0, mount.roll)


def _rotate_head_from_axes(mount: Mount, pan: ArrayLike, tilt: ArrayLike) -> FloatArray:
    """Return the frame that turns with both axes, x along the view if there is no skew."""
    raised = np.asarray(tilt, dtype=np.float64) + mount.tilt_zero
    return _about(2, pan) @ _about(1, -raised)


def _locate_pinhole_in_robot(mount: Mount, axes: FloatArray) -> FloatArray:
    """Return places (..., 3), for `_rotate_head_from_axes` (..., 3, 3)."""
    offset = np.array([mount.pinhole_ahead, mount.pinhole_left, mount.pinhole_up])
    return np.asarray([mount.x, mount.y, mount.z] + _rotate_robot_from_head(mount) @ axes @ offset)


def compute_camera_frames(
    places: FloatArray, mount: Mount, gazes: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return rotations (..., 3, 3) and centres (..., 3) of cameras, as in `camera_pose`.

    `places` (..., 3) are x, y, heading of the robot, `gazes` (..., 2) pan and tilt.
    """
    turn = _about(2, places[..., 2])
    axes = _rotate_head_from_axes(mount, gazes[..., 0], gazes[..., 1])
    rotation = (
        turn @ _rotate_robot_from_head(mount) @ axes @ _about(0, mount.skew) @ AHEAD_FROM_CAMERA
    )
    centre = (turn @ _locate_pinhole_in_robot(mount, axes)[..., None])[..., 0]
    centre[..., :2] += places[..., :2]
    return rotation, centre


def camera_pose(robot: Pose2, mount: Mount, gaze: Gaze) -> Pose:
    """Return pose of the camera in the world, of a robot at `robot` in the world.

    >>> camera_pose(Pose2(1.0, 2.0, 0.0), Mount(z=0.7), Gaze(0.0, 0.0)).rotation @ [0, 0, 1]
    array([1., 0., 0.])
    """
    place = np.array([robot.x, robot.y, robot.heading])
    return Pose(*compute_camera_frames(place, mount, np.array([gaze.pan, gaze.tilt])))


def find_gaze(robot: Pose2, mount: Mount, point: FloatArray) -> Gaze:
    """Return the angles at which the optical axis goes through `point` (3,) in the world."""
    turn = _about(2, robot.heading)
    place = np.array([robot.x, robot.y, 0.0])
    gaze = Gaze(0.0, 0.0)
    for _ in range(ROUNDS):
        pinhole = place + turn @ _pinhole(mount, gaze)
        gaze = _find_gaze(turn, mount, point - pinhole)
    return gaze


def stand_for(
    pinhole: tuple[float, float], heading: float, mount: Mount, point: FloatArray
) -> tuple[Pose2, Gaze]:
    """Return where the robot stands, and the angles, so that the pinhole is above `pinhole` (x, y).

    The robot's heading is given; the optical axis goes through `point` (3,). The pinhole's height
    is what the mount makes it.
    """
    turn = _about(2, heading)
    gaze = Gaze(0.0, 0.0)
    for _ in range(ROUNDS):
        offset = turn @ _pinhole(mount, gaze)
        gaze = _find_gaze(turn, mount, point - np.array([*pinhole, offset[2]]))
    offset = turn @ _pinhole(mount, gaze)
    return Pose2(pinhole[0] - float(offset[0]), pinhole[1] - float(offset[1]), heading), gaze


def _pinhole(mount: Mount, gaze: Gaze) -> FloatArray:
    return _locate_pinhole_in_robot(mount, _rotate_head_from_axes(mount, gaze.pan, gaze.tilt))


def _find_gaze(turn: FloatArray, mount: Mount, direction: FloatArray) -> Gaze:
    """Return the angles at which the optical axis has a direction (3,) in the world."""
    x, y, z = (turn @ _rotate_robot_from_head(mount)).T @ direction
    return Gaze(float(np.arctan2(y, x)), float(np.arctan2(z, np.hypot(x, y))) - mount.tilt_zero)


def compute_pose_covariance(
    robot: Pose2, odometry: FloatArray, mount: Mount, gaze: Gaze, head_sd: float
) -> FloatArray:
    """Return covariance (6, 6) of the camera's pose in the world, to first order.

    Rows are x, y, z of the pinhole in metres, then a rotation vector in the world frame in radians.
    `odometry` (3, 3) is the covariance of the robot's x, y, heading in the world, `head_sd` the
    standard deviation of each of the head's angles.
    """
    sizes = (3, 2, len(mount.values))
    centre = camera_pose(robot, mount, gaze)

    def moved(changes: FloatArray) -> FloatArray:
        place, turn, numbers = np.split(changes, np.cumsum(sizes)[:-1])
        pose = camera_pose(
            Pose2(robot.x + place[0], robot.y + place[1], robot.heading + place[2]),
            mount.replace_values(tuple((np.array(mount.values) + numbers).tolist())),
            Gaze(gaze.pan + turn[0], gaze.tilt + turn[1]),
        )
        turned = Rotation.from_matrix(pose.rotation @ centre.rotation.T).as_rotvec()
        return np.concatenate([pose.centre - centre.centre, turned])

    steps = np.eye(sum(sizes)) * STEP
    jacobian = np.stack([(moved(s) - moved(-s)) / (2 * STEP) for s in steps], axis=1)
    of_mount = np.diag(np.square(mount.sds))
    inputs = block_diag(odometry, np.diag([head_sd**2, head_sd**2]), of_mount)
    covariance = jacobian @ inputs @ jacobian.T
    return np.asarray((covariance + covariance.T) / 2)
