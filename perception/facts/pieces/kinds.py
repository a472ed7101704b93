"""The kinds of facts about pieces and openings: the rows of the schema that speak of them."""

from functools import partial

from facetlog.perception.facts.fact_kinds import FactKind, Solutions, parse_fact_kind

_ONE, _MAYBE, _ANY = Solutions.ONE, Solutions.AT_MOST_ONE, Solutions.ANY
_NO_UP = "up is not known"
_kind = partial(parse_fact_kind, on_demand=True)

_PIECES: tuple[FactKind, ...] = (
    _kind("piece +P:piece", _ONE, "a solid part of an object: a board, bar or block"),
    _kind("piece_of +P:piece T:thing", _ONE, "the object that it is a part of"),
    _kind(
        "explained +T:thing R:share",
        _MAYBE,
        "share of its volume that its pieces fill",
        "it is not known from all sides",
    ),
    _kind(
        "unexplained +T:thing X0:length Y0:length Z0:length X1:length Y1:length Z1:length",
        _ANY,
        "lowest and highest corner of a box round what none of its pieces fills",
        "pieces fill it, or it is not known from all sides",
    ),
    _kind(
        "piece_size +P:piece L:length W:length H:length Sd:length",
        _ONE,
        "length, width and thickness of the least box around its surface, longest first: exact "
        "where the surface of its object is closed, else an end may be known to one cell only",
    ),
    _kind(
        "piece_heights +P:piece Low:length High:length Sd:length",
        _MAYBE,
        "heights of its lowest and highest point above the lowest point of its object",
        _NO_UP,
    ),
    _kind(
        "piece_tilt +P:piece Angle:deg Sd:deg",
        _MAYBE,
        "tilt of the length of a bar, 0 level, 90 upright; of other pieces, of the broad side, 0 "
        "level, 90 upright, the most level one of equally broad sides",
        _NO_UP,
    ),
    _kind(
        "piece_side_tilt +P:piece Angle:deg Sd:deg",
        _MAYBE,
        "tilt of the most level side of its least box, 0 level",
        _NO_UP,
    ),
    _kind(
        "piece_angle +P:piece +Q:piece Angle:deg Sd:deg",
        _ONE,
        "angle between the lengths of bars and the broad sides of others, 0 parallel, 90 "
        "perpendicular; of pieces of one object",
    ),
    _kind(
        "piece_on_ground +P:piece",
        _MAYBE,
        "its lowest point is that of its object, within one cell, or it stands on a board that "
        "lies there",
        "otherwise, or " + _NO_UP,
    ),
    _kind(
        "piece_overlap +P:piece +Q:piece R:share Sd:share",
        _MAYBE,
        "seen from above, share of the smaller box that lies over or under the other; of pieces of "
        "one object",
        _NO_UP + ", or unseen space may change it by more than 5 %",
    ),
    _kind(
        "piece_distance +P:piece +Q:piece V:length Sd:length",
        _MAYBE,
        "seen from above, how far apart their middles are; of pieces of one object",
        _NO_UP + ", or it depends on unseen space",
    ),
    _kind(
        "piece_inset +P:piece +Q:piece V:length Corner:length Sd:length",
        _MAYBE,
        "seen from above, how far P lies within the box around Q on the side where that is least, "
        "below 0 if it projects, and on the farther side of the nearest corner; of pieces of one "
        "object",
        _NO_UP + ", or it depends on unseen space",
    ),
    _kind(
        "piece_round +P:piece R:share",
        _ONE,
        "share of the outline of its section that is "
        "curved: 1 for a wheel or pole; of its surface where that of its object is not closed",
    ),
    _kind(
        "piece_measured +P:piece",
        _MAYBE,
        "some of it was measured",
        "all its faces were only completed from their neighbours",
    ),
    _kind(
        "piece_face +P:piece F:face",
        _ANY,
        "a face that mostly belongs to it",
        "it is curved all over",
    ),
    _kind("joins +P:piece +Q:piece", _MAYBE, "they touch, within one cell", "otherwise"),
    _kind(
        "may_join +P:piece +Q:piece",
        _MAYBE,
        "they do not touch, but volume that is in no piece lies against both",
        "otherwise",
    ),
    _kind(
        "carries +P:piece +Q:piece",
        _MAYBE,
        "Q is off the ground, and P touches it and extends as low; or P carries a piece that "
        "carries Q",
        "otherwise, or " + _NO_UP,
    ),
    _kind(
        "hangs_from +P:piece +Q:piece",
        _MAYBE,
        "they touch, Q's middle is higher, and without Q nothing joins P to the ground",
        "otherwise, or " + _NO_UP,
    ),
    _kind(
        "piece_level +P:piece Measure:symbol V:number Sd:number",
        _ANY,
        "a measure of space (`cover` to `rise_span`, and `shelves_below`) of the level of the "
        "upper side of a level board or block",
        _NO_UP + ", or it is a bar, or leans more than 30° from level or lies inside its object",
    ),
    _kind(
        "piece_unseen +P:piece +Measure:symbol IfFree:number IfFull:number",
        _MAYBE,
        "value of such a measure, or of its `length`, `width`, `height`, `elevation`, `top_of` or "
        "`bottom_of`, if all unseen space is free, and if all is full; its depth behind a visible "
        "face is taken as seen",
        "no unseen space could change the measure",
    ),
)

OPENING_KINDS: tuple[FactKind, ...] = (
    _kind("opening +O:opening", _ONE, "a hole that one can see through, surrounded by its object"),
    _kind("opening_of +O:opening T:thing", _ONE, "the object that it is in"),
    _kind(
        "opening_size +O:hole L:length W:length Sd:length",
        _ONE,
        "length and width of the rectangle around it, or around the section of a hollow",
    ),
    _kind(
        "opening_heights +O:hole Low:length High:length Sd:length",
        _MAYBE,
        "heights of its lowest and highest point above the lowest point of its object",
        _NO_UP,
    ),
    _kind(
        "openings_known +T:thing",
        _MAYBE,
        "all its openings are known",
        "unseen space has room for another",
    ),
    _kind(
        "opening_in +O:opening +X:level",
        _MAYBE,
        "the face surrounds it and leaves it free, or the piece is its whole rim",
        "otherwise",
    ),
    _kind(
        "frames +P:piece +O:opening",
        _MAYBE,
        "the piece forms at least 5 % of the rim of the opening",
        "otherwise",
    ),
    _kind(
        "hollow_of +H:hollow T:thing",
        _ONE,
        "the object that it is in: a space walled on four sides, closed behind, and open at the "
        "top or at one side",
    ),
    _kind(
        "hollow_mouth +H:hollow Side:symbol Depth:length Sd:length Share:share ShareSd:share",
        _ONE,
        "where it opens, `top` or `side`, how far it reaches in from there, and the share of its "
        "section that is open",
    ),
    _kind(
        "hollows_known +T:thing",
        _MAYBE,
        "all its hollows are known",
        "it is not known from all sides, or " + _NO_UP,
    ),
    _kind(
        "inside +X:solid +Y:solid Known:symbol",
        _MAYBE,
        "`yes`: the box around X lies in that of Y, except for at most 5 % at each side; `no`: it "
        "does not",
        "it depends on unseen space",
    ),
    _kind(
        "beside +X:solid +Y:solid Known:symbol",
        _MAYBE,
        "`yes`: at least half the height of the lower one is shared by the other, at most two "
        "thirds of the smaller one are sunk into the other, and at most 10 % of the rest lie over "
        "or under it; `no`: otherwise",
        _NO_UP + ", or it depends on unseen space",
    ),
    _kind(
        "beside_shares +X:solid +Y:solid Abreast:share Sunk:share Over:share",
        _MAYBE,
        "of two solids near each other the shares that `beside` rests on: of the lower one's "
        "height, of the smaller one that is sunk into the other, of the rest that is over or under",
        "it is known that X is beside Y, or " + _NO_UP,
    ),
)

PIECE_KINDS = _PIECES + OPENING_KINDS
