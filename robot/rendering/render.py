"""The simulated camera: a grey picture of a world, by casting rays.

One ray through the middle of every pixel finds what is seen there; pixels in which surfaces or
light and shadow meet are then averaged over many rays, so that an edge lies where it is to a few
hundredths of a pixel.
"""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.types import Camera, FloatArray, Image, Pose
from facetlog.robot.rendering.texture import Sheet, Texture, sample
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


# A Fibonacci lattice (Niederreiter, Random Number Generation, 1992, section 5.3): seen along
# either axis its points are evenly spaced, so even an upright edge is placed to 1/34 of a pixel.
LATTICE_POINTS = 34
LATTICE_STEP = 21
# Across some directions, (5, 3) for one, the lattice has wide gaps, and an edge along them would
# be off by up to 0.07 px all the way (measured): so each pixel has it shifted, by the next number
# of an even sequence in the square, and what is left differs from pixel to pixel.
PLASTIC_NUMBER = 1.32471795724474602596
SHIFTS = np.array([PLASTIC_NUMBER**-1, PLASTIC_NUMBER**-2])
# Rays cast at a time: few enough for the processor's cache, enough to outweigh the steps a facet
# costs (fastest of 8,192 to 65,536 over block, table and cylinder).
RAYS_AT_A_TIME = 32_768
# The picture is cut from a larger one, so that the blur near its border sees true neighbours.
MARGIN_SDS = 3.0
WHITE = 255.0


def render(
    world: World,
    camera: Camera,
    pose: Pose,
    *,
    noise_sd: float = 5.0,
    blur_px: float = 1.0,
    rng: np.random.Generator,
) -> Image:
    """Return grey picture (H, W) of the world: Lambert and ambient light, cast shadows, blur,
    noise.

    `noise_sd` is in grey levels, `blur_px` the sd of the lens blur. The middle of the top-left
    pixel is (0, 0).
    """
    margin = math.ceil(MARGIN_SDS * blur_px)
    grey = _render_irradiance(_Stage.of(world, camera, pose), margin=margin)
    if blur_px > 0:
        grey = np.asarray(cv2.GaussianBlur(grey, (0, 0), blur_px), dtype=np.float64)
    grey = grey[margin : margin + camera.height, margin : margin + camera.width]
    if noise_sd > 0:
        grey = grey + rng.normal(0.0, noise_sd, grey.shape)
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


def _render_irradiance(stage: "_Stage", *, margin: int) -> FloatArray:
    """Return the picture before blur and noise, with `margin` more pixels on every side."""
    rows = stage.camera.height + 2 * margin
    columns = stage.camera.width + 2 * margin
    v, u = np.mgrid[0:rows, 0:columns].astype(np.float64) - margin
    uv = np.stack([u.ravel(), v.ravel()])
    flat, surface = np.empty(rows * columns), np.empty(rows * columns, dtype=np.intp)
    for start in range(0, rows * columns, RAYS_AT_A_TIME):
        part = slice(start, start + RAYS_AT_A_TIME)
        flat[part], surface[part] = _shade_pixels(stage, uv[:, part], spacing=1.0)

    mixed = np.flatnonzero(_find_differing(surface.reshape(rows, columns)))
    i = np.arange(LATTICE_POINTS)
    lattice = np.stack([i, i * LATTICE_STEP % LATTICE_POINTS]) / LATTICE_POINTS
    step = RAYS_AT_A_TIME // LATTICE_POINTS
    for start in range(0, len(mixed), step):
        pixels = mixed[start : start + step]
        offsets = (lattice[:, None, :] + (SHIFTS[:, None] * pixels)[:, :, None]) % 1.0 - 0.5
        rays = (uv[:, pixels, None] + offsets).reshape(2, -1)
        fine, _ = _shade_pixels(stage, rays, spacing=LATTICE_POINTS**-0.5)
        flat[pixels] = fine.reshape(-1, LATTICE_POINTS).mean(axis=1)
    return flat.reshape(rows, columns)


def _find_differing(surface: IndexArray) -> IndexArray:
    """Return pixels one of whose eight neighbours shows another surface, or the same in other
    light."""
    cells = surface.astype(np.float32)  # exact: numbers of surfaces stay far below 2^24
    square = np.ones((3, 3), np.uint8)
    return np.asarray(cv2.dilate(cells, square) != cv2.erode(cells, square))


@dataclass(frozen=True, eq=False, slots=True)
class _Stage:
    """All that is the same for every ray of a picture.

    `in_sun` and `in_shade` are the greys of each facet in either light, `surfaces` its number;
    the floor has index FLOOR there.
    """

    world: World
    camera: Camera
    pose: Pose
    seen: Screen
    sunlit: Screen
    in_sun: FloatArray
    in_shade: FloatArray
    surfaces: IndexArray

    @classmethod
    def of(cls, world: World, camera: Camera, pose: Pose) -> "_Stage":
        seen, sunlit = seen_by(world, camera, pose), find_facets_to_sun(world)
        return cls(world, camera, pose, seen, sunlit, *_tables(world))


def _shade_pixels(
    stage: _Stage, uv: FloatArray, *, spacing: float
) -> tuple[FloatArray, IndexArray]:
    """Return grey (n,) seen through pixels uv (2, n), and a number (n,) per surface and light.

    `spacing` is how far apart the rays are, in pixels.
    """
    hits = find_first_hits(stage.world, stage.camera, stage.pose, stage.seen, uv)
    solid = np.flatnonzero(hits.facet != BACKGROUND)
    facet = hits.facet[solid]
    points = hits.directions.take(solid, axis=1) * hits.depth[solid] + stage.pose.centre[:, None]

    lit = stage.in_sun[facet] > stage.in_shade[facet]
    sunny = np.flatnonzero(lit)
    lit[sunny] = ~in_shadow(stage.world, stage.sunlit, points.take(sunny, axis=1))
    grey = np.full(uv.shape[1], float(stage.world.background))
    grey[solid] = np.where(lit, stage.in_sun[facet], stage.in_shade[facet])
    _apply_prints(grey, stage, hits, solid, points, spacing)
    surface = np.full(uv.shape[1], BACKGROUND, dtype=np.intp)
    surface[solid] = 2 * stage.surfaces[facet] + lit
    return grey, surface


def _tables(world: World) -> tuple[FloatArray, FloatArray, IndexArray]:
    """Return grey in the sun, grey in the shade and number of the surface, of each facet and at
    FLOOR."""
    rows = len(world.facets) + 2  # FLOOR and BACKGROUND count from the end
    normals, albedos = np.zeros((rows, 3)), np.zeros(rows)
    surfaces = np.zeros(rows, dtype=np.intp)
    for i, facet in enumerate(world.facets):
        normals[i], albedos[i], surfaces[i] = facet.normal, facet.albedo, facet.surface
    normals[FLOOR] = 0.0, 0.0, 1.0
    albedos[FLOOR] = world.floor.albedo if world.floor is not None else 0.0
    surfaces[FLOOR] = 2 * rows
    # Lambert: I = exposure albedo (ambient + (1 - ambient) max(0, n·s))
    albedos *= WHITE * world.exposure
    shade = albedos * _ambient(world, normals)
    sun = albedos * (1 - world.ambient) * np.maximum(normals @ world.sun, 0.0)
    return shade + sun, shade, surfaces


def _ambient(world: World, normals: FloatArray) -> FloatArray:
    """Return ambient light on faces with these normals (n, 3): a little more on the window's
    side."""
    window = np.cross([0.0, 0.0, 1.0], world.sun)
    length = np.linalg.norm(window)
    window = window / length if length > 0 else np.array([1.0, 0.0, 0.0])
    return np.asarray(world.ambient * (1 - world.sided / 2 * (1 - normals @ window)))


def _apply_prints(
    grey: FloatArray,
    stage: _Stage,
    hits: Hits,
    solid: IndexArray,
    points: FloatArray,
    spacing: float,
) -> None:
    """Multiply grey (n,) by the textures at the `points` (3, m) that the rays `solid` (m,) meet."""
    facet = hits.facet[solid]
    world = stage.world
    textured: list[tuple[int, Texture | Sheet, FloatArray, FloatArray, FloatArray]] = [
        (i, f.texture, f.origin, f.axes, f.normal) for i, f in enumerate(world.facets) if f.texture
    ]
    if world.floor is not None and world.floor.texture is not None:
        level = np.eye(3)
        textured.append((FLOOR, world.floor.texture, np.zeros(3), level[:2], level[2]))
    for index, texture, origin, axes, normal in textured:
        here = np.flatnonzero(facet == index)
        if len(here):
            rays = solid[here]
            d = hits.directions.take(rays, axis=1)
            # A square pixel covers a rectangle of sides depth/f and depth/(f cos), cos = -n·d/|d|.
            cos = np.abs(normal @ d) / np.sqrt((d * d).sum(axis=0))
            footprint = spacing / stage.camera.fx * hits.depth[rays] / np.sqrt(cos)
            grey[rays] *= sample(
                texture, axes @ points.take(here, axis=1) - (axes @ origin)[:, None], footprint
            )
