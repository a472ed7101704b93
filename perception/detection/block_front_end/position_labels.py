"""Position labels of a block's vertices in one picture, and what they mean across pictures.

Section 5.3 of the paper labels vertices "back-left-top, back-right-top, ... depending on their
positions in the block", as the picture shows it: the front is the side that faces the camera
most. So front in pictures of set I is back in those of set III. The labels of tracks refer to the
side that faces the first picture.

A camera on a pan-tilt head without skew keeps the rows of its pictures level, so that the axes x of
all cameras lie in the ground plane (the plan). A block's level edges point in four directions of
it, a quarter turn apart.

Evidence, in this order: the plan directions of the edges that leave the vertex (a vertex with an
edge to the right is a left one, with one away from the camera a front one, with one downwards a
top one); RULE 1's test of the 8 neighbours and its counterparts; whether the object lies above,
below, left or right of the vertex. A vertex without enough evidence, or with contradicting
evidence, has no label.

"More than one vertex in an image has the same label [...] additional junction labeling scheme needs
to be adopted" (Waltz's): vertices without a label are marked by their junctions. A junction has the
same type in pictures that show the same side of the object; from another side it has another one.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Self

import numpy as np

from facetlog.perception.detection.block_front_end.edge_lines import EdgeLine
from facetlog.perception.detection.block_front_end.image_vertices import ImageVertex
from facetlog.perception.detection.block_front_end.plane_regions import PlaneRegions
from facetlog.perception.line_drawing import LineDrawing
from facetlog.perception.types import FloatArray, PositionLabel, View

QUARTER = np.pi / 2.0
# The cameras' x axes fix the ground plane if they spread more than this (second singular value
# over the first): some 6 degrees; below it the mean of the pictures' own upward axes is taken.
LEAST_SPREAD = 0.1
# Edges vote for the block's turn; the winning turn has this share of all level directions (by
# length) within TURN_WINDOW of it. Directions at random would give it 2 * 5 / 90 = .11.
LEAST_TURN_SHARE = 0.35
TURN_WINDOW = np.deg2rad(5.0)
TURN_STEPS = 180
# Below this sine an edge's plane of rays contains the upright: 3 degrees, an edge's own error.
UPRIGHT_SINE = 0.05
# Sine of the tilt off the ground below which an edge at the height of the eye has no azimuth.
LEAST_TILT = 0.05
# Without a known turn of the block its sides are distinguished by where the views stand, except
# within this angle of the corner between two sides.
SIDE_MARGIN = np.deg2rad(15.0)
# RULE 1 looks at the 8 nearest pixels of a picture without blur; a real edge is some 3 px wide,
# so the neighbours are taken this far from the vertex.
NEIGHBOUR_PX = 5
# An edge belongs to a direction of the plan, or to the upright, within this angle: it is where
# half the least slope change that makes a vertex (30 degrees) would fit another one as well.
DIRECTION_WINDOW = np.deg2rad(15.0)

# Steps (du, dv) to the 8 neighbours.
COMPASS = {
    "N": (0, -1),
    "NE": (1, -1),
    "E": (1, 0),
    "SE": (1, 1),
    "S": (0, 1),
    "SW": (-1, 1),
    "W": (-1, 0),
    "NW": (-1, -1),
}
# RULE 1, and its counterparts for the corners that a picture from in front and above shows.
RULES = {
    frozenset({"E", "SE", "S"}): PositionLabel.BACK_LEFT_TOP,
    frozenset({"W", "SW", "S"}): PositionLabel.BACK_RIGHT_TOP,
    frozenset({"NE", "E", "SE", "S"}): PositionLabel.FRONT_LEFT_TOP,
    frozenset({"NW", "W", "SW", "S"}): PositionLabel.FRONT_RIGHT_TOP,
    frozenset({"N", "NE", "E"}): PositionLabel.FRONT_LEFT_BOTTOM,
    frozenset({"N", "NW", "W"}): PositionLabel.FRONT_RIGHT_BOTTOM,
}
# The corners of the plan, counter-clockwise seen from above.
RING = ("front_left", "front_right", "back_right", "back_left")


@dataclass(frozen=True, eq=False, slots=True)
class Plan:
    """Axes (3,) of the ground plane, right x ahead = up, and the turn of the block in it.

    Azimuths are counter-clockwise from `right`, seen from above, in radians; `turn` is that of the
    block's level edges (0..pi/2), None if no turn stands out.
    """

    up: FloatArray
    right: FloatArray
    ahead: FloatArray
    turn: float | None = None

    @classmethod
    def of(
        cls,
        views: Sequence[View],
        lines: Sequence[Sequence[EdgeLine]],
        up: FloatArray | None = None,
    ) -> Self:
        """Return the plan of views with their edges; `up` (3,) is the world's if known."""
        upward = (
            estimate_upward_direction(views) if up is None else np.asarray(up, dtype=np.float64)
        )
        right = views[0].pose.rotation[:, 0]
        right = right - upward * (upward @ right)
        right = right / np.linalg.norm(right)
        plan = cls(upward, right, np.cross(upward, right))
        level = [
            (azimuth, line.length)
            for view, own in zip(views, lines, strict=True)
            for line in own
            if (azimuth := plan.measure_edge_azimuth(view, line)) is not None
        ]
        azimuths, lengths = np.array(level).reshape(-1, 2).T
        return cls(upward, right, plan.ahead, estimate_block_turn(azimuths, lengths))

    def azimuth(self, direction: FloatArray) -> float:
        """Return the azimuth of a direction (3,)."""
        return float(np.arctan2(direction @ self.ahead, direction @ self.right))

    def measure_edge_azimuth(self, view: View, line: EdgeLine) -> float | None:
        """Return the azimuth of a level edge from its start to its end; None if it can be upright.

        The rays through a line span a plane; the level direction in it is that plane's normal x up.
        """
        inverse = np.linalg.inv(view.camera.matrix)
        rays = np.array([inverse @ [*p, 1.0] for p in (line.start, line.end)])
        rays = rays @ view.pose.rotation.T
        normal = np.cross(rays[0], rays[1])
        normal /= np.linalg.norm(normal)
        level = np.cross(normal, self.up)
        # |level| is the sine of the plane's tilt off the ground: a level plane fixes nothing.
        if np.linalg.norm(level) < LEAST_TILT or abs(normal @ self.up) < UPRIGHT_SINE:
            return None
        level /= np.linalg.norm(level)
        # From start to end: the ray at the end lies towards the level direction.
        along = rays[1] / np.linalg.norm(rays[1]) - rays[0] / np.linalg.norm(rays[0])
        return self.azimuth(-level if along @ level < 0 else level)

    def measure_camera_azimuth(self, view: View, pixel: FloatArray) -> float | None:
        """Return the azimuth of the camera as seen from a pixel (2,); None straight above it."""
        ray = view.pose.rotation @ np.linalg.solve(view.camera.matrix, [*pixel, 1.0])
        level = -(ray - self.up * (self.up @ ray))
        if np.linalg.norm(level) <= 1e-6 * np.linalg.norm(ray):
            return None
        return self.azimuth(level)


@dataclass(frozen=True, slots=True)
class ShownSide:
    """The side of the block that faces a view.

    `front` is the azimuth of its outward normal, None where the block's turn is not known: then
    only the 8 neighbours count as evidence. `quarters` is by how many quarter turns it lies
    counter-clockwise of the first picture's side, None if unknown.
    """

    front: float | None = None
    quarters: int | None = None


@dataclass(frozen=True, eq=False, slots=True)
class LabelledVertex:
    """A 2-D vertex with its label as this picture shows the block, and the same on the block
    whose front faces the first picture.

    `position` is the known part of the label, as `front_?_top`, though others may have it as well.
    `mark` distinguishes a vertex without a label from the picture's others, and limits the vertices
    of other pictures that it may correspond to.
    """

    vertex: ImageVertex
    label: PositionLabel | None
    block_label: PositionLabel | None
    position: str = "?_?_?"
    mark: tuple[str, str] | None = None


def estimate_upward_direction(views: Sequence[View]) -> FloatArray:
    """Return the unit vector (3,) that is up in the pictures, for cameras without skew."""
    x_axes = np.array([view.pose.rotation[:, 0] for view in views])
    up_axes = -np.array([view.pose.rotation[:, 1] for view in views])
    mean_up = up_axes.sum(axis=0)
    _, spread, vt = np.linalg.svd(x_axes)
    level = len(spread) >= 2 and spread[1] >= LEAST_SPREAD * spread[0]
    up = vt[2] if level else mean_up - vt[0] * (vt[0] @ mean_up)
    if up @ mean_up < 0:
        up = -up
    return np.asarray(up / np.linalg.norm(up), dtype=np.float64)


def estimate_block_turn(azimuths: FloatArray, lengths: FloatArray) -> float | None:
    """Return the turn (radians, 0..pi/2) of the block's level edges; None if none stands out.

    Each edge votes by its length for its azimuth modulo a quarter turn.

    >>> directions = np.deg2rad([10, 101, -79, -171, 40])
    >>> round(float(np.rad2deg(estimate_block_turn(directions, np.ones(5)))))
    10
    """
    if not len(azimuths):
        return None
    candidates = np.linspace(0.0, QUARTER, TURN_STEPS, endpoint=False)
    off = (azimuths[None, :] - candidates[:, None] + QUARTER / 2) % QUARTER - QUARTER / 2
    votes = (lengths * np.maximum(0.0, 1.0 - np.abs(off) / TURN_WINDOW)).sum(axis=1)
    best = int(np.argmax(votes))
    near = np.abs(off[best]) <= TURN_WINDOW
    if lengths[near].sum() < LEAST_TURN_SHARE * lengths.sum():
        return None
    middle = float((lengths[near] * off[best][near]).sum() / lengths[near].sum())
    return float((candidates[best] + middle) % QUARTER)


def find_shown_sides(plan: Plan, azimuths: Sequence[float | None]) -> list[ShownSide]:
    """Return the side of the block that faces each view, by the azimuths of the cameras.

    An azimuth is None where the view shows no block.
    """
    first = next((azimuth for azimuth in azimuths if azimuth is not None), None)
    sides = []
    for azimuth in azimuths:
        side = ShownSide()
        if azimuth is not None and first is not None:
            if plan.turn is not None:
                quarter, began = (round((a - plan.turn) / QUARTER) for a in (azimuth, first))
                side = ShownSide(plan.turn + quarter * QUARTER, (quarter - began) % 4)
            else:
                around = (azimuth - first) / QUARTER
                if abs(around - round(around)) * QUARTER <= QUARTER / 2 - SIDE_MARGIN:
                    side = ShownSide(None, round(around) % 4)
        sides.append(side)
    return sides


def turn_label(label: PositionLabel, quarters: int) -> PositionLabel:
    """Return the label on the block itself of one given from another side.

    That side is `quarters` counter-clockwise (seen from above) of the block's front.

    >>> turn_label(PositionLabel.FRONT_LEFT_TOP, 2).value
    'back_right_top'
    """
    corner, _, level = label.value.rpartition("_")
    return PositionLabel(f"{RING[(RING.index(corner) + quarters) % 4]}_{level}")


def find_rule_label(alike: frozenset[str]) -> PositionLabel | None:
    """Return the label by RULE 1 and its counterparts, from the neighbours on the object.

    >>> find_rule_label(frozenset({"S", "E", "SE"})).value
    'back_left_top'
    """
    return RULES.get(alike)


def label_vertices(
    view: View,
    vertices: Sequence[ImageVertex],
    lines: Sequence[EdgeLine],
    regions: PlaneRegions,
    plan: Plan,
    side: ShownSide,
) -> tuple[LabelledVertex, ...]:
    """Label the vertices of one picture; none of the labels is given twice."""
    labelled = []
    for vertex in vertices:
        evidence = set()
        if side.front is not None:
            evidence = _read_edge_words(view, vertex, lines, plan, side.front)
        labelled.append(
            (vertex, *_combine(evidence, _find_neighbours_on_object(regions, vertex.uv)))
        )
    given = [label for _, label, _ in labelled if label is not None]
    result = []
    for vertex, found, position in labelled:
        label = None if found is None or given.count(found) > 1 else found
        block = None
        if label is not None and side.quarters is not None:
            block = turn_label(label, side.quarters)
        result.append(LabelledVertex(vertex, label, block, position))
    return tuple(result)


def _find_neighbours_on_object(regions: PlaneRegions, uv: FloatArray) -> frozenset[str]:
    # All neighbours at one distance, as on a circle round the vertex.
    height, width = regions.labels.shape
    alike = set()
    for name, step in COMPASS.items():
        u, v = (round(float(x)) for x in uv + np.array(step) * (NEIGHBOUR_PX / np.hypot(*step)))
        if 0 <= u < width and 0 <= v < height and regions.labels[v, u] > 0:
            alike.add(name)
    return frozenset(alike)


def _read_edge_words(
    view: View, vertex: ImageVertex, lines: Sequence[EdgeLine], plan: Plan, front: float
) -> set[str]:
    """Return which of front, back, left, right, top, bottom the edges at the vertex say."""
    vanishing = view.camera.matrix @ (view.pose.rotation.T @ plan.up)
    upwards = vanishing[:2] - vertex.uv * vanishing[2]
    upwards /= np.linalg.norm(upwards)
    words = set()
    for index in vertex.lines:
        line = lines[index]
        azimuth = plan.measure_edge_azimuth(view, line)
        for far, forward in line.leaving(vertex.uv):
            way = (far - vertex.uv) / np.linalg.norm(far - vertex.uv)
            if abs(way @ upwards) >= np.cos(DIRECTION_WINDOW / 2):
                words.add("bottom" if way @ upwards > 0 else "top")
            elif azimuth is not None:
                outward = (azimuth if forward else azimuth + np.pi) - front
                quarter = round(outward / QUARTER)
                if abs(outward - quarter * QUARTER) <= DIRECTION_WINDOW:
                    # An edge towards the front leaves a back vertex, one to the right a left one.
                    words.add(("back", "left", "front", "right")[quarter % 4])
    return words


def _combine(words: set[str], alike: frozenset[str]) -> tuple[PositionLabel | None, str]:
    """Return the label that the evidence adds up to, None if it does not, and the position."""
    rule = find_rule_label(alike)
    depth_rule, side_rule, level_rule = rule.value.split("_") if rule else (None, None, None)

    def decide(first: str, second: str, otherwise: str | None) -> str | None:
        said = words & {first, second}
        return otherwise if not said else None if len(said) == 2 else said.pop()

    def place(first: str, second: str, names: tuple[str, str], otherwise: str | None) -> str | None:
        # By the side of the vertex on which alone the object lies.
        if (first in alike) == (second in alike):
            return otherwise
        return names[0] if first in alike else names[1]

    level = decide("top", "bottom", place("S", "N", ("top", "bottom"), level_rule))
    side = decide("left", "right", place("E", "W", ("left", "right"), side_rule))
    depth = decide("front", "back", depth_rule)
    if level == "bottom" and words & {"left", "right"} and not words & {"front", "back"}:
        depth = "front"  # the back's own bottom edge is hidden behind the block
    position = "_".join(word or "?" for word in (depth, side, level))
    return None if "?" in position else PositionLabel(position), position


def draw_picture_lines(
    vertices: tuple[ImageVertex, ...], lines: tuple[EdgeLine, ...]
) -> tuple[LineDrawing, tuple[int, ...]]:
    """Return the drawing, whose first points are the vertices, and which edge each of its lines is
    of.

    A line's direction is that of its edge, as uncertain as this is. Where an edge goes on beyond
    its last vertex, it ends in a point of its own.
    """
    points = [vertex.uv for vertex in vertices]
    pieces: dict[frozenset[int], tuple[int, int, int]] = {}
    for number, line in enumerate(lines):
        on = [i for i, vertex in enumerate(vertices) if number in vertex.lines]
        if not on:
            continue
        on.sort(key=lambda i: float((vertices[i].uv - line.start) @ line.direction))
        if any(not forward for _, forward in line.leaving(vertices[on[0]].uv)):
            points.append(line.start)
            on.insert(0, len(points) - 1)
        if any(forward for _, forward in line.leaving(points[on[-1]])):
            points.append(line.end)
            on.append(len(points) - 1)
        for a, b in pairwise(on):
            pieces.setdefault(frozenset((a, b)), (a, b, number))
    found = np.array(list(pieces.values()), dtype=np.intp).reshape(-1, 3)
    along = np.array([lines[k].direction for k in found[:, 2]]).reshape(-1, 2)
    sds = np.sqrt([float(lines[k].cov[1, 1]) for k in found[:, 2]])
    # v runs down: counter-clockwise as one sees it
    angles = np.arctan2(-along[:, 1], along[:, 0])
    drawing = LineDrawing(np.array(points).reshape(-1, 2), found[:, :2], angles, sds)
    return drawing, tuple(found[:, 2].tolist())


def mark_junctions(
    labelled: tuple[LabelledVertex, ...], lines: tuple[EdgeLine, ...], quarters: int | None
) -> tuple[LabelledVertex, ...]:
    """Return the vertices of one picture; those without a label get a mark that no other one has.

    `quarters` says which side the picture shows: marks of one side can be compared.
    """
    if quarters is None or all(v.block_label is not None for v in labelled):
        return labelled
    drawing, _ = draw_picture_lines(tuple(v.vertex for v in labelled), lines)
    kinds = [
        None
        if vertex.block_label is not None or rays is None
        else (f"{vertex.position}@{quarters}", rays.type.value)
        for vertex, rays in zip(labelled, drawing.rays, strict=False)
    ]
    count = Counter(kinds)
    return tuple(
        replace(vertex, mark=kind if count[kind] == 1 else None)
        for vertex, kind in zip(labelled, kinds, strict=True)
    )
