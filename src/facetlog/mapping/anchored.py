"""How sure the poses of some views are beside the first of them, and not in the world.

Where a robot has driven for long it may be off by a metre, and all views that it then takes of a
thing are off alike: that moves what they show, and hides none of it. The error of a pose is that of
the first one, as a small motion of the world (pose_chain.py), and what was added since.
"""

from collections.abc import Sequence

import numpy as np

from facetlog.perception.estimation.pose_refinement.pose_chain import OWN_SD, added, of_twist
from facetlog.perception.types import FloatArray, Pose

__all__ = ["covariances_beside_first"]


def covariances_beside_first(poses: Sequence[Pose], covariances: FloatArray) -> FloatArray:
    """The covariances (V, 6, 6) of place (world units) and rotation vector (radians) of poses that
    a robot took in this order, as if its odometry had begun with the first one.
    """
    if not len(poses):
        return np.zeros((0, 6, 6))
    centres = np.array([pose.centre for pose in poses])
    about = centres.mean(axis=0)
    # As far as from one another the views are from what they look at.
    distance = float(np.linalg.norm(centres - about, axis=1).max())
    own = np.diag([(OWN_SD * distance) ** 2] * 3 + [OWN_SD**2] * 3)
    twists = [of_twist(pose, cov, about) for pose, cov in zip(poses, covariances, strict=True)]
    since = np.zeros((6, 6))
    found = []
    for before, twist, pose in zip([twists[0], *twists], twists, poses, strict=False):
        step = added(before, twist)
        # Odometry that restarted is off independently of what it was before.
        since = since + (before + twist if step is None else step)
        back = _place_from_twist(pose, about)
        found.append(back @ since @ back.T + own)
    return np.array(found)


def _place_from_twist(pose: Pose, about: FloatArray) -> FloatArray:
    """From a twist's rotation vector and shift to a pose's place and rotation vector (6, 6): the
    place moves by turn x (centre - about) + shift.
    """
    x, y, z = pose.centre - about
    matrix = np.zeros((6, 6))
    matrix[:3, :3] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    matrix[:3, 3:] = matrix[3:, :3] = np.eye(3)
    return matrix
