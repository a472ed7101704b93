"""Rooms with several things of real size on one floor, and what is true of them; metres.

Boxes, tables, chairs, stools and desks as `robot/rendering/furniture.py` draws them, any way round,
so far from one another that a robot passes between them.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely

from facetlog.mapping.plan_box import PlanBox, plan_box
from facetlog.perception.types import FloatArray
from facetlog.robot.rendering.furniture import VARIED
from facetlog.robot.rendering.solids import placed
from facetlog.robot.rendering.world import Solid, World
from facetlog.robot.rendering.worlds import INCH, make_world

FEWEST, MOST = 4, 8
# The world of which each kind is in `get_world_truth`, and the name of its solids in VARIED.
KINDS = {"block": "boxes", "table": "tables", "chair": "chairs", "stool": "stool", "desk": "desk"}
# From the outlines of things to one another, m: a robot of half a metre passes, and turns.
APART = 1.6
# The floor grows by this share until there is room for all.
GROWTH = 1.15
# A draw's own stream, apart from those of worlds and pictures.
STREAM = 7


@dataclass(frozen=True, eq=False, slots=True)
class TrueThing:
    """A thing of a room: its kind (a name of `get_world_truth`), solid (inches) and plan."""

    kind: str
    solid: Solid
    plan: shapely.Polygon
    box: PlanBox
    height: float

    @property
    def middle(self) -> FloatArray:
        """The middle of its rectangle, at half its height (3,)."""
        return np.array([*self.box.values[:2], self.height / 2])

    @property
    def reach(self) -> float:
        """From the middle to the farthest point of its plan."""
        corners = shapely.get_coordinates(self.plan)
        return float(np.linalg.norm(corners - self.box.values[:2], axis=1).max())


@dataclass(frozen=True, eq=False, slots=True)
class Room:
    """Its world (inches), things, and the area (x, y, width, height) in which they stand."""

    world: World
    things: tuple[TrueThing, ...]
    area: tuple[float, float, float, float]


def make_room(seed: int) -> Room:
    """Return the room of a seed: four to eight things."""
    rng = np.random.default_rng([seed, STREAM])
    base = make_world("empty", seed)
    count = int(rng.integers(FEWEST, MOST + 1))
    kinds = [list(KINDS)[int(rng.integers(len(KINDS)))] for _ in range(count)]
    drawn = [VARIED[KINDS[kind]](rng) for kind in kinds]
    side = 3.0
    things: list[TrueThing] = []
    while len(things) < count:
        solid = drawn[len(things)]
        for _ in range(100):
            x, y = rng.uniform(0.0, side, 2).tolist()
            yaw = float(rng.uniform(-np.pi, np.pi))
            there = placed(solid, x / INCH, y / INCH, yaw=yaw)
            plan = _plan(there)
            if all(shapely.distance(plan, other.plan) >= APART for other in things):
                things.append(_true(kinds[len(things)], there))
                break
        else:
            side *= GROWTH
    solids = tuple(thing.solid for thing in things)
    world = World(solids, base.floor, base.sun, name=f"room-{seed}")
    return Room(world, tuple(things), (-APART, -APART, side + 2 * APART, side + 2 * APART))


def _true(kind: str, solid: Solid) -> TrueThing:
    points = INCH * solid.vertices
    sides = {
        (min(a, b), max(a, b))
        for face in solid.faces
        for a, b in pairwise((*face, face[0]))
        if abs(points[a, 2] - points[b, 2]) < 1e-9
    }
    exact = np.zeros((len(points), 2, 2))
    box = plan_box(points[:, :2], exact, np.array(sorted(sides)))
    assert box is not None
    return TrueThing(kind, solid, _plan(solid), box, float(points[:, 2].max()))


def _plan(solid: Solid) -> shapely.Polygon:
    plan = shapely.convex_hull(shapely.multipoints(INCH * solid.vertices[:, :2]))
    assert isinstance(plan, shapely.Polygon)
    return plan
