"""A small shaded picture of a scene, faces and curved surface, from outside and above."""

import math
from collections.abc import Iterator, Mapping, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.scene import Face, Patch, Scene
from facetlog.perception.surfaces.drawing.lettering import (
    ColourImage,
    measure_text,
    plain,
    wrap,
    write,
)
from facetlog.perception.types import FloatArray, Image

SIZE_PX = 240
SUPERSAMPLED = 2  # drawn so much larger, for smooth outlines
MARGIN = 0.06  # of the picture's side

# From where it is looked at: a little above, over a corner, as catalogues show furniture.
ELEVATION, AZIMUTH = math.radians(24.0), math.radians(36.0)

LIGHT_SHARE, AMBIENT_SHARE = 0.6, 0.4
FACE_SATURATION, PATCH_SATURATION = 70, 0
BRIGHTNESS = 235
HUE_STEP = 0.6180339887  # golden section of the circle: neighbours in number differ
GREY = -1  # the tint of what has none
OUTLINE = (40, 40, 40)
LETTERS_PX, LINE_PX = 10.0, 17.0  # of captions: how high capitals are, and how far apart lines
# A point stands for a disc of its area; with so much more there are no gaps between discs.
DISC_FILL = 1.6
LARGEST_DISC = 0.08  # of the picture's side

Levels = NDArray[np.int32]


def thumbnail(
    scene: Scene, size_px: int = SIZE_PX, tints: Mapping[int, int] | None = None
) -> bytes:
    """Return the scene as a PNG of `size_px` a side, transparent where there is nothing.

    Faces are tinted and outlined, surface that is not flat is grey. Seen along parallel rays from
    above where up is known, else with the third axis upwards. `tints` are numbers of tints by the
    faces' indices: faces of one number look alike, and those without are grey.
    """
    frame = _frame(scene)
    shown = [scene.points[sorted({i for f in scene.faces for i in f.outline})]]
    shown += [patch.points for patch in scene.patches]
    shown += [scene.points[[e.start, e.end]] for e in scene.edges]
    cloud = np.concatenate([points for points in shown if len(points)] or [np.zeros((1, 3))])
    canvas = _Canvas(size_px * SUPERSAMPLED, frame, cloud)
    for patch in scene.patches:
        canvas.draw_patch(patch)
    places = {id(face): index for index, face in enumerate(scene.faces)}
    for face in _towards(scene.faces, frame[2]):
        tint = None if tints is None else tints.get(places[id(face)], GREY)
        canvas.draw_face(face, scene.points, tint)
    bounding = {frozenset(p) for f in scene.faces for p in _sides(f.outline)}
    for edge in scene.edges:
        if frozenset((edge.start, edge.end)) not in bounding:
            canvas.draw_edge(scene.points[[edge.start, edge.end]])
    return canvas.png(size_px)


def put_on_white(png: bytes) -> ColourImage:
    """Return a transparent picture, a PNG, before white."""
    drawn = cv2.imdecode(np.frombuffer(png, dtype=np.uint8), cv2.IMREAD_UNCHANGED)
    levels = np.asarray(drawn, dtype=np.float64)
    cover = levels[..., 3:] / 255.0
    image: ColourImage = np.rint(levels[..., :3] * cover + 255.0 * (1.0 - cover)).astype(np.uint8)
    return image


def contact_sheet(
    shown: Sequence[tuple[Scene, str]], size_px: int = SIZE_PX, across: int = 10
) -> bytes:
    """Return thumbnails of scenes, each with its caption beneath, in rows of so many, as one
    PNG.
    """
    width = size_px * (1 - 2 * MARGIN)
    captions = [wrap(plain(caption), LETTERS_PX, width) for _, caption in shown]
    tall = size_px + round(LINE_PX * (1 + max(map(len, captions), default=0)))
    down, right = -(-len(shown) // across), min(across, len(shown))
    sheet: ColourImage = np.full((down * tall, right * size_px, 3), 255, dtype=np.uint8)
    for nth, ((scene, _), caption) in enumerate(zip(shown, captions, strict=True)):
        row, column = nth // across * tall, nth % across * size_px
        sheet[row : row + size_px, column : column + size_px] = put_on_white(
            thumbnail(scene, size_px)
        )
        for line, text in enumerate(caption, start=1):
            longest = measure_text(text, LETTERS_PX)[0]
            height = LETTERS_PX * min(1.0, width / longest)
            start = column + MARGIN * size_px, row + size_px + line * LINE_PX
            write(sheet, text, start, height, OUTLINE, rim=None)
    return cv2.imencode(".png", sheet)[1].tobytes()


def _towards(faces: Sequence[Face], toward: FloatArray) -> Iterator[Face]:
    """Return the faces but for the backs of sheets: two sides in one place would flicker."""
    turned = [float(face.plane.normal @ toward) >= 0.0 for face in faces]
    fronts = {frozenset(face.outline) for face, ours in zip(faces, turned, strict=True) if ours}
    for face, ours in zip(faces, turned, strict=True):
        if ours or frozenset(face.outline) not in fronts:
            yield face


def _sides(outline: tuple[int, ...]) -> list[tuple[int, int]]:
    return list(zip(outline, (*outline[1:], outline[0]), strict=True))


def _frame(scene: Scene) -> FloatArray:
    """Return the rows of the frame: the picture's right, its upwards, and towards who looks, (3,
    3).
    """
    up = np.array([0.0, 0.0, 1.0]) if scene.up is None else scene.up
    aside = np.eye(3)[int(np.argmin(np.abs(up)))]
    east = np.cross(aside, up)
    east /= np.linalg.norm(east)
    north = np.cross(up, east)
    level = math.cos(AZIMUTH) * east + math.sin(AZIMUTH) * north
    toward = math.cos(ELEVATION) * level + math.sin(ELEVATION) * up
    right = np.cross(up, toward)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(toward, right), toward])


def choose_tint_colour(tint: int) -> NDArray[np.uint8]:
    """Return the colour (3,) of faces of a tint, as OpenCV orders it, in full light."""
    return _colour(tint * HUE_STEP % 1.0, FACE_SATURATION, 1.0)


def _colour(hue: float, saturation: int, lit: float) -> NDArray[np.uint8]:
    pixel = np.array([[[round(179 * hue), saturation, round(BRIGHTNESS * lit)]]], np.uint8)
    return np.asarray(cv2.cvtColor(pixel, cv2.COLOR_HSV2BGR)[0, 0], dtype=np.uint8)


class _Canvas:
    """Colour, depth and the number of what is foremost, at each pixel."""

    def __init__(self, side: int, frame: FloatArray, cloud: FloatArray) -> None:
        self._frame = frame
        seen = cloud @ frame.T
        low, high = seen.min(axis=0), seen.max(axis=0)
        self._middle = (low + high) / 2
        extent = float(max(high[0] - low[0], high[1] - low[1], 1e-300))
        self._px = side * (1 - 2 * MARGIN) / extent  # a unit of length
        self._side = side
        self._colour = np.zeros((side, side, 3), dtype=np.uint8)
        self._depth = np.full((side, side), -np.inf)
        self._owner: Levels = np.zeros((side, side), dtype=np.int32)
        self._drawn = 0
        self._light = frame.T @ np.array([-0.35, 0.55, 0.76])

    def _placed(self, points: FloatArray) -> FloatArray:
        """Return the column, row and nearness (n, 3) of points (n, 3), in px."""
        seen = (points @ self._frame.T - self._middle) * self._px
        half = (self._side - 1) / 2
        return np.column_stack([half + seen[:, 0], half - seen[:, 1], seen[:, 2]])

    def _shade(self, normal: FloatArray, hue: float, saturation: int) -> NDArray[np.uint8]:
        """Return the colour (3,) of surface, lit whichever way it faces: thin sheets have two
        sides.
        """
        lit = AMBIENT_SHARE + LIGHT_SHARE * abs(float(normal @ self._light))
        return _colour(hue, saturation, lit)

    def draw_face(self, face: Face, points: FloatArray, tint: int | None = None) -> None:
        """Draw a face with its holes where it is foremost; without a tint it gets one of its
        own.
        """
        rings = [self._placed(points[list(ring)]) for ring in (face.outline, *face.holes)]
        mask = np.zeros((self._side, self._side), dtype=np.uint8)
        fixed = [np.rint(ring[:, :2] * 16).astype(np.int32) for ring in rings]
        cv2.fillPoly(mask, fixed, 1, cv2.LINE_8, 4)
        rows, columns = np.nonzero(mask)
        right, upwards, toward = self._frame @ face.plane.normal
        at = rings[0].mean(axis=0)
        # n · (x, y, z) = 0 about the middle, y being upwards in space and downwards in the picture
        slant = toward if abs(toward) > 1e-3 else math.copysign(1e-3, toward)
        near = at[2] - (right * (columns - at[0]) - upwards * (rows - at[1])) / slant
        bounds = np.concatenate([ring[:, 2] for ring in rings])
        near = np.clip(near, bounds.min(), bounds.max())
        number = self._drawn if tint is None else tint
        saturation = PATCH_SATURATION if number == GREY else FACE_SATURATION
        colour = self._shade(face.plane.normal, number * HUE_STEP % 1.0, saturation)
        self._put(rows, columns, near, colour)

    def draw_patch(self, patch: Patch) -> None:
        """Draw surface that is not flat, as discs of the areas that its points stand for."""
        placed = self._placed(patch.points)
        radii = np.sqrt(patch.areas * DISC_FILL / math.pi) * self._px
        radii = np.clip(radii, 1.0, LARGEST_DISC * self._side)
        self._drawn += 1
        for (column, row, near), radius, normal in zip(placed, radii, patch.normals, strict=True):
            top, left = max(0, math.ceil(row - radius)), max(0, math.ceil(column - radius))
            bottom = min(self._side, math.floor(row + radius) + 1)
            end = min(self._side, math.floor(column + radius) + 1)
            own = self._depth[top:bottom, left:end]
            rows, columns = np.ogrid[top:bottom, left:end]
            mask = ((rows - row) ** 2 + (columns - column) ** 2 <= radius**2) & (near > own)
            own[mask] = near
            self._colour[top:bottom, left:end][mask] = self._shade(normal, 0.0, PATCH_SATURATION)
            self._owner[top:bottom, left:end][mask] = self._drawn

    def draw_edge(self, ends: FloatArray) -> None:
        """Draw an edge that bounds no face, before everything."""
        (a, b, _), (c, d, _) = self._placed(ends)
        at = tuple(round(16 * x) for x in (a, b)), tuple(round(16 * x) for x in (c, d))
        mask = np.zeros((self._side, self._side), dtype=np.uint8)
        cv2.line(mask, at[0], at[1], 1, SUPERSAMPLED, cv2.LINE_8, 4)
        rows, columns = np.nonzero(mask)
        self._put(rows, columns, np.full(len(rows), np.inf), np.array(OUTLINE, dtype=np.uint8))

    def _put(
        self,
        rows: NDArray[np.intp],
        columns: NDArray[np.intp],
        near: FloatArray,
        colour: NDArray[np.uint8],
    ) -> None:
        self._drawn += 1
        front = near > self._depth[rows, columns]
        rows, columns = rows[front], columns[front]
        self._depth[rows, columns] = near[front]
        self._colour[rows, columns] = colour
        self._owner[rows, columns] = self._drawn

    def png(self, size_px: int) -> bytes:
        """Return the picture with outlines where another thing begins, made smaller."""
        edge = np.zeros_like(self._owner, dtype=bool)
        across = self._owner[:, 1:] != self._owner[:, :-1]
        down = self._owner[1:] != self._owner[:-1]
        edge[:, 1:] |= across
        edge[1:] |= down
        image: Image = np.dstack([self._colour, np.where(self._owner > 0, 255, 0).astype(np.uint8)])
        image[edge] = (*OUTLINE, 255)
        small = cv2.resize(image, (size_px, size_px), interpolation=cv2.INTER_AREA)
        _, data = cv2.imencode(".png", small, [cv2.IMWRITE_PNG_COMPRESSION, 9])
        return data.tobytes()
