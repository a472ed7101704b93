"""How two faces lie to each other: angle, offset, opposite, coplanar; all pairs at once."""

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.outlines import FlatFace, cross, plane_axes
from facetlog.perception.tolerance import ANGLE_RESOLUTION, SDS, Tolerance
from facetlog.perception.types import FloatArray, Plane, Scene

__all__ = ["coplanar_pairs", "offsets", "opposite_pairs", "pairwise_angles", "projected"]

# First-order angles are calibrated up to 7° and mean little beyond 15°.
VAGUE = np.deg2rad(15.0)
# Opposite faces of a made thing are seldom out of parallel by more than this.
OPPOSITE_LEAST = np.deg2rad(5.0)
# Outlines that overlap by less of the smaller one only graze each other.
LEAST_FACING = 0.01


def pairwise_angles(planes: Sequence[Plane]) -> tuple[FloatArray, FloatArray]:
    """Angles (n, n) between the normals of all pairs of planes and their 1σ, in radians, 0..π.

    With t1 the unit vector in which n2 leans away from n1, dθ = -t1 · dn1 - t2 · dn2, so
    var θ = t1ᵀ C1 t1 + t2ᵀ C2 t2. Parallel normals have no such direction: there it is the worst.
    """
    n = len(planes)
    normals = np.array([p.normal for p in planes]).reshape(n, 3)
    covs = np.array([p.cov[:3, :3] for p in planes]).reshape(n, 3, 3)
    across = np.eye(3) - normals[:, :, None] * normals[:, None, :]
    covs = across @ covs @ across  # nothing varies along the normal itself
    sine = np.linalg.norm(cross(normals[:, None], normals[None]), axis=2)
    angles = np.arctan2(sine, normals @ normals.T)
    # t1 = (n2 - cos θ n1) / sin θ and C1 n1 = 0, so t1ᵀ C1 t1 = n2ᵀ C1 n2 / sin² θ
    squares = (normals[:, :, None] * normals[:, None, :]).reshape(n, 9)
    leaning = covs.reshape(n, 9) @ squares.T
    parallel = sine < ANGLE_RESOLUTION
    variance = (leaning + leaning.T) / np.where(parallel, 1.0, sine) ** 2
    worst = np.linalg.eigvalsh(covs)[:, -1] if n else np.zeros(0)
    variance = np.where(parallel, worst[:, None] + worst[None], variance)
    sds = np.sqrt(np.maximum(variance, 0.0))
    np.fill_diagonal(angles, 0.0)
    np.fill_diagonal(sds, 0.0)
    return angles, sds


def offsets(scene: Scene, faces: tuple[FlatFace, ...]) -> tuple[FloatArray, FloatArray]:
    """Signed distances [i, j] of the middle of face i from the plane of face j, and their 1σ.

    The middle has the covariance of the mean of the outline's vertices.
    """
    n = len(faces)
    middles = np.array([f.middle for f in faces]).reshape(n, 3)
    middle_covs = np.array(
        [
            sum((scene.vertices[i].cov for i in f.outline), start=np.zeros((3, 3)))
            / len(f.outline) ** 2
            for f in faces
        ]
    ).reshape(n, 9)
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
