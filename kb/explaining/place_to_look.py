"""A place to look from: where it lies, and how one who stands where a view was taken gets there."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facetlog.kb.explaining.amounts import with_unit
from facetlog.kb.explaining.sight import Place, Point
from facetlog.kb.explaining.wording import listed

__all__ = ["AXES", "DIGITS", "UPRIGHT", "Looked", "Vector", "Way", "axis_words"]

UPRIGHT = 1e-3
"""Lengths of unit vectors in plan below this are those of upright ones."""
# A way to go is said from this share of the distance to the thing on.
WORTH_SAYING = 0.15
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
        """The ways (n, 3) from its middle to the places."""
        return np.array([place.at for place in self.seers]).reshape(-1, 3) - self.middle

    def level_with_views(self, direction: Vector) -> Vector:
        """The direction, as high as most views: it shows from there what they show from theirs.

        What looks down or up stays as it is.
        """
        if self.up is None or abs(direction @ self.up) >= 0.5:
            return direction
        steps = self.steps()
        rise = float(np.median(steps @ self.up / np.linalg.norm(steps, axis=1)))
        level: Vector = math.sqrt(1 - rise**2) * direction + rise * self.up
        return level

    def way(self, direction: Vector) -> Way:
        """The way to a place in that direction, as far away as most views are, from the nearest."""
        away = float(np.median(np.linalg.norm(self.steps(), axis=1)))
        place = self.middle + away * direction
        # Of several as near the first, whatever their last digits.
        nearest = min(self.seers, key=lambda seer: round(math.dist(seer.at, place) / away, DIGITS))
        named = nearest.name
        if nearest.picture != nearest.name:
            named = f"{nearest.name} ({nearest.picture})"
        x, y, z = place.tolist()
        if self.up is None:
            side = f"the side towards {axis_words(direction)}"
            return Way((x, y, z), side, f"from there, from as far away as {named} is")
        step = place - np.array(nearest.at)
        forward = self.middle - np.array(nearest.at)
        forward -= (forward @ self.up) * self.up
        size = np.linalg.norm(forward)
        ahead = size > UPRIGHT * away
        forward = forward / size if ahead else np.cross(self.up, np.roll(self.up, 1))
        left = np.cross(self.up, forward)
        side = _side_words(direction, forward, left, self.up)
        side += "" if side == "above" else f", as {nearest.name} sees it"
        moves = [
            f"{self._length(step @ axis, away)} {ways[int(step @ axis < 0)]}"
            for axis, ways in zip((left, forward, self.up), WAYS, strict=True)
            if abs(step @ axis) > WORTH_SAYING * away
        ]
        go = f"from a place {listed(moves)} as seen from {named}" if moves else f"as {named} does"
        return Way((x, y, z), side, go)

    def _length(self, value: float, away: float) -> str:
        """A way to go, with one digit; where the scale is not known as a share of the distance."""
        if self.length_unit is None:
            return f"{abs(value) / away:.1f} of the distance"
        size = abs(value)
        return with_unit(f"{size:.1f}" if size >= 0.1 else f"{size:.2f}", self.length_unit)


def axis_words(direction: Vector) -> str:
    """The axis, or the two, that a direction lies nearest to.

    >>> axis_words(np.array([1.0, 0.0, 0.1])), axis_words(np.array([0.6, -0.8, 0.0]))
    ('+x', '+x and -y')
    """
    return " and ".join(name for name, axis in AXES.items() if direction @ axis > 0.45)


def _side_words(direction: Vector, forward: Vector, left: Vector, up: Vector) -> str:
    """The direction as a viewer calls it who looks along `forward`."""
    if direction @ up > 0.9:
        return "above"
    turn = math.degrees(math.atan2(abs(direction @ left), direction @ forward))
    side = "left" if direction @ left > 0 else "right"
    if turn < 30:
        return "behind"
    return f"behind and the {side}" if turn < 70 else f"the {side}"
