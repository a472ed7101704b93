"""Makers of furniture and stairs: each stands on z = 0 with the middle of its plan at the origin.

Lengths are in world units; x is along the length, y along the depth with the front at -y, z up.
No two pieces that meet have a face in one plane, and faces hidden by another piece are left out.
"""

import numpy as np

from facetlog.robot.rendering.solids import LEAST_INSET_SHARE, WHITE_PAINT, Part, joined, legs, slab
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
