"""Position labels of a block's vertices in one picture, and what they mean across pictures.

Section 5.3 of the paper labels vertices "back-left-top, back-right-top, ... depending on their
positions in the block", as the picture shows it: the front is the side that faces the camera
most. So front in pictures of set I is back in those of set III. `turned_label` carries a label
from one side to another; the labels of tracks refer to the side that faces the first picture.

Evidence, in this order: the plan directions of the edges that leave the vertex (a vertex with an
edge to the right is a left one, with one away from the camera a front one, with one downwards a
top one); RULE 1's test of the 8 neighbours and its counterparts; whether the object lies above,
below, left or right of the vertex. A vertex without enough evidence, or with contradicting
evidence, has no label but a reason.
"""

from dataclasses import dataclass

import numpy as np

from facetlog.perception.detection.block_front_end.edge_lines import EdgeLine
from facetlog.perception.detection.block_front_end.image_vertices import ImageVertex
from facetlog.perception.detection.block_front_end.picture_drawing import leaving
from facetlog.perception.detection.block_front_end.plane_regions import PlaneRegions
from facetlog.perception.types import FloatArray, PositionLabel, View

# The cameras' x axes fix the ground plane if they spread more than this (second singular value
# over the first): some 6 degrees; below it the mean of the pictures' own upward axes is taken.
LEAST_SPREAD = 0.1
# Edges vote for the block's turn; the winning turn has this share of all level directions (by
# length) within TURN_WINDOW of it. Directions at random would give it 2 * 5 / 90 = .11.
LEAST_TURN_SHARE = 0.35
TURN_WINDOW = np.deg2rad(5.0)
TURN_STEPS = 180
QUARTER = np.pi / 2.0


def upward_direction(views: tuple[View, ...]) -> FloatArray:
    """Unit vector (3,) in the world that is up in the pictures, for cameras without skew."""
    x_axes = np.array([view.pose.rotation[:, 0] for view in views])
    up_axes = -np.array([view.pose.rotation[:, 1] for view in views])
    mean_up = up_axes.sum(axis=0)
    _, spread, vt = np.linalg.svd(x_axes)
    level = len(spread) >= 2 and spread[1] >= LEAST_SPREAD * spread[0]
    up = vt[2] if level else mean_up - vt[0] * (vt[0] @ mean_up)
    if up @ mean_up < 0:
        up = -up
    return np.asarray(up / np.linalg.norm(up), dtype=np.float64)


def ground_axes(up: FloatArray, first: View) -> tuple[FloatArray, FloatArray]:
    """Unit vectors (3,), (3,) of the plan: right and ahead of the first view; right x ahead = up.

    The azimuths of this module are counter-clockwise from the first one, seen from above.
    """
    right = first.pose.rotation[:, 0]
    right = right - up * (up @ right)
    right = right / np.linalg.norm(right)
    return right, np.cross(up, right)


def edge_azimuth(
    view: View, line: EdgeLine, up: FloatArray, axes: tuple[FloatArray, FloatArray]
) -> float | None:
    """Azimuth (radians) of a level edge from its start to its end; None if the edge can be upright.

    The rays through a line span a plane; the level direction in it is that plane's normal x up.
    """
    inverse = np.linalg.inv(view.camera.matrix)
    rays = np.array([inverse @ [*p, 1.0] for p in (line.start, line.end)]) @ view.pose.rotation.T
    normal = np.cross(rays[0], rays[1])
    normal /= np.linalg.norm(normal)
    level = np.cross(normal, up)
    # |level| is the sine of the plane's tilt off the ground: a nearly level plane fixes nothing.
    if np.linalg.norm(level) < LEAST_TILT or abs(normal @ up) < UPRIGHT_SINE:
        return None
    level /= np.linalg.norm(level)
    # From start to end: the ray at the end lies towards the level direction.
    along = rays[1] / np.linalg.norm(rays[1]) - rays[0] / np.linalg.norm(rays[0])
    if along @ level < 0:
        level = -level
    return float(np.arctan2(level @ axes[1], level @ axes[0]))


# Below this sine an edge's plane of rays contains the upright: 3 degrees, an edge's own error.
UPRIGHT_SINE = 0.05
# Sine of the tilt off the ground below which an edge at the height of the eye has no azimuth.
LEAST_TILT = 0.05


def block_turn(azimuths: FloatArray, lengths: FloatArray) -> float | None:
    """Turn (radians, 0..pi/2) of the block's level edges in the plan; None if no turn stands out.

    Each edge votes by its length for its azimuth modulo a quarter turn.

    >>> round(float(np.rad2deg(block_turn(np.deg2rad([10, 101, -79, -171, 40]), np.ones(5)))))
    10
    """
    if not len(azimuths):
        return None
    folded = np.asarray(azimuths, dtype=np.float64)
    candidates = np.linspace(0.0, QUARTER, TURN_STEPS, endpoint=False)
    off = (folded[None, :] - candidates[:, None] + QUARTER / 2) % QUARTER - QUARTER / 2
    votes = (lengths * np.maximum(0.0, 1.0 - np.abs(off) / TURN_WINDOW)).sum(axis=1)
    best = int(np.argmax(votes))
    near = np.abs(off[best]) <= TURN_WINDOW
    if lengths[near].sum() < LEAST_TURN_SHARE * lengths.sum():
        return None
    middle = float((lengths[near] * off[best][near]).sum() / lengths[near].sum())
    return float((candidates[best] + middle) % QUARTER)


# RULE 1 looks at the 8 nearest pixels of a picture without blur; a real edge is some 3 px wide,
# so the neighbours are taken this far from the vertex.
NEIGHBOUR_PX = 5
# An edge belongs to a direction of the plan, or to the upright, within this angle: it is where
# half the least slope change that makes a vertex (30 degrees) would fit another one as well.
DIRECTION_WINDOW = np.deg2rad(15.0)

COMPASS = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")
_STEPS = ((0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1))

# RULE 1, and its counterparts for the corners that a picture from in front and above shows.
_RULES = {
    frozenset({"E", "SE", "S"}): PositionLabel.BACK_LEFT_TOP,
    frozenset({"W", "SW", "S"}): PositionLabel.BACK_RIGHT_TOP,
    frozenset({"NE", "E", "SE", "S"}): PositionLabel.FRONT_LEFT_TOP,
    frozenset({"NW", "W", "SW", "S"}): PositionLabel.FRONT_RIGHT_TOP,
    frozenset({"N", "NE", "E"}): PositionLabel.FRONT_LEFT_BOTTOM,
    frozenset({"N", "NW", "W"}): PositionLabel.FRONT_RIGHT_BOTTOM,
}

# The corners of the plan, counter-clockwise seen from above.
_RING = ("front_left", "front_right", "back_right", "back_left")


@dataclass(frozen=True, slots=True)
class BlockSide:
    """How the block stands to a view: `turn` of its level edges in the plan (radians), `front`
    the quarter turn (0..3 from `turn`) of the outward normal of the side that faces the view.
    """

    turn: float
    front: int


@dataclass(frozen=True, eq=False, slots=True)
class LabelledVertex:
    """A 2-D vertex with its label as this picture shows the block, and the same on the block
    whose front faces the first picture; `reason` names its evidence, or why there is none.

    `position` is the known part of the label, as `front_?_top`, though others may have it as well.
    `mark` distinguishes a vertex without a label from the picture's others, and limits the vertices
    of other pictures that it may correspond to (junction_marks.py).
    """

    vertex: ImageVertex
    label: PositionLabel | None
    block_label: PositionLabel | None
    reason: str
    position: str = "?_?_?"
    mark: tuple[str, str] | None = None


def turned_label(label: PositionLabel, quarters: int) -> PositionLabel:
    """The label, given from a side that is `quarters` counter-clockwise (seen from above) of the
    block's front, as a label on the block itself.

    >>> turned_label(PositionLabel.FRONT_LEFT_TOP, 2).value
    'back_right_top'
    """
    corner, _, level = label.value.rpartition("_")
    return PositionLabel(f"{_RING[(_RING.index(corner) + quarters) % 4]}_{level}")


def neighbours_alike(regions: PlaneRegions, uv: FloatArray) -> frozenset[str]:
    """Which of the 8 neighbours (N, NE, E, ...) of a vertex lie on the object."""
    height, width = regions.labels.shape
    alike = set()
    for name, (du, dv) in zip(COMPASS, _STEPS, strict=True):
        # All neighbours at one distance, as on a circle round the vertex.
        reach = NEIGHBOUR_PX / np.hypot(du, dv)
        u, v = round(float(uv[0] + du * reach)), round(float(uv[1] + dv * reach))
        if 0 <= u < width and 0 <= v < height and regions.labels[v, u] > 0:
            alike.add(name)
    return frozenset(alike)


def rule_label(alike: frozenset[str]) -> PositionLabel | None:
    """The label by RULE 1 and its counterparts, from the neighbours on the object.

    >>> rule_label(frozenset({"S", "E", "SE"})).value
    'back_left_top'
    """
    return _RULES.get(alike)


def _edge_words(
    view: View,
    vertex: ImageVertex,
    lines: tuple[EdgeLine, ...],
    up: FloatArray,
    axes: tuple[FloatArray, FloatArray],
    side: BlockSide,
) -> set[str]:
    """The evidence of the edges at the vertex: which of front, back, left, right, top, bottom."""
    vanishing = view.camera.matrix @ (view.pose.rotation.T @ up)
    upwards = vanishing[:2] - vertex.uv * vanishing[2]
    upwards /= np.linalg.norm(upwards)
    words = set()
    for index in vertex.lines:
        line = lines[index]
        azimuth = edge_azimuth(view, line, up, axes)
        for far, forward in leaving(line, vertex.uv):
            way = (far - vertex.uv) / np.linalg.norm(far - vertex.uv)
            if abs(way @ upwards) >= np.cos(DIRECTION_WINDOW / 2):
                words.add("bottom" if way @ upwards > 0 else "top")
            elif azimuth is not None:
                outward = (azimuth if forward else azimuth + np.pi) - side.turn
                quarter = round(outward / QUARTER)
                if abs(outward - quarter * QUARTER) <= DIRECTION_WINDOW:
                    # An edge towards the front leaves a back vertex, one to the right a left one.
                    words.add(("back", "left", "front", "right")[(quarter - side.front) % 4])
    return words


def _decided(words: set[str], first: str, second: str, otherwise: str | None) -> str | None:
    """The one of two opposite words that was said, `otherwise` if none, None if both."""
    if first in words and second in words:
        return None
    if first in words:
        return first
    return second if second in words else otherwise


def _only(alike: frozenset[str], first: str, second: str) -> bool:
    return first in alike and second not in alike


def _label(
    words: set[str], alike: frozenset[str], rule: PositionLabel | None
) -> tuple[PositionLabel | None, str, str]:
    """The label that the evidence adds up to, and what decided; None with what is missing.

    And the position, with question marks for what is missing.
    """
    depth_rule, side_rule, level_rule = rule.value.split("_") if rule else (None, None, None)
    level_position = (
        "top" if _only(alike, "S", "N") else "bottom" if _only(alike, "N", "S") else level_rule
    )
    side_position = (
        "left" if _only(alike, "E", "W") else "right" if _only(alike, "W", "E") else side_rule
    )
    level = _decided(words, "top", "bottom", level_position)
    side = _decided(words, "left", "right", side_position)
    depth = _decided(words, "front", "back", depth_rule)
    if level == "bottom" and words & {"left", "right"} and not words & {"front", "back"}:
        depth = "front"  # the back's own bottom edge is hidden behind the block
    position = "_".join(word or "?" for word in (depth, side, level))
    for word, names in (
        (level, ("top", "bottom")),
        (side, ("left", "right")),
        (depth, ("front", "back")),
    ):
        if word is None:
            said = "both" if set(names) <= words else "neither"
            reason = f"the evidence says {said} of {names[0]} and {names[1]}"
            return None, reason, position
    label = PositionLabel(f"{depth}_{side}_{level}")
    sources = []
    if words & {str(level), str(side), str(depth)}:
        sources.append("edges")
    if rule is label:
        sources.append("8 neighbours")
    elif not {str(level), str(side), str(depth)} <= words:
        sources.append("position")
    return label, " and ".join(sources), position


def label_vertices(
    view: View,
    vertices: tuple[ImageVertex, ...],
    lines: tuple[EdgeLine, ...],
    regions: PlaneRegions,
    *,
    up: FloatArray,
    axes: tuple[FloatArray, FloatArray],
    side: BlockSide | None,
    quarters: int | None,
) -> tuple[LabelledVertex, ...]:
    """The vertices of one picture with their labels, none of which is given twice.

    `up` (3,) and `axes` are the plan's (module `upright`), `side` how the block stands to this
    view (None if unknown: then only the 8 neighbours count), `quarters` by how many quarter turns
    this view's side lies counter-clockwise of the first picture's (None if unknown).
    """
    labelled = []
    for vertex in vertices:
        alike = neighbours_alike(regions, vertex.uv)
        words = set() if side is None else _edge_words(view, vertex, lines, up, axes, side)
        labelled.append((vertex, *_label(words, alike, rule_label(alike))))
    given = [label for _, label, _, _ in labelled if label is not None]
    result = []
    for vertex, label, reason, position in labelled:
        if label is not None and given.count(label) > 1:
            repeated = f"more than one vertex is {label.value}"
            result.append(LabelledVertex(vertex, None, None, repeated, position))
            continue
        block = None if label is None or quarters is None else turned_label(label, quarters)
        result.append(LabelledVertex(vertex, label, block, reason, position))
    return tuple(result)
