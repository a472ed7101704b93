"""What was not seen of a thing: why, as far as the scene knows, and from where it could be seen.

Where a part was not found, nobody knows where it would be; but what faces a direction from which
no view came cannot have been seen. Directions are those from the thing's middle to whoever looks at
it, or, where nobody noted that, those that its faces face.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facetlog.kb.explaining.amounts import with_unit
from facetlog.kb.explaining.sight import ImpliedFace, Place, Point, Sight
from facetlog.kb.explaining.wording import listed
from facetlog.perception.facts.fact_schema import FEWEST_VIEWS

__all__ = ["Unseen", "unseen"]

# A face that is looked at from further off its normal than this is seen at a grazing angle: cos 75°
# is a quarter of what one sees from the front (perception's photometric views ask for as much).
GRAZING_DEG = 75.0
# What nobody looked at from within this is worth another look; half a right angle sees both faces
# of an edge.
NEAR_DEG = 45.0
# Lengths of unit vectors in plan below this are those of upright ones.
UPRIGHT = 1e-3
# A way to go is said from this share of the distance to the thing on.
WORTH_SAYING = 0.15
# Digits to which directions and distances are compared.
DIGITS = 6
WAYS = (("to the left", "to the right"), ("further on", "back"), ("up", "down"))
AXES = {
    "+x": (1.0, 0.0, 0.0),
    "-x": (-1.0, 0.0, 0.0),
    "+y": (0.0, 1.0, 0.0),
    "-y": (0.0, -1.0, 0.0),
    "+z": (0.0, 0.0, 1.0),
    "-z": (0.0, 0.0, -1.0),
}

Vector = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Unseen:
    """Why something of a thing may have been missed, and if known from where it could be seen.

    `look` says that in the scene's words, empty where it is not known; `direction` is a unit vector
    from the thing, `place` is in the scene's frame and unit, each None where it is not known.
    """

    why: str
    look: str = ""
    direction: Point | None = None
    place: Point | None = None

    def lines(self, roles: Sequence[str] = ()) -> Iterator[str]:
        """It as text, `roles` being the parts that were not seen."""
        named = f"{' and '.join(roles)} – " if roles else ""
        yield f"unseen: {named}{self.why}"
        if self.look:
            yield f"    {self.look}"

    def to_json(self) -> dict[str, Any]:
        """It as plain data."""
        return {key: value for key, value in asdict(self).items() if value}


def unseen(sight: Sight, thing: str, length_unit: str | None) -> tuple[Unseen, ...]:
    """Why something of the thing may have been missed, whatever it is; nothing of a whole one.

    First the directions that it was looked at from least, in plan and from above, then views that
    are too few or past it, then faces that are known only from their neighbours.
    """
    if sight.whole:
        return ()
    if not sight.points:
        return tuple(map(Unseen, _nothing_found(len(sight.places))))
    points = np.array(sight.points)
    about = _Thing(thing, (points.min(axis=0) + points.max(axis=0)) / 2, length_unit)
    seers = [p for p in sight.places if p.count != 0 and p.at != _point(about.middle)]
    found = list(_least_looked_at(sight, about, seers))
    found.extend(map(Unseen, _missed(sight, thing)))
    return tuple(found)


def _least_looked_at(sight: Sight, about: "_Thing", seers: Sequence[Place]) -> Iterator[Unseen]:
    steps = [np.array(place.at) - about.middle for place in seers]
    steps = steps or [np.array(normal) for normal in sight.normals]
    if not steps:
        return
    towards = np.array(steps) / np.linalg.norm(steps, axis=1)[:, None]
    for direction, off in _least_seen(towards, None if sight.up is None else np.array(sight.up)):
        if any(direction @ n > math.cos(math.radians(NEAR_DEG)) for n in np.array(sight.normals)):
            continue  # a face that looks there was found
        if off > NEAR_DEG and seers:
            yield _beside_a_view(direction, off, sight, seers, about)
        elif off > NEAR_DEG:
            side = _axis_words(direction)
            why = f"no face that was found of {about.name} faces towards {side}"
            look = f"look at it from the side towards {side}"
            yield Unseen(why, look, _point(direction))


@dataclass(frozen=True, eq=False, slots=True)
class _Thing:
    name: str
    middle: Vector
    length_unit: str | None

    def length(self, value: float, away: float) -> str:
        """A way to go, with one digit; where the scale is not known as a share of the distance."""
        if self.length_unit is None:
            return f"{abs(value) / away:.1f} of the distance"
        size = abs(value)
        return with_unit(f"{size:.1f}" if size >= 0.1 else f"{size:.2f}", self.length_unit)


def _nothing_found(views: int) -> Iterator[str]:
    found = f"a face is found where at least {FEWEST_VIEWS} agree on it"
    if 0 < views < FEWEST_VIEWS:
        yield f"there {'are' if views > 1 else 'is'} but {views} view{'s' * (views > 1)}: {found}"
    elif views:
        yield f"the {views} views agree on no face"


def _missed(sight: Sight, thing: str) -> Iterator[str]:
    """Why something of the thing may have been missed, whatever it is: views too few or past it."""
    views = [place for place in sight.places if place.count is not None]
    seeing = [place for place in views if place.count]
    if views and len(seeing) < FEWEST_VIEWS:
        which = " and ".join(place.name for place in seeing) or "no view"
        yield f"too few views: {which} alone show{'s' * (len(seeing) < 2)} something of {thing}"
    past = [place.name for place in views if not place.count]
    if past and seeing:
        shown = ", ".join(past[:4]) + (" …" if len(past) > 4 else "")
        yield f"outside the pictures: nothing of {thing} was found in {shown}"
    for face in sight.implied:
        yield f"{face.name} was not measured: {_missed_face(face)}"


def _missed_face(face: ImpliedFace) -> str:
    """Why a face is only known from its neighbours."""
    if not face.looks:
        return "every view is behind it, or looks along it"
    best = max(face.looks, key=lambda look: look.seen)
    hidden = max(best.hidden, key=lambda pair: pair[1], default=("", 0.0))
    reasons = {
        f"{best.view}, which is before it, has {best.outside:.0%} of it outside the picture": (
            best.outside
        ),
        f"{hidden[0]} hides {hidden[1]:.0%} of it from {best.view}": hidden[1],
        f"views do not agree on it; {best.view} shows most, {best.seen:.0%}": (
            1 - best.seen - best.outside - sum(share for _, share in best.hidden)
        ),
    }
    return max(reasons, key=lambda reason: reasons[reason])


# ---- directions


def _least_seen(towards: Vector, up: Vector | None) -> Iterator[tuple[Vector, float]]:
    """The directions farthest from all (n, 3) that it was seen from, and by how many degrees.

    Where up is known the middle of the widest gap in plan, then up; else the farthest of the axes.
    """
    if up is None:
        axes = np.array(list(AXES.values()), dtype=np.float64)
        angles = _least_angles(axes, towards)
        yield axes[angles.argmax()], float(angles.max())
        return
    flat = towards - np.outer(towards @ up, up)
    sizes = np.linalg.norm(flat, axis=1)
    if (sizes > UPRIGHT).any():
        level = flat[sizes > UPRIGHT] / sizes[sizes > UPRIGHT, None]
        ahead, left = level[0], np.cross(up, level[0])
        turns = np.sort(np.arctan2(level @ left, level @ ahead))
        gaps = np.diff([*turns, turns[0] + 2 * math.pi])
        widest = np.round(gaps, DIGITS).argmax()
        middle = turns[widest] + gaps[widest] / 2
        yield math.cos(middle) * ahead + math.sin(middle) * left, math.degrees(gaps.max() / 2)
    yield up, float(_least_angles(up[None], towards)[0])


def _least_angles(directions: Vector, others: Vector) -> Vector:
    cosines = (directions @ others.T).max(axis=1)
    angles: Vector = np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0)))
    return angles


def _axis_words(direction: Vector) -> str:
    """The axis, or the two, that a direction lies nearest to.

    >>> _axis_words(np.array([1.0, 0.0, 0.1])), _axis_words(np.array([0.6, -0.8, 0.0]))
    ('+x', '+x and -y')
    """
    return " and ".join(name for name, axis in AXES.items() if direction @ axis > 0.45)


# ---- a place to look from


def _beside_a_view(
    direction: Vector, off: float, sight: Sight, seers: Sequence[Place], thing: "_Thing"
) -> Unseen:
    """A place in that direction, described from the view that is nearest to it."""
    steps = np.array([place.at for place in seers]) - thing.middle
    away = float(np.median(np.linalg.norm(steps, axis=1)))
    up = None if sight.up is None else np.array(sight.up)
    if up is not None and abs(direction @ up) < 0.5:
        # As high as most views, so that it shows from there what they show from their side.
        rise = float(np.median(steps @ up / np.linalg.norm(steps, axis=1)))
        direction = math.sqrt(1 - rise**2) * direction + rise * up
    place = thing.middle + away * direction
    # Of several as near the first, whatever their last digits.
    nearest = min(seers, key=lambda seer: round(math.dist(seer.at, place) / away, DIGITS))
    named = nearest.name
    if nearest.picture != nearest.name:
        named = f"{nearest.name} ({nearest.picture})"
    if up is None:
        side = f"the side towards {_axis_words(direction)}"
        move = f"from there, from as far away as {named} is"
    else:
        step = place - np.array(nearest.at)
        forward = thing.middle - np.array(nearest.at)
        forward -= (forward @ up) * up
        size = np.linalg.norm(forward)
        forward = forward / size if size > UPRIGHT * away else np.cross(up, np.roll(up, 1))
        left = np.cross(up, forward)
        side = _side_words(direction, forward, left, up)
        side += "" if side == "above" else f", as {nearest.name} sees it"
        moves = [
            f"{thing.length(step @ axis, away)} {ways[int(step @ axis < 0)]}"
            for axis, ways in zip((left, forward, up), WAYS, strict=True)
            if abs(step @ axis) > WORTH_SAYING * away
        ]
        move = f"from a place {listed(moves)} as seen from {named}"
    why = f"no view looks at {thing.name} from {side}"
    if GRAZING_DEG <= off < 90:
        why = f"from {side}, {thing.name} is seen only at a grazing angle of {90 - off:.0f}°"
    return Unseen(why, f"look at it {move}", _point(direction), _point(place))


def _point(vector: Vector) -> Point:
    x, y, z = vector.tolist()
    return x, y, z


def _side_words(direction: Vector, forward: Vector, left: Vector, up: Vector) -> str:
    """The direction as a viewer calls it who looks along `forward`."""
    if direction @ up > 0.9:
        return "above"
    turn = math.degrees(math.atan2(abs(direction @ left), direction @ forward))
    side = "left" if direction @ left > 0 else "right"
    if turn < 30:
        return "behind"
    return f"behind and the {side}" if turn < 70 else f"the {side}"
