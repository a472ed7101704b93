"""The kinds of facts about pieces and openings: the rows of the schema that speak of them."""

from functools import partial

from facetlog.perception.facts.fact_kinds import FactKind, Solutions, fact_kind

__all__ = ["OPENING_KINDS", "PIECE_KINDS"]

_ONE, _MAYBE, _ANY = Solutions.ONE, Solutions.AT_MOST_ONE, Solutions.ANY
_NO_UP = "up is not known"
_kind = partial(fact_kind, on_demand=True)

_PIECES: tuple[FactKind, ...] = (
    _kind("piece +P:piece", _ONE, "a solid part of a thing: a board, a bar, a block"),
    _kind("piece_of +P:piece T:thing", _ONE, "the thing that it is a part of"),
    _kind(
        "piece_size +P:piece L:length W:length H:length Sd:length",
        _ONE,
        "length, width and thickness of the least box round its surface, longest first; an end at "
        "another piece is where their faces meet, or else known to a cell",
    ),
    _kind(
        "piece_heights +P:piece Low:length High:length Sd:length",
        _MAYBE,
        "from where to where it reaches above the lowest point of its thing",
        _NO_UP,
    ),
    _kind(
        "piece_tilt +P:piece Angle:deg Sd:deg",
        _MAYBE,
        "of what is slender the tilt of its length, 0 lying, 90 standing; of others that of their "
        "broad side, 0 level, 90 upright: of sides as broad within a cell the most level one",
        _NO_UP,
    ),
    _kind(
        "piece_angle +P:piece +Q:piece Angle:deg Sd:deg",
        _ONE,
        "between the length of what is slender and the broad side of others, 0 to 90: 0 along each "
        "other, 90 square; of pieces of one thing",
    ),
    _kind(
        "piece_on_ground +P:piece",
        _MAYBE,
        "its lowest point is level with its thing's, within a cell of its space",
        "otherwise, or " + _NO_UP,
    ),
    _kind(
        "piece_overlap +P:piece +Q:piece R:share Sd:share",
        _MAYBE,
        "the share of the smaller one's plan, of its least box, that lies over or under the "
        "other's; of pieces of one thing",
        _NO_UP + ", or by space that nobody saw it may differ by more than 5 %",
    ),
    _kind("piece_round +P:piece R:share", _ONE, "share of its surface that is curved"),
    _kind(
        "piece_measured +P:piece",
        _MAYBE,
        "pictures, a mesh or a scan show some of it",
        "all its faces were only completed from their neighbours",
    ),
    _kind(
        "piece_face +P:piece F:face", _ANY, "a face that is mostly its own", "it is curved all over"
    ),
    _kind("joins +P:piece +Q:piece", _MAYBE, "they touch, within a cell", "otherwise"),
    _kind(
        "carries +P:piece +Q:piece",
        _MAYBE,
        "Q is off the ground, and P touches it and reaches as low; or P carries what carries Q",
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
        "a measure of space (`cover` and so on to `rise_span`, and `shelves_below`) of the level "
        "that the upper side of a level board or block has",
        _NO_UP + ", or it is slender, or leans more than 30° from level",
    ),
    _kind(
        "piece_unseen +P:piece +Measure:symbol IfFree:number IfFull:number",
        _MAYBE,
        "what that measure of its level, or its `length`, `width`, `height`, `elevation`, `top_of` "
        "or `bottom_of` comes to if all unseen space is free, and if all is full; its depth behind "
        "a face that it shows is taken as what was seen of it",
        "no unseen space could change the measure",
    ),
)

OPENING_KINDS: tuple[FactKind, ...] = (
    _kind("opening +O:opening", _ONE, "a hole that one sees through, with its thing all round it"),
    _kind("opening_of +O:opening T:thing", _ONE, "the thing through which it goes"),
    _kind(
        "opening_size +O:opening L:length W:length Sd:length",
        _ONE,
        "length and width of the rectangle round what one sees through",
    ),
    _kind(
        "opening_heights +O:opening Low:length High:length Sd:length",
        _MAYBE,
        "from where to where it reaches above the lowest point of its thing",
        _NO_UP,
    ),
    _kind(
        "openings_known +T:thing",
        _MAYBE,
        "all its openings are known",
        "space that nobody saw has room for another",
    ),
    _kind(
        "opening_in +O:opening +X:level",
        _MAYBE,
        "the face lies across it, reaches round it and leaves it free; or the piece is all of its "
        "rim",
        "otherwise",
    ),
    _kind(
        "frames +P:piece +O:opening",
        _MAYBE,
        "the piece is along at least 5 % of the opening's rim",
        "otherwise",
    ),
    _kind(
        "inside +X:solid +Y:solid Known:symbol",
        _MAYBE,
        "`yes`: the box round X lies in that of Y, but for 5 % of its extent at each side at most; "
        "`no`: it does not",
        "it hangs on space that nobody saw",
    ),
    _kind(
        "beside +X:solid +Y:solid Known:symbol",
        _MAYBE,
        "`yes`: half of the lower one's height at least is the other's, too, and no more than 10 % "
        "of the smaller one's plan is over or under the other; `no`: it is not so",
        _NO_UP + ", or it hangs on space that nobody saw",
    ),
)

PIECE_KINDS = _PIECES + OPENING_KINDS
