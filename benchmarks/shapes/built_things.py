"""Things of wood as a joiner builds them, every length varied: their parts are known.

A thing is a list of its parts, closed meshes, convex but for plates and rings, in metres, with z
upwards, which touch, overlap or reach into one another as in drawings.
"""

from collections.abc import Callable, Iterator

import numpy as np
import shapely
import trimesh

from benchmarks.shapes.own_solids import bar, block, extruded, hull
from facetlog.perception.ragged import Indices
from facetlog.perception.types import FloatArray

Parts = list[trimesh.Trimesh]
# every length is varied by so much
VARIED = 0.2


class Sizes:
    """Lengths drawn about usual ones."""

    def __init__(self, rng: np.random.Generator) -> None:
        """Draw from this generator."""
        self.rng = rng

    def __call__(self, length: float) -> float:
        """Return the length, a fifth more or less, to a hundredth of it."""
        return length * (1.0 + round(float(self.rng.uniform(-VARIED, VARIED)), 2))

    def flip(self) -> bool:
        """Return true or false."""
        return bool(self.rng.integers(2))


def make_pallet(size: Sizes) -> Parts:
    """Return a EUR pallet: 5 deck boards, 3 boards across, 9 blocks, 3 boards below."""
    length, width = float(size.rng.uniform(1.0, 1.5)), size(0.8)
    thick = [size(0.022) for _ in range(3)]
    high = size(0.078)
    wide, narrow = size(0.145) * width / 0.8, size(0.1) * width / 0.8
    long = size(0.145)
    gap = (width - 3 * wide - 2 * narrow) / 4
    if gap < 0.025:
        wide, narrow = 0.145 * width / 0.8, 0.1 * width / 0.8
        gap = (width - 3 * wide - 2 * narrow) / 4
    z = np.cumsum([0.0, thick[0], high, thick[1], thick[2]]).tolist()
    rows = [(0.0, narrow), (0.5 * (width - wide), 0.5 * (width + wide)), (width - narrow, width)]
    spots = [(0.0, long), (0.5 * (length - long), 0.5 * (length + long)), (length - long, length)]
    parts = [block([0, a, z[0]], [length, b, z[1]]) for a, b in rows]
    parts += [block([c, a, z[1]], [d, b, z[2]]) for a, b in rows for c, d in spots]
    parts += [block([c, 0, z[2]], [d, width, z[3]]) for c, d in spots]
    start = 0.0
    for board in (wide, narrow, wide, narrow, wide):
        parts.append(block([0, start, z[3]], [length, start + board, z[4]]))
        start += board + gap
    return parts


def make_ladder(size: Sizes) -> Parts:
    """Return two rails with 4 to 14 rungs, round or square, upright or leaning."""
    count = int(size.rng.integers(4, 15))
    thick, deep, wide, apart = size(0.025), size(0.06), size(0.4), size(0.28)
    height = apart * (count + 0.3 + 0.4 * float(size.rng.random()))
    lean = float(size.rng.uniform(0.1, 0.4)) if size.flip() else 0.0
    reach = float(size.rng.choice([0.0, 0.5, 1.0, 1.4]))  # how far rungs go into the rails
    low = thick * (1.0 - reach)
    radius = size(0.014)
    round_ones = size.flip()
    parts = []
    for x in (0.0, wide - thick):
        foot = np.array([[a, b, 0.0] for a in (x, x + thick) for b in (0.0, deep)])
        parts.append(hull(np.concatenate([foot, foot + np.array([0.0, lean * height, height])])))
    for number in range(count):
        z = apart * (number + 0.5)
        y = 0.5 * deep + lean * z
        if round_ones:
            rung = bar([low, y, z], [wide - low, y, z], radius)
        else:
            rung = block([low, y - radius, z - radius], [wide - low, y + radius, z + 0.9 * radius])
        parts.append(rung)
    return parts


def make_cabinet(size: Sizes) -> Parts:
    """Return a block on four legs of 4 to 14 cm, or on a plinth that is set back."""
    width, depth, high = size(0.8), size(0.45), size(0.9)
    leg, raised = size(0.045), float(size.rng.uniform(0.04, 0.14))
    parts = [block([0, 0, raised], [width, depth, raised + high])]
    if size.rng.random() < 0.35:
        back = size(0.05)
        return [*parts, block([back * 0.5, back, 0], [width - back * 0.5, depth, raised])]
    inset = float(size.rng.choice([0.0, 0.0, 0.03]))
    return parts + _legs(size, width, depth, raised, leg, inset)


def _legs(size: Sizes, width: float, depth: float, high: float, leg: float, inset: float) -> Parts:
    x = (inset, width - inset - leg)
    y = (inset, depth - inset - leg)
    if inset and size.flip():
        half = 0.5 * leg
        return [
            bar([a + half, b + half, 0], [a + half, b + half, high], half) for a in x for b in y
        ]
    return [block([a, b, 0], [a + leg, b + leg, high]) for a in x for b in y]


def make_trolley(size: Sizes) -> Parts:
    """Return two or three shelves on four uprights with wheels, and a handle."""
    length, width, high = size(0.8), size(0.5), size(0.9)
    post, thick, radius, tyre = size(0.03), size(0.02), size(0.06), size(0.028)
    count = int(size.rng.integers(2, 4))
    raised = radius * 2.0 - size(0.012)
    inset = float(size.rng.choice([0.0, 0.04]))
    parts = []
    for number in range(count):
        z = raised + size(0.05) + number * (high - raised - 0.2) / (count - 1)
        parts.append(block([0, 0, z], [length, width, z + thick]))
    for x in (inset, length - inset - post):
        for y in (inset, width - inset - post):
            parts.append(block([x, y, raised], [x + post, y + post, high]))
            centre = [x + 0.5 * post, y + 0.5 * post]
            parts.append(
                bar(
                    [centre[0], centre[1] - tyre / 2, radius],
                    [centre[0], centre[1] + tyre / 2, radius],
                    radius,
                    sections=int(size.rng.choice([16, 24, 32])),
                )
            )
    x, z = inset + 0.5 * post, high - 2.0 * post
    ends = (inset + 0.8 * post, width - inset - 0.8 * post)
    parts.append(bar([x, ends[0], z], [x, ends[1], z], 0.4 * post))
    return parts


def make_table(size: Sizes) -> Parts:
    """Return a top on four legs: flush or set back, square, round or splayed."""
    length, width, high, thick, leg = size(1.2), size(0.8), size(0.74), size(0.03), size(0.06)
    top = block([0, 0, high - thick], [length, width, high])
    style = size.rng.integers(3)
    if style == 2:
        lean = size(0.1)
        parts = [top]
        for x, dx in ((0.15, -lean), (length - 0.15 - leg, lean)):
            for y, dy in ((0.12, -lean), (width - 0.12 - leg, lean)):
                plan = np.array([[a, b, 0.0] for a in (x, x + leg) for b in (y, y + leg)])
                parts.append(
                    hull(
                        np.concatenate(
                            [plan + np.array([dx, dy, 0]), plan + np.array([0, 0, high - thick])]
                        )
                    )
                )
        return parts
    return [top, *_legs(size, length, width, high - thick, leg, 0.04 if style else 0.0)]


def make_chair(size: Sizes) -> Parts:
    """Return a seat on four legs with a back, upright or sloping."""
    width, depth, high, thick, leg = size(0.42), size(0.42), size(0.45), size(0.03), size(0.04)
    back, tall = size(0.025), size(0.45)
    parts = [block([0, 0, high - thick], [width, depth, high])]
    parts += _legs(size, width, depth, high - thick, leg, float(size.rng.choice([0.0, 0.03])))
    slope = float(size.rng.choice([0.0, 0.25]))
    foot = np.array([[a, b, high] for a in (0.0, width) for b in (depth - back, depth)])
    return [*parts, hull(np.concatenate([foot, foot + np.array([0.0, slope * tall, tall])]))]


def make_stool(size: Sizes) -> Parts:
    """Return a round or square seat on three or four legs."""
    seat, high, thick, radius = size(0.17), size(0.45), size(0.03), size(0.018)
    count = int(size.rng.integers(3, 5))
    out = float(size.rng.choice([0.0, 0.06]))
    if size.flip():
        parts = [bar([0, 0, high - thick], [0, 0, high], seat, sections=32)]
    else:
        parts = [block([-seat, -seat, high - thick], [seat, seat, high])]
    for number in range(count):
        angle = 2.0 * np.pi * (number + 0.5) / count
        x, y = 0.65 * seat * np.cos(angle), 0.65 * seat * np.sin(angle)
        k = 1.0 + out / (0.65 * seat)
        end = [x, y, high - 0.5 * thick]
        parts.append(bar([k * x, k * y, 0], end, radius, square=bool(count == 4 and out == 0.0)))
    return parts


def make_shelf(size: Sizes) -> Parts:
    """Return two sides, top, bottom, back and shelves between them: 15 pieces at most."""
    width, depth, high, thick, back = size(0.8), size(0.3), size(1.8), size(0.02), size(0.008)
    count = int(size.rng.integers(2, 11))
    parts = [
        block([0, 0, 0], [thick, depth, high]),
        block([width - thick, 0, 0], [width, depth, high]),
    ]
    raised = float(size.rng.choice([0.0, 0.06]))
    parts += [
        block([thick, 0, z], [width - thick, depth, z + thick]) for z in (raised, high - thick)
    ]
    parts.append(block([thick, depth - back, raised + thick], [width - thick, depth, high - thick]))
    apart = (high - raised - 2 * thick) / (count + 1)
    for number in range(count):
        z = raised + thick + apart * (number + 1) - 0.5 * thick
        parts.append(block([thick, 0, z], [width - thick, depth - back, z + thick]))
    return parts


def make_desk(size: Sizes) -> Parts:
    """Return an L-shaped top of one plate on five legs."""
    long, short, deep, wide = size(1.6), size(1.5), size(0.7), size(0.6)
    high, thick, leg = size(0.74), size(0.03), size(0.06)
    plan = shapely.Polygon(
        [(0, 0), (long, 0), (long, deep), (wide, deep), (wide, short), (0, short)]
    )
    parts = [extruded(plan, high - thick, high)]
    in_ = float(size.rng.choice([0.0, 0.03]))
    spots = [
        (in_, in_),
        (long - in_ - leg, in_),
        (long - in_ - leg, deep - in_ - leg),
        (in_, short - in_ - leg),
        (wide - in_ - leg, short - in_ - leg),
    ]
    return parts + [block([x, y, 0], [x + leg, y + leg, high - thick]) for x, y in spots]


def make_frame(size: Sizes) -> Parts:
    """Return a picture frame of four bars, mitred or butt."""
    width, high, bar_, deep = size(0.5), size(0.7), size(0.05), size(0.02)
    if size.flip():
        return [
            block([0, 0, 0], [bar_, deep, high]),
            block([width - bar_, 0, 0], [width, deep, high]),
            block([bar_, 0, 0], [width - bar_, deep, bar_]),
            block([bar_, 0, high - bar_], [width - bar_, deep, high]),
        ]
    outer = np.array([[0, 0], [width, 0], [width, high], [0, high]])
    inner = np.array(
        [[bar_, bar_], [width - bar_, bar_], [width - bar_, high - bar_], [bar_, high - bar_]]
    )
    parts = []
    for k in range(4):
        plan = np.array([outer[k], outer[(k + 1) % 4], inner[k], inner[(k + 1) % 4]])
        parts.append(hull([[x, y, z] for x, z in plan for y in (0.0, deep)]))
    return parts


def make_stairs(size: Sizes) -> Parts:
    """Return treads between two slanting boards."""
    count = int(size.rng.integers(3, 10))
    rise, run, width, thick, side = size(0.18), size(0.25), size(0.8), size(0.03), size(0.04)
    deep, lap = size(0.28), float(size.rng.choice([0.0, 0.5]))
    parts = []
    for x in (0.0, width - side):
        plan = np.array([[-0.1, 0.0], [0.3, 0.0], [0.3 + run * count, rise * count]])
        plan = np.concatenate([plan, [[-0.1 + run * count, rise * count]]])
        parts.append(hull([[a, y, z] for a in (x, x + side) for y, z in plan]))
    for number in range(count):
        z, y = rise * (number + 0.5), run * (number + 0.5) + 0.1 - 0.5 * deep
        low = side * (1.0 - lap)
        parts.append(block([low, y, z], [width - low, y + deep, z + thick]))
    return parts


def make_steps(size: Sizes) -> Parts:
    """Return solid steps, each a block."""
    count = int(size.rng.integers(2, 7))
    parts = _make_columns(count, size(0.18), size(0.28), size(0.9))
    return parts if size.flip() else _make_slabs(parts)


def _make_columns(count: int, rise: float, run: float, width: float) -> Parts:
    """Return steps as blocks side by side."""
    return [block([0, run * k, 0], [width, run * (k + 1), rise * (k + 1)]) for k in range(count)]


def _make_slabs(parts: Parts) -> Parts:
    """Return the same steps as slabs one above the other."""
    width, length, high = np.max([part.bounds[1] for part in parts], axis=0)
    rise, run = high / len(parts), length / len(parts)
    return [
        block([0, run * k, rise * k], [width, length, rise * (k + 1)]) for k in range(len(parts))
    ]


def list_builds(family: str, parts: Parts) -> list[Parts]:
    """Return the ways to build what looks like these parts: solid steps of slabs or of blocks."""
    if family != "steps":
        return [parts]
    width, length, high = np.max([part.bounds[1] for part in parts], axis=0)
    count = len(parts)
    return [_make_slabs(parts), _make_columns(count, high / count, length / count, width)]


def make_box(size: Sizes) -> Parts:
    """Return a closed box."""
    return [block([0, 0, 0], [size(0.6), size(0.4), size(0.3)])]


def make_crate(size: Sizes) -> Parts:
    """Return an open crate of five boards."""
    x, y, z, t = size(0.6), size(0.4), size(0.3), size(0.015)
    return [
        block([0, 0, 0], [x, y, t]),
        block([0, 0, t], [t, y, z]),
        block([x - t, 0, t], [x, y, z]),
        block([t, 0, t], [x - t, t, z]),
        block([t, y - t, t], [x - t, y, z]),
    ]


def make_well(size: Sizes) -> Parts:
    """Return a round shaft of 8 to 64 sides, two posts let into its wall, and a roof."""
    radius, wall, deep, high = size(0.6), size(0.15), size(0.8), size(1.8)
    turns = 2.0 * np.pi * np.arange(int(size.rng.integers(8, 65)))
    turns = turns / len(turns) + float(size.rng.random())
    around = np.column_stack([np.cos(turns), np.sin(turns)])
    plan = shapely.Polygon(radius * around, [(radius - wall) * around])
    out, half = radius - 0.5 * wall, size(0.04)
    posts = [
        block([x - half, -half, deep - size(0.1)], [x + half, half, high]) for x in (-out, out)
    ]
    wide, across = radius + size(0.2), size(0.4)
    roof = block([-wide, -across, high], [wide, across, high + size(0.04)])
    return [extruded(plan, 0.0, deep), *posts, roof]


def make_worktop(size: Sizes) -> Parts:
    """Return a worktop with a sink's hole, round or not, on four legs."""
    length, width, high, thick, leg = size(1.8), size(0.6), size(0.9), size(0.04), size(0.06)
    sink = shapely.box(0.3, 0.12, 0.3 + size(0.4), 0.12 + size(0.22))
    if size.flip():
        sink = shapely.Point(0.6, 0.5 * width).buffer(size(0.15), quad_segs=8)
    top = extruded(shapely.box(0, 0, length, width).difference(sink), high - thick, high)
    return [top, *_legs(size, length, width, high - thick, leg, 0.0)]


FAMILIES: dict[str, Callable[[Sizes], Parts]] = {
    "pallet": make_pallet,
    "ladder": make_ladder,
    "cabinet": make_cabinet,
    "trolley": make_trolley,
    "table": make_table,
    "chair": make_chair,
    "stool": make_stool,
    "shelf": make_shelf,
    "desk": make_desk,
    "frame": make_frame,
    "stairs": make_stairs,
    "steps": make_steps,
    "box": make_box,
    "crate": make_crate,
    "well": make_well,
    "worktop": make_worktop,
}


def join_parts(parts: Parts, how: str, rng: np.random.Generator) -> trimesh.Trimesh:
    """Return parts as one mesh: their `union`, or `joined` or `separate` bodies; subdivided or not.

    Unions need manifold3d.
    """
    if how == "union":
        import manifold3d

        solids = [
            manifold3d.Manifold(
                manifold3d.Mesh64(
                    np.asarray(part.vertices, np.float64), np.asarray(part.faces, np.uint64)
                )
            )
            for part in parts
        ]
        made = manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add).to_mesh64()
        mesh = trimesh.Trimesh(made.vert_properties[:, :3], made.tri_verts, process=False)
    else:
        mesh = trimesh.util.concatenate(parts)
        if how == "joined":
            mesh.merge_vertices()
    for _ in range(int(rng.integers(3)) if len(mesh.faces) < 1500 else 0):
        mesh = mesh.subdivide()
    return mesh


def turn_at_random(rng: np.random.Generator) -> FloatArray:
    """Return a random rotation (3, 3)."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return np.asarray(q * np.linalg.det(q))


def iter_variants(
    family: str, seeds: range, how: str
) -> Iterator[tuple[Parts, FloatArray, Indices, FloatArray]]:
    """Yield for each seed the parts, the points and triangles of the mesh, its frame's turn."""
    for seed in seeds:
        rng = np.random.default_rng([seed, *family.encode()])
        parts = FAMILIES[family](Sizes(rng))
        mesh = join_parts(parts, how, rng)
        turn = turn_at_random(rng)
        yield parts, mesh.vertices @ turn.T, np.asarray(mesh.faces, dtype=np.int64), turn
