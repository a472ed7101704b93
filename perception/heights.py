"""What follows from a known up: tilt, heights in a thing, overlap in plan, free height below."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.contacts import Bend, SideContact
from facetlog.perception.flat_faces import Estimate, FlatFace, plane_axes, vertex_sd
from facetlog.perception.measures import least_rectangle
from facetlog.perception.relations import projected
from facetlog.perception.things import Thing, components
from facetlog.perception.tolerance import ANGLE_RESOLUTION, Tolerance
from facetlog.perception.types import FloatArray, Plane, Scene

__all__ = ["Ground", "clear_below", "elevation", "extremes", "overlaps", "tilt", "vertical_sense"]

# A face this near to upright has a line for a plan (the vocabulary's "upright": 80° and more).
UPRIGHT = np.deg2rad(10.0)
# "Points up" needs 2 sd: 97.7 % one-sided.
SENSE_SDS = 2.0
# Free height "under most of it": 80 %, the vocabulary's figure.
MOST = 0.8
# Rays a side of the grid under a face: 1 % steps of its plan.
RAYS = 10
# Less overlap than this share is not stated; two faces of one solid share a rim of rounding.
LEAST_OVERLAP = 1e-3


def tilt(plane: Plane, up: FloatArray) -> Estimate:
    """Angle between the plane and the level, radians, 0..π/2, up taken as exact."""
    rise = float(plane.normal @ up)
    lean = up - rise * plane.normal
    size = float(np.linalg.norm(lean))
    cov = plane.cov[:3, :3]
    if size < ANGLE_RESOLUTION:
        variance = float(np.linalg.eigvalsh(cov)[-1])
    else:
        variance = float(lean @ cov @ lean) / size**2
    return Estimate(float(np.arctan2(size, abs(rise))), float(np.sqrt(max(variance, 0.0))))


def vertical_sense(plane: Plane, up: FloatArray) -> int:
    """1 if the normal points above the horizon by more than 2 sd, -1 if below, else 0."""
    leaning = tilt(plane, up)
    if np.pi / 2 - leaning.value <= SENSE_SDS * leaning.sd + ANGLE_RESOLUTION:
        return 0
    return 1 if plane.normal @ up > 0.0 else -1


@dataclass(frozen=True, eq=False, slots=True)
class Ground:
    """The lowest of a thing's vertices, with those level with it: what its heights count from.

    `heights` (n,) and `variances` (n,) are those of all the scene's vertices, along up.
    """

    vertices: NDArray[np.intp]
    heights: FloatArray
    variances: FloatArray
    tolerance: Tolerance
    up: FloatArray

    @classmethod
    def under(
        cls,
        members: Iterable[int],
        points: FloatArray,
        covs: FloatArray,
        tolerance: Tolerance,
        up: FloatArray,
    ) -> "Ground":
        """The ground of a thing with these vertices."""
        own = np.array(list(members), dtype=np.intp)
        heights = points @ up
        equal = tolerance.highest(own, -heights[own])
        return cls(own[equal], heights, up @ covs @ up, tolerance, up)

    def above(self, vertices: NDArray[np.intp], weights: FloatArray) -> Estimate:
        """Weighted height of some vertices (weights of sum 1) less the ground's, and its 1σ."""
        rows = np.concatenate((vertices, self.vertices))
        base = np.full(len(self.vertices), -1.0 / len(self.vertices))
        shares = np.bincount(rows, np.concatenate((weights, base)))
        shares, used = shares[rows], np.unique(rows, return_index=True)[1]
        variance = float((shares**2 * self.variances[rows])[used].sum())
        value = float((shares * self.heights[rows])[used].sum())
        return Estimate(value, math.sqrt(max(variance, 0.0)))


def extremes(members: Iterable[int], ground: Ground) -> tuple[Estimate, Estimate]:
    """Heights of the highest and the lowest of some vertices above the ground."""
    own = np.array(list(members), dtype=np.intp)
    found = []
    for sign in (1.0, -1.0):
        equal = own[ground.tolerance.highest(own, sign * ground.heights[own])]
        found.append(ground.above(equal, np.full(len(equal), 1.0 / len(equal))))
    return found[0], found[1]


def elevation(face: FlatFace, ground: Ground, covs: FloatArray) -> Estimate:
    """Height of the face's middle above the ground; `covs` (n, 3, 3) are the vertices'."""
    members = list(face.members)
    base = float(ground.heights[ground.vertices].mean())
    slope = ground.up @ face.middle_slope
    for i in ground.vertices.tolist():
        if i in members:
            slope[members.index(i)] -= ground.up / len(ground.vertices)
    others = [i for i in ground.vertices.tolist() if i not in members]
    rest = float(ground.variances[others].sum()) / len(ground.vertices) ** 2
    sd = math.hypot(vertex_sd(slope, covs[members]), math.sqrt(max(rest, 0.0)))
    return Estimate(float(face.middle @ ground.up) - base, sd)


def _plans(
    scene: Scene, faces: tuple[FlatFace, ...], up: FloatArray
) -> tuple[list[FlatFace], NDArray[np.object_], FloatArray]:
    """Faces that are not upright, their plans (n,), and the plan's axes (2, 3)."""
    least = np.sin(UPRIGHT)
    lying = [f for f in faces if abs(float(f.normal @ up)) > least and f.area > 0.0]
    axes = plane_axes(up, lying[0].axes[0] if lying else np.eye(3)[0])
    if not lying:
        return [], np.zeros(0, dtype=np.object_), axes
    plans = projected(lying, scene.points, [axes] * len(lying))
    seen = shapely.area(plans) > 0.0
    return [f for f, there in zip(lying, seen.tolist(), strict=True) if there], plans[seen], axes


def overlaps(
    scene: Scene, faces: tuple[FlatFace, ...], up: FloatArray
) -> list[tuple[int, int, float]]:
    """(i, j, share) for pairs i < j whose plans overlap: the intersection over the smaller plan."""
    lying, plans, _ = _plans(scene, faces, up)
    areas = shapely.area(plans)
    one, two = shapely.STRtree(plans).query(plans, predicate="intersects")
    one, two = one[one < two], two[one < two]
    shares = shapely.area(shapely.intersection(plans[one], plans[two]))
    shares /= np.minimum(areas[one], areas[two])
    return [
        (lying[i].index, lying[j].index, min(r, 1.0))
        for i, j, r in zip(one.tolist(), two.tolist(), shares.tolist(), strict=True)
        if r >= LEAST_OVERLAP
    ]


def _ray_grid(plan: shapely.Geometry) -> FloatArray:
    """Points (n, 2) of a grid square to the plan's least rectangle, those within the plan."""
    corners = shapely.get_coordinates(plan)
    direction, length, width = least_rectangle(corners)
    frame = np.array([direction, [-direction[1], direction[0]]])
    low = (corners @ frame.T).min(axis=0)
    steps = (np.arange(RAYS) + 0.5) / RAYS
    across, along = np.meshgrid(low[1] + width * steps, low[0] + length * steps)
    grid = np.column_stack([along.ravel(), across.ravel()]) @ frame
    inside = grid[shapely.contains_xy(plan, grid)]
    if not len(inside):
        inside = shapely.get_coordinates(plan.representative_point())
    return np.asarray(inside, dtype=np.float64)


def _solid_down_to(
    scene: Scene,
    faces: tuple[FlatFace, ...],
    contacts: tuple[tuple[SideContact, Bend], ...],
    senses: NDArray[np.int64],
    up: FloatArray,
) -> FloatArray:
    """For every upward face the height to which the solid under it reaches, as far as is seen.

    Upward faces that meet convexly or flat roof one solid. It reaches down as far as the shortest
    of the other faces that meet the roof convexly; a roof without such sides is but itself, down
    to its lowest point. (A table's slab is as deep as its rim, a block as its sides.)
    """
    points = scene.points
    bottoms = np.array([float((points[list(f.outline)] @ up).min()) for f in faces])
    bends = [(c.first.face, c.second.face, b) for c, b in contacts if c.against]
    roofs = np.array(
        components(
            len(faces),
            ((i, j) for i, j, b in bends if senses[i] > 0 and senses[j] > 0 and not b.concave),
        )
    )
    count = int(roofs.max()) + 1
    sides = np.full(count, -np.inf)
    for i, j, b in bends:
        if b.convex and (senses[i] > 0) != (senses[j] > 0):
            roof, side = (i, j) if senses[i] > 0 else (j, i)
            sides[roofs[roof]] = max(sides[roofs[roof]], bottoms[side])
    own = np.full(count, np.inf)
    np.minimum.at(own, roofs, bottoms)
    return np.asarray(np.where(np.isfinite(sides), sides, own)[roofs], dtype=np.float64)


def _first_below(
    rays: NDArray[np.intp], heights: FloatArray, limits: FloatArray
) -> NDArray[np.intp]:
    """For every ray the number of its highest hit below its limit (rays,), or -1."""
    first = np.full(len(limits), -1, dtype=np.intp)
    below = np.flatnonzero(heights < limits[rays])
    order = below[np.argsort(heights[below], kind="stable")]
    first[rays[order]] = order  # the last assignment, the highest, stays
    return first


def clear_below(
    scene: Scene,
    faces: tuple[FlatFace, ...],
    things: tuple[Thing, ...],
    contacts: tuple[tuple[SideContact, Bend], ...],
    up: FloatArray,
) -> dict[int, float]:
    """Free height under 80 % of each face that is not upright, by a grid of rays downwards.

    A ray from an upward face starts in the solid: it leaves it through the next downward face, or,
    if none was seen, where the sides of the solid end. From there it is free down to the next
    face of any thing, or to the level of the lowest point of its own.
    """
    lying, plans, axes = _plans(scene, faces, up)
    if not lying:
        return {}
    points = scene.points
    grids = [_ray_grid(plan) for plan in plans]
    owner = np.repeat(np.arange(len(lying)), [len(g) for g in grids])
    where = np.concatenate(grids)
    normals = np.array([f.normal for f in lying])
    middles = np.array([f.middle for f in lying])
    rise = normals @ up
    base = middles @ up
    slopes = -(normals @ axes.T) / rise[:, None]  # height of a plane over the plan, per unit
    base = base - np.einsum("ij,ij->i", slopes, middles @ axes.T)

    ray, hit = shapely.STRtree(plans).query(shapely.points(where), predicate="intersects")
    other = hit != owner[ray]
    ray, hit = ray[other], hit[other]
    heights = base[hit] + np.einsum("ij,ij->i", slopes[hit], where[ray])
    start = base[owner] + np.einsum("ij,ij->i", slopes[owner], where)
    resolution = Tolerance.of(scene).finest

    senses = np.array([vertical_sense(scene.faces[f.index].plane, up) for f in faces])
    ground = np.empty(len(faces))
    for thing in things:
        members = [i for f in thing.faces for i in faces[f].members]
        members += [i for e in thing.edges for i in (scene.edges[e].start, scene.edges[e].end)]
        ground[list(thing.faces)] = (points[members] @ up).min()
    solid = _solid_down_to(scene, faces, contacts, senses, up)
    index = np.array([f.index for f in lying])
    from_above = (senses[index] > 0)[owner]

    first = _first_below(ray, heights, start - resolution)
    heights, hit = np.append(heights, -np.inf), np.append(hit, 0)  # what -1, no hit, points at
    leaves = from_above & (first >= 0) & (senses[index[hit[first]]] < 0)
    sides_end = np.minimum(start, solid[index[owner]])
    free_from = np.where(leaves, heights[first], np.where(from_above, sides_end, start))
    limit = np.where(leaves, free_from, start) - resolution
    last = _first_below(ray, heights[:-1], limit)
    floor = np.maximum(heights[last], ground[index[owner]])
    clear = np.maximum(free_from - floor, 0.0)
    return {
        face.index: float(np.quantile(clear[owner == nth], 1.0 - MOST, method="lower"))
        for nth, face in enumerate(lying)
    }
