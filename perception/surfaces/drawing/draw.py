"""Drawings of a scene into the views in which it was found."""

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.scene import Evidence, Scene, Vertex
from facetlog.perception.surfaces.drawing.frustum import Frustum
from facetlog.perception.surfaces.drawing.hidden_surface import (
    HiddenSurface,
    hidden_surface,
    is_facing_camera,
)
from facetlog.perception.surfaces.drawing.lettering import (
    PAPER,
    WHITE,
    Colour,
    ColourImage,
    Lettering,
    add_legend,
)
from facetlog.perception.surfaces.drawing.upright import turn_pixel, upright
from facetlog.perception.types import FloatArray, View

# Sizes are for a picture 640 px on its long side and grow with it.
REFERENCE_PX = 640
LINE_PX = 1.6
FACE_LETTERS_PX = 12.0
VERTEX_LETTERS_PX = 8.0
CROSS_PX = 5.0
DASH_PERIOD_PX, DASH_SHARE = 11.0, 0.6
SAMPLE_PX = 1.0  # an edge is tested for being hidden at every so many px

TINT_MEASURED, TINT_IMPLIED = 0.38, 0.18
ELLIPSE_SD = 2.0
GOLDEN = 0.6180339887498949  # turns of the hue circle: any number of faces get distinct hues
YELLOW: Colour = (60, 230, 255)
EDGE: Colour = (90, 255, 90)

SHEET_WIDTH_PX = 2400
SHEET_GAP_PX = 8
SHEET_BEST_RATIO = 1.6  # about that of a screen


def draw_scene(
    view: View,
    scene: Scene,
    *,
    parts: Mapping[str, str] | None = None,
    verdict: str = "",
) -> ColourImage:
    """Return the view in colour with the scene drawn in, (H + legend, W, 3) uint8, blue-green-red.

    Faces that turn to the camera are tinted and named (f1 is the first), with the part they play
    if `parts` maps their name to one; measured edges are solid, implied ones dashed, hidden ones
    left out. A cross is an observed vertex, an ellipse the projected estimate at 2 sd. Below: the
    names of scene and view, counts, and the verdict. A picture that lies on its side is turned.
    """
    observed = _find_observed_pixels(view, scene)
    view, turns = upright(taken := view, scene.up)
    scale = max(view.image.shape) / REFERENCE_PX
    image: ColourImage = np.asarray(cv2.cvtColor(view.image, cv2.COLOR_GRAY2BGR), dtype=np.uint8)
    surface = hidden_surface(view, scene)
    _tint_faces(image, scene, surface)
    _draw_edges(image, view, scene, surface, scale)
    for uv in observed:
        _cross(image, turn_pixel(uv, taken, turns), scale)
    shown = _draw_vertices(image, view, scene, surface, scale)
    lettering = Lettering(image)
    _name_faces(lettering, scene, surface, parts or {}, scale)
    _name_vertices(lettering, shown, scale)
    return add_legend(image, _legend(view, scene, verdict), scale)


def contact_sheet(
    images: Sequence[ColourImage], *, width: int = SHEET_WIDTH_PX, columns: int | None = None
) -> ColourImage:
    """Return all pictures on one sheet, row by row, (H, ≤ width, 3) uint8; each keeps its
    proportions.

    >>> contact_sheet([np.zeros((60, 80, 3), np.uint8)] * 5, width=400, columns=3).shape[1]
    400
    """
    if not images:
        raise ValueError("a contact sheet needs at least one picture")
    ratio = float(np.median([i.shape[1] / i.shape[0] for i in images]))
    count = columns or max(1, round(np.sqrt(len(images) * SHEET_BEST_RATIO / ratio)))
    count = min(count, len(images))
    cell_w = (width - SHEET_GAP_PX * (count + 1)) // count
    cell_h = max(1, round(cell_w / ratio))
    rows = -(-len(images) // count)
    height = rows * (cell_h + SHEET_GAP_PX) + SHEET_GAP_PX
    sheet = np.full((height, width, 3), PAPER, dtype=np.uint8)
    for i, image in enumerate(images):
        shrink = min(cell_w / image.shape[1], cell_h / image.shape[0])
        size = max(1, round(image.shape[1] * shrink)), max(1, round(image.shape[0] * shrink))
        small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
        top = SHEET_GAP_PX + i // count * (cell_h + SHEET_GAP_PX) + (cell_h - size[1]) // 2
        left = SHEET_GAP_PX + i % count * (cell_w + SHEET_GAP_PX) + (cell_w - size[0]) // 2
        sheet[top : top + size[1], left : left + size[0]] = small
    return sheet


def _choose_face_ink(index: int) -> Colour:
    """Return a saturated colour, far from those of its neighbours in number."""
    hue = round(index * GOLDEN % 1.0 * 179)
    pixel = cv2.cvtColor(np.array([[[hue, 230, 255]]], dtype=np.uint8), cv2.COLOR_HSV2BGR)[0, 0]
    return int(pixel[0]), int(pixel[1]), int(pixel[2])


def _tint_faces(image: ColourImage, scene: Scene, surface: HiddenSurface) -> None:
    h, w = image.shape[:2]
    index = cv2.resize(surface.face, (w, h), interpolation=cv2.INTER_NEAREST)
    covered = index >= 0
    face = index[covered]
    shares = [
        TINT_MEASURED if f.evidence is Evidence.MEASURED else TINT_IMPLIED for f in scene.faces
    ]
    share = np.array(shares)[face, None]
    inks = np.array([_choose_face_ink(number) for number in range(len(scene.faces))]).reshape(-1, 3)
    image[covered] = np.rint(image[covered] * (1 - share) + inks[face] * share).astype(np.uint8)


def _draw_edges(
    image: ColourImage, view: View, scene: Scene, surface: HiddenSurface, scale: float
) -> None:
    frustum = Frustum(view.camera, view.pose)
    points = scene.points
    for (start, end), evidence in _choose_drawn_edges(view, scene).items():
        ends = frustum.segment(points[start], points[end])
        if ends is None:
            continue
        first, last = frustum.pixels(ends)
        length = float(np.hypot(*(last - first)))
        count = max(2, int(length / (SAMPLE_PX * scale)) + 1)
        share = np.linspace(0, 1, count)
        # Inverse depth, not depth, is linear along a line of the picture.
        depth = 1 / ((1 - share) / ends[0, 2] + share / ends[1, 2])
        pixels = first + np.outer(share, last - first)
        drawn = surface.visible(pixels, depth)
        if evidence is Evidence.IMPLIED:
            drawn &= share * length / (DASH_PERIOD_PX * scale) % 1.0 < DASH_SHARE
        for piece in _runs(drawn):
            _line(image, pixels[piece[0]], pixels[piece[1]], scale)


def _choose_drawn_edges(view: View, scene: Scene) -> dict[tuple[int, int], Evidence]:
    """Return the edges to draw, by their ends: loose ones, and those of faces that turn to the
    camera.
    """
    bounding: set[tuple[int, int]] = set()
    toward: dict[tuple[int, int], Evidence] = {}
    for face in scene.faces:
        turned = is_facing_camera(face, view)
        for ring in (face.outline, *face.holes):
            for a, b in zip(ring, (*ring[1:], ring[0]), strict=True):
                pair = min(a, b), max(a, b)
                bounding.add(pair)
                if turned:  # a side of the outline that is no edge of the scene was not measured
                    toward[pair] = Evidence.IMPLIED
    for edge in scene.edges:
        pair = min(edge.start, edge.end), max(edge.start, edge.end)
        if pair in toward or pair not in bounding:
            toward[pair] = edge.evidence
    return toward


def _runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return the first and last index of each run of at least two true values."""
    steps = np.diff(np.concatenate([[0], flags.astype(np.int8), [0]]))
    starts, ends = np.nonzero(steps == 1)[0], np.nonzero(steps == -1)[0] - 1
    return [(int(a), int(b)) for a, b in zip(starts, ends, strict=True) if b > a]


def _line(image: ColourImage, start: FloatArray, end: FloatArray, scale: float) -> None:
    thickness = max(1, round(LINE_PX * scale))
    ends = [tuple(int(x) for x in np.rint(p * 16)) for p in (start, end)]  # 4 bits of sub-pixel
    cv2.line(image, ends[0], ends[1], EDGE, thickness, cv2.LINE_AA, 4)


def _draw_vertices(
    image: ColourImage, view: View, scene: Scene, surface: HiddenSurface, scale: float
) -> list[tuple[str, FloatArray]]:
    """Draw ellipses; return name and pixel of each vertex that is to be seen."""
    shown: list[tuple[str, FloatArray]] = []
    used = {i for pair in _choose_drawn_edges(view, scene) for i in pair}
    for number, vertex in enumerate(scene.vertices):
        projected = _projected(view, vertex)
        if number not in used or projected is None:
            continue
        uv, cov, depth = projected
        if surface.visible(uv[None], np.array([depth]))[0]:
            _ellipse(image, uv, cov, scale)
            shown.append((f"v{number + 1}", uv))
    return shown


def _find_observed_pixels(view: View, scene: Scene) -> list[FloatArray]:
    """Return the pixels (2,) at which the view shows vertices."""
    index = scene.views.index(view.name) if view.name in scene.views else -1
    return [
        observation.resized(1.0 / view.enlargement).uv
        for vertex in scene.vertices
        for observation in vertex.observations
        if observation.view == index
    ]


def _projected(view: View, vertex: Vertex) -> tuple[FloatArray, FloatArray, float] | None:
    """Return the pixel (2,), covariance (2, 2) in px² to first order, and depth; None behind the
    camera.
    """
    x, y, z = view.pose.rotation.T @ (vertex.point - view.pose.centre)
    if z <= 0:
        return None
    c = view.camera
    # u = fx x/z + cx: its derivatives by the point in the camera's frame, then by the world's.
    jacobian = np.array([[c.fx / z, 0, -c.fx * x / z**2], [0, c.fy / z, -c.fy * y / z**2]])
    jacobian = jacobian @ view.pose.rotation.T
    uv = np.array([c.fx * x / z + c.cx, c.fy * y / z + c.cy])
    return uv, jacobian @ vertex.cov @ jacobian.T, float(z)


def _cross(image: ColourImage, uv: FloatArray, scale: float) -> None:
    arm = CROSS_PX * scale
    thin = max(1, round(LINE_PX * scale / 2))
    for colour, thickness in (((0, 0, 0), thin + 2), (WHITE, thin)):
        for direction in ((1, 1), (1, -1)):
            ends = [np.rint((uv + s * arm * np.array(direction)) * 16).astype(int) for s in (-1, 1)]
            a, b = ((int(p[0]), int(p[1])) for p in ends)
            cv2.line(image, a, b, colour, thickness, cv2.LINE_AA, 4)


def _ellipse(image: ColourImage, uv: FloatArray, cov: FloatArray, scale: float) -> None:
    values, vectors = np.linalg.eigh(cov)
    largest = 2.0 * max(image.shape)  # more than the picture says no more
    axes = np.minimum(ELLIPSE_SD * np.sqrt(np.maximum(values, 0.0)), largest)
    angle = float(np.degrees(np.arctan2(vectors[1, 1], vectors[0, 1])))
    thin = max(1, round(LINE_PX * scale / 2))
    # Never smaller than a dot of the line's width, else a sure vertex could not be seen.
    sizes = np.maximum(axes[::-1], LINE_PX * scale)
    at = tuple(int(x) for x in np.rint(uv * 16))
    size = round(sizes[0] * 16), round(sizes[1] * 16)
    cv2.ellipse(image, at, size, angle, 0.0, 360.0, YELLOW, thin, cv2.LINE_AA, 4)


def _name_faces(
    lettering: Lettering,
    scene: Scene,
    surface: HiddenSurface,
    parts: Mapping[str, str],
    scale: float,
) -> None:
    """Name each face at the middle of the widest place where it is to be seen."""
    for number in range(len(scene.faces)):
        mask = np.pad((surface.face == number).astype(np.uint8), 1)
        if not mask.any():
            continue
        room = cv2.distanceTransform(mask, cv2.DIST_L2, 3)[1:-1, 1:-1]
        row, column = divmod(int(np.argmax(room)), room.shape[1])
        u, v = ((i + 0.5) / surface.scale - 0.5 for i in (column, row))
        name = f"f{number + 1}"
        text = f"{name} {parts[name]}" if name in parts else name
        step = FACE_LETTERS_PX * scale * 1.5
        spots = ((u, v), (u, v - step), (u, v + step), (u, v - 2 * step), (u, v + 2 * step))
        lettering.place(text, spots, FACE_LETTERS_PX * scale, WHITE)


def _name_vertices(lettering: Lettering, shown: list[tuple[str, FloatArray]], scale: float) -> None:
    """Name vertices beside themselves, away from the middle of all where there is room."""
    if not shown:
        return
    gap = (VERTEX_LETTERS_PX + CROSS_PX) * scale
    middle = np.mean([uv for _, uv in shown], axis=0)
    for name, uv in shown:
        corners = uv + gap * np.array([[1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]])
        away = np.argsort(-((corners - middle) ** 2).sum(axis=1), kind="stable")
        spots = tuple((float(corners[i, 0]), float(corners[i, 1])) for i in away)
        lettering.place(name, spots, VERTEX_LETTERS_PX * scale, WHITE)


def _many(count: int, one: str, several: str = "") -> str:
    return f"{count} {one if count == 1 else several or f'{one}s'}"


def _legend(view: View, scene: Scene, verdict: str) -> tuple[str, ...]:
    """Return the lines below the picture."""
    measured = sum(e.evidence is Evidence.MEASURED for e in scene.edges)
    index = scene.views.index(view.name) if view.name in scene.views else -1
    here = sum(any(o.view == index for o in v.observations) for v in scene.vertices)
    return (
        f"{scene.name}, {view.name}: {_many(len(scene.faces), 'face')}, "
        f"{_many(len(scene.edges), 'edge')} ({measured} measured), "
        f"{_many(len(scene.vertices), 'vertex', 'vertices')} ({here} observed here)",
        "solid: measured, dashed: implied; cross: observed, ellipse: estimate at 2 sd",
        *([verdict] if verdict else []),
    )
