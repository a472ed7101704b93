"""A map of a collection as a picture: what the camera saw, path, poses and their uncertainty.

Drawn: the floor that pictures show, darker where more of them do, each view's line of sight to
where it meets the floor, the path driven, where the robot stood for each view (a circle of its size
with its heading), ellipses of two standard deviations, the keep-out circles, the tour's target or
what was recognised with its outlines, a scale and a legend of all that.
Lines end with the map, so that none crosses the words about it.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.types import Camera, FloatArray, Pose
from facetlog.robot.camera.optics import Optics
from facetlog.robot.collecting.record import Taken, write_file
from facetlog.robot.collecting.route import Circle, Point
from facetlog.robot.pose2 import Pose2

# Places along each side of the picture at which it is asked where it shows the floor.
PLACES = 65


def find_floor_in_view(pose: Pose, camera: Camera, far: float) -> FloatArray:
    """Return the outline (n, 2) on the floor (z = 0) of what a picture shows of it up to `far`
    metres.

    Empty if it shows none of it so near. What stands on the floor is not looked at, and no lens.
    """
    heights = np.linspace(camera.height - 0.5, -0.5, PLACES)
    left = _intersect_floor(pose, camera, np.full(PLACES, -0.5), heights, far)
    right = _intersect_floor(pose, camera, np.full(PLACES, camera.width - 0.5), heights, far)
    return np.concatenate([left, right[::-1]])


def looked_at(pose: Pose, camera: Camera, far: float) -> FloatArray:
    """Return where (2,) the line of sight of the picture's middle meets the floor, or is at
    `far`.
    """
    u, v = (camera.width - 1) / 2, (camera.height - 1) / 2
    found = _intersect_floor(pose, camera, np.array([u]), np.array([v]), far)
    if len(found):
        return np.asarray(found[0])
    ahead = pose.rotation[:2, 2]
    return np.asarray(pose.centre[:2] + far * ahead / max(float(np.hypot(*ahead)), 1e-9))


def _intersect_floor(
    pose: Pose, camera: Camera, u: FloatArray, v: FloatArray, far: float
) -> FloatArray:
    """Return where (k, 2) the rays of pixels meet the floor no farther than that, of those that
    do.
    """
    ahead = np.ones(len(u))
    rays = np.column_stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, ahead])
    directions = rays @ pose.rotation.T
    down = directions[:, 2] < 0
    # c + t d with z = 0
    times = pose.centre[2] / -directions[down, 2]
    places = pose.centre[:2] + times[:, None] * directions[down, :2]
    near = np.hypot(*(places - pose.centre[:2]).T) <= far
    return np.asarray(places[near])


# Pixels from a label's anchor to its middle, from near to far, and the directions that are tried.
DISTANCES = (16, 24, 34, 46, 60, 80, 105, 135)
DIRECTIONS = 16
GAP = 2  # pixels between two labels


@dataclass(frozen=True, slots=True)
class Box:
    """A rectangle of pixels: its upper left corner, width and height."""

    left: float
    top: float
    width: float
    height: float

    def shared(self, other: "Box") -> float:
        """Return the area that both have, a gap about each included."""
        width = min(self.left + self.width, other.left + other.width) - max(self.left, other.left)
        height = min(self.top + self.height, other.top + other.height) - max(self.top, other.top)
        return max(width + GAP, 0.0) * max(height + GAP, 0.0)

    def outside(self, width: float, height: float) -> float:
        """Return how many pixels it is beyond a picture's border."""
        right, bottom = self.left + self.width - width, self.top + self.height - height
        return max(-self.left, 0.0) + max(-self.top, 0.0) + max(right, 0.0) + max(bottom, 0.0)


def placed(
    anchors: Sequence[tuple[float, float]],
    sizes: Sequence[tuple[float, float]],
    drawn: Iterable[Box],
    picture: tuple[float, float],
) -> list[Box]:
    """Return a box of each size near its anchor, clear of what is `drawn` and of the boxes before
    it.

    Where no place near it is clear, the one that covers least.
    """
    taken = list(drawn)
    boxes = []
    for anchor, size in zip(anchors, sizes, strict=True):
        best, least = None, math.inf
        for box in _candidates(anchor, size):
            cost = box.outside(*picture) * size[0] * size[1] + sum(
                box.shared(other) for other in taken
            )
            if cost < least:
                best, least = box, cost
            if cost == 0:
                break
        assert best is not None  # noqa: S101 - there are candidates, and each has a finite cost
        boxes.append(best)
        taken.append(best)
    return boxes


def _candidates(anchor: tuple[float, float], size: tuple[float, float]) -> Iterable[Box]:
    (x, y), (width, height) = anchor, size
    for distance in DISTANCES:
        for k in range(DIRECTIONS):
            # First up and to the right, where a number is looked for.
            angle = math.pi / 4 + 2 * math.pi * k / DIRECTIONS
            dx, dy = math.cos(angle), -math.sin(angle)
            # Long words keep off by half their length where they lie beside.
            middle_x = x + dx * (distance + width / 2 - height / 2)
            middle_y = y + dy * distance
            yield Box(middle_x - width / 2, middle_y - height / 2, width, height)


MAP_FILE = "map.png"

Pixel = tuple[int, int]
Entry = tuple[str, tuple[int, int, int], int]
"""Of the legend: words, and the colour and sign of what they name."""

SIZE_PX = 1200
MARGIN_PX = 70
# What is drawn reaches this far beyond the outermost place, metres.
BORDER = 0.35
ELLIPSE_SDS = 2.0
# The share of the colour that the floor has where most pictures show it.
STRONGEST = 0.75
# Colours, blue-green-red.
PAPER, GRID, INK = (255, 255, 255), (228, 228, 228), (60, 60, 60)
WAY, ROBOT, SEEN, SIGHT = (190, 120, 20), (60, 60, 60), (120, 190, 120), (90, 160, 90)
FOUND = (30, 30, 190)
CLOSED, TARGET, ELLIPSE, MISSED = (150, 150, 240), (40, 40, 210), (200, 60, 160), (170, 170, 170)
RIM = (200, 200, 200)
# Pixels of the dot where the robot stood, and the size of words beside what they name.
DOT_PX, WORD = 4, 0.5
# The share of an arrow that its head takes.
TIP = 0.4
# Pixels of a line of the legend, and of a coloured sign in it.
LINE_PX, SIGN_PX = 22, 32
# Signs of the legend that are no marker of OpenCV: a ring, and a line.
RING, STROKE = -1, -2
FLOOR_IN = "floor in up to {} pictures"
FONT, SMOOTH = cv2.FONT_HERSHEY_SIMPLEX, cv2.LINE_AA


@dataclass(frozen=True, eq=False, slots=True)
class Floor:
    """The floor: keep-out circles `closed` to the whole robot, the target, the robot's radius.

    `missed` are places (x, y) of the tour's views that were not taken.
    """

    closed: tuple[Circle, ...]
    target: FloatArray | None
    robot_radius: float
    missed: tuple[Point, ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class Found:
    """A recognised object: a line of words, and the outlines (n, 3) of its faces."""

    said: str
    outlines: tuple[FloatArray, ...]


class _Canvas:
    """The picture and the scale from places in the world to pixels; y is up."""

    def __init__(self, places: FloatArray, legend: Sequence[Entry]) -> None:
        low, high = places.min(axis=0) - BORDER, places.max(axis=0) + BORDER
        self.scale = (SIZE_PX - 2 * MARGIN_PX) / float(max(high - low))
        width, height = ((high - low) * self.scale + 2 * MARGIN_PX).astype(int).tolist()
        self.legend = _arrange_in_rows(legend, width)
        self.above = max(MARGIN_PX, self.legend[-1][1] + LINE_PX)
        """Pixels of the margin above, which holds the legend."""
        height += self.above - MARGIN_PX
        self.low, self.high = low, high
        self.reach = float(np.hypot(*(high - low)))
        """Metres within which everything on the map is."""
        self.image: NDArray[np.uint8] = np.full((height, width, 3), PAPER, dtype=np.uint8)

    def at(self, x: float, y: float) -> tuple[int, int]:
        u = MARGIN_PX + (x - self.low[0]) * self.scale
        v = self.image.shape[0] - MARGIN_PX - (y - self.low[1]) * self.scale
        return round(float(u)), round(float(v))

    @property
    def inner(self) -> NDArray[np.uint8]:
        """The map without its margins."""
        return self.image[self.above : -MARGIN_PX, MARGIN_PX:-MARGIN_PX]

    def clip(self) -> None:
        """Clear what reaches into the margins."""
        kept = self.inner.copy()
        self.image[:] = PAPER
        self.inner[:] = kept

    def line(self, points: Sequence[Point], colour: tuple[int, int, int], thick: int) -> None:
        pixels = np.array([self.at(*p) for p in points], dtype=np.int32).reshape(-1, 1, 2)
        cv2.polylines(self.image, [pixels], False, colour, thick, SMOOTH)

    def word(self, text: str, place: tuple[int, int], size: float = 0.45) -> None:
        cv2.putText(self.image, text, place, FONT, size, INK, 1, SMOOTH)


@dataclass(frozen=True, eq=False, slots=True)
class Mapped:
    """The contents of the map of a collection."""

    path: tuple[Pose2, ...]
    taken: tuple[Taken, ...]
    floor: Floor
    optics: Optics

    def draw(self, folder: Path, found: Sequence[Found] = ()) -> None:
        """Draw it, with what was recognised; InputError where it cannot be written."""
        data = map_png(self.path, self.taken, self.floor, self.optics, found)
        write_file(folder / MAP_FILE, data)


def map_png(
    path: Sequence[Pose2],
    taken: Sequence[Taken],
    floor: Floor,
    optics: Optics,
    found: Sequence[Found] = (),
) -> bytes:
    """Return the map as PNG; `path` are the robot's places in the world, in order."""
    legend = _entries(len(taken), floor, found=bool(found))
    canvas = _Canvas(_places(path, taken, floor, found), legend)
    most = _colour_seen_floor(canvas, taken, optics)
    _draw_grid(canvas)
    _draw_circles(canvas, floor)
    for view in taken:
        place = (float(view.pose.centre[0]), float(view.pose.centre[1]))
        x, y = looked_at(view.pose, optics.camera, canvas.reach).tolist()
        canvas.line([place, (x, y)], SIGHT, 1)
    for each in found:
        for loop in each.outlines:
            canvas.line([(x, y) for x, y, _ in (*loop.tolist(), loop[0].tolist())], FOUND, 2)
    if len(path) > 1:
        canvas.line([(p.x, p.y) for p in path], WAY, 2)
    for x, y in floor.missed:
        cv2.drawMarker(
            canvas.image, canvas.at(x, y), MISSED, cv2.MARKER_TILTED_CROSS, 14, 2, SMOOTH
        )
    for view in taken:
        _draw_ellipse(canvas, view)
    drawn = [box for view in taken for box in _robot(canvas, view, floor.robot_radius)]
    canvas.clip()
    _draw_coordinates(canvas)
    _draw_words(canvas, taken, found, drawn)
    _draw_legend(canvas, most)
    _, data = cv2.imencode(".png", canvas.image)
    return data.tobytes()


def _places(
    path: Sequence[Pose2], taken: Sequence[Taken], floor: Floor, found: Sequence[Found]
) -> FloatArray:
    """Return points (n, 2) that must be on the map; the origin if there is nothing."""
    places = [(p.x, p.y) for p in path] + [(v.robot.x, v.robot.y) for v in taken]
    places += floor.missed
    places += [(x, y) for each in found for loop in each.outlines for x, y, _ in loop.tolist()]
    places += [(c.x + s * c.radius, c.y + s * c.radius) for c in floor.closed for s in (-1, 1)]
    if floor.target is not None:
        places.append((float(floor.target[0]), float(floor.target[1])))
    return np.array(places or [(0.0, 0.0)], dtype=np.float64)


def _list_grid_lines(canvas: _Canvas) -> Iterator[tuple[int, float, Pixel, Pixel]]:
    """Iterate over lines at every half metre (of large floors fewer): axis, coordinate, and both
    ends."""
    span = float(max(canvas.high - canvas.low))
    step = 0.5 * max(1, math.ceil(span / 8))
    for axis in (0, 1):
        first = math.ceil(canvas.low[axis] / step)
        for k in range(first, math.floor(canvas.high[axis] / step) + 1):
            low, high = canvas.low.tolist(), canvas.high.tolist()
            low[axis] = high[axis] = k * step
            yield axis, k * step, canvas.at(*low), canvas.at(*high)


def _draw_grid(canvas: _Canvas) -> None:
    for _, _, a, b in _list_grid_lines(canvas):
        cv2.line(canvas.image, a, b, GRID, 1, SMOOTH)


def _draw_coordinates(canvas: _Canvas) -> None:
    """Write the coordinates of the grid's lines at the rim."""
    for axis, value, (u, v), _ in _list_grid_lines(canvas):
        canvas.word(f"{value:g}", (u - 10, v + 20) if axis == 0 else (u - 45, v + 5))
    corner = canvas.at(*canvas.high.tolist())
    canvas.word("metres", (corner[0] - 60, canvas.image.shape[0] - 15))


def _draw_circles(canvas: _Canvas, floor: Floor) -> None:
    for circle in floor.closed:
        radius = round(circle.radius * canvas.scale)
        cv2.circle(canvas.image, canvas.at(circle.x, circle.y), radius, CLOSED, 3, SMOOTH)
    if floor.target is not None:
        place = canvas.at(float(floor.target[0]), float(floor.target[1]))
        cv2.drawMarker(canvas.image, place, TARGET, cv2.MARKER_CROSS, 22, 2, SMOOTH)


def _colour_seen_floor(canvas: _Canvas, taken: Sequence[Taken], optics: Optics) -> int:
    """Colour the floor by how many pictures show it; the largest number of them."""
    count = np.zeros(canvas.image.shape[:2], dtype=np.int32)
    for view in taken:
        outline = find_floor_in_view(view.pose, optics.camera, canvas.reach)
        if len(outline):
            shown = np.zeros(count.shape, dtype=np.uint8)
            pixels = np.array([canvas.at(x, y) for x, y in outline.tolist()], dtype=np.int32)
            cv2.fillPoly(shown, [pixels.reshape(-1, 1, 2)], 1)
            count += shown
    most = int(count.max(initial=0))
    if most:
        share = (STRONGEST * count / most)[:, :, None]
        mixed = (1 - share) * np.array(PAPER) + share * np.array(SEEN)
        canvas.image[:] = np.round(mixed).astype(np.uint8)
        canvas.clip()
    return most


def _robot(canvas: _Canvas, view: Taken, radius: float) -> list[Box]:
    """Draw the robot with its heading; return the boxes that words keep clear of."""
    place = canvas.at(view.robot.x, view.robot.y)
    cv2.circle(canvas.image, place, round(radius * canvas.scale), RIM, 1, SMOOTH)
    cv2.circle(canvas.image, place, DOT_PX, ROBOT, -1, SMOOTH)
    nose = radius / 2
    tip = canvas.at(
        view.robot.x + nose * math.cos(view.robot.heading),
        view.robot.y + nose * math.sin(view.robot.heading),
    )
    cv2.arrowedLine(canvas.image, place, tip, ROBOT, 2, SMOOTH, tipLength=TIP)
    # As OpenCV draws it: from its tip two strokes lead back at 45° to the shaft.
    back = TIP * (np.array(place, dtype=np.float64) - tip)
    strokes = [tip + back @ (np.array([[1, s], [-s, 1]]) * math.sqrt(0.5)) for s in (-1, 1)]
    return [box for end in (np.array(place), *strokes) for box in _along(np.array(tip), end)]


def _along(one: FloatArray, other: FloatArray) -> list[Box]:
    """Return boxes of a dot's size that cover a stroke between two places, pixels."""
    count = math.ceil(math.dist(one, other) / (2 * DOT_PX)) + 1
    return [
        Box(x - DOT_PX, y - DOT_PX, 2 * DOT_PX, 2 * DOT_PX)
        for x, y in np.linspace(one, other, count).tolist()
    ]


def _draw_words(
    canvas: _Canvas, taken: Sequence[Taken], found: Sequence[Found], drawn: list[Box]
) -> None:
    """Draw the views' numbers and what was recognised, clear of one another, with lines to them."""
    anchors = [canvas.at(view.robot.x, view.robot.y) for view in taken]
    texts = [str(view.number) for view in taken]
    for each in found:
        corners = np.array([canvas.at(x, y) for loop in each.outlines for x, y, _ in loop])
        low, high = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
        drawn.append(Box(low[0], low[1], high[0] - low[0], high[1] - low[1]))
        anchors.append((round((low[0] + high[0]) / 2), low[1]))
        texts.append(each.said)
    sizes = [_size(text) for text in texts]
    height, width = canvas.image.shape[:2]
    boxes = placed(anchors, sizes, drawn, (width, height))
    for text, anchor, box in zip(texts, anchors, boxes, strict=True):
        near = (
            round(min(max(anchor[0], box.left), box.left + box.width)),
            round(min(max(anchor[1], box.top), box.top + box.height)),
        )
        if math.dist(near, anchor) > 2 * box.height:
            cv2.line(canvas.image, anchor, near, MISSED, 1, SMOOTH)
        canvas.word(text, (round(box.left), round(box.top + box.height)), WORD)


def _draw_ellipse(canvas: _Canvas, view: Taken) -> None:
    """Draw two standard deviations of the pinhole's place over the floor."""
    values, vectors = np.linalg.eigh(view.covariance[:2, :2])
    axes = ELLIPSE_SDS * np.sqrt(np.maximum(values, 0.0)) * canvas.scale
    # The picture's y axis points down, so angles turn the other way.
    angle = -math.degrees(math.atan2(vectors[1, 1], vectors[0, 1]))
    place = canvas.at(float(view.pose.centre[0]), float(view.pose.centre[1]))
    size = (max(round(float(axes[1])), 1), max(round(float(axes[0])), 1))
    cv2.ellipse(canvas.image, place, size, angle, 0, 360, ELLIPSE, 1, SMOOTH)


def _size(text: str) -> tuple[int, int]:
    """Return the width and height of words on the map, pixels."""
    (width, height), _ = cv2.getTextSize(text, FONT, WORD, 1)
    return width, height


def _entries(taken: int, floor: Floor, *, found: bool) -> list[Entry]:
    """Return the legend: words, and the colour and sign that they explain."""
    entries = [
        (f"{taken} view{'s' * (taken != 1)}", ROBOT, STROKE),
        ("the robot", RIM, RING),
        ("way by odometry", WAY, STROKE),
        ("line of sight to the floor", SIGHT, STROKE),
        (f"{ELLIPSE_SDS:.0f} sd of the pinhole", ELLIPSE, STROKE),
    ]
    if found:
        entries.append(("recognised", FOUND, STROKE))
    if floor.target is not None:
        entries.append(("looked at", TARGET, cv2.MARKER_CROSS))
    if floor.closed:
        entries.append(("keep-out", CLOSED, RING))
    if floor.missed:
        entries.append((f"{len(floor.missed)} not taken", MISSED, cv2.MARKER_TILTED_CROSS))
    # How many they are is known when the floor is drawn; they are no more than there are views.
    entries.append((FLOOR_IN.format(taken), SEEN, STROKE))
    return entries


def _arrange_in_rows(entries: Sequence[Entry], width: int) -> list[tuple[int, int, Entry]]:
    """Return where each entry begins on a picture of this width, in rows from the top."""
    x, y = MARGIN_PX, LINE_PX
    rows = []
    for entry in entries:
        wide = SIGN_PX + _size(entry[0])[0] + SIGN_PX
        if x > MARGIN_PX and x + wide > width:
            x, y = MARGIN_PX, y + LINE_PX
        rows.append((x, y, entry))
        x += wide
    return rows


def _draw_legend(canvas: _Canvas, most: int) -> None:
    for x, y, (text, colour, sign) in canvas.legend:
        if colour == SEEN:
            if not most:
                continue
            text = FLOOR_IN.format(most)
        middle = (x + (SIGN_PX - 8) // 2, y)
        if sign == STROKE:
            cv2.line(canvas.image, (x, y), (x + SIGN_PX - 8, y), colour, 3, SMOOTH)
        elif sign == RING:
            cv2.circle(canvas.image, middle, LINE_PX // 2 - 3, colour, 2, SMOOTH)
        else:
            cv2.drawMarker(canvas.image, middle, colour, sign, LINE_PX - 8, 2, SMOOTH)
        canvas.word(text, (x + SIGN_PX, y + 5), WORD)
