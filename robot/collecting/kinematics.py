"""From the robot's place and the head's angles to the camera's pose, and back.

The chain is the paper's: pinhole = robot ∘ mount ∘ pan-tilt ∘ pinhole offset. Its angles A and B
(perception/pan_tilt.py) are those of a level mount: A = heading + yaw + pan - 90°, B = tilt - 90°.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation

from facetlog.perception.types import FloatArray, Pose
from facetlog.robot.collecting.mount import Mount
from facetlog.robot.pose2 import Pose2

__all__ = ["Gaze", "camera_pose", "gaze_at", "pose_covariance", "stand_for"]

# From OpenCV's camera (x right, y down, z along the view) to a frame with x along it and z up.
AHEAD_FROM_CAMERA = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
# The angles depend on where the pinhole is, and that on the angles by an offset of centimetres
# over metres of distance: each round leaves about that ratio of the error, ten leave nothing.
ROUNDS = 10
# For numerical derivatives, metres and radians: the cube root of the precision of a double.
STEP = 6e-6


@dataclass(frozen=True, slots=True)
class Gaze:
    """Angles of the head, radians: pan to the left and tilt up are positive."""

    pan: float
    tilt: float


def _about_z(angle: float) -> FloatArray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _about_y(angle: float) -> FloatArray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def _about_x(angle: float) -> FloatArray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _robot_from_head(mount: Mount) -> FloatArray:
    return _about_z(mount.yaw) @ _about_y(mount.pitch) @ _about_x(mount.roll)


def _head_from_axes(mount: Mount, gaze: Gaze) -> FloatArray:
    """The frame that turns with both axes, x along the view if there is no skew."""
    return _about_z(gaze.pan) @ _about_y(-(gaze.tilt + mount.tilt_zero))


def _pinhole_in_robot(mount: Mount, gaze: Gaze) -> FloatArray:
    offset = np.array([mount.pinhole_ahead, mount.pinhole_left, mount.pinhole_up])
    axes = np.array([mount.x, mount.y, mount.z])
    return np.asarray(axes + _robot_from_head(mount) @ _head_from_axes(mount, gaze) @ offset)


def camera_pose(robot: Pose2, mount: Mount, gaze: Gaze) -> Pose:
    """Pose of the camera in the world, of a robot at `robot` in the world.

    >>> camera_pose(Pose2(1.0, 2.0, 0.0), Mount(z=0.7), Gaze(0.0, 0.0)).rotation @ [0, 0, 1]
    array([1., 0., 0.])
    """
    turn = _about_z(robot.heading)
    axes = _robot_from_head(mount) @ _head_from_axes(mount, gaze)
    rotation = turn @ axes @ _about_x(mount.skew) @ AHEAD_FROM_CAMERA
    place = np.array([robot.x, robot.y, 0.0])
    return Pose(rotation, place + turn @ _pinhole_in_robot(mount, gaze))


def gaze_at(robot: Pose2, mount: Mount, point: FloatArray) -> Gaze:
    """The angles at which the optical axis goes through `point` (3,) in the world."""
    turn = _about_z(robot.heading)
    place = np.array([robot.x, robot.y, 0.0])
    gaze = Gaze(0.0, 0.0)
    for _ in range(ROUNDS):
        pinhole = place + turn @ _pinhole_in_robot(mount, gaze)
        gaze = _gaze_along(turn, mount, point - pinhole)
    return gaze


def stand_for(
    pinhole: tuple[float, float], heading: float, mount: Mount, point: FloatArray
) -> tuple[Pose2, Gaze]:
    """Where the robot stands, and the angles, so that the pinhole is above `pinhole` (x, y).

    The robot's heading is given; the optical axis goes through `point` (3,). The pinhole's height
    is what the mount makes it.
    """
    turn = _about_z(heading)
    gaze = Gaze(0.0, 0.0)
    for _ in range(ROUNDS):
        offset = turn @ _pinhole_in_robot(mount, gaze)
        gaze = _gaze_along(turn, mount, point - np.array([*pinhole, offset[2]]))
    offset = turn @ _pinhole_in_robot(mount, gaze)
    return Pose2(pinhole[0] - float(offset[0]), pinhole[1] - float(offset[1]), heading), gaze


def _gaze_along(turn: FloatArray, mount: Mount, direction: FloatArray) -> Gaze:
    """The angles at which the optical axis has a direction (3,) in the world."""
    x, y, z = (turn @ _robot_from_head(mount)).T @ direction
    return Gaze(float(np.arctan2(y, x)), float(np.arctan2(z, np.hypot(x, y))) - mount.tilt_zero)


def pose_covariance(
    robot: Pose2, odometry: FloatArray, mount: Mount, gaze: Gaze, head_sd: float
) -> FloatArray:
    """Covariance (6, 6) of the camera's pose in the world, to first order.

    Rows are x, y, z of the pinhole in metres, then a small turn about the world's x, y, z in
    radians. `odometry` (3, 3) is of the robot's x, y, heading in the world, `head_sd` of each of
    the head's angles.
    """
    sizes = (3, 2, len(mount.values))
    centre = camera_pose(robot, mount, gaze)

    def moved(changes: FloatArray) -> FloatArray:
        place, turn, numbers = np.split(changes, np.cumsum(sizes)[:-1])
        pose = camera_pose(
            Pose2(robot.x + place[0], robot.y + place[1], robot.heading + place[2]),
            mount.with_values(tuple((np.array(mount.values) + numbers).tolist())),
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
