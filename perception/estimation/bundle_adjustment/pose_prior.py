"""The prior of poses and lenses in bundle adjustment: a normal density.

A pose has the error that its file states, independent or in a chain as that of odometry, and beyond
that an independent one whose size is estimated from the residuals; so it is with
lenses.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.estimation.pose_refinement.pose_chain import added, convert_to_twist_cov
from facetlog.perception.types import FloatArray, Pose, PoseErrorKind, PoseErrors


@dataclass(frozen=True, eq=False, slots=True)
class Prior:
    """A normal density of twists (V, 6), shifts in units of the cameras' distance, and of lenses.

    `mean` (V, 6) are the twists from the poses that are adjusted to the stated ones. `own` (V, 6,
    6) are covariances of an independent error of one radian of each pose, `stated` (V, 6, 6) those
    of the stated errors, or `chain` (6 V, 6 V) that of all poses together. The lenses' `unknowns`
    have mean 0.
    """

    mean: FloatArray
    own: FloatArray
    stated: FloatArray
    unknowns: int
    chain: FloatArray | None = None

    def precision(self, own_sd: float, lens_sd: float) -> tuple[FloatArray, float]:
        """Return inverse (m, m) of the covariance, m = 6 V + unknowns, and its log determinant."""
        covs = self.stated + own_sd**2 * self.own
        whole = covs if self.chain is None else (self.chain + build_block_diagonal(covs))[None]
        inverse = np.asarray(np.linalg.inv(whole), dtype=np.float64)
        log_det = float(np.linalg.slogdet(whole)[1].sum())
        of_poses = build_block_diagonal((inverse + inverse.transpose(0, 2, 1)) / 2)
        belief = np.zeros((len(of_poses) + self.unknowns,) * 2)
        belief[: len(of_poses), : len(of_poses)] = of_poses
        lenses = np.arange(len(of_poses), len(belief))
        belief[lenses, lenses] = 1.0 / lens_sd**2
        return belief, log_det + 2 * self.unknowns * float(np.log(lens_sd))

    def off(self, twists: FloatArray, lens: FloatArray) -> FloatArray:
        """Return how far twists (V, 6) and the lenses' unknowns (C, 2) are from the mean, (m,)."""
        return np.concatenate([(twists - self.mean).ravel(), lens.ravel()])

    def weighted(self, weight: FloatArray) -> "Prior":
        """Return the prior where nearly identical views share their errors (each 1 / weight as
        large).
        """
        return replace(self, own=self.own / weight[:, None, None])

    def some(self, chosen: NDArray[np.intp]) -> "Prior":
        """Return the prior of the chosen views (indices) alone."""
        rows = (6 * chosen[:, None] + np.arange(6)).ravel()
        chain = None if self.chain is None else self.chain[np.ix_(rows, rows)]
        own, stated = self.own[chosen], self.stated[chosen]
        return Prior(self.mean[chosen], own, stated, self.unknowns, chain)


def build_prior(
    poses: Sequence[Pose],
    errors: PoseErrors | None,
    about: FloatArray,
    distance: float,
    unknowns: int = 0,
) -> Prior:
    """Return the prior of the twists about a point (3,) that move these poses, and of lenses'
    unknowns.

    An independent error is as large in place as in rotation: by the same angle at this distance.
    """
    unit = np.repeat([1.0, distance], 3)
    scale = np.outer(unit, unit)
    by_angle = np.diag([distance**2] * 3 + [1.0] * 3)
    own = np.array([convert_to_twist_cov(pose, by_angle, about) for pose in poses]) / scale
    nothing = np.zeros_like(own)
    if errors is None:
        return Prior(np.zeros((len(poses), 6)), own, nothing, unknowns)
    mean = np.array([_twist(p, q, about) for p, q in zip(poses, errors.poses, strict=True)]) / unit
    pairs = zip(poses, errors.covariances, strict=True)
    stated = np.array([convert_to_twist_cov(pose, cov, about) for pose, cov in pairs]) / scale
    if errors.kind is PoseErrorKind.INDEPENDENT:
        return Prior(mean, own, stated, unknowns)
    return Prior(mean, own, nothing, unknowns, _chain_covariances(stated))


def build_block_diagonal(blocks: FloatArray) -> FloatArray:
    """Return the matrix (V k, V k) with these blocks (V, k, k) on its diagonal."""
    count, size, _ = blocks.shape
    whole = np.zeros((count, size, count, size))
    each = np.arange(count)
    whole[each, :, each, :] = blocks
    return whole.reshape(count * size, count * size)


def _chain_covariances(stated: FloatArray) -> FloatArray:
    # The covariance of two poses of a chain is that of the first of them; across a restart of the
    # odometry they are independent.
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
    from scipy.spatial.transform import Rotation  # loaded only now: few poses state their errors

    turn = end.rotation @ start.rotation.T
    shift = end.centre - about - turn @ (start.centre - about)
    return np.concatenate([Rotation.from_matrix(turn).as_rotvec(), shift])
