"""Planes through texture points: seeded by neighbours, tested against chance.

As RANSAC, but with samples of neighbouring points instead of random ones. A label, a book's cover,
boards of wood or a wall of stones show points by the dozen and hardly a straight line that two
views agree on; where the points lie on one plane, there may be a face. Such planes that no lines
propose are added to those of lines.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from facetlog.perception.detection.line_front_end.planes.plane_choice import (
    ChosenPlane,
    find_same_planes,
)
from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import (
    PlaneHypothesis,
    plane_basis,
)
from facetlog.perception.detection.line_front_end.points_3d.texture_points import TexturePoints
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import LineCloud
from facetlog.perception.flat_faces import make_plane_axes, make_ring_sides
from facetlog.perception.stable_order import descending, largest
from facetlog.perception.types import FloatArray

# Three points of each plane are a point and two of so many neighbours; so many points, evenly from
# all, seed planes.
NEIGHBOURS, SEEDS = 8, 100
# Any three points make a plane: it must be likelier than the best that so many choices offer by
# chance, and once more so that it is less than one plane in a thousand scenes.
SCENES = float(np.log(1000.0))
# A point lies on a plane within so many standard deviations.
SDS = 3.0
# Shares of the points that may lie on a plane: the likeliest is taken.
SHARES = np.array([0.02, 0.05, 0.1, 0.2, 0.4, 0.6, 0.8])
# Planes that are examined closely, of those with most points; and how often each is refitted.
BEST, FITS = 8, 3
# A plane is known by three points; fewer than so many more prove nothing, whatever they say.
MIN_POINTS = 6
# Points are one patch as far as gaps are no wider than once in a thousand by chance: of points as
# dense as by the upper quartile's third neighbours, a disc of √(log 1000 / 3) their distance.
THIRD, QUARTILE, GAP = 3, 0.75, float(np.sqrt(np.log(1000.0) / 3.0))
# A segment whose ends are this near to a plane, px, may bound a face there.
ON_PLANE_PX = 3.0


@dataclass(frozen=True, eq=False, slots=True)
class TexturePlane:
    """Plane normal · x = distance; the numbers (m,) of its inliers, which form one patch.

    `ratio` (m,) is each point's log-likelihood ratio against one that lies anywhere, and `penalty`
    the penalty that their sum must exceed, or it may be chance. It is seen from its `sides` (±1).
    """

    normal: FloatArray
    distance: float
    points: NDArray[np.intp]
    ratio: FloatArray
    penalty: float
    sides: tuple[float, ...] = (1.0, -1.0)

    @property
    def score(self) -> float:
        """The log-likelihood ratio of the patch."""
        return float(self.ratio.sum())


def texture_planes(texture: TexturePoints, pixel: float) -> tuple[TexturePlane, ...]:
    """Return patches of points on planes, those of the likeliest plane first.

    `pixel` is a pixel's length at the object: nothing is taken to be flatter than that.
    """
    count = len(texture.points)
    if count < MIN_POINTS:
        return ()
    penalty = 3 * float(np.log(count)) + SCENES
    scene = _Scene.of(texture, pixel)
    normal, distance = _seeds(texture.points)
    if not scene.spread or not len(normal):
        return ()
    gain = scene.gain(normal, distance)
    left = np.ones(count, dtype=np.bool_)
    found: list[TexturePlane] = []
    while left.sum() >= MIN_POINTS:
        best = descending(gain[left].sum(axis=0, dtype=np.float64))[:BEST]
        fits = [scene.fitted(left & (gain[:, k] > 0), left, normal[k]) for k in best]
        scores = np.array([fit.score for fit in fits])
        if not len(scores) or scores.max() < penalty:
            break
        plane = fits[largest(scores)]
        if not plane.on.any():
            break
        for patch in _patches(texture.points, plane):
            ratio = scene.ratio(plane, patch, int(left.sum()))
            if len(patch) < MIN_POINTS or ratio.sum() <= penalty:
                continue
            if not scene.bends(plane.normal, patch):
                found.append(TexturePlane(plane.normal, plane.distance, patch, ratio, penalty))
        left &= ~plane.on
    return tuple(found)


def keep_shown_patches(
    patches: Sequence[TexturePlane],
    texture: TexturePoints,
    surface: Callable[[FloatArray, FloatArray], NDArray[np.bool_]],
) -> tuple[TexturePlane, ...]:
    """Return the patches that are surface, of each what is.

    `surface`, given a normal and n points, returns whether the plane is surface round each (2, n),
    as seen from its front and its back: only those points support a patch, and from that side.
    """
    found = []
    for patch in patches:
        shown = surface(patch.normal, texture.points[patch.points])
        sides = [score > patch.penalty for score in shown @ patch.ratio]
        on = shown[sides].any(axis=0)
        if on.any():
            seen_from = tuple(side for side, may in zip((1.0, -1.0), sides, strict=True) if may)
            found.append(
                replace(patch, points=patch.points[on], ratio=patch.ratio[on], sides=seen_from)
            )
    return tuple(found)


@dataclass(frozen=True, eq=False, slots=True)
class _Fit:
    # A plane, the points (n,) on it, and how likely it is against points that lie anywhere.
    normal: FloatArray
    distance: float
    on: NDArray[np.bool_]
    score: float


@dataclass(frozen=True, eq=False, slots=True)
class _Scene:
    # Points (n, 3), their covariances (n, 3, 3), over which length they spread, and the pixel.
    points: FloatArray
    covs: FloatArray
    spread: float
    pixel: float

    @classmethod
    def of(cls, texture: TexturePoints, pixel: float) -> "_Scene":
        away = np.linalg.norm(texture.points - np.median(texture.points, axis=0), axis=1)
        # Half of what fills a cube lies within half of its side from the middle, or nearly.
        return cls(texture.points, texture.covs, 2.0 * float(np.median(away)), pixel)

    def gain(self, normal: FloatArray, distance: FloatArray) -> NDArray[np.float32]:
        """Return the log-likelihood (n, p), over that of chance, of the points on planes; 0 where
        not on.
        """
        squares = (normal[:, :, None] * normal[:, None]).reshape(-1, 9)
        # Single precision is enough to choose what is looked at closely.
        variance = (self.covs.reshape(-1, 9) @ squares.T + self.pixel**2).astype(np.float32)
        chi2 = (self.points @ normal.T - distance).astype(np.float32) ** 2 / variance
        density = np.float32(2.0 * np.log(self.spread / np.sqrt(2 * np.pi))) - np.log(variance)
        gain = np.float32(0.5) * (density - chi2)
        return np.where((chi2 < SDS**2) & (gain > 0), gain, np.float32(0.0))

    def fitted(self, on: NDArray[np.bool_], left: NDArray[np.bool_], normal: FloatArray) -> _Fit:
        """Return the plane fitted to the points on it (n,), which change with it, of those left
        (n,).
        """
        distance = 0.0
        for _ in range(FITS):
            if on.sum() < MIN_POINTS:
                return _Fit(normal, distance, on, 0.0)
            normal, distance = self._plane(on, normal)
            off = self.points @ normal - distance
            on = left & (off**2 < SDS**2 * self.variance(normal))
        density = self._density(normal, distance)[left]
        # A share of the points left lies on the plane, the others anywhere.
        scores = np.log1p(SHARES[:, None] * (density - 1.0)).sum(axis=1)
        return _Fit(normal, distance, on, float(scores.max()))

    def ratio(self, plane: _Fit, patch: NDArray[np.intp], left: int) -> FloatArray:
        """Return what each point (m,) of a patch says for it, of so many points that it may be
        among.

        That the others lie anywhere costs a little, which all of the patch's points bear.
        """
        share = len(patch) / (left + 1)
        density = self._density(plane.normal, plane.distance)[patch]
        others = (left - len(patch)) * np.log1p(-share) / len(patch)
        ratio: FloatArray = np.log1p(share * (density - 1.0)) + others
        return ratio

    def bends(self, normal: FloatArray, patch: NDArray[np.intp]) -> bool:
        """Return whether a paraboloid is so much likelier for the points (m,) of a patch than a
        plane.
        """
        points = self.points[patch]
        flat = (points - points.mean(axis=0)) @ plane_basis(normal)
        flat /= max(float(np.abs(flat).max()), 1e-300)
        u, v = flat.T
        weight = 1.0 / np.sqrt(self.variance(normal)[patch])
        bent = np.column_stack([np.ones(len(u)), u, v, u * u, u * v, v * v]) * weight[:, None]
        off = points @ normal * weight
        left = [off - a @ np.linalg.lstsq(a, off, rcond=None)[0] for a in (bent[:, :3], bent)]
        return bool(left[0] @ left[0] - left[1] @ left[1] > 2 * SCENES)

    def _density(self, normal: FloatArray, distance: float) -> FloatArray:
        # Of the points (n,) across a plane, over that of chance.
        variance = self.variance(normal)
        off = self.points @ normal - distance
        density = np.exp(-0.5 * off**2 / variance) / np.sqrt(2 * np.pi * variance)
        return np.asarray(self.spread * density)

    def variance(self, normal: FloatArray) -> FloatArray:
        """Return the variance of the points (n,) across a plane."""
        across: FloatArray = np.einsum("k,nkl,l->n", normal, self.covs, normal)
        return across + self.pixel**2

    def _plane(self, on: NDArray[np.bool_], normal: FloatArray) -> tuple[FloatArray, float]:
        # Total least squares, each point by its variance across the plane before.
        weight = 1.0 / self.variance(normal)[on]
        points = self.points[on]
        centre = weight @ points / weight.sum()
        _, _, vt = np.linalg.svd((points - centre) * np.sqrt(weight)[:, None], full_matrices=False)
        return vt[2], float(vt[2] @ centre)


def _seeds(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    # Normals (p, 3) and distances (p,) of planes through a point and two of its neighbours.
    seeds = np.linspace(0, len(points) - 1, min(len(points), SEEDS)).round().astype(np.intp)
    apart = np.linalg.norm(points[seeds, None] - points, axis=-1)
    near = np.argsort(apart, axis=1, kind="stable")[:, 1 : NEIGHBOURS + 1]
    one, other = np.array(list(combinations(range(near.shape[1]), 2))).T
    first = np.repeat(points[seeds, None], len(one), axis=1)
    normal = np.cross(points[near[:, one]] - first, points[near[:, other]] - first).reshape(-1, 3)
    size = np.linalg.norm(normal, axis=1)
    sound = size > 0
    normal = normal[sound] / size[sound, None]
    return normal, np.einsum("pk,pk->p", normal, first.reshape(-1, 3)[sound])


def _patches(points: FloatArray, plane: _Fit) -> list[NDArray[np.intp]]:
    # The points on a plane, those together that no wide gap parts; the first point's patch first.
    on = np.flatnonzero(plane.on)
    flat = points[on] @ plane_basis(plane.normal)
    apart = np.linalg.norm(flat[:, None] - flat, axis=-1)
    third = np.sort(apart, axis=1)[:, min(THIRD, len(on) - 1)]
    gap = GAP * float(np.quantile(third, QUARTILE))
    count, label = connected_components(apart <= gap, directed=False)
    return [on[label == k] for k in range(count)]


def bound_patch(points: FloatArray, normal: FloatArray, along: FloatArray | None) -> FloatArray:
    """Return the sides (4, 2, 3) of a rectangle of the plane through points (n, 3) that holds them.

    It runs `along` (3,) a direction of the plane, or else is the smallest.
    """
    height = float((points @ normal).mean())
    if along is None:
        basis = plane_basis(normal)
        corners = cv2.boxPoints(cv2.minAreaRect((points @ basis).astype(np.float32)))
        ring = np.asarray(corners, dtype=np.float64) @ basis.T
    else:
        basis = make_plane_axes(normal, along).T
        flat = points @ basis
        (left, low), (right, high) = flat.min(axis=0), flat.max(axis=0)
        box = np.array([[left, low], [right, low], [right, high], [left, high]])
        ring = box @ basis.T
    ring += height * normal
    return make_ring_sides(ring)


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
