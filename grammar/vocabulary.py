"""The words that models are written in: what they take, what they give, what they mean.

One row a word. rules/vocabulary.pl computes them (a test compares both); `facetlog model
words`, the checker, completion and hover are made from these rows.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType
from typing import Any

from facetlog.grammar.source import Source, Span


class Kind(StrEnum):
    """The kinds of elements that a name can stand for."""

    FACE = "face"
    EDGE = "edge"
    VERTEX = "vertex"
    THING = "thing"
    PIECE = "piece"
    OPENING = "opening"
    HOLLOW = "hollow"

    def __repr__(self) -> str:
        return self.value


Kinds = frozenset[Kind]
FACE, EDGE, VERTEX, THING, PIECE, OPENING, HOLLOW = (frozenset({kind}) for kind in Kind)
ELEMENT = FACE | EDGE
ANY = ELEMENT | THING
SOLID = THING | PIECE
EACH_HOLE = OPENING, HOLLOW
HOLES = OPENING | HOLLOW
SPANNING = SOLID | HOLES
LEVEL = FACE | PIECE
"""What has a level: a face, and a board by its upper side."""
IN_SPACE = PIECE | HOLES
"""What takes room of its own in a thing's space."""


class Gives(StrEnum):
    """The type of a word with its arguments."""

    CONDITION = "condition"
    ANGLE = "angle"
    LENGTH = "length"
    AREA = "area"
    RATIO = "ratio"
    COUNT = "count"


@dataclass(frozen=True, slots=True)
class Word:
    """A word of the vocabulary.

    `arguments` says for each argument which kinds it may be; the last repeats if `many`. A
    condition of one argument is also a property (`top is level`), one of two a relation (`x adjoins
    y`).
    `low` and `high` bound a measure in degrees, shares or counts; lengths are bounded below alone.
    `unknown_when` says when the scene does not know. Of a word whose arguments are `alike` they are
    of one kind. A word that `yields` may also be the name of
    a part, a definition or a model: that then hides it, as texts use it that are older.
    """

    name: str
    arguments: tuple[Kinds, ...]
    gives: Gives
    meaning: str
    unknown_when: str = ""
    symmetric: bool = False
    many: bool = False
    low: float | None = None
    high: float | None = None
    number_last: Gives | None = None
    alike: bool = False
    yields: bool = False
    source: Source | None = None
    span: Span | None = None

    @property
    def is_condition(self) -> bool:
        """Whether it is true or false, and no measure."""
        return self.gives is Gives.CONDITION

    @property
    def signature(self) -> str:
        """The word with the kinds of its arguments: `angle(face, face): angle`."""
        kinds = ["/".join(sorted(kinds)) for kinds in self.arguments]
        if self.number_last:
            kinds.append(self.number_last.value)
        if self.many:
            kinds.append("...")
        return f"{self.name}({', '.join(kinds)}): {self.gives}"


_UP = "up is not known"
_UNSEEN = "it depends on unseen space"
_SPACE = f"{_UP}, or {_UNSEEN}"
_HIDDEN = "it is a piece and depends on unseen space"
_HIGH = f"{_UP}, or {_HIDDEN}"
_LEVEL = f"{_SPACE}, or it leans more than 30 degrees from level or lies inside its object"
_BACK = f"{_LEVEL}, or no side is closed more than the opposite one"
_RISE = f"{_LEVEL}, or nothing rises above it"


def _condition(name: str, *arguments: Kinds, unknown: str = "", **more: Any) -> Word:
    return Word(name, arguments, Gives.CONDITION, unknown_when=unknown, **more)


def _measure(
    name: str,
    gives: Gives,
    *arguments: Kinds,
    unknown: str = "",
    low: float | None = 0.0,
    **more: Any,
) -> Word:
    return Word(name, arguments, gives, unknown_when=unknown, low=low, **more)


_WORDS = (
    # Two faces
    _measure("angle", Gives.ANGLE, LEVEL, LEVEL, symmetric=True, alike=True, high=180.0,
             meaning="of faces: the angle between their outward normals; of pieces: between the "
                     "length of a bar and the broad side of any other, 0 parallel, 90 "
                     "perpendicular"),
    _measure("dihedral", Gives.ANGLE, FACE, FACE, symmetric=True, high=360.0,
             meaning="the angle through the solid at the edge that they share: 90 at the edge of "
                     "a box, 270 in the corner of a room",
             unknown="they share no edge, or which side is solid is not known"),
    _measure("offset", Gives.LENGTH, FACE, FACE, low=None,
             meaning="the signed distance of the middle of the first from the plane of the "
                     "second, positive in front"),
    _measure("overlap", Gives.RATIO, LEVEL, LEVEL, symmetric=True, alike=True, high=1.0,
             meaning="seen from above, the share of the smaller one that lies over or under the "
                     "other",
             unknown=f"{_UP}, a face is upright, or {_HIDDEN}"),
    _measure("shared_length", Gives.LENGTH, FACE, FACE, symmetric=True,
             meaning="the length of the edge that they share", unknown="they share no edge"),
    _condition("adjoins", FACE, FACE, symmetric=True, meaning="they share an edge"),
    _condition("coplanar", FACE, FACE, symmetric=True, meaning="they lie in one plane"),
    _condition("opposite", FACE, FACE, symmetric=True,
               meaning="their normals are opposed, and their outlines overlap along them"),
    _condition("convex", FACE, FACE, symmetric=True,
               meaning="the solid is convex at the edge that they share",
               unknown="which side is solid is not known"),
    _condition("concave", FACE, FACE, symmetric=True,
               meaning="the solid is concave at the edge that they share",
               unknown="which side is solid is not known"),
    _condition("congruent", FACE, FACE, symmetric=True,
               meaning="their lengths, widths and areas are equal within 5 %"),
    _condition("closes", FACE, FACE,
               meaning="the first adjoins the second, is upright, and closes the space below it",
               unknown=_UP),
    _condition("underside_of", FACE, FACE,
               meaning="the first is the lower side of a board, the second its upper side",
               unknown=_UP),
    _condition("above", LEVEL | HOLES, LEVEL | HOLES, unknown=_UP,
               meaning="its middle is higher than that of the face, or the top of the piece"),
    _condition("below", LEVEL | HOLES, LEVEL | HOLES, unknown=_UP,
               meaning="its middle is lower than that of the face, or the bottom of the piece"),
    Word("parallel", (LEVEL, LEVEL), Gives.CONDITION,
         "normals of faces, or directions of pieces, are parallel within the given angle",
         symmetric=True, number_last=Gives.ANGLE, alike=True),
    Word("share_corner", (FACE,), Gives.CONDITION, "all meet at one vertex", symmetric=True,
         many=True),
    # One face
    _measure("tilt", Gives.ANGLE, ELEMENT | PIECE, high=90.0, unknown=_UP,
             meaning="0 level, 90 upright, whichever way it faces; of the length of a bar, of the "
                     "broad side of any other piece"),
    _measure("area", Gives.AREA, FACE, meaning="its area without holes"),
    _measure("length", Gives.LENGTH, FACE | SPANNING, unknown=_HIDDEN,
             meaning="the longer side of the least rectangle around a face, opening or "
                     "hollow's section; the longest side of the least box around an object or "
                     "piece"),
    _measure("width", Gives.LENGTH, FACE | SPANNING, unknown=_HIDDEN,
             meaning="the shorter side of that rectangle; the second longest side of that box"),
    _measure("depth", Gives.LENGTH, THING | HOLLOW,
             meaning="the shortest side of that box; how far a hollow reaches in from its mouth"),
    _measure("mouth", Gives.RATIO, HOLLOW, high=1.0, yields=True,
             meaning="the share of the section of a hollow that is open: 100 % for a bucket"),
    _measure("height", Gives.LENGTH, ANY | PIECE | HOLES, unknown=_HIGH,
             meaning="the height of its top above its bottom"),
    _measure("elevation", Gives.LENGTH, LEVEL | HOLES, unknown=_HIGH,
             meaning="the height of its middle above the lowest point of its object"),
    _measure("top_of", Gives.LENGTH, ANY | PIECE | HOLES, unknown=_HIGH,
             meaning="the height of its highest point above the lowest point of its object"),
    _measure("bottom_of", Gives.LENGTH, ANY | PIECE | HOLES, unknown=_HIGH,
             meaning="the height of its lowest point above the lowest point of its object"),
    _measure("protrusion", Gives.LENGTH, FACE,
             meaning="how far its object extends in front of its plane"),
    _measure("reach_behind", Gives.LENGTH, FACE,
             meaning="how far its object extends behind its plane: to the opposite side, if that "
                     "was found"),
    _measure("clear_below", Gives.LENGTH, FACE, unknown=f"{_UP}, or it is upright",
             meaning="the free height under most of it, without its supports, down to the next "
                     "face or the ground"),
    _measure("share", Gives.RATIO, FACE, high=1.0,
             meaning="its area divided by the silhouette of its object, seen along its normal"),
    _measure("fill", Gives.RATIO, FACE, high=1.0,
             meaning="its area divided by that of the least rectangle around it"),
    _measure("coverage", Gives.RATIO, FACE, high=1.0,
             meaning="the share of it that was seen in at least one picture"),
    _measure("corners", Gives.COUNT, FACE, low=3.0, meaning="the number of corners of its outline"),
    # What lies beneath, on and above the level of a face, or of the upper side of a level board
    _measure("cover", Gives.RATIO, LEVEL, high=1.0, unknown=_LEVEL,
             meaning="the share of the footprint that its level covers: all that faces up at that "
                     "height"),
    _measure("level_length", Gives.LENGTH, LEVEL, unknown=_LEVEL,
             meaning="the longer side of its level, along the sides of the plan of the object"),
    _measure("level_width", Gives.LENGTH, LEVEL, unknown=_LEVEL,
             meaning="the shorter side of its level"),
    _measure("built_over", Gives.RATIO, LEVEL, high=1.0, unknown=_LEVEL,
             meaning="the share of its level that has something above it"),
    _measure("room_below", Gives.LENGTH, LEVEL, unknown=_LEVEL,
             meaning="the mean free height directly below its level"),
    _measure("room_width", Gives.LENGTH, LEVEL, unknown=_LEVEL,
             meaning="the width of the widest free space below its level, such as for knees: most "
                     "of it free from the rim to half the depth, and from the ground to half the "
                     "height"),
    _measure("room_above", Gives.LENGTH, LEVEL, unknown=_LEVEL,
             meaning="the mean free height directly above its level"),
    _measure("free_below", Gives.RATIO, LEVEL, high=1.0, unknown=_LEVEL,
             meaning="the share of the space below its level, with its board, that is free"),
    _measure("see_through", Gives.RATIO, LEVEL, high=1.0, unknown=_LEVEL,
             meaning="the share of the space below its level that one can see through, from the "
                     "front or from the side, whichever is more"),
    _measure("see_across", Gives.RATIO, LEVEL, high=1.0, unknown=_LEVEL,
             meaning="as `see_through`, but from the side where it is less"),
    _measure("open_from_two_sides", Gives.RATIO, LEVEL, high=1.0, unknown=_LEVEL,
             meaning="the share of horizontal lines of sight below its level that reach the "
                     "middle of its object, from the second most open of its four sides"),
    _measure("enclosed", Gives.RATIO, LEVEL, high=1.0, unknown=_LEVEL,
             meaning="the share of the rim of its level above which something rises high: all of "
                     "it in a crate", yields=True),
    _measure("closed_behind", Gives.RATIO, LEVEL, high=1.0, unknown=_LEVEL,
             meaning="the share of one side of its level above which something rises high, such "
                     "as a back: of the side that exceeds its opposite side most"),
    _measure("closed_in_front", Gives.RATIO, LEVEL, high=1.0, unknown=_LEVEL,
             meaning="as `closed_behind`, but of the opposite side"),
    _measure("side_behind", Gives.LENGTH, LEVEL, yields=True,
             unknown=_BACK,
             meaning="the length of the side that `closed_behind` measures: the long side of a "
                     "sofa, the short side of a bed"),
    _measure("front_width", Gives.LENGTH, FACE, yields=True, unknown=_BACK,
             meaning="the width of a seat: the side of the least rectangle around it that is "
                     "opposite to the side that `closed_behind` measures"),
    _measure("front_depth", Gives.LENGTH, FACE, yields=True, unknown=_BACK,
             meaning="the depth of a seat: the other side of that rectangle"),
    _measure("shelves_below", Gives.COUNT, LEVEL, unknown=_LEVEL, yields=True,
             meaning="the number of shelves below its level: heights at which at least half of "
                     "its area faces up"),
    _measure("rise_side", Gives.RATIO, LEVEL, unknown=_RISE,
             meaning="how far to one side of its level something rises high above it: 0 in the "
                     "middle, 1 at the rim"),
    _measure("rise_off_middle", Gives.RATIO, LEVEL, unknown=_RISE,
             meaning="how far that is from the middle of this side: 0 in the middle, 1 at an end"),
    _measure("rise_span", Gives.RATIO, LEVEL, high=1.0, unknown=_RISE,
             meaning="the share of the length of this side that it takes"),
    _condition("measured", LEVEL,
               meaning="it was seen, not only completed from its neighbours"),
    _condition("upward", FACE, meaning="its outward normal points up", unknown=_UP),
    _condition("downward", FACE, meaning="its outward normal points down", unknown=_UP),
    _condition("level", ELEMENT | PIECE, unknown=_UP,
               meaning="within 10 degrees of level; of a block any of its sides is, so that it is "
                       "not tilted"),
    _condition("upright", ELEMENT | PIECE, unknown=_UP,
               meaning="within 10 degrees of upright: the length of a bar, else the broad side"),
    # Edges, vertices, things
    _measure("edge_length", Gives.LENGTH, EDGE, meaning="its length"),
    _measure("faces_at", Gives.COUNT, VERTEX, meaning="the number of faces that meet there"),
    _measure("gap", Gives.LENGTH, THING, THING, symmetric=True,
             meaning="the least distance between what was found of two objects"),
    _condition("bounds", EDGE, FACE, meaning="the edge is a side of the face"),
    _condition("supports", ELEMENT, FACE, unknown=_UP,
               meaning="the first is upright, starts near the ground (within 15 % of the height "
                       "of the second) and reaches at least half way up to it, and past it only "
                       "at its rim"),
    _condition("on_ground", ANY | PIECE, unknown=_UP,
               meaning="its lowest point is that of its object, within 3 % of the height of the "
                       "object"),
    _condition("at_rim", ELEMENT, FACE, unknown=_UP,
               meaning="seen from above, the first, which is upright, is at the rim of the "
                       "second, within 15 % of its width"),
    _measure("footprint", Gives.AREA, THING, unknown=_SPACE,
             meaning="its area seen from above"),
    _measure("solidity", Gives.RATIO, THING, high=1.0,
             unknown=_UNSEEN,
             meaning="the share of the least box around it that it fills; the box is upright or "
                     "aligned with its largest face, enclosed space counts as filled"),
    _measure("hollow_side", Gives.RATIO, THING, high=1.0,
             unknown=_UNSEEN,
             meaning="the share of a side of that box that is far from the surface, for the most "
                     "hollow side; the side on the ground does not count"),
    _measure("curved", Gives.RATIO, SOLID, high=1.0,
             meaning="the share of an object's surface that is not flat; of a piece the share of "
                     "the outline of its section that is curved, 1 for a wheel"),
    # Pieces
    _measure("thickness", Gives.LENGTH, PIECE, yields=True,
             meaning="the shortest side of the least box around it"),
    _measure("inset", Gives.LENGTH, PIECE, PIECE, low=None, yields=True,
             unknown=f"{_UP}, or {_UNSEEN}",
             meaning="seen from above, how far the first lies within the least box around the "
                     "second, on the side where that is least: the set-back of a plinth; below 0 "
                     "if it projects"),
    _measure("distance", Gives.LENGTH, PIECE, PIECE, symmetric=True, yields=True,
             unknown=f"{_UP}, or {_UNSEEN}",
             meaning="seen from above, how far apart their middles are"),
    _measure("corner_inset", Gives.LENGTH, PIECE, PIECE, low=None, yields=True,
             unknown=f"{_UP}, or {_UNSEEN}",
             meaning="seen from above, how far the first lies within the least box around the "
                     "second, on the farther one of the two sides of the nearest corner: small for "
                     "a leg at a corner"),
    _condition("board", PIECE, meaning="its thickness is at most 35 % of its width",
               yields=True),
    _condition("bar", PIECE, yields=True,
               meaning="it is no board, and its width is at most 35 % of its length"),
    _condition("block", PIECE, meaning="it is neither a board nor a bar", yields=True),
    _condition("joins", PIECE, PIECE, meaning="they touch, to within a cell of the grid",
               symmetric=True, yields=True),
    _condition("carries", PIECE, PIECE, unknown=_UP, yields=True,
               meaning="the first touches the second from below, or carries a piece that does"),
    _condition("hangs_from", PIECE, PIECE, unknown=_UP, yields=True,
               meaning="they touch, the middle of the second is higher, and without the second "
                       "nothing joins the first to the ground"),
    # Pieces and openings
    _condition("beside", IN_SPACE, IN_SPACE, symmetric=True, yields=True,
               unknown=_SPACE,
               meaning="at least half the height of the lower one is shared by the other, and at "
                       "most 10 % of the smaller one lies over or under the other; what is sunk "
                       "into it does not count, if that is at most two thirds"),
    _condition("inside", IN_SPACE, IN_SPACE, yields=True,
               unknown=_UNSEEN,
               meaning="the least box around it lies in that around the other, or in the free "
                       "space of an opening, except for at most 5 % at each side"),
    _condition("in", OPENING, LEVEL, yields=True,
               meaning="the face surrounds the opening and leaves it free, or the piece is its "
                       "whole rim"),
    _condition("open_at_top", HOLLOW, yields=True,
               meaning="the hollow opens upwards; something may hang over it"),
    _condition("open_at_side", HOLLOW, yields=True,
               meaning="the hollow opens to one side, such as to the front"),
    _condition("frames", PIECE, OPENING, yields=True,
               meaning="it forms at least 5 % of the rim of the opening"),
    _condition("touches", THING, THING, symmetric=True, meaning="there is nothing between them"),
)  # fmt: skip

VOCABULARY: Mapping[str, Word] = MappingProxyType({word.name: word for word in _WORDS})
"""The words by name."""
