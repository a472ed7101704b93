"""From where a thing was seen, as the scene knows it."""

from dataclasses import dataclass

from facetlog.errors import EngineError
from facetlog.kb.engine.terms import Atom, Struct, Term
from facetlog.kb.explaining.wording import readable

__all__ = ["ImpliedFace", "Look", "Place", "Point", "Sight", "decode_sight"]

Point = tuple[float, float, float]
"""A place in the world, or a direction."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where a camera or a scanner stood; `count` of the thing's vertices are seen from there.

    `count` is None of a scanner, of which nobody noted it. `picture` is the name of the view's.
    """

    name: str
    picture: str
    at: Point
    count: int | None


@dataclass(frozen=True, slots=True)
class Look:
    """What a view before a face shows of it, as shares: seen, outside the picture, hidden by."""

    view: str
    seen: float
    outside: float
    hidden: tuple[tuple[str, float], ...]


@dataclass(frozen=True, slots=True)
class ImpliedFace:
    """A face that was completed from its neighbours, and what views that are before it show."""

    name: str
    normal: Point
    looks: tuple[Look, ...]


@dataclass(frozen=True, slots=True)
class Sight:
    """A thing's vertices, from where it was seen, and what its faces face.

    `whole` says that its surface is known from all sides; `up` is a unit vector, None where it is
    not known; `normals` are those of measured faces, outwards; `opening` are the directions from
    which unseen space round it would show, and how much of it, 0..1; `assumed` is the share of what
    it fills that was not seen, and is taken to be full.
    """

    whole: bool
    up: Point | None
    points: tuple[Point, ...]
    places: tuple[Place, ...]
    normals: tuple[Point, ...]
    implied: tuple[ImpliedFace, ...]
    opening: tuple[tuple[Point, float], ...] = ()
    assumed: float = 0.0


def decode_sight(term: Term) -> Sight:
    """The sight that sight/2 of sight.pl says. Raises EngineError if it cannot be read."""
    match term:
        case Struct(
            "sight",
            (
                Atom(whole),
                tuple(ups),
                tuple(points),
                tuple(places),
                tuple(normals),
                tuple(implied),
                tuple(opening),
                int() | float() as assumed,
            ),
        ):
            return Sight(
                whole == "true",
                _point(ups[0]) if ups else None,
                tuple(map(_point, points)),
                tuple(map(_place, places)),
                tuple(map(_point, normals)),
                tuple(map(_implied, implied)),
                tuple(map(_opening, opening)),
                float(assumed),
            )
    raise _unreadable(term)


def _point(term: Term) -> Point:
    match term:
        case Struct("at", (int() | float() as x, int() | float() as y, int() | float() as z)):
            return float(x), float(y), float(z)
    raise _unreadable(term)


def _place(term: Term) -> Place:
    match term:
        case Struct("from", (Atom(name), picture, x, y, z, count)):
            seen = count if isinstance(count, int) else None
            return Place(name, readable(picture), _point(Struct("at", (x, y, z))), seen)
    raise _unreadable(term)


def _implied(term: Term) -> ImpliedFace:
    match term:
        case Struct("implied", (Atom(name), normal, tuple(looks))):
            return ImpliedFace(name, _point(normal), tuple(map(_look, looks)))
    raise _unreadable(term)


def _look(term: Term) -> Look:
    match term:
        case Struct(
            "shows",
            (Atom(view), int() | float() as seen, int() | float() as outside, tuple(hidden)),
        ):
            return Look(view, float(seen), float(outside), tuple(map(_hidden, hidden)))
    raise _unreadable(term)


def _hidden(term: Term) -> tuple[str, float]:
    match term:
        case Struct("-", (Atom(by), int() | float() as share)):
            return by, float(share)
    raise _unreadable(term)


def _opening(term: Term) -> tuple[Point, float]:
    match term:
        case Struct("-", (int() | float() as share, towards)):
            return _point(towards), float(share)
    raise _unreadable(term)


def _unreadable(term: Term) -> EngineError:
    return EngineError(f"Prolog's sight cannot be read: {readable(term)[:80]}")
