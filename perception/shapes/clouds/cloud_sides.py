"""Which side of a cloud's faces is outside."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.flat_faces import plane_axes
from facetlog.perception.scene import Plane
from facetlog.perception.types import FloatArray

__all__ = ["Surroundings", "outer_side"]

# Points further from a plane than this many sd are not on it.
OFF_PLANE_SDS = 4.0
# Rays run through cells so many spacings wide: of points at random one cell in 500 is empty.
CELL_SPACINGS = 2.5
# One way is free if it is this much longer than the other, on the mean over the face.
CLEARLY_FREE = 1.5
# Given normals, or the places a face was seen from, decide where they agree by so much (-1 … 1).
AGREEMENT = 0.3
# Of the thing's other points this share is behind a face at least; otherwise both sides are alike.
BEHIND_SHARE = 0.6


@dataclass(frozen=True, eq=False, slots=True)
class Surroundings:
    """A cloud's points (n, 3), the region and object of each, noise and spacing.

    `normals` (n, 3) as the file gives them and `seen_from` (n, 3), a place from which each point
    was seen; None where the file does not have them.
    """

    points: FloatArray
    owner: NDArray[np.intp]
    bodies: NDArray[np.intp]
    noise: float
    spacing: float
    normals: FloatArray | None = None
    seen_from: FloatArray | None = None


def outer_side(
    region: int,
    members: NDArray[np.intp],
    plane: Plane,
    about: Surroundings,
    *,
    up: FloatArray | None = None,
) -> int:
    """1 if the plane of `region`, whose points are `members`, looks outwards, -1 if inwards.

    By the first criterion that decides: the normals of the file; where it was seen from; the side
    from which rays go further before they meet other surface; the side with less of the same
    object; up; away from the middle.
    """
    paths = _free_paths(region, members, plane, about)
    sign = _stated_sign(members, plane, about)
    if not sign:
        # a ray that meets nothing is as long as the whole cloud
        longest = float(np.linalg.norm(np.ptp(about.points, axis=0)))
        ahead, back = (np.minimum(path, longest).mean() for path in paths)
        if ahead > CLEARLY_FREE * back:
            sign = 1
        elif back > CLEARLY_FREE * ahead:
            sign = -1
    sign = sign or _emptier_side(region, members, plane, about)
    if not sign and up is not None:
        sign = int(np.sign(np.round(float(plane.normal @ up), 1)))
    if not sign:
        middle = about.points.mean(axis=0)
        sign = 1 if float(plane.distance(middle)) <= 0.0 else -1
    return sign


def _stated_sign(members: NDArray[np.intp], plane: Plane, about: Surroundings) -> int:
    """Sign by the file's normals or by the places it was seen from; 0 where these do not decide."""
    votes: list[FloatArray] = []
    if about.normals is not None:
        votes.append(about.normals[members] @ plane.normal)
    if about.seen_from is not None:
        votes.append(np.sign(plane.distance(about.seen_from[members])))
    for vote in votes:
        known = vote[np.isfinite(vote)]
        mean = float(known.mean()) if len(known) else 0.0
        if abs(mean) >= AGREEMENT:
            return 1 if mean > 0.0 else -1
    return 0


def _free_paths(
    region: int, members: NDArray[np.intp], plane: Plane, about: Surroundings
) -> tuple[FloatArray, FloatArray]:
    """Lengths of rays from cells of the face to other surface, before and behind it; inf: none."""
    points = about.points
    axes = plane_axes(plane.normal, np.roll(plane.normal, 1))
    width = CELL_SPACINGS * about.spacing
    own = points[members] @ axes.T
    low, high = own.min(axis=0), own.max(axis=0)
    shape = np.floor((high - low) / max(width, 1e-300)).astype(np.intp) + 1
    height = plane.distance(points)
    rest = (about.owner != region) & (np.abs(height) > OFF_PLANE_SDS * about.noise)
    flat = points[rest] @ axes.T
    over = ((flat >= low) & (flat <= high)).all(axis=1)
    cells = np.floor((flat[over] - low) / max(width, 1e-300)).astype(np.intp) @ [shape[1], 1]
    above = height[rest][over]
    used = np.unique(np.floor((own - low) / max(width, 1e-300)).astype(np.intp) @ [shape[1], 1])
    paths = []
    for sign in (1.0, -1.0):
        nearest = np.full(int(shape.prod()), np.inf)
        way = sign * above > 0.0
        np.minimum.at(nearest, cells[way], np.abs(above[way]))
        paths.append(nearest[used])
    return paths[0], paths[1]


def _emptier_side(region: int, members: NDArray[np.intp], plane: Plane, about: Surroundings) -> int:
    """Sign of the side with less of the face's own object; 0 where both have about as much."""
    body = np.bincount(about.bodies[members] + 1).argmax() - 1
    rest = (about.bodies == body) & (about.owner != region) & (body >= 0)
    height = plane.distance(about.points[rest])
    height = height[np.abs(height) > OFF_PLANE_SDS * about.noise]
    if not len(height):
        return 0
    behind = float((height < 0.0).mean())
    if behind >= BEHIND_SHARE:
        return 1
    return -1 if behind <= 1.0 - BEHIND_SHARE else 0
