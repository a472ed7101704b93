"""The words that models are written in: what they take, what they give, what they mean.

One row a word. rules/vocabulary.pl computes them (a test compares both); the reference of
docs/models.md, the checker, completion and hover are made from these rows.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType
from typing import Any

from facetlog.grammar.source import Source, Span


class Kind(StrEnum):
    """What a name can stand for."""

    FACE = "face"
    EDGE = "edge"
    VERTEX = "vertex"
    THING = "thing"
    PIECE = "piece"
    OPENING = "opening"

    def __repr__(self) -> str:
        return self.value


Kinds = frozenset[Kind]
FACE, EDGE, VERTEX, THING, PIECE, OPENING = (frozenset({kind}) for kind in Kind)
ELEMENT = FACE | EDGE
ANY = ELEMENT | THING
SOLID = THING | PIECE
SPANNING = SOLID | OPENING
LEVEL = FACE | PIECE
"""What has a level: a face, and a board by its upper side."""
IN_SPACE = PIECE | OPENING
"""What takes room of its own in a thing's space."""


class Gives(StrEnum):
    """What a word is once it has its arguments."""

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
_CUT = "the outline was not wholly seen"
_SPACE = f"{_UP}, or it hangs on space that nobody saw"
_HIDDEN = "of a piece it hangs on space that nobody saw"
_HIGH = f"{_UP}, or {_HIDDEN}"
_LEVEL = f"{_SPACE}, or it leans more than 30 degrees from level or lies within its thing"
_BACK = f"{_LEVEL}, or no side is closed more than the one opposite"
_RISE = f"{_LEVEL}, or nothing rises above it"
_SCALE = "it is compared with metres and the scale is not known"


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
             meaning="of faces the angle between their outward normals; of pieces that between "
                     "bars' lengths and others' broad sides, 0 along each other, 90 square"),
    _measure("dihedral", Gives.ANGLE, FACE, FACE, symmetric=True, high=360.0,
             meaning="the angle through the solid at the edge that they share: 90 at a box's edge, "
                     "270 in a room's corner",
             unknown="they share no edge, or which side is solid is not known"),
    _measure("offset", Gives.LENGTH, FACE, FACE, low=None,
             meaning="how far the middle of the first lies in front of the second's plane; "
                     "negative behind it"),
    _measure("overlap", Gives.RATIO, LEVEL, LEVEL, symmetric=True, alike=True, high=1.0,
             meaning="the share of the smaller one's plan that lies over or under the other's",
             unknown=f"{_UP}, a face stands upright, or a piece hangs on space that nobody saw"),
    _measure("shared_length", Gives.LENGTH, FACE, FACE, symmetric=True,
             meaning="the length of the edge that they share", unknown="they share no edge"),
    _condition("adjoins", FACE, FACE, symmetric=True, meaning="they share an edge"),
    _condition("coplanar", FACE, FACE, symmetric=True, meaning="they lie in one plane"),
    _condition("opposite", FACE, FACE, symmetric=True,
               meaning="their normals are opposed, and their outlines overlap along them"),
    _condition("convex", FACE, FACE, symmetric=True,
               meaning="the solid bulges outwards at the edge that they share",
               unknown="which side is solid is not known"),
    _condition("concave", FACE, FACE, symmetric=True,
               meaning="the solid is hollow at the edge that they share",
               unknown="which side is solid is not known"),
    _condition("congruent", FACE, FACE, symmetric=True,
               meaning="their lengths, widths and areas are equal within 5 %"),
    _condition("closes", FACE, FACE,
               meaning="the first adjoins the second, is upright, and shuts the space below it",
               unknown=_UP),
    _condition("underside_of", FACE, FACE,
               meaning="the first is the lower side of the board whose upper side the second is",
               unknown=_UP),
    _condition("above", LEVEL | OPENING, LEVEL | OPENING, unknown=_UP,
               meaning="its middle is higher than the other's"),
    _condition("below", LEVEL | OPENING, LEVEL | OPENING, unknown=_UP,
               meaning="its middle is lower than the other's"),
    Word("parallel", (LEVEL, LEVEL), Gives.CONDITION,
         "normals of faces are along one line, pieces along each other, within the given angle",
         symmetric=True, number_last=Gives.ANGLE, alike=True),
    Word("share_corner", (FACE,), Gives.CONDITION, "all of them meet at one vertex", symmetric=True,
         many=True),
    # One face
    _measure("tilt", Gives.ANGLE, ELEMENT | PIECE, high=90.0, unknown=_UP,
             meaning="0 level, 90 upright, whichever way it faces; of a bar's length, of "
                     "another piece's broad side"),
    _measure("area", Gives.AREA, FACE, meaning="the area, without holes"),
    _measure("length", Gives.LENGTH, FACE | SPANNING, unknown=_HIDDEN,
             meaning="the longer side of the least rectangle round a face or of that round an "
                     "opening; the longest side of the least box round a thing or piece"),
    _measure("width", Gives.LENGTH, FACE | SPANNING, unknown=_HIDDEN,
             meaning="the shorter side of that rectangle; the middle side of that box"),
    _measure("depth", Gives.LENGTH, THING, meaning="the shortest side of that box"),
    _measure("height", Gives.LENGTH, ANY | PIECE | OPENING, unknown=_HIGH,
             meaning="how much higher its top is than its bottom"),
    _measure("elevation", Gives.LENGTH, LEVEL | OPENING, unknown=_HIGH,
             meaning="how high its middle is above the lowest point of its thing"),
    _measure("top_of", Gives.LENGTH, ANY | PIECE | OPENING, unknown=_HIGH,
             meaning="how high its highest point is above the lowest of its thing"),
    _measure("bottom_of", Gives.LENGTH, ANY | PIECE | OPENING, unknown=_HIGH,
             meaning="how high its lowest point is above the lowest of its thing"),
    _measure("protrusion", Gives.LENGTH, FACE,
             meaning="how far its thing reaches in front of its plane"),
    _measure("reach_behind", Gives.LENGTH, FACE,
             meaning="how far its thing reaches behind its plane: to the side opposite, if that "
                     "was found"),
    _measure("clear_below", Gives.LENGTH, FACE, unknown=f"{_UP}, or it stands upright",
             meaning="the free height under most of it but for what carries it, down to the next "
             "face or the ground"),
    _measure("share", Gives.RATIO, FACE, high=1.0,
             meaning="its area over the silhouette of its thing, seen along its normal"),
    _measure("fill", Gives.RATIO, FACE, high=1.0,
             meaning="its area over that of the least rectangle round it"),
    _measure("coverage", Gives.RATIO, FACE, high=1.0,
             meaning="the share of it that was seen in at least one picture"),
    _measure("corners", Gives.COUNT, FACE, low=3.0, meaning="how many corners its outline has"),
    # What lies beneath, on and above the level of a face, or of the upper side of a level board
    _measure("cover", Gives.RATIO, LEVEL, high=1.0, unknown=_LEVEL,
             meaning="the share of the thing's footprint that its level takes: all that faces up "
                     "at that height"),
    _measure("level_length", Gives.LENGTH, LEVEL, unknown=_LEVEL,
             meaning="the longer extent of its level, along the sides of the thing's plan"),
    _measure("level_width", Gives.LENGTH, LEVEL, unknown=_LEVEL,
             meaning="the shorter extent of its level"),
    _measure("built_over", Gives.RATIO, LEVEL, high=1.0, unknown=_LEVEL,
             meaning="the share of its level that has something above it"),
    _measure("room_below", Gives.LENGTH, LEVEL, unknown=_LEVEL,
             meaning="the free height right beneath its level, on average"),
    _measure("room_width", Gives.LENGTH, LEVEL, unknown=_LEVEL,
             meaning="the width of the widest room beneath its level: as far as, from the rim to "
                     "half its depth, most is free from the ground to half its height"),
    _measure("room_above", Gives.LENGTH, LEVEL, unknown=_LEVEL,
             meaning="the free height right above its level, on average"),
    _measure("free_below", Gives.RATIO, LEVEL, high=1.0, unknown=_LEVEL,
             meaning="the share of the space beneath its level, its board included, that is free"),
    _measure("see_through", Gives.RATIO, LEVEL, high=1.0, unknown=_LEVEL,
             meaning="the share of the space beneath its level that one sees through, from the "
                     "front or from the side, whichever is more"),
    _measure("see_across", Gives.RATIO, LEVEL, high=1.0, unknown=_LEVEL,
             meaning="the same from the front or from the side, whichever is less"),
    _measure("open_from_two_sides", Gives.RATIO, LEVEL, high=1.0, unknown=_LEVEL,
             meaning="the share of level lines of sight beneath its level that reach the middle of "
                     "its thing, from the second most open of four sides"),
    _measure("enclosed", Gives.RATIO, LEVEL, high=1.0, unknown=_LEVEL,
             meaning="the share of the rim of its level that has something high above it: all of "
                     "it in a crate", yields=True),
    _measure("closed_behind", Gives.RATIO, LEVEL, high=1.0, unknown=_LEVEL,
             meaning="the share of the length of one side of its level that has something high "
                     "above it: of the side where that exceeds the opposite one's most, as a "
                     "back's does"),
    _measure("closed_in_front", Gives.RATIO, LEVEL, high=1.0, unknown=_LEVEL,
             meaning="the same of the opposite side"),
    _measure("side_behind", Gives.LENGTH, LEVEL, yields=True,
             unknown=_BACK,
             meaning="the length of the side that `closed_behind` is of: a sofa's back stands "
                     "along the longer extent of its seat, a bed's head along the shorter"),
    _measure("front_width", Gives.LENGTH, FACE, yields=True, unknown=_BACK,
             meaning="the side of the least rectangle round it that lies along its front, opposite "
                     "the side that `closed_behind` is of: how broad a seat is"),
    _measure("front_depth", Gives.LENGTH, FACE, yields=True, unknown=_BACK,
             meaning="the other side of that rectangle: how deep a seat is"),
    _measure("shelves_below", Gives.COUNT, LEVEL, unknown=_LEVEL, yields=True,
             meaning="how many shelves lie beneath its level: heights at which at least half of "
                     "its plan faces up"),
    _measure("rise_side", Gives.RATIO, LEVEL, unknown=_RISE,
             meaning="how far to one side what rises high above its level stands: 0 in the "
                     "middle, 1 at the rim"),
    _measure("rise_off_middle", Gives.RATIO, LEVEL, unknown=_RISE,
             meaning="how far that is from the middle of this side: 0 in the middle, 1 at its end"),
    _measure("rise_span", Gives.RATIO, LEVEL, high=1.0, unknown=_RISE,
             meaning="how much of the length of that side it takes"),
    _condition("measured", LEVEL,
               meaning="it was seen, and not only completed from its neighbours"),
    _condition("upward", FACE, meaning="its outward side looks upwards", unknown=_UP),
    _condition("downward", FACE, meaning="its outward side looks downwards", unknown=_UP),
    _condition("level", ELEMENT | PIECE, meaning="within 10 degrees of level", unknown=_UP),
    _condition("upright", ELEMENT | PIECE, meaning="within 10 degrees of upright", unknown=_UP),
    # Edges, vertices, things
    _measure("edge_length", Gives.LENGTH, EDGE, meaning="its length"),
    _measure("faces_at", Gives.COUNT, VERTEX, meaning="how many faces meet there"),
    _measure("gap", Gives.LENGTH, THING, THING, symmetric=True,
             meaning="the least distance between what was found of two things"),
    _condition("bounds", EDGE, FACE, meaning="the edge is a side of the face"),
    _condition("supports", ELEMENT, FACE, unknown=_UP,
               meaning="the first is upright, starts near the ground (within 15 % of the second's "
                       "height) and reaches at least half way up to the second, past it at its "
                       "rim alone"),
    _condition("on_ground", ANY | PIECE, unknown=_UP,
               meaning="its lowest point is level with that of its thing, within 3 % of the "
                       "thing's height"),
    _condition("at_rim", ELEMENT, FACE, unknown=_UP,
               meaning="seen from above, the first, which is upright, stands at the rim of the "
                       "second: within 15 % of its width"),
    _measure("footprint", Gives.AREA, THING, unknown=_SPACE,
             meaning="the area that it takes, seen from above"),
    _measure("solidity", Gives.RATIO, THING, high=1.0,
             unknown="it hangs on space that nobody saw",
             meaning="its share of the least box round it, upright or square to its largest face; "
                     "what cannot be reached from outside counts as its own"),
    _measure("hollow_side", Gives.RATIO, THING, high=1.0,
             unknown="it hangs on space that nobody saw",
             meaning="the share of a side of that box that lies deep behind it, of the side where "
                     "it is most; what stands on the ground has no side below"),
    _measure("curved", Gives.RATIO, SOLID, high=1.0,
             meaning="the share of its surface that is not flat"),
    # Pieces
    _measure("thickness", Gives.LENGTH, PIECE, yields=True,
             meaning="the shortest side of the least box round it"),
    _condition("board", PIECE, meaning="it is thin: its thickness is at most 35 % of its width",
               yields=True),
    _condition("bar", PIECE, yields=True,
               meaning="it is slender: no board, and its width is at most 35 % of its length"),
    _condition("block", PIECE, meaning="it is neither a board nor a bar", yields=True),
    _condition("joins", PIECE, PIECE, meaning="they touch, as finely as the space is known",
               symmetric=True, yields=True),
    _condition("carries", PIECE, PIECE, unknown=_UP, yields=True,
               meaning="the first touches the second from below, or carries another that does"),
    _condition("hangs_from", PIECE, PIECE, unknown=_UP, yields=True,
               meaning="they touch, the second's middle is higher, and without the second nothing "
                       "joins the first to the ground"),
    # Pieces and openings
    _condition("beside", IN_SPACE, IN_SPACE, symmetric=True, yields=True,
               unknown=f"{_UP}, or it hangs on space that nobody saw",
               meaning="half of the lower one's height at least is the other's, too, and no more "
                       "than 10 % of the smaller one's plan is over or under the other"),
    _condition("inside", IN_SPACE, IN_SPACE, yields=True,
               unknown="it hangs on space that nobody saw",
               meaning="the least box round it lies in that round the other, or in what is free "
                       "of an opening, but for 5 % of its extent at each side at most"),
    _condition("in", OPENING, LEVEL, yields=True,
               meaning="the face lies across the opening, reaches round it and leaves it free; or "
                       "the piece is all of its rim"),
    _condition("frames", PIECE, OPENING, yields=True,
               meaning="it is along at least 5 % of the opening's rim"),
    _condition("touches", THING, THING, symmetric=True, meaning="nothing is between them"),
)  # fmt: skip

VOCABULARY: Mapping[str, Word] = MappingProxyType({word.name: word for word in _WORDS})
"""The words by name."""
