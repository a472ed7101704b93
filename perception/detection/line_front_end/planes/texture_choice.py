"""Planes of texture points that no lines propose, added to those of lines."""

from collections.abc import Sequence

import numpy as np

from facetlog.perception.detection.line_front_end.planes.plane_choice import (
    ChosenPlane,
    find_same_planes,
)
from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import PlaneHypothesis
from facetlog.perception.detection.line_front_end.planes.texture_planes import (
    TexturePlane,
    bound_patch,
)
from facetlog.perception.detection.line_front_end.points_3d.texture_points import TexturePoints
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import LineCloud
from facetlog.perception.stable_order import largest
from facetlog.perception.types import FloatArray

# A segment whose ends are this near to a plane, px, may bound a face there.
ON_PLANE_PX = 3.0


def add_texture_patches(
    chosen: Sequence[ChosenPlane],
    patches: Sequence[TexturePlane],
    texture: TexturePoints,
    cloud: LineCloud,
) -> tuple[ChosenPlane, ...]:
    """Return the planes chosen by lines, then those of texture patches that are not among them."""
    planes = list(chosen)
    for patch in patches:
        own = to_hypothesis(patch, texture, cloud)
        if not find_same_planes(own, own.texture, [c.plane for c in planes], cloud.pixel).any():
            planes.append(ChosenPlane(own, patch.score, patch.sides, _box(own, cloud)))
    return tuple(planes)


def to_hypothesis(patch: TexturePlane, texture: TexturePoints, cloud: LineCloud) -> PlaneHypothesis:
    """Return the plane of a patch, with its points and the segments that lie on it."""
    off = np.abs(cloud.segments @ patch.normal - patch.distance).max(axis=1, initial=0.0)
    lines = np.flatnonzero(off < ON_PLANE_PX * cloud.pixel)
    covs = texture.covs[patch.points]
    variance = np.einsum("k,nkl,l->n", patch.normal, covs, patch.normal) + cloud.pixel**2
    points = texture.points[patch.points]
    return PlaneHypothesis(patch.normal, patch.distance, lines, points, variance)


def _box(plane: PlaneHypothesis, cloud: LineCloud) -> FloatArray:
    # The sides of a face run along or across its longest line, if it has any.
    lines = cloud.segments[plane.lines]
    along = lines[:, 1] - lines[:, 0]
    if not len(lines):
        return bound_patch(plane.texture, plane.normal, None)
    longest = along[largest(np.linalg.norm(along, axis=1))]
    return bound_patch(plane.texture, plane.normal, longest)
