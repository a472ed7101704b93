"""Fill holes of parts that are one part with them: a pipe, a mug, a bored board, a worktop's sink.

A hole opens at a loop within a flat face. It is filled if the loop is round, whatever its size, or
if the face is that of a board of which its holes take little; else what is round it is cut into
bars, as of a frame, or boards, as of a crate.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import shapely

from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.pieces.exact.box_cover import BOARD
from facetlog.perception.pieces.exact.cap_sheets import cap_loop
from facetlog.perception.pieces.exact.regions import PLANE_SLACK, Regions
from facetlog.perception.pieces.exact.sheets import Sheets, measure_triangles
from facetlog.perception.pieces.exact.wind_bodies import run_along
from facetlog.perception.ragged import (
    Bools,
    Indices,
    iter_groups,
    joined,
    sum_by_group,
    unique_rows,
)
from facetlog.perception.types import FloatArray

# A loop is round if its isoperimetric quotient 4 π A / P² is larger: .948 is that of an octagon.
ROUND = 0.93
# Holes of any shape may take this share of a board: frames of bars have more.
HOLES = 0.25
# A floor faces the mouth of its hole to this cosine, 45°; walls do not.
LEVEL = np.sqrt(0.5)


@dataclass(frozen=True, eq=False, slots=True)
class _Border:
    """Sides of flat regions: the region, the pair (k,), which side of it, start and end (k, 2), the
    loop (k,) of each, and the signed area of each loop, less than zero where it bounds a hole.
    """

    region: Indices
    pair: Indices
    side: Indices
    ends: Indices
    loop: Indices
    areas: FloatArray


def fill_hollows(sheets: Sheets, regions: Regions) -> Sheets:
    """Return the sheets without the walls of holes that belong to a part, their mouths closed."""
    border = _find_borders(sheets, regions)
    if border is None:
        return sheets
    walls = _Walls(sheets, regions, border)
    wall = np.full(len(sheets.triangles), -1)
    for number, mouth in enumerate(walls.mouths):
        rows = walls.find_wall(mouth)
        if rows is not None and (wall[rows] < 0).all():
            wall[rows] = number
    caps = _make_caps(sheets, wall)
    return _replace_walls(sheets, wall >= 0, caps) if caps else sheets


def _find_borders(sheets: Sheets, regions: Regions) -> _Border | None:
    """Return the borders of flat regions with holes, if there are any."""
    label = regions.label[sheets.pairs]
    pair, side = np.nonzero((label[:, :1] != label[:, 1:]) & ~regions.curved[label])
    region = label[pair, side]
    node = region[:, None] * len(sheets.points) + sheets.edges[pair]
    used, ends = np.unique(node, return_inverse=True)
    ends = ends.reshape(-1, 2)
    loop = joined(len(used), ends)[1][ends[:, 0]]
    loops = unique_rows(np.column_stack([region, loop]))[:, 0]
    chosen = np.bincount(loops, minlength=len(regions.areas))[region] > 1
    if not chosen.any():
        return None
    pair, side, region = pair[chosen], side[chosen], region[chosen]
    loop = np.unique(loop[chosen], return_inverse=True)[1]
    ends = run_along(sheets.triangles[sheets.pairs[pair, side]], sheets.edges[pair]).T
    start, end = np.moveaxis(sheets.points[ends], 1, 0)
    twice = (np.cross(start, end) * regions.normals[region]).sum(axis=1)
    return _Border(
        region, pair, side, ends, loop, 0.5 * sum_by_group(loop, twice, int(loop.max()) + 1)
    )


class _Walls:
    """The walls of holes of closed sheets, and their mouths: loops that are to be closed."""

    def __init__(self, sheets: Sheets, regions: Regions, border: _Border) -> None:
        self.sheets, self.regions, self.border = sheets, regions, border
        inner = border.areas < 0.0
        concave = np.zeros(len(inner), dtype=np.bool_)
        np.logical_or.at(concave, border.loop, regions.concave[border.pair])
        self.mouth = inner & ~concave
        self.blocked = np.zeros(len(sheets.pairs), dtype=np.bool_)
        self.blocked[border.pair[self.mouth[border.loop]]] = True
        self.loops = list(iter_groups(border.loop))
        self.round = [self.mouth[i] and self._is_round(i) for i in range(len(self.loops))]
        self.outer: dict[int, Indices] = {}
        self.share: dict[int, float] = {}
        for number, own in enumerate(self.loops):
            region = int(border.region[own[0]])
            if not inner[number]:
                self.outer[region] = own
            elif self.mouth[number] and not self.round[number]:
                self.share[region] = self.share.get(region, 0.0) - float(border.areas[number])
        both = np.concatenate([sheets.pairs, sheets.pairs[:, ::-1]])
        order = np.argsort(both[:, 0], kind="stable")
        self.other = both[order, 1]
        self.way = np.tile(np.arange(len(sheets.pairs)), 2)[order]
        self.first = np.searchsorted(both[order, 0], np.arange(len(sheets.triangles) + 1))

    @property
    def mouths(self) -> Iterator[Indices]:
        """Rows of the border of each mouth."""
        return (self.loops[i] for i in np.flatnonzero(self.mouth).tolist())

    def _is_round(self, number: int) -> bool:
        own = self.loops[number]
        start, end = np.moveaxis(self.sheets.points[self.border.ends[own]], 1, 0)
        length = float(np.linalg.norm(end - start, axis=1).sum())
        return -4.0 * np.pi * float(self.border.areas[number]) > ROUND * length**2

    def find_wall(self, mouth: Indices) -> Indices | None:
        """Return the triangles of the wall behind a mouth, up to other mouths and its floor; None
        if it is not to be filled.
        """
        sheets, regions, border = self.sheets, self.regions, self.border
        region = int(border.region[mouth[0]])
        normal = regions.normals[region]
        level = np.abs(sheets.normals @ normal) > LEVEL
        inside = np.zeros(len(sheets.triangles), dtype=np.bool_)
        rows = np.unique(sheets.pairs[border.pair[mouth], 1 - border.side[mouth]])
        inside[rows] = True
        while len(rows):
            ways = np.concatenate([np.arange(self.first[r], self.first[r + 1]) for r in rows])
            other, way = self.other[ways], self.way[ways]
            other = other[~self.blocked[way] & ~(regions.concave[way] & level[other])]
            rows = np.unique(other[~inside[other]])
            if (regions.label[rows] == region).any():
                return None  # it goes round to the face that it is a hole of
            inside[rows] = True
        found = np.flatnonzero(inside)
        own = self.mouth[border.loop]
        behind = own & inside[sheets.pairs[border.pair, 1 - border.side]]
        before = own & inside[sheets.pairs[border.pair, border.side]]
        if before.any():
            return None
        mouths = np.unique(border.loop[behind]).tolist()
        corners = sheets.points[sheets.triangles[found]].reshape(-1, 3)
        return found if all(self._is_filled(m, corners) for m in mouths) else None

    def _is_filled(self, number: int, corners: FloatArray) -> bool:
        """Return whether a hole with corners (n, 3) behind a mouth is part of what it is in."""
        region = int(self.border.region[self.loops[number][0]])
        normal = self.regions.normals[region]
        depth = self.regions.offsets[region] - corners @ normal
        if depth.min() < -PLANE_SLACK * self.sheets.slack:
            return False
        if self.round[number]:
            return True
        outer = self.outer[region]
        area = float(self.border.areas[self.border.loop[outer[0]]])
        if self.share[region] > HOLES * area:
            return False
        flat = self.sheets.points[self.border.ends[outer, 0]]
        flat = flat @ make_plane_axes(normal, np.eye(3)[np.abs(normal).argmin()]).T
        least = shapely.get_coordinates(shapely.MultiPoint(flat).minimum_rotated_rectangle)
        width = np.linalg.norm(np.diff(least[:3], axis=0), axis=1).min()
        return bool(depth.max() <= BOARD * width)


def _make_caps(sheets: Sheets, wall: Indices) -> list[tuple[Indices, Indices, Indices]]:
    """Return for each loop round walls the triangles (k, 3) that close it, and the sides (l, 2) of
    the loop with what lies on the other side of each (l,).

    `wall` (m,) is the wall of each triangle, -1 for none, as it is from now on for those that have
    a loop that is not flat, or meet others.
    """
    both = wall[sheets.pairs]
    wall[np.isin(wall, both[(both[:, 0] != both[:, 1]) & (both.min(axis=1) >= 0)])] = -1
    both = wall[sheets.pairs]
    rim = np.flatnonzero(both[:, 0] != both[:, 1])
    beyond = sheets.pairs[rim, both[rim].argmin(axis=1)]
    whose = both[rim].max(axis=1)
    start, end = run_along(sheets.triangles[beyond], sheets.edges[rim])
    _, number = np.unique(whose * len(sheets.points) + np.stack([start, end]), return_inverse=True)
    number = number.reshape(2, -1)
    label = joined(int(number.max(initial=-1)) + 1, number.T)[1][number[0]]
    made, of = [], []
    for own in iter_groups(label):
        after = dict(zip(start[own].tolist(), end[own].tolist(), strict=True))
        loop = [int(start[own[0]])]
        while len(loop) < len(own) and after.get(loop[-1], loop[0]) != loop[0]:
            loop.append(after[loop[-1]])
        closed = len(loop) == len(own) and after.get(loop[-1]) == loop[0]
        cap = cap_loop(sheets.points, loop, sheets.slack) if closed else None
        if cap is None:
            wall[wall == whose[own[0]]] = -1
        else:
            made.append((cap, np.column_stack([start[own], end[own]]), beyond[own]))
            of.append(int(whose[own[0]]))
    kept = set(np.unique(wall).tolist())
    return [each for each, number in zip(made, of, strict=True) if number in kept]


def _replace_walls(
    sheets: Sheets, gone: Bools, made: list[tuple[Indices, Indices, Indices]]
) -> Sheets:
    """Return the sheets without some triangles, and with caps in their places."""
    caps = np.concatenate([cap for cap, _, _ in made])
    sides = np.concatenate([side for _, side, _ in made])
    beyond = np.concatenate([each for _, _, each in made])
    cap_of = np.repeat(np.arange(len(made)), [len(cap) for cap, _, _ in made])
    side_of = np.repeat(np.arange(len(made)), [len(side) for _, side, _ in made])
    next_to = np.array([each[0] for _, _, each in made])[cap_of]
    count, total = len(sheets.triangles), len(sheets.points)
    # half edges of caps, and of what they meet, that run against each other
    starts = np.concatenate([caps.ravel(), sides[:, 0]])
    ends = np.concatenate([np.roll(caps, -1, axis=1).ravel(), sides[:, 1]])
    of = np.concatenate([count + np.repeat(np.arange(len(caps)), 3), beyond])
    loop = np.concatenate([np.repeat(cap_of, 3), side_of])
    key = (loop * total + np.minimum(starts, ends)) * total + np.maximum(starts, ends)
    order = np.argsort(key, kind="stable").reshape(-1, 2)
    whole = ~gone[sheets.pairs].any(axis=1)
    pairs = np.concatenate([sheets.pairs[whole], of[order]])
    edges = np.concatenate([sheets.edges[whole], np.column_stack([starts, ends])[order[:, 0]]])
    number = np.cumsum(np.append(~gone, np.ones(len(caps), dtype=np.bool_))) - 1
    normals, areas = measure_triangles(sheets.points, caps)
    corners = np.concatenate([sheets.points[caps], sheets.points[sheets.triangles[gone]]])
    a, b, c = np.moveaxis(corners, 1, 0)
    volumes = (a * np.cross(b, c)).sum(axis=1) / 6.0
    volumes[len(caps) :] *= -1.0
    body = np.concatenate([sheets.body[next_to], sheets.body[gone]])
    return replace(
        sheets,
        triangles=np.concatenate([sheets.triangles[~gone], caps]),
        normals=np.concatenate([sheets.normals[~gone], normals]),
        areas=np.concatenate([sheets.areas[~gone], areas]),
        body=np.concatenate([sheets.body[~gone], sheets.body[next_to]]),
        pairs=number[pairs],
        edges=edges,
        volumes=sheets.volumes + sum_by_group(body, volumes, len(sheets.volumes)),
    )
