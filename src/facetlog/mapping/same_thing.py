"""Which things of several scenes are one: by the Mahalanobis distance of their poses and sizes.

What stands where another thing stands cannot be a second one: a thing of which a view showed only
a part, as its top, has another middle than the whole, but most of it lies within the whole.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from scipy.optimize import minimize_scalar
from scipy.stats import chi2

from facetlog.mapping.placed_thing import PlacedThing
from facetlog.mapping.plan_box import PlanBox
from facetlog.perception.polygons import find_intersection
from facetlog.perception.types import FloatArray

# The gate: of one thing's poses and sizes 3 in 1,000 are farther apart by chance, as of 3 sd.
GATE_SHARE = 0.9973
GATE_SDS = 3.0
MOST = 0.5
"""More than this share of the lesser of two things lies within the other: then they are one. What
shows more than this share of a thing's surface shows what it is."""
REACH_SDS = 3.0
"""What two surfaces that meet may share by their noise alone: so many standard deviations."""


@dataclass(frozen=True, eq=False, slots=True)
class MappedThing:
    """One thing of the room: its `best` estimate, and all that was seen of it, in its scenes."""

    name: str
    best: PlacedThing
    seen: tuple[PlacedThing, ...]

    @property
    def model(self) -> str:
        """The name that fits best; empty where no model holds."""
        return self.best.said[0].model if self.best.said else ""

    @property
    def label(self) -> str:
        """Text beside it: its name in the map, its model and how sure that is."""
        first = self.best.said[:1]
        return " ".join((self.name, *(f"{said.model} ({said.figure})" for said in first)))


@dataclass(frozen=True, eq=False, slots=True)
class Clash:
    """Two visits that saw one thing at places that are farther apart than they are unsure.

    `distance` is Mahalanobis', metres and radians are `off` and `turned`.
    """

    one: PlacedThing
    other: PlacedThing
    distance: float
    off: float
    turned: float


def distance(one: PlacedThing, other: PlacedThing) -> float:
    """Return the Mahalanobis distance of two things' poses (x, y, heading), with their headings as
    near as what looks the same allows.
    """
    return _distance(_apart(one, other), compute_cov_between(one, other))


def compute_cov_between(one: PlacedThing, other: PlacedThing) -> FloatArray:
    """Return the covariance (3, 3) of how far two estimates of one thing's pose are apart.

    Those of two visits are independent, or else nearer: errors that both have in common are counted
    twice. Within a visit where the robot was is off by what it had driven: the later estimate is
    off as the earlier one, and by what came between. P₂ = F P₁ Fᵀ + Q, and F takes the earlier
    error of the thing to the later one, so Q is the difference of both.
    """
    if one.source[0] != other.source[0]:
        return np.asarray(one.cov + other.cov)
    own: FloatArray = one.box.cov[:3, :3] + other.box.cov[:3, :3]
    values, vectors = np.linalg.eigh(other.common - one.common)
    if values.sum() < 0:
        values = -values
    between = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return np.asarray(own + between)


def merged(
    things: Iterable[PlacedThing],
) -> tuple[tuple[MappedThing, ...], tuple[Clash, ...]]:
    """Return each thing once, in the order of how much was seen of it, and what contradicts that.

    Things of one scene are merged where they stand in each other, too: a drawer block that was told
    apart from its desk is a part of it.
    """
    ranked = sorted(things, key=_rank)
    kept: list[list[PlacedThing]] = []
    clashes = []
    for thing in ranked:
        for group in kept:
            first = group[0]
            if _is_same(first, thing):
                if first.source[0] != thing.source[0]:
                    group[0] = fused(first, thing)
                group.append(thing)
                break
            if _shared(first, thing) > MOST:
                if first.source[0] != thing.source[0] and alike(first, thing):
                    clashes.append(_clash(first, thing))
                    group[0] = _place_where_surer(first, thing)
                group.append(thing)
                break
        else:
            kept.append([thing, thing])
    return (
        tuple(_mapped(f"m{k}", g[0], g[1:]) for k, g in enumerate(kept, start=1)),
        tuple(clashes),
    )


def _rank(thing: PlacedThing) -> tuple[float, tuple[str, str]]:
    """Return a sort key by which what was seen most of comes first: a model may well fit a
    fragment, as a door a panel.
    """
    return -round(thing.seen, 9), thing.source


def _mapped(name: str, best: PlacedThing, seen: Sequence[PlacedThing]) -> MappedThing:
    """Return one thing, named by the first of those `seen`, in their order, that show most
    of it.
    """
    whole = (thing for thing in seen if thing.seen >= MOST * seen[0].seen)
    said = next((thing.said for thing in whole if thing.said), ())
    return MappedThing(name, replace(best, said=said), tuple(seen))


def _turn(one: PlacedThing, other: PlacedThing) -> float:
    """Return the smallest turn between two headings that look the same otherwise."""
    alike = min(one.box.turns_alike, other.box.turns_alike)
    return math.remainder(float(other.pose[2] - one.pose[2]), alike)


def _apart(one: PlacedThing, other: PlacedThing) -> FloatArray:
    return np.array([*(other.pose - one.pose)[:2], _turn(one, other)])


def _distance(apart: FloatArray, cov: FloatArray) -> float:
    return float(np.sqrt(max(float(apart @ np.linalg.pinv(cov, hermitian=True) @ apart), 0.0)))


def _is_same(one: PlacedThing, other: PlacedThing) -> bool:
    """Return whether both may be estimates of one pose and one size."""
    gate = math.sqrt(float(chi2.ppf(GATE_SHARE, 3)))
    return alike(one, other) and distance(one, other) <= gate


def alike(one: PlacedThing, other: PlacedThing) -> bool:
    """Return whether the sizes agree; of plans that may be turned by a quarter, either way
    round.
    """
    first = _lengths(one)
    quarter = min(one.box.turns_alike, other.box.turns_alike) < math.pi
    ways = ((0, 1, 2), (1, 0, 2)) if quarter else ((0, 1, 2),)
    for order in ways:
        second = _lengths(other)[list(order)]
        sds = np.hypot(first[:, 1], second[:, 1])
        if (np.abs(first[:, 0] - second[:, 0]) <= GATE_SDS * sds).all():
            return True
    return False


def _lengths(thing: PlacedThing) -> FloatArray:
    return np.array([(each.value, each.sd) for each in thing.lengths])


def _shared(one: PlacedThing, other: PlacedThing) -> float:
    """Return which share of the lesser lies within the greater, as upright prisms over their hulls.

    Each is as much larger as it is unsure where it is: of a sheet there would be nothing.
    """
    reach = REACH_SDS * math.sqrt(float(compute_cov_between(one, other)[:2, :2].trace()) / 2)
    reach = max(reach, float(np.finfo(np.float32).eps))
    plans = [thing.plan.buffer(reach, quad_segs=2) for thing in (one, other)]
    in_plan = shapely.area(find_intersection(*plans)) / min(shapely.area(p) for p in plans)
    sd = math.hypot(one.high.sd, other.high.sd)
    spans = [(t.low - REACH_SDS * sd, t.high.value + REACH_SDS * sd) for t in (one, other)]
    least = min(high - low for low, high in spans)
    both = min(spans[0][1], spans[1][1]) - max(spans[0][0], spans[1][0])
    return float(in_plan * max(both, 0.0) / least) if least > 0 else float(in_plan)


def _clash(one: PlacedThing, other: PlacedThing) -> Clash:
    apart = _apart(one, other)
    off = float(np.hypot(*apart[:2]))
    return Clash(one, other, distance(one, other), off, abs(float(apart[2])))


def fused(one: PlacedThing, other: PlacedThing) -> PlacedThing:
    """Return the first with the pose that both estimates give together, by covariance intersection.

    Two runs of one robot share errors that are not known, as of its mount: this estimate is
    consistent whatever they share (Julier and Uhlmann 1997). P⁻¹ = ω A⁻¹ + (1 - ω) B⁻¹ with the ω
    that makes P's determinant least.
    """
    a, b = (np.linalg.pinv(thing.cov, hermitian=True) for thing in (one, other))

    def cov_of(share: float) -> FloatArray:
        return np.linalg.pinv(share * a + (1 - share) * b, hermitian=True)

    found = minimize_scalar(
        lambda share: np.linalg.det(cov_of(share)), bounds=(0.0, 1.0), method="bounded"
    )
    share = min((0.0, float(found.x), 1.0), key=lambda each: np.linalg.det(cov_of(each)))
    cov = cov_of(share)
    step = cov @ ((1 - share) * b) @ _apart(one, other)
    return _at(one, step, cov)


def _place_where_surer(one: PlacedThing, other: PlacedThing) -> PlacedThing:
    """Return the first where that one of two poses has it that is surer of its place."""
    spreads = [float(thing.cov[:2, :2].trace()) for thing in (one, other)]
    return one if spreads[0] <= spreads[1] else _at(one, _apart(one, other), other.cov)


def _at(one: PlacedThing, step: FloatArray, cov: FloatArray) -> PlacedThing:
    """Return a thing moved by a step (3,) in x, y and heading, to a pose of this covariance
    (3, 3).
    """
    values = one.box.values.copy()
    values[:3] += step
    own = one.box.cov.copy()
    # All of it counts as in common from here on: what is each one's own is not told apart.
    own[:3, :] = own[:, :3] = 0.0
    outline = _moved(one.outline, one.pose, values[:3])
    corners = one.triangles.reshape(-1, 3)
    level = _moved(corners[:, :2], one.pose, values[:3])
    triangles = np.column_stack([level, corners[:, 2]]).reshape(-1, 3, 3)
    box = PlanBox(values, own)
    return replace(one, box=box, common=(cov + cov.T) / 2, outline=outline, triangles=triangles)


def _moved(points: FloatArray, before: FloatArray, after: FloatArray) -> FloatArray:
    """Return points (n, 2) of what was at one pose (3,) and is at another."""
    turn = float(after[2] - before[2])
    c, s = math.cos(turn), math.sin(turn)
    moved: FloatArray = (points - before[:2]) @ np.array([[c, s], [-s, c]]) + after[:2]
    return moved
