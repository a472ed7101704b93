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
from facetlog.perception.facts.fact_kinds import parse_fact_kind as _kind
from facetlog.perception.facts.pieces.kinds import PIECE_KINDS
from facetlog.perception.min_views import FEWEST_VIEWS

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
    "check_fact",
]

_ONE, _MAYBE, _ANY = Solutions.ONE, Solutions.AT_MOST_ONE, Solutions.ANY
_NO_UP = "up is not known"
_UPRIGHT = "up is not known, or a face is within 10° of upright"

_NO_LEVEL = _NO_UP + ", or the face leans more than 30° from level or lies inside its object"
_NO_BACK = _NO_LEVEL + ", or no side is closed more than the opposite one"
_NO_FRONT = _NO_BACK + ", or unseen space could be a back at another side"
_NO_RISE = _NO_LEVEL + ", or nothing rises above it"
_NO_CAMERA = "no camera of the view is known, as of meshes and clouds"

FACT_SCHEMA: tuple[FactKind, ...] = (
    _kind("scene Name:text", _ONE, "the scene's name"),
    _kind("scale Unit:symbol", _ONE, "`metric`: lengths are metres; `unknown`: only ratios count"),
    _kind("up X:number Y:number Z:number", _MAYBE, "unit vector upwards", _NO_UP),
    _kind("view +View:view Name:text", _ONE, "a picture and its file name"),
    _kind("vertex +V:vertex", _ONE, "a 3-D vertex"),
    _kind("point +V:vertex X:length Y:length Z:length", _ONE, "the position of the vertex"),
    _kind(
        "point_cov +V:vertex XX:area XY:area XZ:area YY:area YZ:area ZZ:area",
        _ONE,
        "covariance of that position",
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
        "uncertainty of the plane: largest tilt of the normal, offset at the middle of the face",
    ),
    _kind(
        "corner +F:face +I:count V:vertex",
        _ONE,
        "V is the I-th vertex (from 1) of the outline, counter-clockwise from outside",
        "I exceeds the number of corners",
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
        "longer side of the least rectangle around the face",
    ),
    _kind("width +F:face W:length Sd:length", _ONE, "shorter side of that rectangle"),
    _kind("fill +F:face R:share Sd:share", _ONE, "area divided by that of the rectangle"),
    _kind("coverage +F:face R:share", _ONE, "share of the face seen in at least one view"),
    _kind(
        "viewpoint +P:symbol X:length Y:length Z:length",
        _ONE,
        "position of a camera or scanner: P is a view, or `scan1` …",
    ),
    _kind(
        "shows +View:view +F:face Seen:share Outside:share",
        _MAYBE,
        "share of the face that the view shows, and share outside of its picture",
        "the view looks at the face from behind or along it, or visibility was not recorded",
    ),
    _kind(
        "hides +View:view +F:face +By:face R:share",
        _MAYBE,
        "share of the face F that the face By hides from the view",
        "it hides nothing of it, or visibility was not recorded",
    ),
    _kind("thing +T:thing", _ONE, "an object: a connected group of faces and loose edges"),
    _kind(
        "part_of +X:part T:thing",
        _MAYBE,
        "the face or loose edge X belongs to T",
        "X is a side of a face, or a loose edge that touches no object with faces",
    ),
    _kind(
        "thing_size +T:thing L:length W:length H:length",
        _ONE,
        "sides of the least box around the object, aligned with its largest face, longest first",
    ),
    _kind(
        "gap +T1:thing +T2:thing D:length Sd:length",
        _ONE,
        "least distance between what was found of two objects, 0 if they touch or intersect",
    ),
    _kind(
        "share +F:face R:share Sd:share",
        _ONE,
        "area of F divided by the silhouette of its object along the normal of F",
    ),
    _kind(
        "protrusion +F:face P:length Sd:length",
        _ONE,
        "how far the object extends in front of the plane of F",
    ),
    _kind(
        "reach_behind +F:face R:length Sd:length",
        _ONE,
        "how far the object extends behind the plane of F: to the opposite side, if found",
    ),
    _kind(
        "angle +F1:face +F2:face Angle:deg Sd:deg",
        _ONE,
        "angle between the outward normals, 0 to 180",
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
        "angle through the solid at the (longest) edge where they adjoin, 0 to 360: 90 at the edge "
        "of a box, 270 in the corner of a room, 0 back to back",
        "they do not adjoin, or run the same way along the edge (one is on the rim of the other)",
    ),
    _kind(
        "convex +F1:face +F2:face",
        _MAYBE,
        "the solid is convex at their edge: dihedral below 180 and above 0, by more than 3 sd",
        "otherwise, or it is not known",
    ),
    _kind(
        "concave +F1:face +F2:face",
        _MAYBE,
        "the solid is concave at their edge: dihedral above 180 and below 360, by more than 3 sd",
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
        "height of the middle of the face above the lowest point of its object",
        _NO_UP,
    ),
    _kind(
        "top_of +X:body H:length Sd:length",
        _MAYBE,
        "height of the highest point of a face, loose edge or object above the lowest of its "
        "object",
        _NO_UP + ", or X belongs to no object",
    ),
    _kind(
        "bottom_of +X:body H:length Sd:length",
        _MAYBE,
        "height of the lowest point of a face, loose edge or object above the lowest of its object",
        _NO_UP + ", or X belongs to no object",
    ),
    _kind(
        "clear_below +F:face H:length",
        _MAYBE,
        "free height under most (80 %) of the face, down to the next face or the lowest point of "
        "the object; supports, up to half of the area, do not count",
        _UPRIGHT,
    ),
    _kind(
        "overlap +F1:face +F2:face R:share",
        _MAYBE,
        "seen from above, the share of the smaller one that lies over or under the other",
        _UPRIGHT + "; else absent means less than 0.001",
    ),
    _kind(
        "on_ground +X:body",
        _MAYBE,
        "its lowest point is that of its object, within 3 % of the height of the object or 3 sd",
        "otherwise, or " + _NO_UP,
    ),
    _kind(
        "at_rim +X:part +F:face",
        _MAYBE,
        "seen from above, the upright X is at the rim of F, within 15 % of the width of F",
        "otherwise, or " + _NO_UP,
    ),
    _kind(
        "whole +T:thing",
        _MAYBE,
        "a mesh or cloud shows it from all sides: its surface is closed, and no space around it is "
        "unseen",
        "otherwise",
    ),
    _kind(
        "scanned +T:thing",
        _MAYBE,
        "a mesh or cloud shows it from some sides, and all that is visible from there",
        "it is known from all sides, or from pictures, which may miss visible faces",
    ),
    _kind("curved +T:thing R:share", _ONE, "share of its surface that is not flat"),
    _kind(
        "footprint +T:thing A:area Sd:area",
        _MAYBE,
        "its area seen from above, holes filled",
        _NO_UP,
    ),
    _kind(
        "solidity +T:thing R:share Sd:share",
        _MAYBE,
        "share of the least box around it that it fills; the box is upright or aligned with its "
        "largest face; enclosed space and space behind seen surface count as filled",
        "it is a line or a point",
    ),
    _kind(
        "hollow_side +T:thing R:share Sd:share",
        _MAYBE,
        "share of a side of that box that is farther from the surface than 7 % of its longest "
        "side, for the most hollow side; the side on the ground does not count",
        "its surface is not known from all sides",
    ),
    _kind(
        "cover +F:face R:share Sd:share",
        _MAYBE,
        "share of the footprint of its object that the level of the face covers: all that faces up "
        "at that height",
        _NO_LEVEL,
    ),
    _kind(
        "level_length +F:face L:length Sd:length",
        _MAYBE,
        "longer side of the level, along the sides of the plan of the object",
        _NO_LEVEL,
    ),
    _kind("level_width +F:face L:length Sd:length", _MAYBE, "shorter side of the level", _NO_LEVEL),
    _kind(
        "built_over +F:face R:share Sd:share",
        _MAYBE,
        "share of the level that has something above it",
        _NO_LEVEL,
    ),
    _kind(
        "room_below +F:face H:length Sd:length",
        _MAYBE,
        "mean free height directly below the level",
        _NO_LEVEL,
    ),
    _kind(
        "room_width +F:face W:length Sd:length",
        _MAYBE,
        "width of the widest free space below the level: most of it free from the rim to half the "
        "depth, and from the ground to half the height",
        _NO_LEVEL,
    ),
    _kind(
        "room_above +F:face H:length Sd:length",
        _MAYBE,
        "mean free height directly above the level, up to the highest point",
        _NO_LEVEL,
    ),
    _kind(
        "free_below +F:face R:share Sd:share",
        _MAYBE,
        "share of the space below the level, with its board, that is free",
        _NO_LEVEL,
    ),
    _kind(
        "see_through +F:face R:share Sd:share",
        _MAYBE,
        "share of the space below the level that one can see through, from the front or from the "
        "side, whichever is more",
        _NO_LEVEL,
    ),
    _kind(
        "see_across +F:face R:share Sd:share",
        _MAYBE,
        "as `see_through`, but from the side where it is less",
        _NO_LEVEL,
    ),
    _kind(
        "open_from_two_sides +F:face R:share Sd:share",
        _MAYBE,
        "share of the horizontal lines of sight below the level that reach the middle of the "
        "object, from the second most open of four sides",
        _NO_LEVEL,
    ),
    _kind(
        "enclosed +F:face R:share Sd:share",
        _MAYBE,
        "share of the rim of the level above which something rises high",
        _NO_LEVEL,
    ),
    _kind(
        "closed_behind +F:face R:share Sd:share",
        _MAYBE,
        "share of a side of the level above which something rises high, for the side that exceeds "
        "its opposite side most",
        _NO_LEVEL,
    ),
    _kind(
        "closed_in_front +F:face R:share Sd:share",
        _MAYBE,
        "as `closed_behind`, but of the opposite side",
        _NO_LEVEL,
    ),
    _kind(
        "side_behind +F:face L:length Sd:length",
        _MAYBE,
        "length of the side that `closed_behind` measures",
        _NO_BACK,
    ),
    _kind(
        "front_width +F:face L:length Sd:length",
        _MAYBE,
        "side of the least rectangle around its outline along the front of its level, opposite to "
        "the side that `closed_behind` measures",
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
        "how far to one side of the level something rises high above it: 0 in the middle, 1 at "
        "the rim",
        _NO_RISE,
    ),
    _kind(
        "rise_off_middle +F:face R:number Sd:number",
        _MAYBE,
        "how far that is from the middle of this side: 0 in the middle, 1 at an end",
        _NO_RISE,
    ),
    _kind(
        "rise_span +F:face R:share Sd:share",
        _MAYBE,
        "share of the length of this side that it takes",
        _NO_RISE,
    ),
    _kind(
        "unseen_bounds +Measure:symbol +X:body IfFree:number IfFull:number",
        _MAYBE,
        "value of a measure of space (`footprint`, `solidity`, `cover` to `see_across`) for the "
        "face or object X if all unseen space is free, and if all is full; the fact of the "
        "measure has their middle",
        "no unseen space could change the measure",
    ),
    _kind(
        "assumed_full +T:thing R:share",
        _MAYBE,
        "share of the space it fills that was not seen but is assumed full, behind seen surface "
        "and within the seen extent",
        "all that it fills was seen or is enclosed",
        on_demand=True,
    ),
    _kind(
        "unseen_towards +T:thing X:number Y:number Z:number R:share",
        _ANY,
        "share of the unseen space around it that would be visible from the direction X, Y, Z of "
        "one of its sides; not from below if up is known",
        "no space around it is unseen",
        on_demand=True,
    ),
    _kind(
        "shelves_below +F:face N:count",
        _MAYBE,
        "number of shelves seen below the level: heights at which at least half of its area faces "
        "up",
        _NO_LEVEL,
        on_demand=True,
    ),
    _kind(
        "shelves_unseen +F:face Fewest:count Most:count",
        _MAYBE,
        "least and greatest possible number of shelves, with those that fit into unseen space",
        "no unseen space has room for one more",
        on_demand=True,
    ),
    *PIECE_KINDS,
    _kind(
        "junction +View:view +J:junction Type:symbol",
        _MAYBE,
        "how lines meet at a vertex of the line drawing of the view: `end`, `straight`, `l`, "
        "`fork`, `arrow`, `t`, `k`, `x`, `peak` or `multi`; J is a vertex of the scene, or `x1` … "
        "where lines only cross, or end at the picture's border",
        "the view does not show it, or " + _NO_CAMERA,
        on_demand=True,
    ),
    _kind(
        "line_at +View:view +J:junction +I:count K:junction E:edge",
        _MAYBE,
        "the I-th line (from 1) at J leads to K and is part of E; counter-clockwise, starting at "
        "the widest gap",
        "I exceeds the number of lines, or the view does not show J, or " + _NO_CAMERA,
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


def check_fact(fact: Fact) -> str | None:
    """Return how a fact breaks the schema, or None.

    >>> check_fact(Fact("area", ("f1", 2.0)))
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
