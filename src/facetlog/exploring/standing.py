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

__all__ = ["may_be_off_so_far", "moved_beside", "standing_by_pictures"]


def standing_by_pictures(here: Pose2, last: Taken, aligned: Pose) -> Pose2:
    """Where the robot stands in the world, which is `here` by its odometry since it took its `last`
    view of a place; `aligned` is the pose of that view by the pictures.
    """
    x, y, turn = _off(last, aligned)
    at = Pose2(*last.pose.centre[:2].tolist())
    return Pose2(at.x + x, at.y + y, turn).compose(at.between(here))


def may_be_off_so_far(last: Taken, aligned: Pose) -> bool:
    """Whether odometry may be off as the pictures say, at three standard deviations of what drifted
    since the first view of the place.
    """
    off = np.array(_off(last, aligned))
    rows = [0, 1, 5]
    cov = last.covariance[np.ix_(rows, rows)]
    return bool(off @ np.linalg.solve(cov, off) <= chi2.ppf(GATE_SHARE, len(rows)))


def _off(last: Taken, aligned: Pose) -> tuple[float, float, float]:
    """How far the world lies off by a view, as its x, y and turn about the view's place."""
    rotation: FloatArray = aligned.rotation @ last.pose.rotation.T
    turn = math.atan2(rotation[1, 0] - rotation[0, 1], rotation[0, 0] + rotation[1, 1])
    x, y = (aligned.centre - last.pose.centre)[:2].tolist()
    return x, y, wrapped(turn)


def moved_beside(here: Pose2, found: Pose2) -> str:
    """How far off odometry was, in words."""
    off = here.between(found)
    centimetres, degrees = 100 * math.hypot(off.x, off.y), math.degrees(abs(off.heading))
    return f"by its pictures odometry was off by {centimetres:.0f} cm and {degrees:.1f}°"
