"""A map of a collection as a picture: floor, path, poses and their uncertainty.

Drawn: the path driven, where the robot stood for each view (a circle of its size with its heading),
the camera's field of view over the floor, ellipses of two standard deviations, the keep-out
circles, the tour's target, and a scale.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.types import FloatArray
from facetlog.robot.collecting.optics import Optics
from facetlog.robot.collecting.record import Taken
from facetlog.robot.collecting.route import Circle, Point
from facetlog.robot.pose2 import Pose2

__all__ = ["Floor", "map_png"]

SIZE_PX = 1200
MARGIN_PX = 70
# What is drawn reaches this far beyond the outermost place, metres.
BORDER = 0.35
CONE = 0.45
ELLIPSE_SDS = 2.0
# Colours, blue-green-red.
PAPER, GRID, INK = (255, 255, 255), (228, 228, 228), (60, 60, 60)
WAY, ROBOT, CONE_COLOUR = (190, 120, 20), (60, 60, 60), (150, 205, 150)
CLOSED, TARGET, ELLIPSE, MISSED = (200, 200, 245), (40, 40, 210), (200, 60, 160), (170, 170, 170)
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


class _Canvas:
    """The picture and the scale from places in the world to pixels; y is up."""

    def __init__(self, places: FloatArray) -> None:
        low, high = places.min(axis=0) - BORDER, places.max(axis=0) + BORDER
        self.scale = (SIZE_PX - 2 * MARGIN_PX) / float(max(high - low))
        width, height = ((high - low) * self.scale + 2 * MARGIN_PX).astype(int).tolist()
        self.low, self.high = low, high
        self.image: NDArray[np.uint8] = np.full((height, width, 3), PAPER, dtype=np.uint8)

    def at(self, x: float, y: float) -> tuple[int, int]:
        u = MARGIN_PX + (x - self.low[0]) * self.scale
        v = self.image.shape[0] - MARGIN_PX - (y - self.low[1]) * self.scale
        return round(float(u)), round(float(v))

    def line(self, points: Sequence[Point], colour: tuple[int, int, int], thick: int) -> None:
        pixels = np.array([self.at(*p) for p in points], dtype=np.int32).reshape(-1, 1, 2)
        cv2.polylines(self.image, [pixels], False, colour, thick, SMOOTH)

    def word(self, text: str, place: tuple[int, int], size: float = 0.45) -> None:
        cv2.putText(self.image, text, place, FONT, size, INK, 1, SMOOTH)


def map_png(path: Sequence[Pose2], taken: Sequence[Taken], floor: Floor, optics: Optics) -> bytes:
    """The map as PNG; `path` are the robot's places in the world, in order."""
    canvas = _Canvas(_places(path, taken, floor))
    _grid(canvas)
    _circles(canvas, floor)
    for view in taken:
        _cone(canvas, view, optics)
    if len(path) > 1:
        canvas.line([(p.x, p.y) for p in path], WAY, 2)
    for x, y in floor.missed:
        cv2.drawMarker(
            canvas.image, canvas.at(x, y), MISSED, cv2.MARKER_TILTED_CROSS, 14, 2, SMOOTH
        )
    for view in taken:
        _robot(canvas, view, floor.robot_radius)
    for view in taken:
        _ellipse(canvas, view)
    _legend(canvas, len(taken), len(floor.missed))
    _, data = cv2.imencode(".png", canvas.image)
    return data.tobytes()


def _places(path: Sequence[Pose2], taken: Sequence[Taken], floor: Floor) -> FloatArray:
    """Points (n, 2) that must be on the map; the origin if there is nothing."""
    places = [(p.x, p.y) for p in path] + [(v.robot.x, v.robot.y) for v in taken]
    places += floor.missed
    places += [(c.x + s * c.radius, c.y + s * c.radius) for c in floor.closed for s in (-1, 1)]
    if floor.target is not None:
        places.append((float(floor.target[0]), float(floor.target[1])))
    return np.array(places or [(0.0, 0.0)], dtype=np.float64)


def _grid(canvas: _Canvas) -> None:
    """Lines at every half metre (of large floors fewer), their coordinates at the rim."""
    span = float(max(canvas.high - canvas.low))
    step = 0.5 * max(1, math.ceil(span / 8))
    for axis in (0, 1):
        first = math.ceil(canvas.low[axis] / step)
        for k in range(first, math.floor(canvas.high[axis] / step) + 1):
            low, high = canvas.low.tolist(), canvas.high.tolist()
            low[axis] = high[axis] = k * step
            a, b = canvas.at(*low), canvas.at(*high)
            cv2.line(canvas.image, a, b, GRID, 1, SMOOTH)
            text = f"{k * step:g}"
            place = (a[0] - 10, a[1] + 20) if axis == 0 else (a[0] - 45, a[1] + 5)
            canvas.word(text, place)
    corner = canvas.at(*canvas.high.tolist())
    canvas.word("metres", (corner[0] - 60, canvas.image.shape[0] - 15))


def _circles(canvas: _Canvas, floor: Floor) -> None:
    for circle in floor.closed:
        radius = round(circle.radius * canvas.scale)
        cv2.circle(canvas.image, canvas.at(circle.x, circle.y), radius, CLOSED, -1, SMOOTH)
    if floor.target is not None:
        place = canvas.at(float(floor.target[0]), float(floor.target[1]))
        cv2.drawMarker(canvas.image, place, TARGET, cv2.MARKER_CROSS, 22, 2, SMOOTH)


def _cone(canvas: _Canvas, view: Taken, optics: Optics) -> None:
    """The camera's horizontal field of view, over the floor."""
    half = math.atan(optics.camera.width / 2 / optics.camera.fx)
    ahead = view.pose.rotation[:, 2]
    middle = math.atan2(ahead[1], ahead[0])
    x, y = float(view.pose.centre[0]), float(view.pose.centre[1])
    rim = [
        (x + CONE * math.cos(middle + side), y + CONE * math.sin(middle + side))
        for side in (half, 0.0, -half)
    ]
    canvas.line([(x, y), rim[0], rim[1], rim[2], (x, y)], CONE_COLOUR, 1)


def _robot(canvas: _Canvas, view: Taken, radius: float) -> None:
    place = canvas.at(view.robot.x, view.robot.y)
    cv2.circle(canvas.image, place, round(radius * canvas.scale), GRID, 1, SMOOTH)
    cv2.circle(canvas.image, place, 4, ROBOT, -1, SMOOTH)
    nose = radius / 2
    tip = (
        view.robot.x + nose * math.cos(view.robot.heading),
        view.robot.y + nose * math.sin(view.robot.heading),
    )
    cv2.arrowedLine(canvas.image, place, canvas.at(*tip), ROBOT, 2, SMOOTH, tipLength=0.4)
    canvas.word(str(view.number), (place[0] + 8, place[1] - 8), 0.5)


def _ellipse(canvas: _Canvas, view: Taken) -> None:
    """Two standard deviations of the pinhole's place over the floor."""
    values, vectors = np.linalg.eigh(view.covariance[:2, :2])
    axes = ELLIPSE_SDS * np.sqrt(np.maximum(values, 0.0)) * canvas.scale
    # The picture's y axis points down, so angles turn the other way.
    angle = -math.degrees(math.atan2(vectors[1, 1], vectors[0, 1]))
    place = canvas.at(float(view.pose.centre[0]), float(view.pose.centre[1]))
    size = (max(round(float(axes[1])), 1), max(round(float(axes[0])), 1))
    cv2.ellipse(canvas.image, place, size, angle, 0, 360, ELLIPSE, 2, SMOOTH)


def _legend(canvas: _Canvas, taken: int, missed: int) -> None:
    texts = [f"{taken} views", "way by odometry", "2 sd of the pinhole"]
    colours = [ROBOT, WAY, ELLIPSE]
    if missed:
        texts.append(f"{missed} not taken")
        colours.append(MISSED)
    x = MARGIN_PX
    for text, colour in zip(texts, colours, strict=True):
        cv2.line(canvas.image, (x, 28), (x + 24, 28), colour, 3, SMOOTH)
        canvas.word(text, (x + 32, 33), 0.5)
        x += 60 + 9 * len(text)
