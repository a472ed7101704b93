"""Furniture, boxes and stairs: makers by size, and things whose sizes follow from a seed.

Each stands on z = 0 with the middle of its plan at the origin; x is along the length, y along the
depth with the front at -y, z up. No two pieces that meet have a face in one plane, and faces hidden
by another piece are left out. Sizes of things in `VARIED` are drawn in centimetres, from the ranges
that makers of furniture offer, and given in inches. `shrunk` makes a model of the thing that the
paper's tour of 24 views sees well.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from facetlog.robot.rendering.solids import (
    LEAST_INSET_SHARE,
    WHITE_PAINT,
    Part,
    chair,
    cuboid,
    joined,
    legs,
    placed,
    slab,
    table,
)
from facetlog.robot.rendering.world import Solid

# A desk's front panel hangs this far in from its rear rim, as a share of the depth.
MODESTY_INSET_SHARE = 0.15


def desk(
    length: float,
    depth: float,
    height: float,
    *,
    thickness: float,
    panel: float,
    modesty: float,
    blocks: tuple[float, float] = (0.0, 0.0),
    albedo: float = WHITE_PAINT,
) -> Solid:
    """Return a top on two side panels, tied at the rear by a panel that hangs `modesty` of the
    height.

    `blocks` are the widths of a drawer block at the left and at the right end: 0 for none, where
    a side panel of thickness `panel` stands instead.
    """
    below = height - thickness
    x, y = (1 - LEAST_INSET_SHARE) * length / 2, (1 - LEAST_INSET_SHARE) * depth / 2
    left, right = (width or panel for width in blocks)
    sides = [
        slab((low, -y, 0.0), (width, 2 * y, below), without=("top",))
        for low, width in ((-x, left), (x - right, right))
    ]
    rear = slab(
        (-x + left, depth * (0.5 - MODESTY_INSET_SHARE) - panel, below - modesty * height),
        (2 * x - left - right, panel, modesty * height),
        without=("top", "left", "right"),
    )
    return joined("desk", [_top(length, depth, height, thickness), *sides, rear], albedo)


def bed(
    length: float,
    width: float,
    height: float,
    *,
    head: float,
    thickness: float,
    albedo: float = WHITE_PAINT,
) -> Solid:
    """Return a block to lie on, with a board `head` high and a little broader across its left
    end.
    """
    block = slab(
        (thickness - length / 2, -width / 2, 0.0),
        (length - thickness, width, height),
        without=("left",),
    )
    reach = (1 + LEAST_INSET_SHARE) * width
    board = slab((-length / 2, -reach / 2, 0.0), (thickness, reach, head))
    return joined("bed", [block, board], albedo)


def bench(
    length: float,
    depth: float,
    height: float,
    *,
    thickness: float,
    support: float,
    panels: bool,
    albedo: float = WHITE_PAINT,
) -> Solid:
    """Return a long seat on two panels across it, or on four legs; `support` is how thick they
    are.
    """
    below = height - thickness
    if not panels:
        parts = legs(length, depth, below, support)
    else:
        x = length / 2 - LEAST_INSET_SHARE * length
        y = (1 - LEAST_INSET_SHARE) * depth / 2
        parts = tuple(
            slab((low, -y, 0.0), (support, 2 * y, below), without=("top",))
            for low in (-x, x - support)
        )
    return joined("bench", [_top(length, depth, height, thickness), *parts], albedo)


def crate(
    length: float,
    width: float,
    height: float,
    *,
    thickness: float,
    albedo: float = WHITE_PAINT,
) -> Solid:
    """Return a floor with walls all round, open above."""
    x, y = length / 2, width / 2
    sides = [slab((-x, low, 0.0), (length, thickness, height)) for low in (-y, y - thickness)]
    # The ends stand between them, a little farther in and lower, the floor between all four.
    margin = LEAST_INSET_SHARE * thickness
    room = width - 2 * thickness
    ends = [
        slab(
            (low, thickness - y, 0.0),
            (thickness, room, height - margin),
            without=("front", "back"),
        )
        for low in (margin - x, x - margin - thickness)
    ]
    floor = slab(
        (margin + thickness - x, thickness - y, margin),
        (length - 2 * (margin + thickness), room, thickness),
        without=("left", "right", "front", "back"),
    )
    return joined("crate", [*sides, *ends, floor], albedo)


def frame(
    width: float, height: float, *, thickness: float, rim: float, albedo: float = WHITE_PAINT
) -> Solid:
    """Return four rails round one opening, upright."""
    margin = LEAST_INSET_SHARE * thickness
    x, y = width / 2, thickness / 2
    sides = [slab((low, -y, 0.0), (rim, thickness, height)) for low in (-x, x - rim)]
    rails = [
        slab(
            (rim - x, margin - y, low),
            (width - 2 * rim, thickness - 2 * margin, rim),
            without=("left", "right"),
        )
        for low in (margin, height - margin - rim)
    ]
    return joined("frame", [*sides, *rails], albedo)


def sofa(
    length: float,
    depth: float,
    height: float,
    *,
    seat: float,
    arm: float,
    back: float,
    albedo: float = WHITE_PAINT,
) -> Solid:
    """Return a block to sit on, `seat` high, between two arms `arm` broad and before a back `back`
    deep.

    The arms reach half as far above the seat as the back does.
    """
    margin = LEAST_INSET_SHARE * depth
    x, y = length / 2, depth / 2
    rests = [
        slab((low, -y, 0.0), (arm, depth - margin, (seat + height) / 2)) for low in (-x, x - arm)
    ]
    inner = (arm - x, length - 2 * arm)
    rear = slab((inner[0], y - back, 0.0), (inner[1], back, height))
    block = slab(
        (inner[0], margin - y, 0.0),
        (inner[1], depth - back - margin, seat),
        without=("left", "right", "back"),
    )
    return joined("sofa", [*rests, rear, block], albedo)


def stool(
    length: float,
    depth: float,
    height: float,
    *,
    thickness: float,
    leg: float,
    albedo: float = WHITE_PAINT,
) -> Solid:
    """Return a small seat without a back on four square legs."""
    parts = [_top(length, depth, height, thickness), *legs(length, depth, height - thickness, leg)]
    return joined("stool", parts, albedo)


def shelf(
    width: float,
    depth: float,
    height: float,
    *,
    boards: int,
    thickness: float,
    back: bool,
    albedo: float = WHITE_PAINT,
) -> Solid:
    """Return `boards` level boards between two sides, evenly from foot to top, open in front.

    With a `back` it is shut behind. ValueError for fewer than two boards, or boards too thick.
    """
    if boards < 2:
        raise ValueError(f"a shelf needs two boards at least, not {boards}")
    if boards * thickness >= height or 2 * thickness >= width or 2 * thickness >= depth:
        raise ValueError("the boards of a shelf leave no room between them")
    # The sides reach a little higher, lower and farther forward than what they hold.
    margin = LEAST_INSET_SHARE * depth
    x, y = width / 2, depth / 2
    inner = width - 2 * thickness
    parts = [slab((low, -y, 0.0), (thickness, depth, height)) for low in (-x, x - thickness)]
    lowest, highest = margin, height - margin - thickness
    rear = y - margin
    between = rear
    if back:
        # It stands on the lowest board and below the highest; the others end in front of it.
        between -= thickness
        room = highest - lowest - thickness
        upright = slab(
            (thickness - x, between, lowest + thickness),
            (inner, thickness, room),
            without=("left", "right", "bottom", "top"),
        )
        parts.append(upright)
    for low in np.linspace(lowest, highest, boards):
        ends = rear if low in (lowest, highest) else between
        corner = (thickness - x, margin - y, float(low))
        hidden = ("left", "right") if ends == rear else ("left", "right", "back")
        parts.append(slab(corner, (inner, ends - margin + y, thickness), without=hidden))
    return joined("shelf", parts, albedo)


def cabinet(
    width: float,
    depth: float,
    height: float,
    *,
    foot: float,
    leg: float = 0.0,
    albedo: float = WHITE_PAINT,
) -> Solid:
    """Return a closed block on a plinth `foot` high, or on four legs of thickness `leg` and that
    height.

    ValueError if the foot is as high as the whole.
    """
    if not 0 < foot < height:
        raise ValueError("the foot of a cabinet must be lower than the cabinet")
    body = slab((-width / 2, -depth / 2, foot), (width, depth, height - foot))
    inset = LEAST_INSET_SHARE * min(width, depth)
    plinth = slab(
        (inset - width / 2, inset - depth / 2, 0.0),
        (width - 2 * inset, depth - 2 * inset, foot),
        without=("top",),
    )
    feet = legs(width, depth, foot, leg) if leg > 0 else (plinth,)
    return joined("cabinet", [body, *feet], albedo)


def stairs(
    steps: int, width: float, rise: float, going: float, *, albedo: float = WHITE_PAINT
) -> Solid:
    """Return a solid flight that climbs along x: each step `rise` high and `going` deep, `width`
    across.

    ValueError for fewer than two steps.
    """
    if steps < 2:
        raise ValueError(f"stairs need two steps at least, not {steps}")
    treads = [(going * i, rise * (i + k)) for i in range(steps) for k in (0, 1)]
    # Anticlockwise seen from the front (-y), where x points to the right and z up.
    profile = [(0.0, 0.0), (going * steps, 0.0), (going * steps, rise * steps), *treads[:0:-1]]
    n = len(profile)
    x, y = going * steps / 2, width / 2
    points = np.array([(u - x, v, z) for v in (-y, y) for u, z in profile])
    loops = [tuple(range(n)), tuple(reversed(range(n, 2 * n)))]
    loops += [(i, n + i, n + (i + 1) % n, (i + 1) % n) for i in range(n)]
    return joined("stairs", [(points, loops)], albedo)


def _top(length: float, depth: float, height: float, thickness: float) -> Part:
    return slab((-length / 2, -depth / 2, height - thickness), (length, depth, thickness))


CM = 1 / 2.54  # inches
# What the tour's cameras, 35 inches away and 28.5 high, see whole in 20 of 24 pictures and from
# above (measured on boxes turned at random): the diagonal of the plan, and the height.
PLAN_IN = 16.5
HEIGHT_IN = 16.0
# Models are made a little smaller than that at random.
SMALLEST_SHARE = 0.8

Range = tuple[float, float]
# Height, length, and width over length, of what people sit at: coffee, dining and bar tables.
TABLES: tuple[tuple[Range, Range, Range], ...] = (
    ((38.0, 50.0), (70.0, 130.0), (0.45, 1.0)),
    ((71.0, 78.0), (70.0, 220.0), (0.42, 1.0)),
    ((90.0, 110.0), (60.0, 150.0), (0.5, 1.0)),
)
COMMONEST_TABLE = (0.25, 0.6, 0.15)

Draw = Callable[[np.random.Generator], Solid]


def shrunk(solid: Solid, rng: np.random.Generator) -> tuple[Solid, float]:
    """Return a model of a thing that fits the tour, and how many times larger the thing is."""
    x, y, z = np.ptp(solid.vertices, axis=0)
    largest = min(PLAN_IN / float(np.hypot(x, y)), HEIGHT_IN / float(z))
    share = largest * float(rng.uniform(SMALLEST_SHARE, 1.0))
    return placed(solid, 0.0, 0.0, scale=share), 1 / share


def _cm(rng: np.random.Generator, low: float, high: float) -> float:
    """Return a length between two of so many centimetres, in inches."""
    return CM * float(rng.uniform(low, high))


def _table(rng: np.random.Generator) -> Solid:
    height, length, share = TABLES[int(rng.choice(len(TABLES), p=COMMONEST_TABLE))]
    long = _cm(rng, *length)
    return table(
        long,
        long * float(rng.uniform(*share)),
        _cm(rng, *height),
        thickness=_cm(rng, 2.0, 6.0),
        leg=_cm(rng, 4.0, 10.0),
        inset=float(rng.uniform(0.02, 0.1)),
    )


def _chair(rng: np.random.Generator) -> Solid:
    width = _cm(rng, 38.0, 55.0)
    return chair(
        width,
        width * float(rng.uniform(0.85, 1.1)),
        _cm(rng, 42.0, 50.0),
        _cm(rng, 35.0, 60.0),
        thickness=_cm(rng, 2.0, 6.0),
        leg=_cm(rng, 3.0, 6.0),
    )


def _box(rng: np.random.Generator) -> Solid:
    length = _cm(rng, 15.0, 80.0)
    width = length * float(rng.uniform(0.35, 1.0))
    return cuboid(length, width, width * float(rng.uniform(0.3, 1.5)), name="box")


def _desk(rng: np.random.Generator) -> Solid:
    ends = ((0, 0), (1, 0), (0, 1), (1, 1))[int(rng.integers(4))]
    left, right = (end * _cm(rng, 35.0, 48.0) for end in ends)
    return desk(
        _cm(rng, 110.0, 180.0),
        _cm(rng, 55.0, 80.0),
        _cm(rng, 70.0, 78.0),
        thickness=_cm(rng, 2.0, 4.0),
        panel=_cm(rng, 2.0, 4.0),
        modesty=float(rng.uniform(0.3, 0.7)),
        blocks=(left, right),
    )


def _bench(rng: np.random.Generator) -> Solid:
    panels = bool(rng.random() < 0.5)
    return bench(
        _cm(rng, 90.0, 180.0),
        _cm(rng, 28.0, 45.0),
        _cm(rng, 40.0, 50.0),
        thickness=_cm(rng, 2.5, 6.0),
        support=_cm(rng, 2.5, 6.0) if panels else _cm(rng, 4.0, 8.0),
        panels=panels,
    )


def _stool(rng: np.random.Generator) -> Solid:
    length = _cm(rng, 28.0, 42.0)
    return stool(
        length,
        length * float(rng.uniform(0.85, 1.0)),
        _cm(rng, 42.0, 75.0),
        thickness=_cm(rng, 2.0, 5.0),
        leg=_cm(rng, 3.0, 5.0),
    )


def _shelf(rng: np.random.Generator) -> Solid:
    return shelf(
        _cm(rng, 60.0, 120.0),
        _cm(rng, 22.0, 40.0),
        _cm(rng, 75.0, 200.0),
        boards=int(rng.integers(3, 7)),
        thickness=_cm(rng, 1.6, 3.0),
        back=bool(rng.random() < 0.5),
    )


def _cabinet(rng: np.random.Generator) -> Solid:
    depth = _cm(rng, 30.0, 60.0)
    on_legs = bool(rng.random() < 0.5)
    return cabinet(
        _cm(rng, 40.0, 110.0),
        depth,
        depth * float(rng.uniform(1.3, 3.5)),
        foot=_cm(rng, 8.0, 15.0) if on_legs else _cm(rng, 5.0, 10.0),
        leg=_cm(rng, 3.0, 6.0) if on_legs else 0.0,
    )


def _stairs(rng: np.random.Generator) -> Solid:
    return stairs(
        int(rng.integers(3, 6)), _cm(rng, 60.0, 110.0), _cm(rng, 15.0, 20.0), _cm(rng, 24.0, 32.0)
    )


def _steps(rng: np.random.Generator) -> Solid:
    return stairs(2, _cm(rng, 35.0, 50.0), _cm(rng, 18.0, 24.0), _cm(rng, 17.0, 24.0))


def _bed(rng: np.random.Generator) -> Solid:
    height = _cm(rng, 35.0, 60.0)
    return bed(
        _cm(rng, 185.0, 215.0),
        _cm(rng, 80.0, 190.0),
        height,
        head=height + _cm(rng, 20.0, 60.0),
        thickness=_cm(rng, 3.0, 8.0),
    )


def _sofa(rng: np.random.Generator) -> Solid:
    seat = _cm(rng, 36.0, 48.0)
    return sofa(
        _cm(rng, 150.0, 240.0),
        _cm(rng, 75.0, 100.0),
        seat + _cm(rng, 30.0, 45.0),
        seat=seat,
        arm=_cm(rng, 10.0, 25.0),
        back=_cm(rng, 15.0, 28.0),
    )


def _crate(rng: np.random.Generator) -> Solid:
    length = _cm(rng, 30.0, 60.0)
    width = length * float(rng.uniform(0.5, 1.0))
    return crate(length, width, width * float(rng.uniform(0.45, 0.9)), thickness=_cm(rng, 0.8, 2.0))


def _door(rng: np.random.Generator) -> Solid:
    size = _cm(rng, 70.0, 100.0), _cm(rng, 3.5, 8.0), _cm(rng, 195.0, 215.0)
    return cuboid(*size, name="door")


def _frame(rng: np.random.Generator) -> Solid:
    width = _cm(rng, 25.0, 70.0)
    return frame(
        width,
        width * float(rng.uniform(0.75, 1.5)),
        thickness=_cm(rng, 1.5, 3.0),
        rim=width * float(rng.uniform(0.08, 0.16)),
    )


VARIED: Mapping[str, Draw] = MappingProxyType(
    {
        "boxes": _box,
        "tables": _table,
        "chairs": _chair,
        "desk": _desk,
        "bench": _bench,
        "stool": _stool,
        "shelf": _shelf,
        "cabinet": _cabinet,
        "stairs": _stairs,
        "steps": _steps,
        "bed": _bed,
        "sofa": _sofa,
        "crate": _crate,
        "door": _door,
        "frame": _frame,
    }
)
"""The thing at its real size in inches, by the name of its world."""
