"""3-D segments that two pictures allow: pairs of 2-D segments whose planes meet."""

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.types import FloatArray, View

# The two views' parts of the 3-D segment overlap by this share of the shorter one.
MIN_OVERLAP = 0.5
# Sine of the least angle between the two planes: below, half a pixel is 10 % of the depth.
MIN_PLANE_SINE = 0.03


def candidate_segments(
    first: View, segments_1: FloatArray, second: View, segments_2: FloatArray
) -> tuple[FloatArray, NDArray[np.intp]]:
    """Return all 3-D segments (n, 2, 3) that a segment of each view could show, and which two (n,
    2).

    The plane through a pinhole and a segment (n, 4: u0, v0, u1, v1, of some length) holds the 3-D
    segment; two planes meet in its line. Kept are those before both cameras whose parts overlap.
    """
    if not len(segments_1) or not len(segments_2):
        return np.zeros((0, 2, 3)), np.zeros((0, 2), dtype=np.intp)
    plane_1, rays_1 = _plane_and_rays(first, segments_1)
    plane_2, rays_2 = _plane_and_rays(second, segments_2)
    c1, c2 = first.pose.centre, second.pose.centre

    cosine = plane_1[:, :3] @ plane_2[:, :3].T
    sine = np.sqrt(np.maximum(1.0 - cosine**2, 0.0))
    # Where the rays of one segment's ends pierce the other's plane: c + s d.
    with np.errstate(divide="ignore", invalid="ignore"):
        s1 = -(plane_2[:, :3] @ c1 + plane_2[:, 3])[None, :, None] / _slopes(rays_1, plane_2)
        s2 = -(plane_1[:, :3] @ c2 + plane_1[:, 3])[:, None, None] / _slopes(
            rays_2, plane_1
        ).transpose(1, 0, 2)
    good = (sine > MIN_PLANE_SINE) & (s1 > 0).all(-1) & (s2 > 0).all(-1)
    i, j = np.nonzero(good & np.isfinite(s1).all(-1) & np.isfinite(s2).all(-1))
    x1 = c1 + s1[i, j, :, None] * rays_1[i]
    x2 = c2 + s2[i, j, :, None] * rays_2[j]

    along = x1[:, 1] - x1[:, 0]
    length = np.linalg.norm(along, axis=1)
    keep = length > 0
    x1, x2, along, length = x1[keep], x2[keep], along[keep], length[keep]
    made_of = np.stack([i, j], axis=1)[keep]
    unit = along / length[:, None]
    t1 = np.stack([np.zeros_like(length), length], axis=1)
    t2 = np.sort(np.einsum("nek,nk->ne", x2 - x1[:, :1], unit), axis=1)
    overlap = np.minimum(t1[:, 1], t2[:, 1]) - np.maximum(t1[:, 0], t2[:, 0])
    shorter = np.minimum(length, t2[:, 1] - t2[:, 0])
    keep = overlap > MIN_OVERLAP * shorter
    ends = np.stack([np.minimum(t1[:, 0], t2[:, 0]), np.maximum(t1[:, 1], t2[:, 1])], axis=1)
    return x1[keep, :1] + ends[keep, :, None] * unit[keep, None], made_of[keep]


def _slopes(rays: FloatArray, planes: FloatArray) -> FloatArray:
    # normal_j · ray_ie as (i, j, e)
    slopes = rays.reshape(-1, 3) @ planes[:, :3].T
    return slopes.reshape(len(rays), 2, len(planes)).transpose(0, 2, 1)


def _plane_and_rays(view: View, segments: FloatArray) -> tuple[FloatArray, FloatArray]:
    ends = np.stack([segments[:, :2], segments[:, 2:]], axis=1)
    homogeneous = np.concatenate([ends, np.ones((*ends.shape[:2], 1))], axis=-1)
    lines = np.cross(homogeneous[:, 0], homogeneous[:, 1])
    planes = lines @ view.projection
    planes /= np.linalg.norm(planes[:, :3], axis=1, keepdims=True)
    rays = homogeneous @ np.linalg.inv(view.camera.matrix).T @ view.pose.rotation.T
    return planes, rays
