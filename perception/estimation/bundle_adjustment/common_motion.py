"""Relative errors of points: their covariances without a common rigid motion.

Errors of the poses move all points of a scene together, by much more than against one another.
Angles between planes do not depend on that common motion.
"""

import numpy as np

from facetlog.perception.types import FloatArray

__all__ = ["without_common_motion"]


def without_common_motion(points: FloatArray, own: FloatArray, shared: FloatArray) -> FloatArray:
    """Covariances (n, 3, 3) of points (n, 3) after the best rigid alignment of all with the truth.

    Before it the errors of points i and j have the covariance δij own_i + shared_iᵀ shared_j, with
    `own` (n, 3, 3) and `shared` (n, m, 3). The alignment weights points by their precision.
    """
    covs: FloatArray = own + shared.transpose(0, 2, 1) @ shared
    if not len(points):
        return covs
    weight = 1.0 / np.trace(covs, axis1=1, axis2=2)
    arm = points - weight @ points / weight.sum()
    arm = arm / max(float(np.abs(arm).max()), np.finfo(np.float64).tiny)
    # A shift, and a rotation vector, which moves a point by rotation × arm.
    x, y, z = arm.T
    by_motion = np.zeros((len(points), 3, 6))
    by_motion[:, :, :3] = np.eye(3)
    by_motion[:, 0, 4], by_motion[:, 0, 5] = z, -y
    by_motion[:, 1, 3], by_motion[:, 1, 5] = -z, x
    by_motion[:, 2, 3], by_motion[:, 2, 4] = y, -x
    weighted = by_motion * weight[:, None, None]
    # One or two points leave some rotations undetermined: these are set to zero.
    solve = np.linalg.pinv(np.einsum("nia,nib->ab", weighted, by_motion), hermitian=True)
    motion = weighted @ solve  # (n, 3, 6): the best motion is its sum over the errors
    of_shared = np.einsum("nmi,nia->ma", shared, motion)
    with_motion = own @ motion + shared.transpose(0, 2, 1) @ of_shared
    of_motion = np.einsum("nia,nib->ab", motion, with_motion)
    cross = with_motion @ by_motion.transpose(0, 2, 1)
    return np.asarray(
        covs
        - cross
        - cross.transpose(0, 2, 1)
        + by_motion @ of_motion @ by_motion.transpose(0, 2, 1)
    )
