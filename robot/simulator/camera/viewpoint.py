"""The camera's true pose: robot, mount, head, pinhole, one after the other.

The chain is that of the paper: pan about an upright axis of the head, then tilt about a level one.
"""

from dataclasses import dataclass

import numpy as np

from facetlog.perception.types import Camera, FloatArray, Pose
from facetlog.robot.simulator.world_file import CameraSetup, MountSetup

# From OpenCV's camera (x right, y down, z along the view) to x along the view, y left, z up.
AHEAD_FROM_CAMERA = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


@dataclass(frozen=True, slots=True)
class Viewpoint:
    """The robot's true place in the world and the head's true angles, metres and radians."""

    x: float
    y: float
    heading: float
    pan: float
    tilt: float

    def towards(self, other: "Viewpoint", share: float) -> "Viewpoint":
        """A viewpoint on the way to another one, of which little time lies between."""
        turn = float(np.remainder(other.heading - self.heading + np.pi, 2 * np.pi) - np.pi)
        return Viewpoint(
            self.x + share * (other.x - self.x),
            self.y + share * (other.y - self.y),
            self.heading + share * turn,
            self.pan + share * (other.pan - self.pan),
            self.tilt + share * (other.tilt - self.tilt),
        )


def make_camera(setup: CameraSetup, scale: float = 1.0) -> Camera:
    """The pinhole camera of a world file; `scale` makes its picture smaller, with the same view."""
    across = np.deg2rad(setup.across_deg) / 2
    focal = float(setup.width / 2 / np.tan(across)) * scale
    width, height = round(setup.width * scale), round(setup.height * scale)
    return Camera(width, height, focal, focal, (width - 1) / 2, (height - 1) / 2)


def camera_pose(viewpoint: Viewpoint, mount: MountSetup) -> Pose:
    """Pose of the camera in the world.

    >>> camera_pose(Viewpoint(1, 2, 0, 0, 0), MountSetup()).rotation @ [0, 0, 1]
    array([1., 0., 0.])
    """
    yaw, pitch, roll, level, skew = np.deg2rad(
        [mount.yaw_deg, mount.pitch_deg, mount.roll_deg, mount.tilt_zero_deg, mount.skew_deg]
    )
    world_from_robot = _rotate_about_z(viewpoint.heading)
    robot_from_head = _rotate_about_z(yaw) @ _rotate_about_y(pitch) @ _rotate_about_x(roll)
    head_from_axes = _rotate_about_z(viewpoint.pan) @ _rotate_about_y(-(viewpoint.tilt + level))
    world_from_axes = world_from_robot @ robot_from_head @ head_from_axes
    crossing = world_from_robot @ [mount.x, mount.y, mount.z] + [viewpoint.x, viewpoint.y, 0.0]
    offset = [mount.pinhole_ahead, mount.pinhole_left, mount.pinhole_up]
    return Pose(
        world_from_axes @ _rotate_about_x(skew) @ AHEAD_FROM_CAMERA,
        crossing + world_from_axes @ offset,
    )


def _rotate_about_z(angle: float) -> FloatArray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _rotate_about_y(angle: float) -> FloatArray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def _rotate_about_x(angle: float) -> FloatArray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
