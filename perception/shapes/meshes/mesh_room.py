"""Walls and ceiling of a room round a floor, so that what stands in it is judged, not the room.

Walls are large upright planes at the floor's rim, from the floor upwards, and nothing but their own
thickness is beyond them. So are a crate's, and a crate may hold a bottle: only size tells a room
from it, and without metres nothing is a room.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.flat_faces import plane_axes
from facetlog.perception.ragged import group_sums, joined
from facetlog.perception.shapes.meshes.clean_mesh import Surface
from facetlog.perception.shapes.meshes.mesh_planes import LargePlane, iter_planes
from facetlog.perception.shapes.regions.floor_and_walls import LEAST_ROOM
from facetlog.perception.types import FloatArray

__all__ = ["UPRIGHT", "find_room", "leftovers"]

# Normals within 20 degrees of level are of something upright (sine).
UPRIGHT = float(np.sin(np.deg2rad(20.0)))
# A wall is so much of the floor's extent long and of everything's height high, and so much of that
# rectangle is surface: the rest are doors and windows.
WALL_SHARE = 0.5
WALL_FILL = 0.4
# It begins within this share of its height from the floor, and lies within this share of the
# floor's extent from the floor's rim.
NEAR_SHARE = 0.1
# No more than this share of its own surface is beyond it: the ends and the outside of a solid wall.
BEYOND_SHARE = 0.3
# Directions of walls, a bin each, in half a turn.
BINS = 36
# Pieces this many roughnesses from a plane are dents and bumps of it.
BUMPS = 2.0


@dataclass(frozen=True, eq=False, slots=True)
class _Space:
    """What a wall is measured against: the floor's points, and everything's height above it."""

    surface: Surface
    up: FloatArray
    level: float
    floor_points: FloatArray
    height: float

    def is_wall(self, plane: LargePlane, taken: NDArray[np.bool_]) -> bool:
        """Whether a plane, its normal outwards, is a wall; `taken` (m,) are walls already."""
        surface = self.surface
        corners = surface.points[np.unique(surface.triangles[plane.triangles])]
        along = np.cross(self.up, plane.normal)
        along /= np.linalg.norm(along)
        low, high = float((corners @ self.up).min()), float((corners @ self.up).max())
        length, height = float(np.ptp(corners @ along)), high - low
        area = float(surface.areas[plane.triangles].sum())
        rim = plane.heights(self.floor_points)
        return (
            height >= max(LEAST_ROOM, WALL_SHARE * self.height)
            and low - self.level <= NEAR_SHARE * height
            and length >= WALL_SHARE * float(np.ptp(self.floor_points @ along))
            and area >= WALL_FILL * length * height
            and abs(float(rim.max())) <= NEAR_SHARE * float(np.ptp(rim))
            and self._area_beyond(plane, taken) <= BEYOND_SHARE * area
        )

    def is_ceiling(self, plane: LargePlane, taken: NDArray[np.bool_], least: float) -> bool:
        """Whether a level plane, its normal up, is a ceiling of this area at least."""
        area = float(self.surface.areas[plane.triangles].sum())
        middle = self.floor_points.mean(axis=0)
        return (
            area >= least
            and -float(plane.heights(middle[None])[0]) >= (1.0 - NEAR_SHARE) * self.height
            and self._area_beyond(plane, taken) <= BEYOND_SHARE * area
        )

    def _area_beyond(self, plane: LargePlane, taken: NDArray[np.bool_]) -> float:
        surface = self.surface
        heights = plane.heights(surface.points)[surface.triangles].mean(axis=1)
        beyond = (heights > BUMPS * plane.slack) & ~taken & ~plane.triangles
        return float(surface.areas[beyond].sum())


def find_room(
    surface: Surface, floor: NDArray[np.bool_], level: float, up: FloatArray
) -> tuple[LargePlane, ...]:
    """The walls and the ceiling round a floor, normals outwards; none where it is no room.

    `floor` (m,) are the floor's triangles and `level` is their height along `up` (3,), in metres.
    """
    floor_points = surface.points[np.unique(surface.triangles[floor])]
    height = float((surface.points[surface.triangles] @ up).max()) - level
    plan = floor_points @ plane_axes(up, np.roll(up, 1)).T
    if height < LEAST_ROOM or _breadth(plan) < LEAST_ROOM:
        return ()
    space = _Space(surface, up, level, floor_points, height)
    upright = np.abs(surface.normals @ up) <= UPRIGHT
    middle = floor_points.mean(axis=0)
    taken = floor.copy()
    candidates = [
        _turned_away(plane, middle)
        for way in _directions(surface, upright & ~floor, up)
        for plane in iter_planes(surface, way, upright & ~floor)
    ]
    walls: list[LargePlane] = []
    for plane in sorted(candidates, key=lambda plane: float(plane.heights(middle[None])[0])):
        if space.is_wall(plane, taken):
            walls.append(plane)
            taken |= plane.triangles
    if not walls:
        return ()
    least = WALL_SHARE * float((surface.areas * np.abs(surface.normals @ up))[floor].sum())
    ceilings = sorted(iter_planes(surface, up, ~taken), key=lambda plane: -plane.offset)
    for plane in ceilings:
        if space.is_ceiling(plane, taken, least):
            walls.append(plane)
            taken |= plane.triangles
    return tuple(walls)


def leftovers(
    surface: Surface, taken: NDArray[np.bool_], planes: tuple[LargePlane, ...]
) -> NDArray[np.bool_]:
    """What of the other triangles is part of these planes, their normals outwards, the floor first:
    bumps of one of them, and pieces just beyond it, as a wall's ends.
    """
    floor = surface.points[np.unique(surface.triangles[planes[0].triangles])]
    reach = NEAR_SHARE * float(np.linalg.norm(np.ptp(floor, axis=0)))
    left = ~taken
    count, piece = joined(len(taken), surface.links[left[surface.links].all(axis=1)])
    part, bumps = np.zeros(count, dtype=bool), np.zeros(len(taken), dtype=bool)
    for plane in planes:
        heights = plane.heights(surface.points)
        bumps |= (np.abs(heights) <= BUMPS * plane.slack)[surface.triangles].all(axis=1)
        apart = (heights < -BUMPS * plane.slack) | (heights > reach)
        part |= group_sums(piece, apart[surface.triangles].any(axis=1), count) == 0.0
    return (part[piece] | bumps) & left


def _turned_away(plane: LargePlane, middle: FloatArray) -> LargePlane:
    """The plane with its normal away from a point."""
    if float(plane.heights(middle[None])[0]) <= 0.0:
        return plane
    return LargePlane(-plane.normal, -plane.offset, plane.slack, plane.triangles)


def _directions(
    surface: Surface, upright: NDArray[np.bool_], up: FloatArray
) -> Iterator[FloatArray]:
    """Level directions (3,) along which most upright surface points, either way."""
    axes = plane_axes(up, np.roll(up, 1))
    flat = surface.normals[upright] @ axes.T
    areas = surface.areas[upright]
    turn = np.arctan2(flat[:, 1], flat[:, 0]) % np.pi
    bins = np.bincount((turn * (BINS / np.pi)).astype(np.int64) % BINS, areas, minlength=BINS)
    # a direction at the limit of two bins counts in both
    smooth = bins + np.roll(bins, 1)
    for _ in range(4):
        best = int(np.argmax(smooth))
        if not smooth[best] > NEAR_SHARE * areas.sum():
            return
        centre = best * np.pi / BINS
        near = np.abs(np.sin(turn - centre)) <= UPRIGHT
        # the mean of directions without a sign: of twice the angle
        doubled = float(
            np.arctan2(
                (areas[near] * np.sin(2.0 * turn[near])).sum(),
                (areas[near] * np.cos(2.0 * turn[near])).sum(),
            )
        )
        yield np.array([np.cos(0.5 * doubled), np.sin(0.5 * doubled)]) @ axes
        smooth[np.abs(np.sin((np.arange(BINS) - best) * np.pi / BINS)) <= UPRIGHT] = 0.0


def _breadth(plan: FloatArray) -> float:
    """The least breadth of points (n, 2) over a quarter of 32 directions."""
    turns = np.arange(32) * np.pi / 32
    ways = np.column_stack([np.cos(turns), np.sin(turns)])
    return float(np.ptp(plan @ ways.T, axis=0).min())
