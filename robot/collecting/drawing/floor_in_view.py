"""The part of the floor that a picture shows."""

import numpy as np

from facetlog.perception.types import Camera, FloatArray, Pose

__all__ = ["floor_in_view", "looked_at"]

# Places along each side of the picture at which it is asked where it shows the floor.
PLACES = 65


def floor_in_view(pose: Pose, camera: Camera, far: float) -> FloatArray:
    """The outline (n, 2) on the floor (z = 0) of what a picture shows of it up to `far` metres.

    Empty if it shows none of it so near. What stands on the floor is not looked at, and no lens.
    """
    heights = np.linspace(camera.height - 0.5, -0.5, PLACES)
    left = _on_floor(pose, camera, np.full(PLACES, -0.5), heights, far)
    right = _on_floor(pose, camera, np.full(PLACES, camera.width - 0.5), heights, far)
    return np.concatenate([left, right[::-1]])


def looked_at(pose: Pose, camera: Camera, far: float) -> FloatArray:
    """Where (2,) the line of sight of the picture's middle meets the floor, or is at `far`."""
    u, v = (camera.width - 1) / 2, (camera.height - 1) / 2
    found = _on_floor(pose, camera, np.array([u]), np.array([v]), far)
    if len(found):
        return np.asarray(found[0])
    ahead = pose.rotation[:2, 2]
    return np.asarray(pose.centre[:2] + far * ahead / max(float(np.hypot(*ahead)), 1e-9))


def _on_floor(pose: Pose, camera: Camera, u: FloatArray, v: FloatArray, far: float) -> FloatArray:
    """Where (k, 2) the rays of pixels meet the floor no farther than that, of those that do."""
    ahead = np.ones(len(u))
    rays = np.column_stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, ahead])
    directions = rays @ pose.rotation.T
    down = directions[:, 2] < 0
    # c + t d with z = 0
    times = pose.centre[2] / -directions[down, 2]
    places = pose.centre[:2] + times[:, None] * directions[down, :2]
    near = np.hypot(*(places - pose.centre[:2]).T) <= far
    return np.asarray(places[near])
