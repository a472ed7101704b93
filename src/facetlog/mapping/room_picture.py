"""The map of a room as a picture.

Drawn: what is known of the floor, each thing's outline with the heading of its longer side, the
ellipse of two standard deviations of its place, its number and what it is, an arrow from where it
stood to where it stands if it was moved, the robot's ways, where it took views, and a scale.
"""

import math
from typing import TYPE_CHECKING

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.kb.explaining.verdict_text import NO_MODEL
from facetlog.mapping.floor_grid import Cell, FloorGrid
from facetlog.mapping.same_thing import MappedThing
from facetlog.plain_text import to_plain_marks
from facetlog.robot.collecting.map_picture import Box, placed

if TYPE_CHECKING:
    from facetlog.mapping.moved_thing import Moved
    from facetlog.mapping.room_map import RoomMap

Colour = tuple[int, int, int]

# Pixels of the longer side of the floor, of the margin, and of a line of the legend.
LONGER_PX, MARGIN_PX, LINE_PX, SIGN_PX = 1000, 60, 24, 30
# Narrower floors are drawn beside empty paper: the legend needs the room.
LEAST_PX = 560
ELLIPSE_SDS = 2.0
# Colours, blue-green-red.
PAPER, INK, GRID = (255, 255, 255), (50, 50, 50), (215, 215, 215)
FLOOR: dict[Cell, Colour] = {
    Cell.UNSEEN: (236, 236, 236),
    Cell.PASSED: (240, 226, 200),
    Cell.FREE: (205, 235, 205),
    Cell.OCCUPIED: (150, 150, 165),
}
KNOWN, UNNAMED, ELLIPSE = (40, 40, 190), (90, 90, 90), (200, 60, 160)
# Where a thing stood is paler than where it stands.
STOOD = (150, 150, 235)
WAYS: tuple[Colour, ...] = ((190, 120, 20), (20, 130, 200), (60, 150, 60), (170, 60, 140))
VIEW_PX, ARROW_PX, WORD, SMALL = 3, 12, 0.5, 0.42
FONT, SMOOTH = cv2.FONT_HERSHEY_SIMPLEX, cv2.LINE_AA
SAID = {
    Cell.FREE: "free floor",
    Cell.OCCUPIED: "occupied",
    Cell.PASSED: "only sonar passed",
    Cell.UNSEEN: "not seen",
}


class _Sheet:
    """The picture and the scale from places in the world to pixels; y is up."""

    def __init__(self, floor: FloorGrid, above_px: int) -> None:
        rows, columns = floor.cells.shape
        extent = max(rows, columns) * floor.side
        self.scale = LONGER_PX / extent
        width, height = (round(n * floor.side * self.scale) for n in (columns, rows))
        self.low, self.top_px = floor.low, above_px
        self.width, self.height = max(width, LEAST_PX) + 2 * MARGIN_PX, height
        shape = above_px + height + MARGIN_PX, self.width, 3
        self.image: NDArray[np.uint8] = np.full(shape, PAPER, np.uint8)
        colours = np.array([FLOOR[state] for state in Cell], np.uint8)
        cells = colours[floor.cells[::-1]]
        inner = cv2.resize(cells, (width, height), interpolation=cv2.INTER_NEAREST)
        self.image[above_px : above_px + height, MARGIN_PX : MARGIN_PX + width] = inner
        self.floor_px = width

    def at(self, x: float, y: float) -> tuple[int, int]:
        u = MARGIN_PX + (x - self.low[0]) * self.scale
        v = self.top_px + self.height - (y - self.low[1]) * self.scale
        return round(u), round(v)

    def pixels(self, places: NDArray[np.float64]) -> NDArray[np.int32]:
        return np.array([self.at(x, y) for x, y in places], np.int32).reshape(-1, 1, 2)

    def word(self, text: str, place: tuple[int, int], size: float, colour: Colour = INK) -> None:
        cv2.putText(self.image, text, place, FONT, size, colour, 1, SMOOTH)


def map_png(room: "RoomMap") -> bytes:
    """Return the map as PNG; x to the right, y up, in the colours that its legend names."""
    entries = _entries(room)
    across = LEAST_PX if room.floor.cells.shape[0] > room.floor.cells.shape[1] else LONGER_PX
    lines = _lines(entries, across)
    sheet = _Sheet(room.floor, LINE_PX * (lines[-1][0] + 2))
    _grid(sheet, room.floor)
    for k, way in enumerate(room.ways):
        if len(way) > 1:
            path = sheet.pixels(np.array([(p.x, p.y) for p in way]))
            cv2.polylines(sheet.image, [path], False, WAYS[k % len(WAYS)], 2, SMOOTH)
    for view in room.taken:
        cv2.circle(sheet.image, sheet.at(view.robot.x, view.robot.y), VIEW_PX, INK, -1, SMOOTH)
    for moved in room.moved:
        _moved(sheet, moved)
    for thing in room.things:
        _thing(sheet, thing)
    _words(sheet, room)
    for (line, left), (text, colour) in zip(lines, entries, strict=True):
        y = LINE_PX * (line + 1)
        x = MARGIN_PX + left
        cv2.rectangle(sheet.image, (x, y - 9), (x + SIGN_PX - 10, y + 2), colour, -1)
        cv2.rectangle(sheet.image, (x, y - 9), (x + SIGN_PX - 10, y + 2), GRID, 1)
        sheet.word(text, (x + SIGN_PX, y), WORD)
    _, data = cv2.imencode(".png", sheet.image)
    return data.tobytes()


def _entries(room: "RoomMap") -> list[tuple[str, Colour]]:
    """Return the legend: words, and the colour that they explain."""
    floor = room.floor
    areas = [(floor.area(state), SAID[state], FLOOR[state]) for state in SAID]
    found = [
        (f"{said} {area:.1f} m2" if said != SAID[Cell.UNSEEN] else said, colour)
        for area, said, colour in areas
        if area > 0.0
    ]
    things = [thing.model for thing in room.things]
    if any(things):
        found.append(("recognised", KNOWN))
    if not all(things):
        found.append((NO_MODEL, UNNAMED))
    if room.moved:
        found.append(("moved from here", STOOD))
    if things:
        found.append((f"{ELLIPSE_SDS:.0f} sd of the place", ELLIPSE))
    several = len(room.visits) > 1
    for k, name in enumerate(room.visits):
        found.append((f"way of {name}" if several else "way", WAYS[k % len(WAYS)]))
    if room.taken:
        found.append((f"{len(room.taken)} views", INK))
    return found


def _lines(entries: list[tuple[str, Colour]], across_px: int) -> list[tuple[int, int]]:
    """Return the line of each entry of the legend, and how far from the left it begins, pixels."""
    places = []
    line = left = 0
    for text, _ in entries:
        width = SIGN_PX + _size(text, WORD)[0] + SIGN_PX // 2
        if left and left + width > across_px:
            line, left = line + 1, 0
        places.append((line, left))
        left += width
    return places


def _grid(sheet: _Sheet, floor: FloorGrid) -> None:
    """Draw lines at every half metre (fewer on large floors), with coordinates at the rim."""
    (low_x, low_y), (high_x, high_y) = floor.low, floor.high
    step = 0.5 * max(1, math.ceil(max(high_x - low_x, high_y - low_y) / 6))
    bottom, left = sheet.top_px + sheet.height, MARGIN_PX
    for k in range(math.ceil(low_x / step), math.floor(high_x / step) + 1):
        u, _ = sheet.at(k * step, low_y)
        cv2.line(sheet.image, (u, sheet.top_px), (u, bottom), GRID, 1)
        text = f"{k * step:g}"
        sheet.word(text, (u - _size(text, SMALL)[0] // 2, bottom + 18), SMALL)
    for k in range(math.ceil(low_y / step), math.floor(high_y / step) + 1):
        _, v = sheet.at(low_x, k * step)
        cv2.line(sheet.image, (left, v), (left + sheet.floor_px, v), GRID, 1)
        text = f"{k * step:g}"
        sheet.word(text, (left - _size(text, SMALL)[0] - 8, v + 5), SMALL)
    sheet.word("metres", (left + sheet.floor_px - 50, bottom + 38), SMALL)


def _thing(sheet: _Sheet, thing: MappedThing) -> None:
    best = thing.best
    colour = KNOWN if thing.model else UNNAMED
    ring = shapely.get_coordinates(best.plan)
    cv2.polylines(sheet.image, [sheet.pixels(ring)], False, colour, 2, SMOOTH)
    x, y, heading = best.pose.tolist()
    half = best.lengths[0].value / 2
    tip = sheet.at(x + half * math.cos(heading), y + half * math.sin(heading))
    cv2.line(sheet.image, sheet.at(x, y), tip, colour, 1, SMOOTH)
    values, vectors = np.linalg.eigh(best.cov[:2, :2])
    axes = ELLIPSE_SDS * np.sqrt(np.maximum(values, 0.0)) * sheet.scale
    angle = -math.degrees(math.atan2(vectors[1, 1], vectors[0, 1]))
    size = max(round(float(axes[1])), 1), max(round(float(axes[0])), 1)
    cv2.ellipse(sheet.image, sheet.at(x, y), size, angle, 0, 360, ELLIPSE, 1, SMOOTH)


def _moved(sheet: _Sheet, moved: "Moved") -> None:
    before, now = moved.before.best, moved.now.best
    ring = shapely.get_coordinates(before.plan)
    cv2.polylines(sheet.image, [sheet.pixels(ring)], False, STOOD, 2, SMOOTH)
    # From rim to rim, where they are apart: names and ellipses are in the middles.
    middles = shapely.LineString([before.pose[:2], now.pose[:2]])
    between = middles.difference(before.plan.union(now.plan))
    if not isinstance(between, shapely.LineString) or between.is_empty:
        between = middles
    ends = [sheet.at(x, y) for x, y in between.coords]
    long = max(math.dist(ends[0], ends[-1]), 1.0)
    cv2.arrowedLine(sheet.image, ends[0], ends[-1], STOOD, 2, SMOOTH, tipLength=ARROW_PX / long)


def _words(sheet: _Sheet, room: "RoomMap") -> None:
    """Write each thing's label beside it, clear of the others and of things and views."""
    anchors: list[tuple[float, float]] = []
    texts: list[str] = []
    drawn: list[Box] = []
    drawn += [_box(sheet, moved.before) for moved in room.moved]
    for thing in room.things:
        drawn.append(box := _box(sheet, thing))
        anchors.append((box.left + box.width / 2, box.top))
        texts.append(to_plain_marks(thing.label))  # the font is ASCII
    for view in room.taken:
        u, v = sheet.at(view.robot.x, view.robot.y)
        drawn.append(Box(u - VIEW_PX, v - VIEW_PX, 2 * VIEW_PX, 2 * VIEW_PX))
    # The legend is above, and stays clear.
    drawn.append(Box(0, 0, sheet.width, sheet.top_px))
    height, width = sheet.image.shape[:2]
    boxes = placed(anchors, [_size(text, WORD) for text in texts], drawn, (width, height))
    for text, anchor, box in zip(texts, anchors, boxes, strict=True):
        near = (
            round(min(max(anchor[0], box.left), box.left + box.width)),
            round(min(max(anchor[1], box.top), box.top + box.height)),
        )
        if math.dist(near, anchor) > 2 * box.height:
            cv2.line(sheet.image, (round(anchor[0]), round(anchor[1])), near, UNNAMED, 1, SMOOTH)
        sheet.word(text, (round(box.left), round(box.top + box.height)), WORD)


def _box(sheet: _Sheet, thing: MappedThing) -> Box:
    """Return the box round the outline of a thing, pixels."""
    pixels = sheet.pixels(thing.best.outline).reshape(-1, 2)
    (left, top), (right, bottom) = pixels.min(axis=0).tolist(), pixels.max(axis=0).tolist()
    return Box(left, top, right - left, bottom - top)


def _size(text: str, size: float) -> tuple[int, int]:
    """Return width and height of words, pixels."""
    (width, height), _ = cv2.getTextSize(text, FONT, size, 1)
    return width, height
