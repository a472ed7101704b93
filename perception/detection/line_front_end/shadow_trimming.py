"""Parts of an outline that are ground: where a face meets it outlines may go on along shadows.

A shadow is as plain as a face, and has edges of its own: seen on the plane of the face beside it,
part of it agrees in all views. There the ground explains the pixels as well as a face does, and the
ground is there in any case.
"""

from collections.abc import Iterator, Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.evidence.face_evidence import MIN_INNER
from facetlog.perception.detection.line_front_end.evidence.ground_behind import compute_ground_ratio
from facetlog.perception.detection.line_front_end.evidence.half_planes import MIN_CONSISTENT
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.outlines.plane_grid import MAX_CELLS
from facetlog.perception.detection.line_front_end.planes.ground_plane import Ground
from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.stable_order import descending, largest
from facetlog.perception.types import FloatArray

# Sides of a cell, px, in which an outline is looked over: edges reach 2 px to either side.
CELL_PX = 4.0
# A place is ground at odds of 20 to 1, unless the face is likelier by as much.
CLEAR_ODDS = float(np.log(20.0))


def remove_spurs(
    corners: FloatArray,
    normal: FloatArray,
    shown: NDArray[np.bool_],
    taken: Sequence[NDArray[np.uint8]],
    photos: PhotometricViews,
    ground: Ground | None,
    pixel: float,
) -> FloatArray:
    """Return an outline (k, 3), counter-clockwise about its normal, without its parts that are
    ground.

    A part is what one cut takes off that goes on along a side at a reflex corner, or from one such
    corner to another. The views `shown` (V,) show the face, `taken` are their pixels that show
    another one, `pixel` is a pixel's length at the focus. Without a ground it stays as it is.
    """
    if ground is None:
        return corners
    along = np.roll(corners, -1, axis=0) - corners
    basis = make_plane_axes(normal, along[largest(np.linalg.norm(along, axis=1))]).T
    ring = corners @ basis
    if not len(_reflex(ring)) or not shapely.Polygon(ring).is_valid:
        return corners
    cells = _cells(ring, CELL_PX * pixel)
    foot = normal * float(normal @ corners.mean(axis=0))
    points = cells @ basis.T + foot
    face, _ = photos.agree(np.nonzero(shown)[0], points, taken)
    by_ground = compute_ground_ratio(photos, ground, corners, normal, points, shown, taken)
    is_ground = by_ground > np.maximum(CLEAR_ODDS, face.ratio - CLEAR_ODDS)
    left = _without(ring, cells, is_ground)
    return corners if left is ring else left @ basis.T + foot


def _without(ring: FloatArray, cells: FloatArray, is_ground: NDArray[np.bool_]) -> FloatArray:
    # A ring (k, 2) without the parts most of whose cells (n, 2) are ground, the largest first.
    while is_ground.sum() >= MIN_CONSISTENT * MIN_INNER:
        parts = list(_cuts(ring))
        inside = [shapely.contains_xy(shapely.Polygon(part), *cells.T) for part, _ in parts]
        worth = np.array([_worth(is_ground[each]) for each in inside])
        if not (worth > 0).any():
            break
        best = int(descending(worth)[0])
        ring = parts[best][1]
        left = ~inside[best]
        cells, is_ground = cells[left], is_ground[left]
    return ring


def _worth(is_ground: NDArray[np.bool_]) -> float:
    # Cells of ground less what the others are worth, 0 where these are too many or all too few.
    count, ground = len(is_ground), int(is_ground.sum())
    if count < MIN_INNER or ground < MIN_CONSISTENT * count:
        return 0.0
    return float(ground - (count - ground) * MIN_CONSISTENT / (1 - MIN_CONSISTENT)) + 1.0


def _reflex(ring: FloatArray) -> NDArray[np.intp]:
    # The corners of a counter-clockwise ring (k, 2) at which it turns clockwise.
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    return np.nonzero(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0] < 0)[0]


def _cuts(ring: FloatArray) -> Iterator[tuple[FloatArray, FloatArray]]:
    # Each way to cut a ring (k, 2) in two, either part being the first once.
    polygon = shapely.Polygon(ring)
    reflex = _reflex(ring)
    count = len(ring)
    for corner in reflex.tolist():
        for beside in (-1, 1):
            hit = _hit(ring, corner, ring[corner] - ring[(corner + beside) % count])
            if hit is None:
                continue
            side, at = hit
            one = np.concatenate([_run(ring, corner, side), at[None]])
            other = np.concatenate([at[None], _run(ring, (side + 1) % count, corner)])
            yield one, other
            yield other, one
        for end in reflex[reflex > corner].tolist():
            chord = shapely.LineString(ring[[corner, end]])
            if (end - corner) % count in (1, count - 1) or not polygon.covers(chord):
                continue
            one, other = _run(ring, corner, end), _run(ring, end, corner)
            yield one, other
            yield other, one


def _run(ring: FloatArray, first: int, last: int) -> FloatArray:
    # The corners from the first to the last, both with them, counter-clockwise.
    return ring[(first + np.arange((last - first) % len(ring) + 1)) % len(ring)]


def _hit(ring: FloatArray, corner: int, along: FloatArray) -> tuple[int, FloatArray] | None:
    # Where a ray from a corner inwards meets the ring (k, 2) first: side and point.
    span = np.roll(ring, -1, axis=0) - ring
    off = ring - ring[corner]
    sine = along[0] * span[:, 1] - along[1] * span[:, 0]
    safe = np.where(np.abs(sine) > 0, sine, np.nan)
    share = (off[:, 0] * span[:, 1] - off[:, 1] * span[:, 0]) / safe
    place = (off[:, 0] * along[1] - off[:, 1] * along[0]) / safe
    meets = (share > 0) & (place >= 0) & (place <= 1)
    meets[[corner, corner - 1]] = False
    if not meets.any():
        return None
    side = int(np.where(meets, share, np.inf).argmin())
    return side, ring[corner] + share[side] * along


def _cells(ring: FloatArray, step: float) -> FloatArray:
    # The middles (n, 2) of the cells of a ring (k, 2).
    low, high = ring.min(axis=0), ring.max(axis=0)
    step = max(step, float((high - low).max()) / MAX_CELLS)
    x, y = (np.arange(a + step / 2, b, step) for a, b in zip(low, high, strict=True))
    middles = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    polygon = shapely.Polygon(ring)
    shapely.prepare(polygon)
    cells: FloatArray = middles[shapely.contains_xy(polygon, *middles.T)]
    return cells
