"""Ray casting: the first facet that a ray hits, and shadow rays; exact, by plane and outline."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.types import Camera, FloatArray, Pose
from facetlog.robot.rendering.world import Facet, World

IndexArray = NDArray[np.intp]
BoolArray = NDArray[np.bool_]

BACKGROUND = -1
FLOOR = -2

# Nearer to the pinhole than this share of a face's own size nothing is seen of it.
NEAR_SHARE = 1e-6
# A face shades only points further off than this share of its size: rounding, not shadow.
CONTACT_SHARE = 1e-7


@dataclass(frozen=True, eq=False, slots=True)
class Hits:
    """Per ray (n,): index of the facet (or FLOOR, BACKGROUND) and depth along the optical axis.

    `directions` (3, n) are the rays in the world frame with one unit along the optical axis, so
    the point met is centre + depth * direction; the depth of the background is infinite.
    """

    facet: IndexArray
    depth: FloatArray
    directions: FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class Screened:
    """A facet that faces the eye: its index and its bounds (u0, v0, u1, v1) on the screen."""

    index: int
    facet: Facet
    box: FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class Screen:
    """The front-facing facets, solid by solid, each solid with the bounds of all of its facets."""

    solids: tuple[tuple[FloatArray, tuple[Screened, ...]], ...]


def seen_by(world: World, camera: Camera, pose: Pose) -> Screen:
    """Return the facets turned to the camera and not behind it, with their bounds in pixels."""
    found = []
    for index, facet in enumerate(world.facets):
        if facet.normal @ (pose.centre - facet.corners[0]) > 0:
            box = _find_picture_box(facet, camera, pose)
            if box is not None:
                found.append(Screened(index, facet, box))
    return _screen(found)


def find_facets_to_sun(world: World) -> Screen:
    """Return the facets turned to the sun, with their bounds on a plane square to its rays."""
    across = _find_axes_square_to(world.sun)
    found = []
    for index, facet in enumerate(world.facets):
        if facet.normal @ world.sun > 0:
            flat = facet.corners @ across.T
            box = np.concatenate([flat.min(axis=0), flat.max(axis=0)])
            found.append(Screened(index, facet, box))
    return _screen(found)


def find_first_hits(
    world: World, camera: Camera, pose: Pose, screen: Screen, uv: FloatArray
) -> Hits:
    """Return the first surface that the rays through pixels uv (2, n) meet; faces are one-sided.

    `screen` is that of `seen_by` for the same camera.
    """
    u, v = uv
    x_camera, y_camera = (u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy
    directions = pose.rotation[:, :2] @ np.stack([x_camera, y_camera])
    directions += pose.rotation[:, 2:]
    depth = np.full(len(u), np.inf)
    facet_of = np.full(len(u), BACKGROUND, dtype=np.intp)
    if world.floor is not None and pose.centre[2] > 0:
        down = directions[2] < 0
        np.divide(-pose.centre[2], directions[2], out=depth, where=down)
        facet_of[down] = FLOOR

    for solid_box, facets in screen.solids:
        near_solid = _within(u, v, solid_box)
        if not len(near_solid):
            continue
        u_near, v_near = u[near_solid], v[near_solid]
        for screened in facets:
            facet = screened.facet
            rays = near_solid[_within(u_near, v_near, screened.box)]
            d = directions.take(rays, axis=1)
            # centre + t d meets the plane at t = n·(origin - centre) / n·d
            slope = facet.normal @ d
            towards = slope < 0
            if not towards.all():
                rays, d, slope = rays[towards], d[:, towards], slope[towards]
            t = facet.normal @ (facet.origin - pose.centre) / slope
            x, y = facet.axes @ d * t + (facet.axes @ (pose.centre - facet.origin))[:, None]
            hit = (t > _near(facet)) & (t < depth[rays]) & _inside(facet, x, y)
            depth[rays[hit]] = t[hit]
            facet_of[rays[hit]] = screened.index
    return Hits(facet_of, depth, directions)


def in_shadow(world: World, screen: Screen, points: FloatArray) -> BoolArray:
    """Return whether a solid stands between each point (3, n) and the sun, (n,).

    `screen` is that of `find_facets_to_sun` for the world.
    """
    p, q = _find_axes_square_to(world.sun) @ points
    shadowed = np.zeros(len(p), dtype=np.bool_)
    for solid_box, facets in screen.solids:
        near_solid = _within(p, q, solid_box)
        if not len(near_solid):
            continue
        p_near, q_near = p[near_solid], q[near_solid]
        for screened in facets:
            facet = screened.facet
            which = near_solid[_within(p_near, q_near, screened.box)]
            start = points.take(which, axis=1) - facet.origin[:, None]
            t = -(facet.normal @ start) / (facet.normal @ world.sun)
            x, y = facet.axes @ start + t * (facet.axes @ world.sun)[:, None]
            contact = CONTACT_SHARE * facet.reach
            shadowed[which[(t > contact) & _inside(facet, x, y)]] = True
    return shadowed


def _inside(facet: Facet, x: FloatArray, y: FloatArray) -> BoolArray:
    """Return whether points of the facet's plane lie within its outline."""
    if facet.convex:
        inside = np.ones(len(x), dtype=np.bool_)
        for x0, y0, x1, y1 in facet.sides:
            inside &= (x1 - x0) * (y - y0) >= (y1 - y0) * (x - x0)
        return inside
    inside = np.zeros(len(x), dtype=np.bool_)  # crossings to the right, even or odd
    for x0, y0, x1, y1 in facet.sides:
        if y0 != y1:
            inside ^= ((y0 > y) != (y1 > y)) & (x < x0 + (x1 - x0) * (y - y0) / (y1 - y0))
    return inside


def _near(facet: Facet) -> float:
    return NEAR_SHARE * facet.reach


def _find_picture_box(facet: Facet, camera: Camera, pose: Pose) -> FloatArray | None:
    """Return bounds (u0, v0, u1, v1) of the part of a facet before the near plane, None if none
    is."""
    corners = (facet.corners - pose.centre) @ pose.rotation
    near = _near(facet)
    before = corners[:, 2] >= near
    if not before.any():
        return None
    kept = [corners[before]]
    after = np.roll(corners, -1, axis=0)
    crossing = before != np.roll(before, -1)
    if crossing.any():
        a, b = corners[crossing], after[crossing]
        share = (near - a[:, 2]) / (b[:, 2] - a[:, 2])
        kept.append(a + share[:, None] * (b - a))
    x, y, z = np.concatenate(kept).T
    z = np.maximum(z, near)
    u, v = camera.fx * x / z + camera.cx, camera.fy * y / z + camera.cy
    return np.array([u.min(), v.min(), u.max(), v.max()])


def _within(u: FloatArray, v: FloatArray, box: FloatArray) -> IndexArray:
    return np.flatnonzero((u >= box[0]) & (u <= box[2]) & (v >= box[1]) & (v <= box[3]))


def _screen(found: list[Screened]) -> Screen:
    by_solid: dict[int, list[Screened]] = {}
    for screened in found:
        by_solid.setdefault(screened.facet.solid, []).append(screened)
    solids = []
    for facets in by_solid.values():
        boxes = np.array([f.box for f in facets])
        bounds = np.concatenate([boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)])
        solids.append((bounds, tuple(facets)))
    return Screen(tuple(solids))


def _find_axes_square_to(direction: FloatArray) -> FloatArray:
    """Return two unit vectors (2, 3) square to a unit vector and to each other."""
    first = np.cross(direction, np.eye(3)[int(np.argmin(np.abs(direction)))])
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(direction, first)])
