"""The places of an explored area: each was looked at by views of its own.

A place is begun where sonars hear something that is none of the things known by then: what stands
at two places are two things, however far odometry drifted between them, unless they overlap.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import shapely

from facetlog.mapping.placed_thing import PlacedThing

__all__ = ["LOOKS_AT", "OVERHANG", "Place", "is_area", "places_of", "thing_at"]

LOOKS_AT = "looks_at"
"""Of a line of collect.jsonl about a choice in an area: the number of the place that its view looks
at, 0 for a view on the way."""
OVERHANG = 0.6
"""How far what stands on legs may reach from one of them, m, as long as nobody has looked at it:
half of a table for six. Two legs between which the robot's middle would pass are farther apart."""


@dataclass(frozen=True, slots=True)
class Place:
    """What was heard at x and y, which reaches so far (m), and the names of the views of it."""

    number: int
    x: float
    y: float
    reach: float
    names: tuple[str, ...] = ()

    def to_json(self) -> Mapping[str, object]:
        """As part of a line of collect.jsonl."""
        return {LOOKS_AT: self.number, "target": [self.x, self.y, self.reach]}


def places_of(lines: Iterable[Mapping[str, object]]) -> tuple[Place, ...]:
    """The places of which the lines of collect.jsonl tell, in the order of their numbers; of views
    that were chosen and not taken the names are there too.
    """
    found: dict[int, Place] = {}
    for line in lines:
        match line:
            case {
                "looks_at": int() as number,
                "image": str() as name,
                "target": [float() | int() as x, float() | int() as y, float() | int() as reach],
            }:
                place = found.get(number, Place(number, float(x), float(y), float(reach)))
                names = tuple(dict.fromkeys((*place.names, name)))
                found[number] = replace(place, names=names)
    return tuple(found[number] for number in sorted(found))


def is_area(lines: Iterable[Mapping[str, object]]) -> bool:
    """Whether lines of collect.jsonl are of an area that was explored."""
    return any(LOOKS_AT in line for line in lines)


def thing_at(place: Place, things: Sequence[PlacedThing]) -> PlacedThing | None:
    """The thing of a scene that is at a place: the one in which it lies, or the nearest of which it
    may be a leg. It is marked as that place's.
    """
    at = shapely.Point(place.x, place.y)
    near = [
        (round(float(shapely.distance(thing.plan, at)), 6), -round(thing.seen, 6), k)
        for k, thing in enumerate(things)
    ]
    best = min(near, default=None)
    if best is None or best[0] > place.reach + OVERHANG:
        return None
    return replace(things[best[2]], place=place.number)
