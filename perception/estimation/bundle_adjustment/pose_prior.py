"""What is believed of poses before the points have their say: a normal density of their twists.

A pose is off by what its file states, each pose on its own or in a chain as odometry's, and beyond
that by an error of its own whose size the residuals tell (error_sizes.py).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from facetlog.perception.estimation.pose_refinement.pose_chain import added, of_twist
from facetlog.perception.types import FloatArray, Pose, PoseErrorKind, PoseErrors

__all__ = ["PosePrior", "block_diagonal", "pose_prior"]


@dataclass(frozen=True, eq=False, slots=True)
class PosePrior:
    """A normal density of twists (V, 6), shifts in units of the cameras' distance.

    `mean` (V, 6) is where the poses as stated lie from those that the twists move. `own` (V, 6, 6)
    are covariances of an error of one radian of each pose on its own, `stated` (V, 6, 6) those of
    the errors that are stated, or `chain` (6 V, 6 V) those of all poses together.
    """

    mean: FloatArray
    own: FloatArray
    stated: FloatArray
    chain: FloatArray | None = None

    def precision(self, own_sd: float) -> tuple[FloatArray, float]:
        """The inverse (6 V, 6 V) of the covariance, and the covariance's log determinant."""
        covs = self.stated + own_sd**2 * self.own
        whole = covs if self.chain is None else (self.chain + block_diagonal(covs))[None]
        inverse = np.asarray(np.linalg.inv(whole), dtype=np.float64)
        log_det = float(np.linalg.slogdet(whole)[1].sum())
        return block_diagonal((inverse + inverse.transpose(0, 2, 1)) / 2), log_det

    def weighted(self, weight: FloatArray) -> "PosePrior":
        """The same where views almost alike share their own errors (each 1 / weight as large)."""
        return replace(self, own=self.own / weight[:, None, None])

    def some(self, chosen: NDArray[np.intp]) -> "PosePrior":
        """That of the chosen views (indices) alone."""
        rows = (6 * chosen[:, None] + np.arange(6)).ravel()
        chain = None if self.chain is None else self.chain[np.ix_(rows, rows)]
        return PosePrior(self.mean[chosen], self.own[chosen], self.stated[chosen], chain)


def pose_prior(
    poses: Sequence[Pose], errors: PoseErrors | None, about: FloatArray, distance: float
) -> PosePrior:
    """The prior of the twists about a point (3,) that move these poses, V of them.

    An own error is as large in place as in turn, as seen from the cameras: by the same angle at
    this distance.
    """
    unit = np.repeat([1.0, distance], 3)
    scale = np.outer(unit, unit)
    by_angle = np.diag([distance**2] * 3 + [1.0] * 3)
    own = np.array([of_twist(pose, by_angle, about) for pose in poses]) / scale
    nothing = np.zeros_like(own)
    if errors is None:
        return PosePrior(np.zeros((len(poses), 6)), own, nothing)
    mean = np.array([_twist(p, q, about) for p, q in zip(poses, errors.poses, strict=True)]) / unit
    pairs = zip(poses, errors.covariances, strict=True)
    stated = np.array([of_twist(pose, cov, about) for pose, cov in pairs]) / scale
    if errors.kind is PoseErrorKind.INDEPENDENT:
        return PosePrior(mean, own, stated)
    return PosePrior(mean, own, nothing, _chained(stated))


def block_diagonal(blocks: FloatArray) -> FloatArray:
    """The matrix (V k, V k) with these blocks (V, k, k) on its diagonal."""
    count, size, _ = blocks.shape
    whole = np.zeros((count, size, count, size))
    each = np.arange(count)
    whole[each, :, each, :] = blocks
    return whole.reshape(count * size, count * size)


def _chained(stated: FloatArray) -> FloatArray:
    # Errors of two poses of a chain have in common what had gathered up to the first of them; where
    # the odometry began anew they have nothing in common.
    count = len(stated)
    whole = np.zeros((count, 6, count, 6))
    gathered, began = stated[0], 0
    for k in range(count):
        if k:
            step = added(stated[k - 1], stated[k])
            if step is None:
                gathered, began = stated[k], k
            else:
                gathered = gathered + step
        whole[k, :, k] = gathered
        for j in range(began, k):
            whole[j, :, k] = whole[k, :, j] = whole[j, :, j]
    return whole.reshape(6 * count, 6 * count)


def _twist(start: Pose, end: Pose, about: FloatArray) -> FloatArray:
    turn = end.rotation @ start.rotation.T
    shift = end.centre - about - turn @ (start.centre - about)
    return np.concatenate([Rotation.from_matrix(turn).as_rotvec(), shift])
