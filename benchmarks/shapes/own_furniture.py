"""Tables, chairs and what is none of table, chair and box, as meshes with z upwards.

Each maker takes a generator of random numbers. A table is a level top with free space beneath it,
a chair a level seat with a back that rises at one side (rules/chair.model); lengths are metres.
"""

from collections.abc import Callable, Iterator, Mapping

import numpy as np
import shapely
import trimesh

from benchmarks.shapes.own_boxes import LEAST_SIDE
from benchmarks.shapes.own_solids import bar, block, extruded, hull, joined, make_ring_points, moved

Mesh = trimesh.Trimesh
Maker = Callable[[np.random.Generator], Mesh]


def _legs(
    x: float, y: float, low: float, high: float, radius: float, *, square: bool = True
) -> Iterator[Mesh]:
    """Yield four upright legs at the corners of a plan from 0, in from the rim by 2 radii."""
    for px in (2 * radius, x - 2 * radius):
        for py in (2 * radius, y - 2 * radius):
            yield bar([px, py, low], [px, py, high], radius, square=square)


def _table_on_legs(rng: np.random.Generator, *, square: bool) -> Mesh:
    x, y, z = rng.uniform(0.8, 1.8), rng.uniform(0.6, 0.9), rng.uniform(0.4, 0.78)
    under = z - rng.uniform(0.02, 0.05)
    legs = _legs(x, y, 0.0, under, rng.uniform(0.02, 0.04), square=square)
    return joined(block([0, 0, under], [x, y, z]), *legs)


def _square_legs(rng: np.random.Generator) -> Mesh:
    return _table_on_legs(rng, square=True)


def _round_legs(rng: np.random.Generator) -> Mesh:
    return _table_on_legs(rng, square=False)


def _pedestal(rng: np.random.Generator) -> Mesh:
    """Return a square or round top on one column with a foot."""
    width, z = rng.uniform(0.6, 1.0), rng.uniform(0.65, 0.78)
    top = (
        block([-width / 2, -width / 2, z - 0.03], [width / 2, width / 2, z])
        if rng.uniform() < 0.5
        else bar([0, 0, z - 0.03], [0, 0, z], width / 2, sections=32)
    )
    column = bar([0, 0, 0.03], [0, 0, z - 0.03], rng.uniform(0.03, 0.05))
    return joined(top, column, bar([0, 0, 0], [0, 0, 0.03], 0.3 * width, sections=32))


def _round_table(rng: np.random.Generator) -> Mesh:
    radius, z = rng.uniform(0.35, 0.7), rng.uniform(0.4, 0.78)
    feet = make_ring_points(0.8 * radius, int(rng.integers(3, 5)), 0.0)
    legs = [bar(foot, [*foot[:2], z - 0.03], 0.025) for foot in feet]
    return joined(bar([0, 0, z - 0.03], [0, 0, z], radius, sections=48), *legs)


def _on_panels(rng: np.random.Generator) -> Mesh:
    x, y, z = rng.uniform(1.0, 1.8), rng.uniform(0.6, 0.9), rng.uniform(0.65, 0.78)
    left = block([0.1, 0.05, 0.0], [0.14, y - 0.05, z - 0.04])
    right = block([x - 0.14, 0.05, 0.0], [x - 0.1, y - 0.05, z - 0.04])
    return joined(block([0, 0, z - 0.04], [x, y, z]), left, right)


def _with_apron(rng: np.random.Generator) -> Mesh:
    x, y, z = rng.uniform(1.0, 1.8), rng.uniform(0.7, 0.9), rng.uniform(0.7, 0.78)
    low, high = z - 0.13, z - 0.03
    sides = [
        block([0.06, 0.06, low], [x - 0.06, 0.08, high]),
        block([0.06, y - 0.08, low], [x - 0.06, y - 0.06, high]),
        block([0.06, 0.06, low], [0.08, y - 0.06, high]),
        block([x - 0.08, 0.06, low], [x - 0.06, y - 0.06, high]),
    ]
    return joined(block([0, 0, high], [x, y, z]), *sides, *_legs(x, y, 0.0, high, 0.03))


def _with_stretchers(rng: np.random.Generator) -> Mesh:
    x, y, z = rng.uniform(0.9, 1.5), rng.uniform(0.6, 0.9), rng.uniform(0.65, 0.78)
    rails = [
        bar([0.06, 0.06, 0.15], [0.06, y - 0.06, 0.15], 0.015),
        bar([x - 0.06, 0.06, 0.15], [x - 0.06, y - 0.06, 0.15], 0.015),
        bar([0.06, y / 2, 0.15], [x - 0.06, y / 2, 0.15], 0.015),
    ]
    return joined(block([0, 0, z - 0.03], [x, y, z]), *rails, *_legs(x, y, 0, z - 0.03, 0.03))


def _seat(rng: np.random.Generator) -> tuple[float, float, float, float]:
    """Return width, depth, height of the seat and of the back of a chair."""
    return (
        rng.uniform(0.38, 0.5),
        rng.uniform(0.38, 0.5),
        rng.uniform(0.42, 0.48),
        rng.uniform(0.8, 1.05),
    )


def _board_chair(rng: np.random.Generator, *, square: bool) -> Mesh:
    x, y, seat, top = _seat(rng)
    return joined(
        block([0, 0, seat - 0.03], [x, y, seat]),
        block([0, y - 0.03, seat], [x, y, top]),
        *_legs(x, y, 0.0, seat - 0.03, 0.02, square=square),
    )


def _chair_square(rng: np.random.Generator) -> Mesh:
    return _board_chair(rng, square=True)


def _chair_round(rng: np.random.Generator) -> Mesh:
    return _board_chair(rng, square=False)


def _slatted(rng: np.random.Generator) -> Mesh:
    """Return a seat of slats on a frame, a back of slats across."""
    x, y, seat, top = _seat(rng)
    count = int(rng.integers(5, 8))
    pitch = y / count
    slats = [
        block([0, n * pitch, seat - 0.02], [x, (n + 0.85) * pitch, seat]) for n in range(count)
    ]
    rails = [block([a, 0, seat - 0.06], [a + 0.03, y, seat - 0.02]) for a in (0.02, x - 0.05)]
    posts = [block([a, y - 0.03, seat], [a + 0.03, y, top]) for a in (0.0, x - 0.03)]
    back = [
        block([0, y - 0.025, z], [x, y - 0.005, z + 0.07])
        for z in np.linspace(seat + 0.12, top - 0.08, 3)
    ]
    return joined(*slats, *rails, *posts, *back, *_legs(x, y, 0.0, seat - 0.06, 0.02))


def _spindle(rng: np.random.Generator) -> Mesh:
    """Return a back of round spindles under a top rail."""
    x, y, seat, top = _seat(rng)
    spindles = [
        bar([a, y - 0.03, seat], [a, y - 0.03, top], 0.008)
        for a in np.linspace(0.03, x - 0.03, int(rng.integers(5, 9)))
    ]
    rail = block([0, y - 0.05, top], [x, y - 0.01, top + 0.06])
    legs = _legs(x, y, 0.0, seat - 0.03, 0.018, square=False)
    return joined(block([0, 0, seat - 0.03], [x, y, seat]), rail, *spindles, *legs)


def _leaning_back(rng: np.random.Generator) -> Mesh:
    """Return a back that leans by 5 to 15 degrees, on two posts."""
    x, y, seat, top = _seat(rng)
    lean = (top - seat) * np.tan(np.deg2rad(rng.uniform(5.0, 15.0)))
    board = hull(
        [
            [px, py + lean * (pz - seat) / (top - seat), pz]
            for px in (0.0, x)
            for py in (y - 0.03, y)
            for pz in (seat, top)
        ]
    )
    legs = _legs(x, y, 0.0, seat - 0.04, 0.02)
    return joined(block([0, 0, seat - 0.04], [x, y, seat]), board, *legs)


def _with_arms(rng: np.random.Generator) -> Mesh:
    x, y, seat, top = _seat(rng)
    x += 0.1
    arms = [block([a, 0.05, seat + 0.2], [a + 0.04, y, seat + 0.23]) for a in (0.0, x - 0.04)]
    posts = [block([a, 0.06, seat], [a + 0.04, 0.1, seat + 0.2]) for a in (0.0, x - 0.04)]
    back = block([0, y - 0.03, seat], [x, y, top])
    legs = _legs(x, y, 0.0, seat - 0.04, 0.02)
    return joined(block([0, 0, seat - 0.04], [x, y, seat]), back, *arms, *posts, *legs)


def _cylinder(rng: np.random.Generator) -> Mesh:
    return trimesh.creation.cylinder(rng.uniform(0.2, 0.6), rng.uniform(0.4, 1.2), sections=48)


def _sphere(rng: np.random.Generator) -> Mesh:
    ball = trimesh.creation.icosphere(3, rng.uniform(0.3, 1.0))
    return ball.apply_scale([1.0, 1.0, rng.uniform(0.7, 1.0)])


def _prism(rng: np.random.Generator) -> Mesh:
    sides = int(rng.choice([3, 5, 6, 8]))
    plan = shapely.Polygon(make_ring_points(0.5, sides, 0.0)[:, :2])
    return extruded(plan, 0.0, rng.uniform(0.4, 1.2))


def _wedge(rng: np.random.Generator) -> Mesh:
    x, y, z = rng.uniform(0.5, 1.0, 3)
    return hull([[0, 0, 0], [x, 0, 0], [0, y, 0], [x, y, 0], [0, 0, z], [0, y, z]])


def _pyramid(rng: np.random.Generator) -> Mesh:
    base = make_ring_points(0.5, 4, 0.0)
    return hull([*base, [0.0, 0.0, rng.uniform(0.5, 1.0)]])


def _l_block(rng: np.random.Generator) -> Mesh:
    """Return a block with a corner of 30 to 60 % of its sides taken out all along."""
    x, y, z = rng.uniform(0.6, 1.0, 3)
    cut_x, cut_y = rng.uniform(0.3, 0.6, 2) * [x, y]
    plan = shapely.box(0, 0, x, y).difference(shapely.box(x - cut_x, y - cut_y, x, y))
    return extruded(plan, 0.0, z)


def _notched(rng: np.random.Generator) -> Mesh:
    """Return a block with a notch of a third of its sides in one corner of its top."""
    x, y, z = rng.uniform(0.7, 1.0, 3)
    a, b, c = rng.uniform(0.5, 0.67, 3) * [x, y, z]
    upper = shapely.box(0, 0, x, y).difference(shapely.box(a, b, x, y))
    return joined(block([0, 0, 0], [x, y, c]), extruded(upper, c, z))


def _open(x: float, y: float, z: float, wall: float) -> Mesh:
    plan = shapely.box(0, 0, x, y)
    walls = plan.difference(shapely.box(wall, wall, x - wall, y - wall))
    return joined(extruded(walls, wall, z), block([0, 0, 0], [x, y, wall]))


def _tray(rng: np.random.Generator) -> Mesh:
    return _open(rng.uniform(0.4, 0.6), rng.uniform(0.3, 0.4), rng.uniform(0.06, 0.1), 0.008)


def _crate(rng: np.random.Generator) -> Mesh:
    return _open(rng.uniform(0.4, 0.6), rng.uniform(0.3, 0.4), rng.uniform(0.25, 0.4), 0.012)


def _tube(rng: np.random.Generator) -> Mesh:
    """Return a square or a round tube, open at both ends."""
    outer, length = rng.uniform(0.15, 0.3), rng.uniform(0.4, 1.0)
    if rng.uniform() < 0.5:
        return trimesh.creation.annulus(0.9 * outer, outer, length)
    inner = 0.9 * outer
    plan = shapely.box(-outer, -outer, outer, outer)
    return extruded(plan.difference(shapely.box(-inner, -inner, inner, inner)), 0.0, length)


def _board(rng: np.random.Generator) -> Mesh:
    """Return a board, door or pane, lying or upright: 1 to 5 % as thick as it is long."""
    thick = rng.uniform(0.125, 0.6) * LEAST_SIDE
    width = rng.uniform(0.3, 0.9)
    return block([0, 0, 0], [width, 1.0, thick] if rng.uniform() < 0.5 else [width, thick, 1.0])


def _shelf(rng: np.random.Generator) -> Mesh:
    x, y, z = rng.uniform(0.6, 1.0), rng.uniform(0.25, 0.4), rng.uniform(1.2, 2.0)
    levels = np.linspace(0.05, z - 0.02, int(rng.integers(4, 7)))
    boards = [block([0.02, 0, a], [x - 0.02, y, a + 0.02]) for a in levels]
    return joined(block([0, 0, 0], [0.02, y, z]), block([x - 0.02, 0, 0], [x, y, z]), *boards)


def _cabinet(rng: np.random.Generator) -> Mesh:
    """Return a closed body on legs that are a fourth of its height or more."""
    x, y, z = rng.uniform(0.6, 1.2), rng.uniform(0.4, 0.5), rng.uniform(0.7, 1.1)
    low = rng.uniform(0.25, 0.35) * z
    return joined(block([0, 0, low], [x, y, z]), *_legs(x, y, 0.0, low, 0.02))


def _stairs(rng: np.random.Generator) -> Mesh:
    count, rise, run = int(rng.integers(4, 8)), 0.17, 0.28
    corners = [(0.0, 0.0)]
    for n in range(count):
        corners += [(n * run, (n + 1) * rise), ((n + 1) * run, (n + 1) * rise)]
    side = extruded(shapely.Polygon([*corners, (count * run, 0.0)]), 0.0, rng.uniform(0.8, 1.2))
    turn = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    return trimesh.Trimesh(side.vertices @ turn.T, side.faces, process=False)


def _bed(rng: np.random.Generator) -> Mesh:
    x, y, z = rng.uniform(0.9, 1.8), 2.0, rng.uniform(0.25, 0.35)
    return joined(
        block([0, 0, z], [x, y, z + 0.2]),
        block([0, y, 0.0], [x, y + 0.05, rng.uniform(0.9, 1.1)]),
        *_legs(x, y, 0.0, z, 0.03),
    )


def _sofa(rng: np.random.Generator) -> Mesh:
    x, y = rng.uniform(1.5, 2.2), rng.uniform(0.8, 0.95)
    return joined(
        block([0.2, 0, 0], [x - 0.2, y - 0.2, 0.42]),
        block([0, 0, 0], [0.2, y, 0.62]),
        block([x - 0.2, 0, 0], [x, y, 0.62]),
        block([0.2, y - 0.2, 0], [x - 0.2, y, 0.85]),
    )


def _stool(rng: np.random.Generator) -> Mesh:
    radius, z = rng.uniform(0.15, 0.2), rng.uniform(0.42, 0.7)
    feet = make_ring_points(0.8 * radius, int(rng.integers(3, 5)), 0.0)
    legs = [bar(foot, [*foot[:2], z - 0.03], 0.015) for foot in feet]
    return moved(joined(bar([0, 0, z - 0.03], [0, 0, z], radius, sections=32), *legs), [1.0, 0, 0])


TABLES: Mapping[str, Maker] = {
    "table on square legs": _square_legs,
    "table on round legs": _round_legs,
    "pedestal table": _pedestal,
    "round table": _round_table,
    "table on panels": _on_panels,
    "table with an apron": _with_apron,
    "table with stretchers": _with_stretchers,
}
CHAIRS: Mapping[str, Maker] = {
    "chair on square legs": _chair_square,
    "chair on round legs": _chair_round,
    "chair of slats": _slatted,
    "chair with spindles": _spindle,
    "chair with a leaning back": _leaning_back,
    "chair with arms": _with_arms,
}
# By the label that says how they count: a stool is listed apart (shape_judging.py).
NONE_OF_THESE: Mapping[str, Maker] = {
    "cylinder": _cylinder,
    "sphere": _sphere,
    "prism": _prism,
    "wedge": _wedge,
    "pyramid": _pyramid,
    "l_block": _l_block,
    "notched_block": _notched,
    "tray": _tray,
    "crate": _crate,
    "tube": _tube,
    "board_or_door": _board,
    "shelf": _shelf,
    "cabinet_on_legs": _cabinet,
    "stairs": _stairs,
    "bed": _bed,
    "sofa": _sofa,
    "stool": _stool,
}
