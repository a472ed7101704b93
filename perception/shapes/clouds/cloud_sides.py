"""Which side of a cloud's faces is outside."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.scene import Plane
from facetlog.perception.space.flooding import is_empty_shell
from facetlog.perception.types import FloatArray

# Points further from a plane than this many sd are not on it.
OFF_PLANE_SDS = 4.0
# Rays run through cells so many spacings wide: of points at random one cell in 500 is empty.
CELL_SPACINGS = 2.5
# One way is free if it is this much longer than the other, on the mean over the face.
CLEARLY_FREE = 1.5
# Given normals, or the places a face was seen from, decide where they agree by so much (-1 … 1).
AGREEMENT = 0.3
# A face was seen from a place if this share of its points was, and is not hidden from there.
SEEN_SHARE = 0.9
# Seen from its edge, to within so many spacings and the noise, either side may have been seen.
EDGE_ON_SPACINGS = 3.0
# Of the thing's other points this share is behind a face at least; otherwise both sides are alike.
BEHIND_SHARE = 0.6


# Normals, or places that not all of a thing was seen from, decide for a thing if they agree with
# free space on this share of its faces, and of the points on these. Normals of furniture sampled
# all over agree on .9 or more; those that all look up, or to a sensor, on half.
BELIEVED_SHARE = 0.75


@dataclass(frozen=True, eq=False, slots=True)
class Surroundings:
    """A cloud's points (n, 3), the region and object of each, and their spacing.

    `noise` (m,) is the sd of a region's points off it.
    `normals` (n, 3) as the file gives them and `seen_from` (n, 3), a place from which each point
    was seen; None where the file does not have them. Of the objects `partly` other places saw
    some.
    """

    points: FloatArray
    owner: NDArray[np.intp]
    bodies: NDArray[np.intp]
    noise: FloatArray
    spacing: float
    normals: FloatArray | None = None
    seen_from: FloatArray | None = None
    partly: tuple[int, ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class OuterSides:
    """Signs (m,) of planes, 1 if they look outwards and -1 if inwards.

    `is_place_wrong` says that the places it was seen from contradict free space, and were ignored;
    `wrong_normals` are the objects of which the file's normals do.
    """

    signs: NDArray[np.intp]
    is_place_wrong: bool
    wrong_normals: tuple[int, ...]


def find_outer_sides(
    planes: Sequence[Plane],
    body_of: Sequence[int],
    about: Surroundings,
    *,
    around: Collection[int] = (),
    up: FloatArray | None = None,
) -> OuterSides:
    """Return which planes look outwards.

    `planes` are those of the regions that `about.owner` numbers, `body_of` their objects. By the
    first criterion that decides: where it was seen from; the normals of the file; the side from
    which rays go further before they meet other surface; the side with less of the same object;
    up; away from the middle. Regions `around` all things, as a floor, look towards them.
    """
    faces = [
        _Face(number, np.flatnonzero(about.owner == number), plane, about)
        for number, plane in enumerate(planes)
    ]
    free = np.zeros(len(planes), dtype=np.intp)
    seen, by_normals = free.copy(), free.copy()
    inwards = free.copy()
    for number, face in enumerate(faces):
        if number in around:
            inwards[number] = 1 if float(face.plane.distance(about.points).mean()) > 0.0 else -1
        elif len(face.rows):
            free[number] = face.find_freer_side()
        if len(face.rows):
            seen[number] = face.find_seen_side()
            by_normals[number] = face.find_side_of_normals()
    weights = np.array([len(face.rows) for face in faces])
    is_place_wrong = False
    # where the normals of a floor look down, the others may, too
    wrong = set(body_of) if (inwards * by_normals < 0).any() else set[int]()
    for body in set(body_of):
        own = np.array(body_of) == body
        if body >= 0 and body in about.partly:
            agreed = _agreement(seen[own], free[own], weights[own])
            is_place_wrong |= seen[own].any() and not agreed and not _is_room(body, about)
        agreed = _agreement(by_normals[own], free[own], weights[own])
        if agreed is False and not (body >= 0 and _is_room(body, about)):
            wrong.add(body)
    by_normals[np.isin(body_of, list(wrong))] = 0
    if is_place_wrong:
        seen[:] = 0
    signs = np.where(seen != 0, seen, np.where(by_normals != 0, by_normals, free))
    signs = np.where(inwards != 0, inwards, signs)
    for number in np.flatnonzero(signs == 0).tolist():
        signs[number] = faces[number].find_likelier_side(up)
    return OuterSides(signs, bool(is_place_wrong), tuple(wrong))


def _agreement(
    stated: NDArray[np.intp], free: NDArray[np.intp], weights: NDArray[np.intp]
) -> bool | None:
    """Return whether the sides stated of an object's `own` regions agree with free space; None:
    unknown.

    Walls of a room are seen from inside, although there is more free space behind them.
    """
    both = (stated != 0) & (free != 0)
    if not both.any():
        return None
    agree = (stated == free)[both]
    shares = float(agree.mean()), float(np.average(agree, weights=weights[both]))
    return min(shares) >= BELIEVED_SHARE


def _is_room(body: int, about: Surroundings) -> bool:
    """Return whether an object is the walls round another, or round a sensor that something stands
    near.

    Only what lies within its convex hull tells walls from the outside of a thing.
    """
    own = about.points[about.bodies == body]
    try:
        sides = ConvexHull(own).equations
    except (QhullError, ValueError):  # flat, or too few points
        return False

    def find_within(places: FloatArray) -> FloatArray:
        within: FloatArray = places[(places @ sides[:, :3].T + sides[:, 3] < 0.0).all(axis=1)]
        return within

    numbers = np.unique(about.bodies[(about.bodies >= 0) & (about.bodies != body)])
    middles = [about.points[about.bodies == number].mean(axis=0) for number in numbers]
    if len(find_within(np.array(middles).reshape(-1, 3))):
        return True
    if about.seen_from is None:
        return False
    known = about.seen_from[np.isfinite(about.seen_from).all(axis=1)]
    within = find_within(np.unique(known, axis=0))
    return any(not is_empty_shell(own, about.points, place) for place in within)


def _get_clear_sign(mean: float) -> int:
    return 0 if abs(mean) < AGREEMENT else 1 if mean > 0.0 else -1


@dataclass(frozen=True, eq=False, slots=True)
class _Face:
    """A region of a cloud, the `rows` of its points, and its plane."""

    region: int
    rows: NDArray[np.intp]
    plane: Plane
    about: Surroundings

    @property
    def off(self) -> float:
        """Points farther than this from the plane are not on it."""
        return OFF_PLANE_SDS * float(self.about.noise[self.region])

    def find_seen_side(self) -> int:
        """Return the side that most points were seen from; 0 where that is not known."""
        seen_from = self.about.seen_from
        if seen_from is None:
            return 0
        rows = self.rows[np.isfinite(seen_from[self.rows]).all(axis=1)]
        if len(rows) < SEEN_SHARE * len(self.rows):
            return 0
        places, points = seen_from[rows], self.about.points[rows]
        height, away = self.plane.distance(places), np.linalg.norm(places - points, axis=1)
        # how far off the plane lines of sight pass from end to end of the face
        turn = np.abs(height) / np.maximum(away, 1e-300)
        extent = float(np.linalg.norm(np.ptp(points, axis=0)))
        clear = turn * extent > EDGE_ON_SPACINGS * self.about.spacing + self.off
        return _get_clear_sign(float((np.sign(height) * clear).mean()))

    def find_side_of_normals(self) -> int:
        """Return the side that the file's normals look to; 0 where they do not agree."""
        if self.about.normals is None:
            return 0
        own = self.about.normals[self.rows]
        known = (own @ self.plane.normal)[own.any(axis=1)]
        return _get_clear_sign(float(known.mean())) if len(known) else 0

    def find_freer_side(self) -> int:
        """Return the side from which rays go clearly further before they meet other surface; 0 if
        none.
        """
        paths = self._measure_free_paths()
        # a ray that meets nothing is as long as the whole cloud
        longest = float(np.linalg.norm(np.ptp(self.about.points, axis=0)))
        ahead, back = (np.minimum(path, longest).mean() for path in paths)
        if ahead > CLEARLY_FREE * back:
            return 1
        return -1 if back > CLEARLY_FREE * ahead else 0

    def find_likelier_side(self, up: FloatArray | None) -> int:
        """Return the side with less of the same object, else the upper one, else away from the
        middle.
        """
        sign = self._find_emptier_side() if len(self.rows) else 1
        if not sign and up is not None:
            sign = int(np.sign(np.round(float(self.plane.normal @ up), 1)))
        if not sign:
            middle = self.about.points.mean(axis=0)
            sign = 1 if float(self.plane.distance(middle)) <= 0.0 else -1
        return sign

    def _measure_free_paths(self) -> tuple[FloatArray, FloatArray]:
        """Return lengths of rays from cells of the face to other surface, before and behind it;
        inf: none.
        """
        points = self.about.points
        axes = make_plane_axes(self.plane.normal, np.roll(self.plane.normal, 1))
        width = max(CELL_SPACINGS * self.about.spacing, 1e-300)
        own = points[self.rows] @ axes.T
        low, high = own.min(axis=0), own.max(axis=0)
        shape = np.floor((high - low) / width).astype(np.intp) + 1
        height = self.plane.distance(points)
        rest = (self.about.owner != self.region) & (np.abs(height) > self.off)
        flat = points[rest] @ axes.T
        over = ((flat >= low) & (flat <= high)).all(axis=1)
        cells = np.floor((flat[over] - low) / width).astype(np.intp) @ [shape[1], 1]
        above = height[rest][over]
        used = np.unique(np.floor((own - low) / width).astype(np.intp) @ [shape[1], 1])
        paths = []
        for sign in (1.0, -1.0):
            nearest = np.full(int(shape.prod()), np.inf)
            way = sign * above > 0.0
            np.minimum.at(nearest, cells[way], np.abs(above[way]))
            paths.append(nearest[used])
        return paths[0], paths[1]

    def _find_emptier_side(self) -> int:
        """Return the side with less of the face's own object; 0 where both have about as much."""
        about = self.about
        body = np.bincount(about.bodies[self.rows] + 1).argmax() - 1
        rest = (about.bodies == body) & (about.owner != self.region) & (body >= 0)
        height = self.plane.distance(about.points[rest])
        height = height[np.abs(height) > self.off]
        if not len(height):
            return 0
        behind = float((height < 0.0).mean())
        if behind >= BEHIND_SHARE:
            return 1
        return -1 if behind <= 1.0 - BEHIND_SHARE else 0
