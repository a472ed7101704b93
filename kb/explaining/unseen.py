"""Unseen parts of a thing: why, as far as the scene knows, and from where it could be seen.

Where a part was not found, nobody knows where it would be; but what faces a direction from which
no view came cannot have been seen. Directions are those from the thing's middle to whoever looks at
it, or, where nobody noted that, those that its faces face.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facetlog.kb.explaining.amounts import format_with_unit
from facetlog.kb.explaining.sight import ImpliedFace, Place, Point, Sight
from facetlog.kb.explaining.wording import listed
from facetlog.perception.facts.fact_schema import FEWEST_VIEWS

__all__ = ["Unseen", "unseen"]

UPRIGHT = 1e-3
"""Lengths of unit vectors in plan below this are those of upright ones."""
# A way to go is said from this share of the distance to the thing on.
WORTH_SAYING = 0.15
# The most places that are named where volume is in no piece.
MOST_GAPS = 3
DIGITS = 6
"""Digits to which directions and distances are compared."""

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

# A face that is looked at from further off its normal than this is seen at a grazing angle: cos 75°
# is a quarter of what one sees from the front (perception's photometric views ask for as much).
GRAZING_DEG = 75.0
# What nobody looked at from within this is worth another look; half a right angle sees both faces
# of an edge.
NEAR_DEG = 45.0
# Of unseen space less than this share is none that would show, as it is said.
LEAST_SHOWN = 0.005


@dataclass(frozen=True, slots=True)
class Unseen:
    """Why something of a thing may have been missed, and if known from where it could be seen.

    `look` says that in the scene's words, empty where it is not known; `direction` is a unit vector
    from the thing, `place` is in the scene's frame and unit, each None where it is not known.
    `space` says that it is the space round the thing that nobody looked into.
    """

    why: str
    look: str = ""
    direction: Point | None = None
    place: Point | None = None
    space: bool = False

    def lines(self, roles: Sequence[str] = ()) -> Iterator[str]:
        """Return it as text, `roles` being the parts that were not seen."""
        named = f"{' and '.join(roles)} – " if roles else ""
        yield f"unseen: {named}{self.why}"
        if self.look:
            yield f"    {self.look}"

    def to_json(self) -> dict[str, Any]:
        """Return it as plain data."""
        return {key: value for key, value in asdict(self).items() if value}


def unseen(sight: Sight, thing: str, length_unit: str | None) -> tuple[Unseen, ...]:
    """Return why something of the thing may have been missed, whatever it is; of a whole one, what
    is in no piece.

    First the directions that it was looked at from least, in plan and from above, and the one from
    which most of the unseen space round it shows, unless that is near one of them; then views that
    are too few or past it, then faces that are known only from their neighbours.
    """
    gaps = tuple(_iter_gaps(sight, thing, length_unit))
    if sight.whole:
        return gaps
    if not sight.points:
        return tuple(map(Unseen, _iter_no_face_reasons(len(sight.places))))
    points = np.array(sight.points)
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    seers = tuple(p for p in sight.places if p.count != 0 and p.at != tuple(middle.tolist()))
    up = None if sight.up is None else np.array(sight.up)
    about = Looked(thing, middle, seers, up, length_unit)
    found = list(_iter_unseen_sides(sight, about))
    found.extend(_iter_unseen_space(sight, about, found))
    found.extend(map(Unseen, _iter_missed_reasons(sight, thing)))
    return (*found, *gaps)


def _iter_gaps(sight: Sight, thing: str, length_unit: str | None) -> Iterator[Unseen]:
    """Return how much of the thing's volume is in no piece, and where."""
    lacking = 1.0 - sight.filled
    if round(lacking, 2) <= 0.0:
        return
    if not sight.gaps:
        yield Unseen(f"{lacking:.0%} of the volume of {thing} is in no piece")
        return
    points = np.array(sight.points)
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    up = None if sight.up is None else np.array(sight.up)
    places = []
    for low, high in sight.gaps[:MOST_GAPS]:
        corners = np.array([low, high])
        off = corners.mean(axis=0) - middle
        place = describe_axis(off / max(float(np.linalg.norm(off)), 1e-300)) or "nowhere else"
        place = f"towards {place}"
        if up is not None:
            ends = np.where(up < 0.0, corners[::-1], corners)
            heights = ends @ up - (points @ up).min()
            span = "–".join(f"{height:.2g}" for height in heights.tolist())
            place += f", {format_with_unit(span, length_unit or 'units')} up"
        places.append(place)
    yield Unseen(f"{lacking:.0%} of the volume of {thing} is in no piece: {'; '.join(places)}")


def _iter_unseen_sides(sight: Sight, about: "Looked") -> Iterator[Unseen]:
    steps = about.steps() if about.seers else np.array(sight.normals).reshape(-1, 3)
    if not len(steps):
        return
    towards = steps / np.linalg.norm(steps, axis=1)[:, None]
    for direction, off in _iter_least_seen_directions(towards, about.up):
        if off <= NEAR_DEG or any(map(partial(_is_near, _to_point(direction)), sight.normals)):
            continue  # someone looked from there, or a face that looks there was found
        if about.seers:
            yield _describe_unseen_side(about.raise_to_view_height(direction), off, about)
        else:
            side = describe_axis(direction)
            why = f"no face that was found of {about.name} faces towards {side}"
            look = f"look at it from the side towards {side}"
            yield Unseen(why, look, _to_point(direction))


def _describe_unseen_side(direction: Vector, off: float, about: "Looked") -> Unseen:
    way = about.way(direction)
    why = f"no view looks at {about.name} from {way.side}"
    if GRAZING_DEG <= off < 90:
        why = f"from {way.side}, {about.name} is seen only at a grazing angle of {90 - off:.0f}°"
    return Unseen(why, f"look at it {way.go}", _to_point(direction), way.at)


def _iter_unseen_space(sight: Sight, about: "Looked", said: Sequence[Unseen]) -> Iterator[Unseen]:
    """Return the side from which most of the unseen space would show, if nothing said is near
    there."""
    # Of directions as good the first, whatever their last digits.
    best = max(sight.opening, key=lambda each: round(each[1], DIGITS), default=None)
    if best is None:
        return
    towards, share = best
    if share < LEAST_SHOWN:
        yield _explain_enclosed_space(sight, about)
        return
    if any(found.direction and _is_near(found.direction, towards) for found in said):
        return
    why = f"there is space round {about.name} that nobody looked into"
    most = f"{100 * share:.0f} % of it would show from there"
    if not about.seers:
        side = describe_axis(np.array(towards))
        yield Unseen(why, f"look at it from the side towards {side}: {most}", towards, space=True)
        return
    way = about.way(np.array(towards))
    steps = about.steps()
    seen_from = steps / np.linalg.norm(steps, axis=1)[:, None]
    if any(_is_near(_to_point(step), towards) for step in seen_from):
        why = f"what lies behind {about.name}, from {way.side}, has nothing that could be measured"
        go = f"put something with a pattern there, and look at it {way.go}: {most}"
        yield Unseen(why, go, space=True)
    else:
        yield Unseen(why, f"look at it {way.go}: {most}", towards, way.at, space=True)


def _explain_enclosed_space(sight: Sight, about: "Looked") -> Unseen:
    """Return why unseen space shows from nowhere: surface goes all round it."""
    points = np.array(sight.points)
    places = np.array([seer.at for seer in about.seers]).reshape(-1, 3)
    within = (places > points.min(axis=0)) & (places < points.max(axis=0))
    if not within.all(axis=1).any():
        return Unseen(f"the unseen space in {about.name} shows from nowhere outside", space=True)
    why = f"{about.name} goes all round a place that it was seen from"
    go = "look at it from outside, or put right where it was seen from, if it was from outside"
    return Unseen(why, go, space=True)


def _is_near(direction: Point, other: Point) -> bool:
    cosine = sum(a * b for a, b in zip(direction, other, strict=True))
    return cosine > math.cos(math.radians(NEAR_DEG))


def _iter_no_face_reasons(views: int) -> Iterator[str]:
    found = f"a face is found where at least {FEWEST_VIEWS} agree on it"
    if 0 < views < FEWEST_VIEWS:
        yield f"there {'are' if views > 1 else 'is'} but {views} view{'s' * (views > 1)}: {found}"
    elif views:
        yield f"the {views} views agree on no face"


def _iter_missed_reasons(sight: Sight, thing: str) -> Iterator[str]:
    """Return why something of the thing may have been missed, whatever it is: views too few or past
    it."""
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
        yield f"{face.name} was not measured: {_explain_missed_face(face)}"


def _explain_missed_face(face: ImpliedFace) -> str:
    """Return why a face is only known from its neighbours."""
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


def _iter_least_seen_directions(
    towards: Vector, up: Vector | None
) -> Iterator[tuple[Vector, float]]:
    """Return the directions farthest from all (n, 3) that it was seen from, and by how many
    degrees.

    Where up is known the middle of the widest gap in plan, then up; else the farthest of the axes.
    """
    if up is None:
        axes = np.array(list(AXES.values()), dtype=np.float64)
        angles = _compute_least_angles(axes, towards)
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
    yield up, float(_compute_least_angles(up[None], towards)[0])


def _compute_least_angles(directions: Vector, others: Vector) -> Vector:
    cosines = (directions @ others.T).max(axis=1)
    angles: Vector = np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0)))
    return angles


def _to_point(vector: Vector) -> Point:
    x, y, z = vector.tolist()
    return x, y, z


# ---- the way to a place to look from


@dataclass(frozen=True, slots=True)
class Way:
    """The way to a place, `at` in the scene's frame.

    `side` is the side of the thing that it lies on, and `go` how one gets there, in words.
    """

    at: Point
    side: str
    go: str


@dataclass(frozen=True, eq=False, slots=True)
class Looked:
    """A thing, its middle (3,), and the places that it was looked at from; `up` is a unit vector
    (3,), None where it is not known.
    """

    name: str
    middle: Vector
    seers: tuple[Place, ...]
    up: Vector | None
    length_unit: str | None

    def steps(self) -> Vector:
        """Return the ways (n, 3) from its middle to the places."""
        return np.array([place.at for place in self.seers]).reshape(-1, 3) - self.middle

    def raise_to_view_height(self, direction: Vector) -> Vector:
        """Return the direction, as high as most views: it shows from there what they show from
        theirs.

        What looks down or up stays as it is.
        """
        if self.up is None or abs(direction @ self.up) >= 0.5:
            return direction
        steps = self.steps()
        rise = float(np.median(steps @ self.up / np.linalg.norm(steps, axis=1)))
        level: Vector = math.sqrt(1 - rise**2) * direction + rise * self.up
        return level

    def way(self, direction: Vector) -> Way:
        """Return the way to a place in that direction, as far away as most views are, from the
        nearest."""
        away = float(np.median(np.linalg.norm(self.steps(), axis=1)))
        place = self.middle + away * direction
        # Among equally near ones take the first: the last digits must not decide.
        nearest = min(self.seers, key=lambda seer: round(math.dist(seer.at, place) / away, DIGITS))
        named = nearest.name
        if nearest.picture != nearest.name:
            named = f"{nearest.name} ({nearest.picture})"
        x, y, z = place.tolist()
        if self.up is None:
            side = f"the side towards {describe_axis(direction)}"
            return Way((x, y, z), side, f"from there, from as far away as {named} is")
        step = place - np.array(nearest.at)
        forward = self.middle - np.array(nearest.at)
        forward -= (forward @ self.up) * self.up
        size = np.linalg.norm(forward)
        ahead = size > UPRIGHT * away
        forward = forward / size if ahead else np.cross(self.up, np.roll(self.up, 1))
        left = np.cross(self.up, forward)
        side = _describe_side(direction, forward, left, self.up)
        side += "" if side == "above" else f", as {nearest.name} sees it"
        moves = [
            f"{self._length(step @ axis, away)} {ways[int(step @ axis < 0)]}"
            for axis, ways in zip((left, forward, self.up), WAYS, strict=True)
            if abs(step @ axis) > WORTH_SAYING * away
        ]
        go = f"from a place {listed(moves)} as seen from {named}" if moves else f"as {named} does"
        return Way((x, y, z), side, go)

    def _length(self, value: float, away: float) -> str:
        """Return a way to go, with one digit; where the scale is not known as a share of the
        distance."""
        if self.length_unit is None:
            return f"{abs(value) / away:.1f} of the distance"
        size = abs(value)
        return format_with_unit(f"{size:.1f}" if size >= 0.1 else f"{size:.2f}", self.length_unit)


def describe_axis(direction: Vector) -> str:
    """Return the axis, or the two, that a direction lies nearest to.

    >>> describe_axis(np.array([1.0, 0.0, 0.1])), describe_axis(np.array([0.6, -0.8, 0.0]))
    ('+x', '+x and -y')
    """
    return " and ".join(name for name, axis in AXES.items() if direction @ axis > 0.45)


def _describe_side(direction: Vector, forward: Vector, left: Vector, up: Vector) -> str:
    """Return the direction as a viewer calls it who looks along `forward`."""
    if direction @ up > 0.9:
        return "above"
    turn = math.degrees(math.atan2(abs(direction @ left), direction @ forward))
    side = "left" if direction @ left > 0 else "right"
    if turn < 30:
        return "behind"
    return f"behind and the {side}" if turn < 70 else f"the {side}"
