"""The camera's true pose, of the simulated robot and head."""

from dataclasses import dataclass

import numpy as np

from facetlog.perception.types import Camera, Pose
from facetlog.robot.mount.kinematics import Gaze, camera_pose
from facetlog.robot.mount.mount import Mount
from facetlog.robot.pose2 import Pose2
from facetlog.robot.simulator.world_file import CameraSetup


@dataclass(frozen=True, slots=True)
class Viewpoint:
    """The robot's true place in the world and the head's true angles, metres and radians."""

    x: float
    y: float
    heading: float
    pan: float
    tilt: float

    def camera_pose(self, mount: Mount) -> Pose:
        """Return the pose of the camera in the world."""
        return camera_pose(Pose2(self.x, self.y, self.heading), mount, Gaze(self.pan, self.tilt))

    def towards(self, other: "Viewpoint", share: float) -> "Viewpoint":
        """Return a viewpoint on the way to another one, of which little time lies between."""
        turn = float(np.remainder(other.heading - self.heading + np.pi, 2 * np.pi) - np.pi)
        return Viewpoint(
            self.x + share * (other.x - self.x),
            self.y + share * (other.y - self.y),
            self.heading + share * turn,
            self.pan + share * (other.pan - self.pan),
            self.tilt + share * (other.tilt - self.tilt),
        )


def make_camera(setup: CameraSetup, scale: float = 1.0) -> Camera:
    """Return the pinhole camera of a world file; `scale` makes its picture smaller, with the
    same view.
    """
    across = np.deg2rad(setup.across_deg) / 2
    focal = float(setup.width / 2 / np.tan(across)) * scale
    width, height = round(setup.width * scale), round(setup.height * scale)
    return Camera(width, height, focal, focal, (width - 1) / 2, (height - 1) / 2)
