"""Where a robot stands by its pictures of a place, which are aligned with one another.

Odometry drifts by degrees while a robot drives round a thing; what it sees there does not. Where it
stood as it came to the place stays as it was: that no picture of the place tells.
"""

import math

import numpy as np
from scipy.stats import chi2

from facetlog.mapping.same_thing import GATE_SHARE
from facetlog.perception.types import FloatArray, Pose
from facetlog.robot.collecting.record import Taken
from facetlog.robot.pose2 import Pose2, wrapped

__all__ = ["moved_beside", "standing_by_pictures"]


def standing_by_pictures(here: Pose2, last: Taken, aligned: Pose) -> Pose2 | None:
    """Where the robot stands in the world; None where pictures do not say.

    By odometry it is `here`, since it took its `last` view of the place, of which the covariance is
    that beside the first one. `aligned` is the pose of that view by the pictures: one that odometry
    cannot be off by is none.
    """
    rotation: FloatArray = aligned.rotation @ last.pose.rotation.T
    turn = math.atan2(rotation[1, 0] - rotation[0, 1], rotation[0, 0] + rotation[1, 1])
    (x, y), (to_x, to_y) = last.pose.centre[:2].tolist(), aligned.centre[:2].tolist()
    off = np.array([to_x - x, to_y - y, wrapped(turn)])
    rows = [0, 1, 5]
    cov = last.covariance[np.ix_(rows, rows)]
    if off @ np.linalg.solve(cov, off) > chi2.ppf(GATE_SHARE, len(rows)):
        return None
    beside = Pose2(x, y).between(here)
    return Pose2(to_x, to_y, turn).compose(beside)


def moved_beside(here: Pose2, found: Pose2) -> str:
    """How far off odometry was, in words."""
    off = here.between(found)
    centimetres, degrees = 100 * math.hypot(off.x, off.y), math.degrees(abs(off.heading))
    return f"by its pictures odometry was off by {centimetres:.0f} cm and {degrees:.1f}°"
