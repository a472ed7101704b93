"""Regions of a plane on which the pictures are consistent: candidates for faces."""

from collections.abc import Iterator, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.evidence.photo_consistency import (
    GreyLevels,
    agreement,
)
from facetlog.perception.detection.line_front_end.evidence.photometric_views import MIN_FACING_SINE
from facetlog.perception.detection.line_front_end.outlines.plane_grid import (
    COARSE_PX,
    CROSS,
    FINE_PX,
    MAX_CELLS,
    MIN_COARSE,
    MIN_FINE,
    PlaneGrid,
    find_connected_regions,
)
from facetlog.perception.detection.line_front_end.outlines.region_outline import (
    MAX_SIDES,
    border,
    fit_outline_polygon,
    iter_rough_polygons,
)
from facetlog.perception.detection.line_front_end.planes.ground_plane import Ground
from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import PlaneHypothesis
from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.min_views import FEWEST_VIEWS
from facetlog.perception.stable_order import descending
from facetlog.perception.types import FloatArray, View

# More views than this, evenly from those that face the plane, outline a region no better; all of
# them judge it.
MAX_VIEWS = 24
# A cell is of a surface at odds of 20 to 1.
MIN_RATIO = float(np.log(20.0))
# The plane is looked at round its lines, by this share of their extent and px; where a region goes
# on beyond, so is this share more, up to so many times.
MARGIN_SHARE, MARGIN_PX = 0.15, 10.0
GROWTH_SHARE, GROWTHS = 0.4, 3
# A segment this near to the plane, px, may bound a region.
ON_PLANE_PX = 3.0
# Lines bound a region beyond their ends by so many cells: corners are where edges fade.
BEYOND_CELLS = 2.0
# Two regions are one when they share this much of the larger.
SAME_SHARE = 0.97
# A plane is level, and the ground cuts it nowhere, when its normal is this near to the ground's.
LEVEL_SINE = 0.1
SUBPIXEL_BITS = 4


class RegionFinder:
    """Finds regions of planes on which views agree; `pixel` is a pixel's length at the focus."""

    def __init__(
        self,
        views: Sequence[View],
        levels: GreyLevels,
        weight: FloatArray,
        segments: FloatArray,
        ground: Ground | None,
        pixel: float,
    ) -> None:
        self._projections = np.array([view.projection for view in views])
        self._sizes = np.array([view.image.shape[::-1] for view in views])
        self._centres = np.array([view.pose.centre for view in views])
        self._levels = levels
        self._weight = weight
        self._segments = segments
        self._ground = ground
        self._pixel = pixel

    def outlines(
        self,
        plane: PlaneHypothesis,
        span: FloatArray,
        side: float,
        taken: Sequence[NDArray[np.uint8]],
    ) -> Iterator[tuple[FloatArray, bool]]:
        """Return corners (k, 3) of polygons that may be faces seen from one side (±1) of the plane.

        They run counter-clockwise seen from there. True comes with a rough one, whose sides are
        only near the face's. The plane is searched round the segments of `span` (n, 2, 3). `taken`
        are each view's pixels that show a face found already: a pixel shows one surface.
        """
        extent = self._extent(plane, span, side, taken)
        if extent is None:
            return
        basis, low, high = extent
        step = max(FINE_PX * self._pixel, float((high - low).max()) / MAX_CELLS)
        grid = PlaneGrid.over(plane, basis, low, high, step)
        agrees = self._agrees(grid, plane, side, taken)
        if agrees is None:
            return
        near = np.abs(self._segments @ plane.normal - plane.distance) < ON_PLANE_PX * self._pixel
        nearby = np.nonzero(near.all(axis=1))[0]
        lines = grid.cells(self._segments[np.union1d(nearby, plane.lines)])
        walls = _drawn(lines, grid.shape)
        sides = [*lines, *self._ground_line(grid)]
        found: list[NDArray[np.uint8]] = []
        for cut in (True, False):
            for region in find_connected_regions(
                agrees & (walls == 0) if cut else agrees, MIN_FINE
            ):
                if cut:  # back to the lines that cut it out
                    grown = cv2.dilate(region, CROSS) > 0
                    region = (grown & ((agrees > 0) | (walls > 0))).astype(np.uint8)
                region = _filled(region)
                if any(_same(region, other) for other in found):
                    continue
                found.append(region)
                ring = border(region)
                corners = fit_outline_polygon(ring, np.array(sides).reshape(-1, 2, 2) + 0.5)
                if corners is not None:
                    yield grid.points(corners if side > 0 else corners[::-1]), False
                if cut:  # between lines that may be texture: it must have sides on them
                    continue
                for rough in iter_rough_polygons(
                    ring, MAX_SIDES if corners is None else len(corners)
                ):
                    yield grid.points(rough if side > 0 else rough[::-1]), True

    def _extent(
        self,
        plane: PlaneHypothesis,
        span: FloatArray,
        side: float,
        taken: Sequence[NDArray[np.uint8]],
    ) -> tuple[FloatArray, FloatArray, FloatArray] | None:
        # The rectangle of the plane in which the views agree somewhere, found with coarse cells:
        # its axes (3, 2), low and high. Cells lie along the longest line: most sides run along or
        # across it, and the result does not depend on the world frame.
        along = span[:, 1] - span[:, 0]
        longest = descending(np.linalg.norm(along, axis=1))[0]
        basis = make_plane_axes(plane.normal, along[longest]).T
        flat = (span.reshape(-1, 3) - plane.normal * plane.distance) @ basis
        low, high = flat.min(axis=0), flat.max(axis=0)
        margin = np.maximum(MARGIN_SHARE * (high - low), MARGIN_PX * self._pixel)
        low, high = low - margin, high + margin
        for growth in range(GROWTHS + 1):
            step = max(COARSE_PX * self._pixel, 4 * float((high - low).max()) / MAX_CELLS)
            grid = PlaneGrid.over(plane, basis, low, high, step)
            agrees = self._agrees(grid, plane, side, taken)
            if agrees is None:
                return None
            regions = list(find_connected_regions(agrees, MIN_COARSE))
            if not regions:
                return None
            shown = np.any(regions, axis=0)
            rows, columns = np.nonzero(shown)
            at_rim = np.array(
                [
                    [columns.min() == 0, rows.min() == 0],
                    [columns.max() == grid.shape[1] - 1, rows.max() == grid.shape[0] - 1],
                ]
            )
            if not at_rim.any() or growth == GROWTHS:
                break
            more = GROWTH_SHARE * (high - low)
            low, high = low - more * at_rim[0], high + more * at_rim[1]
        first = np.array([columns.min(), rows.min()]) - 2
        last = np.array([columns.max(), rows.max()]) + 3
        first, last = grid.low + first * step, grid.low + last * step
        return basis, np.maximum(first, low), np.minimum(last, high)

    def _agrees(
        self,
        grid: PlaneGrid,
        plane: PlaneHypothesis,
        side: float,
        taken: Sequence[NDArray[np.uint8]],
    ) -> NDArray[np.uint8] | None:
        middle = grid.points(np.array(grid.shape[::-1]) / 2)
        rays = self._centres - middle
        facing = side * (rays @ plane.normal) > MIN_FACING_SINE * np.linalg.norm(rays, axis=1)
        several = np.nonzero(facing)[0]
        if len(several) > MAX_VIEWS:
            several = several[np.linspace(0, len(several) - 1, MAX_VIEWS).round().astype(int)]
        uv, seen = grid.pixels(self._projections[several], self._sizes[several])
        chosen = seen.any(axis=(1, 2))
        if chosen.sum() < FEWEST_VIEWS:
            return None
        several, uv, seen = several[chosen], uv[:, chosen], seen[chosen]
        for n, k in enumerate(several.tolist()):
            if taken[k].any():
                seen[n] &= cv2.remap(taken[k], uv[0, n], uv[1, n], cv2.INTER_NEAREST) == 0
        read = self._levels.read(several, uv, seen)
        agrees = agreement(read, self._weight[several]).ratio > MIN_RATIO
        if self._ground is not None:
            rows, columns = np.indices(grid.shape)
            points = grid.points(np.stack([columns, rows], axis=-1).astype(np.float64) + 0.5)
            agrees &= self._ground.above(points) > -self._ground.margin / 4
        return agrees.astype(np.uint8)

    def _ground_line(self, grid: PlaneGrid) -> Iterator[FloatArray]:
        # Where the plane meets the ground is a border too, in cells (2, 2).
        if self._ground is None:
            return
        slope = grid.basis.T @ self._ground.normal
        size = float(np.linalg.norm(slope))
        if size < LEVEL_SINE:
            return
        high = np.array(grid.shape[::-1]) * grid.step
        middle = grid.low + high / 2
        height = float(self._ground.above(grid.origin + grid.basis @ middle))
        foot = middle - slope * height / size**2
        along = np.array([-slope[1], slope[0]]) / size * high.max()
        yield (np.stack([foot - along, foot + along]) - grid.low) / grid.step - 0.5


def _filled(region: NDArray[np.uint8]) -> NDArray[np.uint8]:
    rings, _ = cv2.findContours(region, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    return np.asarray(cv2.drawContours(np.zeros_like(region), rings, -1, 1, cv2.FILLED), np.uint8)


def _same(one: NDArray[np.uint8], other: NDArray[np.uint8]) -> bool:
    return bool((one & other).sum() > SAME_SHARE * max(one.sum(), other.sum()))


def _drawn(lines: FloatArray, shape: tuple[int, int]) -> NDArray[np.uint8]:
    picture = np.zeros(shape, dtype=np.uint8)
    for start, end in lines:
        unit = (end - start) / max(float(np.linalg.norm(end - start)), 1e-9)
        ends = np.stack([start - BEYOND_CELLS * unit, end + BEYOND_CELLS * unit])
        if np.abs(ends).max() < 1 << 14:
            a, b = np.rint(ends * (1 << SUBPIXEL_BITS)).astype(int).tolist()
            cv2.line(picture, a, b, 1, 1, cv2.LINE_8, SUBPIXEL_BITS)
    return picture
