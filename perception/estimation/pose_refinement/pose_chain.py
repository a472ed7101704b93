"""The prior of poses from odometry: a chain of independent errors of the steps between poses.

The error of a pose is a small motion of the world, a twist: rotation vector (3,) and shift (3,) of
the camera about one fixed point. In this form the error of a pose is that of the previous pose plus
that of the step between them, so a drift over many metres is a chain of independent steps.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from facetlog.perception.estimation.rotations import convert_to_matrices
from facetlog.perception.types import FloatArray, Pose

# Independent error of every view besides odometry: the head's pointing and the settling of the
# robot on its wheels. Radians; for the camera's place the same angle times the distance to the
# scene, since lengths may have any unit.
OWN_SD = np.radians(0.25)
# A rotation's covariance that shrinks by more than this share did not shrink by rounding.
ROUNDING = 1e-6


@dataclass(frozen=True, eq=False, slots=True)
class TwistPrior:
    """Covariances (V, 6, 6) of the twists of poses about the point `about` (3,).

    In a `chain` they are of the first pose's twist, and of what each step adds to it; else of each
    pose's own. Twists are rotation vectors in radians, then shifts in world units.
    """

    about: FloatArray
    covs: FloatArray
    chain: bool

    def expected(self, k: int, twists: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the mean (6,) and covariance (6, 6) of the twist of view k > 0."""
        return twists[k - 1] if self.chain else np.zeros(6), self.covs[k]

    def add_prior(self, twists: FloatArray, h: FloatArray, g: FloatArray) -> None:
        """Add the normal equations of the first twists (V, 6) to h and g."""
        for k, twist in enumerate(twists):
            belief = np.linalg.inv(self.covs[k])
            linked = self.chain and k > 0
            pull = belief @ (twist - twists[k - 1] if linked else twist)
            at, before = slice(6 * k, 6 * k + 6), slice(6 * k - 6, 6 * k)
            h[at, at] += belief
            g[at] -= pull
            if linked:
                h[before, before] += belief
                h[before, at] -= belief
                h[at, before] -= belief
                g[before] += pull


def moved(pose: Pose, twist: FloatArray, about: FloatArray) -> Pose:
    """Return the pose turned by twist[:3] about the point `about` and shifted by twist[3:]."""
    turn = convert_to_matrices(twist[:3])
    return Pose(turn @ pose.rotation, turn @ (pose.centre - about) + about + twist[3:])


def pose_chain(
    poses: Sequence[Pose], covariances: FloatArray, about: FloatArray, distance: float
) -> TwistPrior:
    """Return the chain of poses, in the order in which they were taken.

    `covariances` (V, 6, 6) are of place (world units) and of a rotation vector (radians), both in
    the world frame; they grow from pose to pose as the odometry's do. Where they become smaller
    odometry restarted, and the errors before and after are independent. `about` is the point that
    the views look at, `distance` how far it is from them.
    """
    of_twists = np.array(
        [
            convert_to_twist_cov(pose, cov, about)
            for pose, cov in zip(poses, covariances, strict=True)
        ]
    )
    own_cov = np.diag([(OWN_SD * distance) ** 2] * 3 + [OWN_SD**2] * 3)
    own = np.array([convert_to_twist_cov(pose, own_cov, about) for pose in poses])
    grown = [
        before + after if (step := added(before, after)) is None else step
        for before, after in pairwise(of_twists)
    ]
    return TwistPrior(about, np.array([of_twists[0], *grown]) + own, chain=True)


def convert_to_twist_cov(pose: Pose, cov: FloatArray, about: FloatArray) -> FloatArray:
    """Return covariance (6, 6) of a pose's twist, from that of its place and rotation vector."""
    # The camera's place moves by turn x (centre - about) + shift.
    x, y, z = pose.centre - about
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    change = np.zeros((6, 6))
    change[:3, 3:] = np.eye(3)
    change[3:, :3] = np.eye(3)
    change[3:, 3:] = cross  # shift = place - turn x r = place + r x turn
    return np.asarray(change @ cov @ change.T)


def added(before: FloatArray, after: FloatArray) -> FloatArray | None:
    """Return what the step between two poses adds to the covariance (6, 6) of their twists.

    None where the odometry restarted.
    """
    cov = after - before
    if np.trace(cov[:3, :3]) < -ROUNDING * np.trace(before[:3, :3]):
        return None
    # The difference of two rounded covariances need not be positive.
    values, vectors = np.linalg.eigh((cov + cov.T) / 2)
    return np.asarray((vectors * np.maximum(values, 0.0)) @ vectors.T)
