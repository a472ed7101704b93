"""The facts' schema: which facts perception states about a scene, and what their arguments are.

This is the contract between perception and the knowledge base. It needs no numerics, so the
knowledge base can read it cheaply; `facetlog model words facts` prints it.
"""

from facetlog.perception.facts.fact_kinds import (
    Argument,
    ArgumentKind,
    Fact,
    FactKind,
    Solutions,
    Value,
)
from facetlog.perception.facts.fact_kinds import fact_kind as _kind
from facetlog.perception.facts.pieces.kinds import PIECE_KINDS
from facetlog.perception.fewest_views import FEWEST_VIEWS

__all__ = [
    "FACT_SCHEMA",
    "FEWEST_VIEWS",
    "ON_DEMAND",
    "Argument",
    "ArgumentKind",
    "Fact",
    "FactKind",
    "Solutions",
    "Value",
    "fact_fault",
]

_ONE, _MAYBE, _ANY = Solutions.ONE, Solutions.AT_MOST_ONE, Solutions.ANY
_NO_UP = "up is not known"
_UPRIGHT = "up is not known, or a face stands within 10° of upright (its plan is a line)"

_NO_LEVEL = _NO_UP + ", or the face leans more than 30° from level or lies within its thing"
_NO_BACK = _NO_LEVEL + ", or no side is closed more than the one opposite"
_NO_FRONT = _NO_BACK + ", or unseen space could be a back at another side"
_NO_RISE = _NO_LEVEL + ", or nothing rises above it"
_NO_CAMERA = "no camera of the view is known, as of meshes and clouds"

FACT_SCHEMA: tuple[FactKind, ...] = (
    _kind("scene Name:text", _ONE, "the scene's name"),
    _kind("scale Unit:symbol", _ONE, "`metric`: lengths are metres; `unknown`: only ratios count"),
    _kind("up X:number Y:number Z:number", _MAYBE, "unit vector upwards", _NO_UP),
    _kind("view +View:view Name:text", _ONE, "a picture and its file name"),
    _kind("vertex +V:vertex", _ONE, "a 3-D vertex"),
    _kind("point +V:vertex X:length Y:length Z:length", _ONE, "where the vertex is"),
    _kind(
        "point_cov +V:vertex XX:area XY:area XZ:area YY:area YZ:area ZZ:area",
        _ONE,
        "covariance of that place",
    ),
    _kind(
        "vertex_label +V:vertex Label:symbol",
        _MAYBE,
        "position label of the paper, e.g. `front_left_top`",
        "the vertex has no label",
    ),
    _kind(
        "observed +V:vertex +View:view U:px W:px SdU:px SdW:px",
        _MAYBE,
        "pixel (column, row) at which a view saw the vertex",
        "the view did not see it",
    ),
    _kind(
        "edge +E:edge V1:vertex V2:vertex",
        _ONE,
        "a straight edge; every side of every face has one",
    ),
    _kind("edge_length +E:edge L:length Sd:length", _ONE, "its length"),
    _kind(
        "edge_support +E:edge Share:share",
        _MAYBE,
        "share of it found in the views that could see it",
        "the edge is known only as the side of a face",
    ),
    _kind("face +F:face", _ONE, "a flat face"),
    _kind(
        "evidence +X:part How:symbol",
        _ONE,
        "`measured`: pictures support it; `implied`: completed from its neighbours",
    ),
    _kind(
        "plane +F:face A:number B:number C:number D:length",
        _ONE,
        "unit outward normal and offset, A x + B y + C z + D = 0",
    ),
    _kind(
        "plane_sd +F:face TiltSd:deg OffsetSd:length",
        _ONE,
        "how sure the plane is: worst tilt of the normal, offset at the face's middle",
    ),
    _kind(
        "corner +F:face +I:count V:vertex",
        _ONE,
        "V is the I-th vertex (from 1) of the outline, counter-clockwise from outside",
        "I is above the number of corners",
    ),
    _kind(
        "bounds +E:edge F:face",
        _ANY,
        "E is a side of F, or lies along one within 3 sd",
        "a loose edge bounds nothing",
    ),
    _kind("area +F:face A:area Sd:area", _ONE, "area without holes"),
    _kind(
        "length +F:face L:length Sd:length",
        _ONE,
        "longer side of the least rectangle round the face",
    ),
    _kind("width +F:face W:length Sd:length", _ONE, "shorter side of that rectangle"),
    _kind("fill +F:face R:share Sd:share", _ONE, "area over that rectangle's"),
    _kind("coverage +F:face R:share", _ONE, "share of the face seen in at least one view"),
    _kind(
        "viewpoint +P:symbol X:length Y:length Z:length",
        _ONE,
        "from where something was seen: P is a view, whose camera stood there, or `scan1` …, where "
        "a scanner did",
    ),
    _kind(
        "shows +View:view +F:face Seen:share Outside:share",
        _MAYBE,
        "share of the face that the view shows, and share that lies outside of its picture",
        "the view looks at the face from behind or along it, or nobody noted what views show",
    ),
    _kind(
        "hides +View:view +F:face +By:face R:share",
        _MAYBE,
        "share of the face F that the face By hides from the view",
        "it hides nothing of it, or nobody noted what views show",
    ),
    _kind(
        "thing +T:thing", _ONE, "a connected group of faces and loose edges, judged as one object"
    ),
    _kind(
        "part_of +X:part T:thing",
        _MAYBE,
        "the face or loose edge X belongs to T",
        "X is a side of a face, or a loose edge that touches no face's thing",
    ),
    _kind(
        "thing_size +T:thing L:length W:length H:length",
        _ONE,
        "sides of the least box round the thing that is square to its largest face, longest first",
    ),
    _kind(
        "gap +T1:thing +T2:thing D:length Sd:length",
        _ONE,
        "least distance between what was found of two things, 0 where they touch or intersect",
    ),
    _kind(
        "share +F:face R:share Sd:share",
        _ONE,
        "area of F over the silhouette of its thing along F's normal",
    ),
    _kind(
        "protrusion +F:face P:length Sd:length",
        _ONE,
        "how far the thing reaches in front of F's plane",
    ),
    _kind(
        "reach_behind +F:face R:length Sd:length",
        _ONE,
        "how far the thing reaches behind F's plane: to the side opposite, if that was found",
    ),
    _kind(
        "angle +F1:face +F2:face Angle:deg Sd:deg",
        _ONE,
        "angle between the outward normals, 0..180",
    ),
    _kind(
        "adjoins +F1:face +F2:face E:edge",
        _ANY,
        "the outlines share the edge E, or run along each other within 3 sd over at least 20 % "
        "of E, the shorter of the two sides",
        "no sides meet",
    ),
    _kind(
        "dihedral +F1:face +F2:face Angle:deg Sd:deg",
        _MAYBE,
        "angle through the solid at the (longest) edge where they adjoin, 0..360: 90 at a box's "
        "edge, 270 in a room's corner, 0 back to back",
        "they do not adjoin, or run the same way along the edge (one stands on the other's rim)",
    ),
    _kind(
        "convex +F1:face +F2:face",
        _MAYBE,
        "the solid bulges at their edge: dihedral below 180 and above 0, by more than 3 sd",
        "otherwise, or it is not known",
    ),
    _kind(
        "concave +F1:face +F2:face",
        _MAYBE,
        "the solid is hollow at their edge: dihedral above 180 and below 360, by more than 3 sd",
        "otherwise, or it is not known",
    ),
    _kind(
        "opposite +F1:face +F2:face",
        _MAYBE,
        "outward normals opposed within 3 sd or 5°, whichever is more (at most 15°), and the "
        "outlines overlap along the normal by at least 1 % of the smaller",
        "otherwise",
    ),
    _kind(
        "coplanar +F1:face +F2:face",
        _MAYBE,
        "in one plane within 3 sd (of at most 15°), whichever way the normals point",
        "otherwise",
    ),
    _kind(
        "offset +F1:face +F2:face D:length Sd:length",
        _ONE,
        "signed distance of the middle of F1 from the plane of F2, positive in front of F2",
    ),
    _kind(
        "tilt +F:face Angle:deg Sd:deg",
        _MAYBE,
        "0 level, 90 upright, whichever way it faces",
        _NO_UP,
    ),
    _kind(
        "upward +F:face",
        _MAYBE,
        "the outward normal points above the horizon by more than 2 sd",
        "otherwise, or " + _NO_UP,
    ),
    _kind(
        "downward +F:face",
        _MAYBE,
        "the outward normal points below the horizon by more than 2 sd",
        "otherwise, or " + _NO_UP,
    ),
    _kind(
        "elevation +F:face H:length Sd:length",
        _MAYBE,
        "height of the face's middle above the lowest point of its thing",
        _NO_UP,
    ),
    _kind(
        "top_of +X:body H:length Sd:length",
        _MAYBE,
        "height of the highest point of a face, loose edge or thing above the lowest of its thing",
        _NO_UP + ", or X belongs to no thing",
    ),
    _kind(
        "bottom_of +X:body H:length Sd:length",
        _MAYBE,
        "height of the lowest point of a face, loose edge or thing above the lowest of its thing",
        _NO_UP + ", or X belongs to no thing",
    ),
    _kind(
        "clear_below +F:face H:length",
        _MAYBE,
        "free height under most (80 %) of the face, down to the next face or the thing's lowest "
        "point; what carries it to the ground is not in the way, up to half of it",
        _UPRIGHT,
    ),
    _kind(
        "overlap +F1:face +F2:face R:share",
        _MAYBE,
        "share of the smaller one's plan that lies over or under the other's",
        _UPRIGHT + "; else absent means less than 0.001",
    ),
    _kind(
        "on_ground +X:body",
        _MAYBE,
        "its lowest point is level with its thing's, within 3 % of the thing's height or 3 sd",
        "otherwise, or " + _NO_UP,
    ),
    _kind(
        "at_rim +X:part +F:face",
        _MAYBE,
        "seen from above, the upright X stands at the rim of F: within 15 % of F's width",
        "otherwise, or " + _NO_UP,
    ),
    _kind(
        "whole +T:thing",
        _MAYBE,
        "it was read from a mesh or cloud, and is known from all sides: its surface is closed, and "
        "no space round it is unseen",
        "it is not",
    ),
    _kind(
        "scanned +T:thing",
        _MAYBE,
        "its surface is known from some sides, as a scan's is, and there all that was in sight",
        "it is known from all sides, or pictures show it: they may miss faces in plain sight",
    ),
    _kind("curved +T:thing R:share", _ONE, "share of its surface that is not flat"),
    _kind("footprint +T:thing A:area Sd:area", _MAYBE, "area of its plan, hollows filled", _NO_UP),
    _kind(
        "solidity +T:thing R:share Sd:share",
        _MAYBE,
        "share that it takes of the least box round it, upright or square to its largest face; "
        "what surface encloses counts as taken, and what lies behind seen surface",
        "it is a line or a point",
    ),
    _kind(
        "hollow_side +T:thing R:share Sd:share",
        _MAYBE,
        "share of a side of that box that lies deeper behind it than 7 % of its longest side, of "
        "the side where it is most; what stands on the ground has no side below",
        "its surface is not known from all sides",
    ),
    _kind(
        "cover +F:face R:share Sd:share",
        _MAYBE,
        "share of its thing's footprint that the level of the face takes: all that faces up at "
        "that height",
        _NO_LEVEL,
    ),
    _kind(
        "level_length +F:face L:length Sd:length",
        _MAYBE,
        "longer extent of the face's level, along the sides of the thing's plan",
        _NO_LEVEL,
    ),
    _kind(
        "level_width +F:face L:length Sd:length",
        _MAYBE,
        "shorter extent of the face's level, along the sides of the thing's plan",
        _NO_LEVEL,
    ),
    _kind(
        "built_over +F:face R:share Sd:share",
        _MAYBE,
        "share of the face's level that has something above it",
        _NO_LEVEL,
    ),
    _kind(
        "room_below +F:face H:length Sd:length",
        _MAYBE,
        "free height right beneath the face's level, on average",
        _NO_LEVEL,
    ),
    _kind(
        "room_width +F:face W:length Sd:length",
        _MAYBE,
        "width of the widest room beneath the face's level: as far as, from the rim to half its "
        "depth, most is free from the ground to half its height",
        _NO_LEVEL,
    ),
    _kind(
        "room_above +F:face H:length Sd:length",
        _MAYBE,
        "free height right above the face's level up to the highest point, on average",
        _NO_LEVEL,
    ),
    _kind(
        "free_below +F:face R:share Sd:share",
        _MAYBE,
        "share of the space beneath the face's level, its board included, that is free",
        _NO_LEVEL,
    ),
    _kind(
        "see_through +F:face R:share Sd:share",
        _MAYBE,
        "share of the space beneath the face's level that one sees through, from the front or "
        "from the side, whichever is more",
        _NO_LEVEL,
    ),
    _kind(
        "see_across +F:face R:share Sd:share",
        _MAYBE,
        "the same from the front or from the side, whichever is less",
        _NO_LEVEL,
    ),
    _kind(
        "open_from_two_sides +F:face R:share Sd:share",
        _MAYBE,
        "share of the level lines of sight beneath the face's level that reach the middle of its "
        "thing, from the second most open of four sides",
        _NO_LEVEL,
    ),
    _kind(
        "enclosed +F:face R:share Sd:share",
        _MAYBE,
        "share of the rim of the face's level that has something high above it",
        _NO_LEVEL,
    ),
    _kind(
        "closed_behind +F:face R:share Sd:share",
        _MAYBE,
        "share of the length of a side of the face's level that has something high above its rim, "
        "of the side where that exceeds the opposite side's most",
        _NO_LEVEL,
    ),
    _kind(
        "closed_in_front +F:face R:share Sd:share",
        _MAYBE,
        "the same of the opposite side",
        _NO_LEVEL,
    ),
    _kind(
        "side_behind +F:face L:length Sd:length",
        _MAYBE,
        "length of the side that `closed_behind` is of",
        _NO_BACK,
    ),
    _kind(
        "front_width +F:face L:length Sd:length",
        _MAYBE,
        "side of the least rectangle round its outline that lies along the front of its level: the "
        "side opposite that which `closed_behind` is of",
        _NO_FRONT,
    ),
    _kind(
        "front_depth +F:face L:length Sd:length",
        _MAYBE,
        "the other side of that rectangle",
        _NO_FRONT,
    ),
    _kind(
        "rise_side +F:face R:number Sd:number",
        _MAYBE,
        "how far to one side what rises high above the face's level stands: 0 in its middle, "
        "1 at its rim",
        _NO_RISE,
    ),
    _kind(
        "rise_off_middle +F:face R:number Sd:number",
        _MAYBE,
        "how far that is from the middle of this side: 0 in the middle, 1 at its end",
        _NO_RISE,
    ),
    _kind(
        "rise_span +F:face R:share Sd:share",
        _MAYBE,
        "how much of the length of that side it takes",
        _NO_RISE,
    ),
    _kind(
        "unseen_bounds +Measure:symbol +X:body IfFree:number IfFull:number",
        _MAYBE,
        "what the measure of space that `Measure` names (`footprint`, `solidity`, `cover` and so "
        "on to `see_across`) comes to for the face or thing X if all unseen space is free, and if "
        "all is full; its own fact has their middle",
        "no unseen space could change the measure",
    ),
    _kind(
        "assumed_full +T:thing R:share",
        _MAYBE,
        "of the space that it fills so much was not seen, and is taken to be full: it lies behind "
        "surface that was seen, within the seen extent",
        "all that it fills was seen, or is enclosed",
        on_demand=True,
    ),
    _kind(
        "unseen_towards +T:thing X:number Y:number Z:number R:share",
        _ANY,
        "of the unseen space round it so much would show to who looks at it from the direction "
        "X, Y, Z, one of those of its sides; not from below, where up is known",
        "no space round it is unseen",
        on_demand=True,
    ),
    _kind(
        "shelves_below +F:face N:count",
        _MAYBE,
        "how many shelves were seen beneath the face's level: heights at which at least half of "
        "its plan faces up",
        _NO_LEVEL,
        on_demand=True,
    ),
    _kind(
        "shelves_unseen +F:face Fewest:count Most:count",
        _MAYBE,
        "how many there are at least, and at most: if as many as find room lie in unseen space",
        "no unseen space has room for one more",
        on_demand=True,
    ),
    *PIECE_KINDS,
    _kind(
        "junction +View:view +J:junction Type:symbol",
        _MAYBE,
        "lines meet so at a vertex of the view's line drawing: `end`, `straight`, `l`, `fork`, "
        "`arrow`, `t`, `k`, `x`, `peak` or `multi`; J is a vertex of the scene, or `x1` … where "
        "lines only cross, or end at the picture's border",
        "the view does not show it, or " + _NO_CAMERA,
        on_demand=True,
    ),
    _kind(
        "line_at +View:view +J:junction +I:count K:junction E:edge",
        _MAYBE,
        "the I-th line (from 1) at J goes to K and is part of E; counter-clockwise as one sees it, "
        "from the widest gap",
        "I is above the number of lines, or the view does not show J, or " + _NO_CAMERA,
        on_demand=True,
    ),
    _kind(
        "contour +View:view +J:junction K:junction",
        _ANY,
        "the line from J to K has what is drawn on its right, and nothing on its left",
        "the lines at J have something drawn on both sides, or " + _NO_CAMERA,
        on_demand=True,
    ),
)

FACT_KINDS = {kind.functor: kind for kind in FACT_SCHEMA}
"""The kinds of facts by their functors: there are no two of one functor."""

ON_DEMAND = frozenset(kind.functor for kind in FACT_SCHEMA if kind.on_demand)
"""Facts that are worked out only for who asks for them by name."""


def fact_fault(fact: Fact) -> str | None:
    """What is wrong with a fact by the schema, or None.

    >>> fact_fault(Fact("area", ("f1", 2.0)))
    'area takes 3 arguments, not 2'
    """
    kind = FACT_KINDS.get(fact.functor)
    if kind is None:
        return f"{fact.functor} is no fact of perception"
    if len(fact.args) != kind.arity:
        return f"{fact.functor} takes {kind.arity} arguments, not {len(fact.args)}"
    for argument, value in zip(kind.arguments, fact.args, strict=True):
        wanted = str if argument.kind.is_atom else int if argument.kind == "count" else float
        if type(value) is not wanted:
            return f"{fact.functor}: {argument.name} is {value!r}, not of type {wanted.__name__}"
    return None
