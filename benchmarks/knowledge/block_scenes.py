"""Facts of scenes of many blocks in which each face touches at most six others.

They stand in a row, side against side, or in a grid with gaps and unequal heights; all of them are
one thing, or each is a thing of its own. Angles, dihedrals and offsets are given for faces that
adjoin or are opposite sides of one block, for no others: the number of facts grows as the number of
faces.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise, product

import numpy as np

__all__ = ["FACES_PER_BLOCK", "Layout", "block_scene", "face_count"]

Fact = tuple[str | int | float, ...]
Vector = tuple[float, float, float]

FACES_PER_BLOCK = 6
TOUCHING = 1.0
GAP = 1.25  # blocks of a grid stand this many block sizes apart
ANGLE_SD = 0.4  # degrees
RATIO_SD = 0.01
LENGTH_SD = 0.002  # metres

# A side is an axis and a direction along it: left, right, front, back, bottom, top.
SIDES = tuple((axis, sign) for axis in range(3) for sign in (-1, 1))


class Layout(StrEnum):
    """How the blocks stand."""

    ROW = "row"
    GRID = "grid"


def face_count(blocks: int) -> int:
    """How many faces so many blocks have."""
    return FACES_PER_BLOCK * blocks


@dataclass(frozen=True, slots=True)
class _Block:
    number: int
    low: Vector
    high: Vector

    def face(self, side: tuple[int, int]) -> str:
        return f"f{FACES_PER_BLOCK * self.number + SIDES.index(side)}"

    def vertex(self, corner: tuple[int, ...]) -> str:
        return f"v{8 * self.number + 4 * corner[0] + 2 * corner[1] + corner[2]}"

    def point(self, corner: tuple[int, ...]) -> Vector:
        ends = (self.low, self.high)
        return (ends[corner[0]][0], ends[corner[1]][1], ends[corner[2]][2])

    def extent(self, axis: int) -> float:
        return self.high[axis] - self.low[axis]

    def area(self, axis: int) -> float:
        return math.prod(self.extent(other) for other in range(3) if other != axis)


def block_scene(
    blocks: int, layout: Layout = Layout.ROW, *, one_thing: bool = True, seed: int = 0
) -> tuple[Fact, ...]:
    """The facts; `seed` varies the heights of the blocks of a grid. Metres, up is z."""
    standing = tuple(_standing(blocks, layout, seed))
    facts: list[Fact] = [("scene", f"{blocks} blocks"), ("scale", "metric"), ("up", 0.0, 0.0, 1.0)]
    things = [standing] if one_thing else [(block,) for block in standing]
    for number, members in enumerate(things, 1):
        facts.extend(_thing_facts(f"t{number}", members))
    touching = layout is Layout.ROW and one_thing
    for left, right in pairwise(standing) if touching else ():
        facts.extend(_contact_facts(left, right))
    return tuple(facts)


def _standing(blocks: int, layout: Layout, seed: int) -> Iterator[_Block]:
    random = np.random.default_rng(seed)
    columns = blocks if layout is Layout.ROW else math.ceil(math.sqrt(blocks))
    step = TOUCHING if layout is Layout.ROW else GAP
    size = (0.3, 0.2)
    for number in range(blocks):
        height = 0.25 if layout is Layout.ROW else float(random.uniform(0.1, 0.6))
        row, column = divmod(number, columns)
        x, y = step * size[0] * column, step * size[1] * row
        yield _Block(number, (x, y, 0.0), (x + size[0], y + size[1], height))


def _thing_facts(thing: str, members: tuple[_Block, ...]) -> Iterator[Fact]:
    low = tuple(min(b.low[axis] for b in members) for axis in range(3))
    high = tuple(max(b.high[axis] for b in members) for axis in range(3))
    whole = _Block(0, (low[0], low[1], low[2]), (high[0], high[1], high[2]))
    yield ("thing", thing)
    yield ("thing_size", thing, *sorted((whole.extent(a) for a in range(3)), reverse=True))
    yield ("solidity", thing, sum(map(_volume, members)) / _volume(whole), RATIO_SD)
    yield ("hollow_side", thing, 0.0, RATIO_SD)
    yield ("curved", thing, 0.0)
    for block in members:
        yield from _corner_facts(block)
        for side in SIDES:
            yield from _face_facts(block, side, thing, whole)
        yield from _edge_facts(block)
        yield from _opposite_facts(block)


def _volume(block: _Block) -> float:
    return block.extent(2) * block.area(2)


def _corner_facts(block: _Block) -> Iterator[Fact]:
    for corner in product((0, 1), repeat=3):
        yield ("vertex", block.vertex(corner))
        yield ("point", block.vertex(corner), *block.point(corner))


def _face_facts(block: _Block, side: tuple[int, int], thing: str, whole: _Block) -> Iterator[Fact]:
    face = block.face(side)
    axis, sign = side
    area = block.area(axis)
    spans = sorted(block.extent(other) for other in range(3) if other != axis)
    reach = whole.high[axis] - block.high[axis] if sign > 0 else block.low[axis] - whole.low[axis]
    yield ("face", face)
    yield ("part_of", face, thing)
    yield ("evidence", face, "measured")
    yield ("area", face, area, RATIO_SD * area)
    yield ("length", face, spans[1], LENGTH_SD)
    yield ("width", face, spans[0], LENGTH_SD)
    yield ("fill", face, 1.0, RATIO_SD)
    yield ("coverage", face, 1.0)
    yield ("share", face, area / whole.area(axis), RATIO_SD)
    yield ("protrusion", face, reach, LENGTH_SD)
    for number, corner in enumerate(_outline(side), 1):
        yield ("corner", face, number, block.vertex(corner))
    top, bottom = block.high[2], block.low[2]
    if axis == 2:
        top = bottom = top if sign > 0 else bottom
        yield ("upward" if sign > 0 else "downward", face)
        yield ("clear_below", face, 0.0)
    yield ("tilt", face, 0.0 if axis == 2 else 90.0, ANGLE_SD)
    yield ("elevation", face, (top + bottom) / 2, LENGTH_SD)
    yield ("top_of", face, top, LENGTH_SD)
    yield ("bottom_of", face, bottom, LENGTH_SD)


def _outline(side: tuple[int, int]) -> Iterator[tuple[int, ...]]:
    axis, sign = side
    ring = ((0, 0), (1, 0), (1, 1), (0, 1))
    for a, b in ring if sign > 0 else reversed(ring):
        corner = [0, 0, 0]
        corner[axis] = int(sign > 0)
        corner[(axis + 1) % 3], corner[(axis + 2) % 3] = a, b
        yield tuple(corner)


def _edge_facts(block: _Block) -> Iterator[Fact]:
    """The twelve edges, and what is known of the two faces that meet in each."""
    number = 12 * block.number
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for s, t in product((-1, 1), repeat=2):
            edge = f"e{number}"
            number += 1
            ends = []
            for end in (0, 1):
                corner = [0, 0, 0]
                corner[axis], corner[u], corner[v] = end, int(s > 0), int(t > 0)
                ends.append(block.vertex(tuple(corner)))
            yield ("edge", edge, *ends)
            yield ("edge_length", edge, block.extent(axis), LENGTH_SD)
            yield ("evidence", edge, "measured")
            sides = ((u, s), (v, t))
            for one, other in (sides, sides[::-1]):
                a, b = block.face(one), block.face(other)
                yield ("bounds", edge, a)
                yield ("angle", a, b, 90.0, ANGLE_SD)
                yield ("adjoins", a, b, edge)
                yield ("dihedral", a, b, 90.0, ANGLE_SD)
                yield ("convex", a, b)
                yield ("offset", a, b, -block.extent(other[0]) / 2, LENGTH_SD)


def _opposite_facts(block: _Block) -> Iterator[Fact]:
    for axis in range(3):
        for sign in (-1, 1):
            a, b = block.face((axis, sign)), block.face((axis, -sign))
            yield ("angle", a, b, 180.0, ANGLE_SD)
            yield ("opposite", a, b)
            yield ("offset", a, b, -block.extent(axis), LENGTH_SD)


def _contact_facts(left: _Block, right: _Block) -> Iterator[Fact]:
    """The sides along which a row runs on: one plane, one edge."""
    for axis in (1, 2):
        for sign in (-1, 1):
            a, b = left.face((axis, sign)), right.face((axis, sign))
            # The edge of the left block that lies on its right side.
            edge = f"e{12 * left.number + _edge_number((0, 1), (axis, sign))}"
            for one, other in ((a, b), (b, a)):
                yield ("angle", one, other, 0.0, ANGLE_SD)
                yield ("adjoins", one, other, edge)
                yield ("dihedral", one, other, 180.0, ANGLE_SD)
                yield ("coplanar", one, other)
                yield ("offset", one, other, 0.0, LENGTH_SD)


def _edge_number(one: tuple[int, int], other: tuple[int, int]) -> int:
    axis = 3 - one[0] - other[0]
    signs = dict((one, other))
    u, v = (axis + 1) % 3, (axis + 2) % 3
    return 4 * axis + 2 * int(signs[u] > 0) + int(signs[v] > 0)
