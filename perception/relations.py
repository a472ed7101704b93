"""How two faces lie to each other: offset, opposite, coplanar; all pairs at once."""

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.flat_faces import FlatFace, plane_axes
from facetlog.perception.tolerance import ANGLE_RESOLUTION, SDS, Tolerance
from facetlog.perception.types import FloatArray, Scene

__all__ = ["coplanar_pairs", "offsets", "opposite_pairs", "projected"]

# First-order angles are calibrated up to 7° and mean little beyond 15°.
VAGUE = np.deg2rad(15.0)
# Opposite faces of a made thing are seldom out of parallel by more than this.
OPPOSITE_LEAST = np.deg2rad(5.0)
# Outlines that overlap by less of the smaller one only graze each other.
LEAST_FACING = 0.01


def middle_cov(scene: Scene, face: FlatFace) -> FloatArray:
    """Covariance (3, 3) of a face's middle: Σ J C Jᵀ over its vertices."""
    covs = np.array([scene.vertices[i].cov for i in face.members])
    slopes = face.middle_slope
    return np.asarray((slopes @ covs @ slopes.transpose(0, 2, 1)).sum(axis=0))


def offsets(scene: Scene, faces: tuple[FlatFace, ...]) -> tuple[FloatArray, FloatArray]:
    """Signed distances [i, j] of the middle of face i from the plane of face j, and their 1σ."""
    n = len(faces)
    middles = np.array([f.middle for f in faces]).reshape(n, 3)
    middle_covs = np.array([middle_cov(scene, face) for face in faces]).reshape(n, 9)
    planes = [scene.faces[f.index].plane for f in faces]
    normals = np.array([p.normal for p in planes]).reshape(n, 3)
    plane_covs = np.array([p.cov for p in planes]).reshape(n, 16)
    levers = np.column_stack([middles, np.ones(n)])
    variance = (levers[:, :, None] * levers[:, None, :]).reshape(n, 16) @ plane_covs.T
    variance += middle_covs @ (normals[:, :, None] * normals[:, None, :]).reshape(n, 9).T
    signed = middles @ normals.T + np.array([p.offset for p in planes])
    return signed, np.sqrt(np.maximum(variance, 0.0))


def coplanar_pairs(
    scene: Scene,
    angles: tuple[FloatArray, FloatArray],
    distances: tuple[FloatArray, FloatArray],
) -> list[tuple[int, int]]:
    """Pairs (i < j) in one plane: normals parallel or opposed, middles in each other's plane."""
    off = np.minimum(angles[0], np.pi - angles[0])
    flat = off <= np.minimum(SDS * angles[1], VAGUE) + ANGLE_RESOLUTION
    near = np.abs(distances[0]) <= Tolerance.of(scene).within(distances[1])
    return [(i, j) for i, j in np.argwhere(np.triu(flat & near & near.T, 1)).tolist()]


def projected(
    faces: Sequence[FlatFace], points: FloatArray, axes: Sequence[FloatArray]
) -> NDArray[np.object_]:
    """Polygon (n,) of every face in a frame (2, 3) of its own: its outline as seen along that."""
    coordinates: list[FloatArray] = []
    ring_of: list[int] = []
    polygon_of: list[int] = []
    for nth, (face, frame) in enumerate(zip(faces, axes, strict=True)):
        for ring in face.rings:
            coordinates.append(points[list(ring)] @ frame.T)
            ring_of += [len(polygon_of)] * len(ring)
            polygon_of.append(nth)
    rings = shapely.linearrings(np.concatenate(coordinates), indices=ring_of)
    polygons = shapely.polygons(rings, indices=polygon_of)
    crossed = ~shapely.is_valid(polygons)
    polygons[crossed] = shapely.buffer(polygons[crossed], 0.0)
    return np.asarray(polygons, dtype=np.object_)


def opposite_pairs(
    scene: Scene, faces: tuple[FlatFace, ...], angles: tuple[FloatArray, FloatArray]
) -> list[tuple[int, int]]:
    """Pairs (i < j) with opposed normals whose outlines overlap along the mean normal."""
    points = scene.points
    limit = np.clip(SDS * angles[1], OPPOSITE_LEAST, VAGUE)
    opposed = np.argwhere(np.triu(np.pi - angles[0] <= limit, 1))
    if not len(opposed):
        return []
    middles = np.array([f.middle for f in faces])
    normals = np.array([f.normal for f in faces])
    radii = np.array(
        [np.linalg.norm(points[list(f.outline)] - f.middle, axis=1).max() for f in faces]
    )
    one, two = opposed.T
    between = middles[two] - middles[one]
    mean = normals[one] - normals[two]
    mean /= np.linalg.norm(mean, axis=1)[:, None]
    aside = between - np.einsum("ij,ij->i", between, mean)[:, None] * mean
    close = np.linalg.norm(aside, axis=1) < radii[one] + radii[two]
    one, two, mean = one[close], two[close], mean[close]
    if not len(one):
        return []
    frames = [
        plane_axes(normal, faces[i].axes[0]) for i, normal in zip(one.tolist(), mean, strict=True)
    ]
    first, second = (
        projected([faces[i] for i in rows], points, frames) for rows in (one.tolist(), two.tolist())
    )
    least = np.minimum(shapely.area(first), shapely.area(second))
    shared = shapely.area(shapely.intersection(first, second))
    facing = (least > 0.0) & (shared >= LEAST_FACING * least)
    return list(zip(one[facing].tolist(), two[facing].tolist(), strict=True))
