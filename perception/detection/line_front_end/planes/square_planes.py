"""Planes parallel or perpendicular to known ones: most things have right angles.

For a leg's face some pixels wide, or a rim's, the pictures leave the tilt uncertain by degrees.
Where they are as consistent with a plane parallel or perpendicular to the ground and the faces
found, that plane is taken.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import PlaneHypothesis
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import LineCloud
from facetlog.perception.types import FloatArray

# A plane may have been chosen so far off that a square one is meant: it is only what is tried.
NEAR_SINE, NEAR_COSINE = float(np.sin(np.radians(15.0))), float(np.cos(np.radians(15.0)))
# Two normals span what is square to both where they are farther apart than this sine.
APART_SINE = 0.5
# What is built square is square to half a degree.
SQUARE_SLOPE = float(np.tan(np.radians(0.5)))


def propose_square_normals(normal: FloatArray, known: Sequence[FloatArray]) -> Iterator[FloatArray]:
    """Return normals near one that are parallel or square to `known` ones, what binds it most
    first.

    Of the known ones those come first that count most.
    """
    parallel = [k for k in known if abs(k @ normal) > NEAR_COSINE]
    square = [k for k in known if abs(k @ normal) < NEAR_SINE]
    if parallel:
        yield parallel[0] * np.sign(parallel[0] @ normal)
    if not square:
        return
    first = square[0]
    for other in square[1:]:
        both = np.cross(first, other)
        size = float(np.linalg.norm(both))
        if size > APART_SINE:
            yield both / size * np.sign(both @ normal)
            break
    rest = normal - (normal @ first) * first
    yield rest / np.linalg.norm(rest)


def is_square(normal: FloatArray, wanted: FloatArray) -> bool:
    """Return whether a normal is as near to a square one as things are built."""
    return bool(np.linalg.norm(np.cross(normal, wanted)) < SQUARE_SLOPE)


def project_to_plane(
    corners: FloatArray,
    plane: PlaneHypothesis,
    normal: FloatArray,
    cloud: LineCloud,
    centre: FloatArray,
) -> FloatArray:
    """Return where a ray from a centre (3,) through each corner (k, 3) of a plane meets the plane
    turned.

    It has another normal and goes on through the middle of its lines, each end of them counted by
    how well it is known.
    """
    through = corners.mean(axis=0)
    if len(plane.lines):
        ends = cloud.segments[plane.lines].reshape(-1, 3)
        covs = cloud.end_covs[plane.lines].reshape(-1, 3, 3)
        weight = 1.0 / (cloud.pixel**2 + np.einsum("i,nij,j->n", normal, covs, normal))
        through = weight @ ends / weight.sum()
    rays = corners - centre
    share = (through - centre) @ normal / (rays @ normal)
    return np.asarray(centre + share[:, None] * rays)
