"""Exact scenes of things that are one solid of upright cuboids: a bed, a sofa, a frame.

All are in metres and stand on the ground.
"""

from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids.cuboid_union import cuboid_union

__all__ = ["bed", "frame", "sofa"]

# A bed's head board, of its length; a sofa's back, of its depth.
HEAD_SHARE = 0.03
BACK_SHARE = 0.25
# How far a sofa's arms rise from its seat to the top of its back.
ARMS_SHARE = 0.5


def bed(width: float, length: float, height: float, head: float) -> Scene:
    """A block to lie on, `height` high, with a board up to `head` across one of its short sides."""
    board = HEAD_SHARE * length
    low = [(0.0, 0.0, 0.0), (0.0, 0.0, 0.0)]
    high = [(length, width, height), (board, width, head)]
    return cuboid_union(low, high, "bed")


def sofa(width: float, depth: float, seat: float, height: float, arm: float) -> Scene:
    """A block up to the `seat`, with a back up to the `height` and arms `arm` broad."""
    back = (1.0 - BACK_SHARE) * depth
    rest = seat + ARMS_SHARE * (height - seat)
    low = [(0.0, 0.0, 0.0), (0.0, back, 0.0), (0.0, 0.0, 0.0), (width - arm, 0.0, 0.0)]
    high = [(width, depth, seat), (width, depth, height), (arm, depth, rest), (width, depth, rest)]
    return cuboid_union(low, high, "sofa")


def frame(width: float, height: float, thickness: float, rim: float) -> Scene:
    """An upright frame of four rails, `rim` broad, round one opening."""
    low = [(0.0, 0.0, 0.0), (0.0, 0.0, height - rim), (0.0, 0.0, 0.0), (width - rim, 0.0, 0.0)]
    high = [
        (width, thickness, rim),
        (width, thickness, height),
        (rim, thickness, height),
        (width, thickness, height),
    ]
    return cuboid_union(low, high, "frame")
