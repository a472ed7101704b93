"""From where a thing was seen, as the scene knows it."""

from dataclasses import dataclass

from facetlog.plurals import many

__all__ = ["ImpliedFace", "Look", "OtherThing", "Place", "Point", "Sight"]

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
    """View of a face, as shares: seen, outside the picture, hidden by."""

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
class OtherThing:
    """Another thing near one, and of which shapes its pieces are, with their numbers."""

    name: str
    shapes: tuple[tuple[str, int], ...]

    def __str__(self) -> str:
        pieces = ", ".join(many(count, shape) for shape, count in self.shapes)
        return f"{self.name} ({pieces})" if pieces else self.name


@dataclass(frozen=True, slots=True)
class Sight:
    """A thing's vertices, from where it was seen, and what its faces face.

    `whole` says that its surface is known from all sides; `up` is a unit vector, None where it is
    not known; `normals` are those of measured faces, outwards; `opening` are the directions from
    which unseen space round it would show, and how much of it, 0..1; `assumed` is the share of what
    it fills that was not seen, and is taken to be full. `filled` is the share of its volume that
    its pieces fill, and `gaps` are the lowest and highest corners of boxes round what none fills.
    """

    whole: bool
    up: Point | None
    points: tuple[Point, ...]
    places: tuple[Place, ...]
    normals: tuple[Point, ...]
    implied: tuple[ImpliedFace, ...]
    opening: tuple[tuple[Point, float], ...] = ()
    assumed: float = 0.0
    filled: float = 1.0
    gaps: tuple[tuple[Point, Point], ...] = ()
