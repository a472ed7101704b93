"""The pieces of a scene, and what nobody saw of its space, drawn into a view."""

import cv2
import numpy as np

from facetlog.perception.pieces.shown_pieces import (
    COLOURS,
    SIDES,
    ShownPiece,
    ShownPieces,
    compute_box_corners,
)
from facetlog.perception.space.space import Space, State
from facetlog.perception.surfaces.drawing.frustum import Frustum
from facetlog.perception.surfaces.drawing.lettering import (
    Colour,
    ColourImage,
    Lettering,
    add_legend,
)
from facetlog.perception.surfaces.drawing.upright import upright
from facetlog.perception.types import FloatArray, View

# Sizes are for a picture 640 px on its long side and grow with it.
REFERENCE_PX = 640
LINE_PX, LETTERS_PX, STRIPE_PX = 1.6, 12.0, 7.0
TINT = 0.45
DARKENED = 0.6  # what of a picture's brightness is left, so that colours stand out
MOST_HAZE = 0.5
WHITE: Colour = (255, 255, 255)


def draw_pieces(
    view: View, shown: ShownPieces, title: str, up: FloatArray | None = None
) -> ColourImage:
    """Return the view in colour with the pieces' boxes drawn in, (H + legend, W, 3) uint8, BGR.

    Boards, bars and blocks have a colour each, and their names; of what is implied only, stripes.
    Space that no view looked into lies over it as a haze. The `title` stands below. Where `up` (3,)
    is known, a picture that lies on its side is turned.
    """
    view, _ = upright(view, up)
    scale = max(view.image.shape) / REFERENCE_PX
    grey = np.rint(view.image * DARKENED).astype(np.uint8)
    image: ColourImage = np.asarray(cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR), dtype=np.uint8)
    frustum = Frustum(view.camera, view.pose)
    # The farthest first: what is nearer lies over it.
    depths = [frustum.in_camera(each.piece.middle)[0, 2] for each in shown.pieces]
    for nth in np.argsort(depths)[::-1].tolist():
        _draw_box(image, frustum, shown.pieces[nth], scale)
    for space in shown.spaces:
        _draw_haze(image, frustum, space)
    lettering = Lettering(image)
    for nth in np.argsort(depths).tolist():
        _name(lettering, frustum, shown.pieces[nth], scale)
    key = "orange: board, blue: bar, green: block; striped: implied; haze: unseen"
    return add_legend(image, (title, key), scale)


def _colour(shown: ShownPiece) -> Colour:
    red, green, blue = COLOURS[shown.piece.kind]
    return blue, green, red


def _draw_box(image: ColourImage, frustum: Frustum, shown: ShownPiece, scale: float) -> None:
    corners = compute_box_corners(shown.piece)
    sides = [corners[list(side)] for side in SIDES]
    shown_sides = (_pixels(frustum, side) for side in sides if _faces(frustum, side))
    outlines = [outline for outline in shown_sides if len(outline)]  # others are out of view
    if not outlines:
        return
    # Only the part of the picture round the box is changed, which is small for most.
    corners_px = np.concatenate(outlines).reshape(-1, 2)
    left, top = (max(int(least), 0) for least in corners_px.min(axis=0))
    right, bottom = (max(int(most) + 1, 0) for most in corners_px.max(axis=0))
    window = image[top:bottom, left:right]
    mask = np.zeros(window.shape[:2], dtype=np.uint8)
    for outline in outlines:
        cv2.fillPoly(mask, [outline], 255, offset=(-left, -top))
    inside = mask > 0
    if shown.implied:
        rows, columns = np.ogrid[: window.shape[0], : window.shape[1]]
        inside &= (rows + top + columns + left) // max(1, round(STRIPE_PX * scale)) % 2 == 0
    ink = np.array(_colour(shown), dtype=np.float32)
    window[inside] = np.rint(window[inside] * (1.0 - TINT) + ink * TINT).astype(np.uint8)
    thickness = max(1, round(LINE_PX * scale))
    cv2.polylines(image, outlines, True, _colour(shown), thickness, cv2.LINE_AA)


def _pixels(frustum: Frustum, ring: FloatArray) -> np.ndarray[tuple[int, ...], np.dtype[np.int32]]:
    return np.rint(frustum.polygon(ring)).astype(np.int32).reshape(-1, 1, 2)


def _faces(frustum: Frustum, side: FloatArray) -> bool:
    """Return whether a side (4, 3) of a box turns to the camera."""
    normal = np.cross(side[1] - side[0], side[2] - side[1])
    return float(normal @ (frustum.pose.centre - side[0])) > 0.0


def _draw_haze(image: ColourImage, frustum: Frustum, space: Space) -> None:
    """Whiten each pixel the more, the more unseen cells its line of sight passes."""
    cells = np.argwhere(space.cells == State.UNSEEN) + 0.5
    points = frustum.in_camera((cells * space.cell + space.corner) @ space.axes)
    points = points[points[:, 2] > space.cell]
    if not len(points):
        return
    height, width = image.shape[:2]
    at = np.rint(frustum.pixels(points)).astype(np.intp)
    within = ((at >= 0) & (at < (width, height))).all(axis=1)
    seen = np.zeros((height, width), dtype=np.float32)
    np.add.at(seen, (at[within, 1], at[within, 0]), 1.0)
    # A cell is so many pixels wide, and its share of each as if it were spread over them.
    wide = max(1.0, frustum.camera.fx * space.cell / float(np.median(points[:, 2])))
    cells_deep = cv2.GaussianBlur(seen, (0, 0), wide / 2.0) * wide**2
    deep = float(max(space.cells.shape)) / 2.0
    haze = (MOST_HAZE * np.minimum(cells_deep / deep, 1.0))[..., None]
    image[:] = np.rint(image * (1.0 - haze) + 255.0 * haze).astype(np.uint8)


def _name(lettering: Lettering, frustum: Frustum, shown: ShownPiece, scale: float) -> None:
    point = frustum.in_camera(shown.piece.middle)
    if point[0, 2] <= 0.0:
        return
    u, v = frustum.pixels(point)[0].tolist()
    step = LETTERS_PX * scale * 1.5
    spots = tuple((u, v + shift * step) for shift in (0, -1, 1, -2, 2))
    lettering.place(shown.label, spots, LETTERS_PX * scale, WHITE)
