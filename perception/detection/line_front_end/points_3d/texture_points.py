"""Texture points of a scene: features matched between pairs of views, linked and triangulated.

Features are corners, each with a patch of the picture round it as its descriptor. The poses are
known, so patches are rotated to one direction of the world and scaled by the distance; features
need no scale or rotation invariance of their own. That costs a twentieth of features made for
unknown poses.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from facetlog.perception.detection.coarse_pictures import GRADIENT_NOISE
from facetlog.perception.detection.edge_maps import EdgeMap
from facetlog.perception.detection.view_graph import ViewGraph
from facetlog.perception.estimation.point_consensus import find_agreeing_views
from facetlog.perception.estimation.point_views import Cameras, Sightings
from facetlog.perception.stable_order import descending
from facetlog.perception.types import FloatArray, View

# Sum of gradients round a point, px, and how near another one is the same corner.
WINDOW_PX, APART_PX = 5, 3
# A corner is one where the noise leaves its place open by no more than this, px: less than what
# another view of the same texture moves it by.
MAX_NOISE_PX = 0.25
# Most corners of a view, and of each of GRID x GRID parts of it: the strongest, but a carpet must
# not crowd out a label.
MAX_CORNERS, GRID = 800, 8
MAX_OF_PART = 3 * MAX_CORNERS // GRID**2
# A patch has SAMPLES x SAMPLES samples this far apart, px, for a view at the usual distance: twenty
# px across are distinctive for most texture, and mostly lie on one face. Blurred by half a step, so
# that a sample stands for its surroundings.
SAMPLES, STEP_PX = 8, 2.5
BLUR_PX = STEP_PX / 2
# Corners nearer to the rim are left out: a patch of any direction must fit in.
BORDER_PX = int(np.ceil(np.sqrt(2) * SAMPLES * STEP_PX / 2))


@dataclass(frozen=True, eq=False, slots=True)
class TextureFeatures:
    """Corners (n, 2) of one picture, px, the strongest first, and the patches (n, d) round them.

    Patches have mean 0 and length 1: their product is the correlation of two.
    """

    uv: FloatArray
    patches: NDArray[np.float32]


def find_common_direction(views: Sequence[View]) -> FloatArray:
    """Return the direction (3,) of the world that the views look along least."""
    axes = np.array([v.pose.rotation[:, 2] for v in views])
    _, vectors = np.linalg.eigh(axes.T @ axes)
    return np.asarray(vectors[:, 0])


def find_texture_features(
    view: View, edges: EdgeMap, direction: FloatArray, focus: FloatArray, pixel: float
) -> TextureFeatures:
    """Return the corners of a picture to be matched.

    `direction` (3,) of the world is down in all patches; what the view shows lies about as far
    away as `focus` (3,), where `pixel` is a pixel's length in the usual view.
    """
    uv = _corners(edges)
    away = float(np.linalg.norm(focus - view.pose.centre))
    scale = pixel * view.camera.fx / away
    return TextureFeatures(uv, _patches(view, uv, _turns(view, uv, direction, away), scale))


def _corners(edges: EdgeMap) -> FloatArray:
    # Least eigenvalue of the summed squares of the gradient: noise² over it is the variance of a
    # place the way it is known worst (Förstner and Gülch 1987; Shi and Tomasi 1994).
    window = (WINDOW_PX, WINDOW_PX)
    a, b, c = (
        cv2.boxFilter(product, cv2.CV_32F, window, normalize=False)
        for product in (edges.gx * edges.gx, edges.gx * edges.gy, edges.gy * edges.gy)
    )
    strength = np.asarray((a + c) / 2 - np.sqrt(((a - c) / 2) ** 2 + b * b), dtype=np.float32)
    noise = edges.gradient_noise / GRADIENT_NOISE
    around = np.ones((2 * APART_PX + 1, 2 * APART_PX + 1), dtype=np.uint8)
    peak = (strength >= cv2.dilate(strength, around)) & (strength > (noise / MAX_NOISE_PX) ** 2)
    inner = peak[BORDER_PX:-BORDER_PX, BORDER_PX:-BORDER_PX]
    row, column = (n + BORDER_PX for n in np.nonzero(inner))
    order = descending(strength[row, column].astype(np.float64))
    row, column = row[order], column[order]
    kept = _thin_out_parts(row, column, strength.shape)
    row, column = row[kept], column[kept]
    across = _shift(strength[row, column - 1], strength[row, column], strength[row, column + 1])
    down = _shift(strength[row - 1, column], strength[row, column], strength[row + 1, column])
    return np.stack([column + across, row + down], axis=1)


def _thin_out_parts(
    row: NDArray[np.intp], column: NDArray[np.intp], shape: tuple[int, ...]
) -> NDArray[np.intp]:
    part = row * GRID // shape[0] * GRID + column * GRID // shape[1]
    order = np.argsort(part, kind="stable")
    first = np.searchsorted(part[order], part[order])
    few = np.arange(len(order)) - first < MAX_OF_PART
    return np.sort(order[few])[:MAX_CORNERS]


def _shift(
    before: NDArray[np.float32], here: NDArray[np.float32], after: NDArray[np.float32]
) -> FloatArray:
    # Where the parabola through three neighbours peaks, px from the middle one.
    curve = np.minimum(before - 2.0 * here.astype(np.float64) + after, -1e-12)
    shift: FloatArray = np.clip(0.5 * (before - after) / curve, -0.5, 0.5)
    return shift


def _turns(view: View, uv: FloatArray, direction: FloatArray, away: float) -> FloatArray:
    # Directions (n, 2), unit vectors, in which the world's direction appears at each pixel.
    rays = np.column_stack([uv, np.ones(len(uv))]) @ np.linalg.inv(view.projection[:, :3]).T
    rays *= away / np.linalg.norm(rays, axis=1, keepdims=True)
    # A point that moves along it from x does so by (P3 d)(p12 - uv p3) / depth: only the direction.
    h = (view.pose.centre + rays) @ view.projection[:, :3].T + view.projection[:, 3]
    slope = view.projection[:, :3] @ direction
    moves = (slope[:2] - h[:, :2] / h[:, 2:] * slope[2]) / h[:, 2:]
    size = np.linalg.norm(moves, axis=1, keepdims=True)
    turns: FloatArray = moves / np.maximum(size, 1e-300)
    return turns


def _patches(view: View, uv: FloatArray, down: FloatArray, scale: float) -> NDArray[np.float32]:
    if not len(uv):
        return np.zeros((0, SAMPLES**2), dtype=np.float32)
    steps = (np.arange(SAMPLES) - (SAMPLES - 1) / 2) * STEP_PX * scale
    along, across = (grid.ravel() for grid in np.meshgrid(steps, steps, indexing="ij"))
    u = uv[:, :1] + down[:, :1] * along + down[:, 1:] * across
    v = uv[:, 1:] + down[:, 1:] * along - down[:, :1] * across
    smooth = cv2.GaussianBlur(view.image, (0, 0), BLUR_PX * scale)
    read = cv2.remap(
        smooth, u.astype(np.float32), v.astype(np.float32), cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_REPLICATE,
    ).astype(np.float32)  # fmt: skip
    read -= read.mean(axis=1, keepdims=True)
    read /= np.maximum(np.linalg.norm(read, axis=1, keepdims=True), np.float32(1e-6))
    return np.asarray(read, dtype=np.float32)


# Standard deviation of a corner's place, px: texture looks different from elsewhere, and its corner
# moves by a share of the window.
CORNER_SD_PX = 0.7
# A match lies this near to the epipolar line, in standard deviations of both corners.
LINE_SDS = 3.0
# Patches are alike from this correlation on: of two that have nothing in common, each of some
# twenty independent samples, it is 1 / √20 on average, and once in 300 as much as this.
MIN_CORRELATION = 0.6
# Ratio test: the second best match on the line must be this much farther off (Lowe 2004).
RATIO = 0.85
# Two views of a point prove nothing: the rays of a chance match on epipolar lines always meet.
MIN_TRACK = 3


def link_features(
    features: Mapping[int, TextureFeatures],
    views: Sequence[View],
    pairs: Sequence[tuple[int, int]],
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return pixels (n, V, 2) of n candidate points, and which views show them (n, V).

    `features` are those of the views (by their number) that the `pairs` name. Of a chain with two
    features of one view neither counts: they are not the same point.
    """
    numbers = sorted(features)
    counts = [len(features[k].uv) for k in numbers]
    first = dict(zip(numbers, np.cumsum([0, *counts[:-1]]).tolist(), strict=True))
    links = [np.zeros((0, 2), dtype=np.intp)]
    for i, j in pairs:
        found = match_features(features[i], features[j], views[i], views[j])
        links.append(found + np.array([first[i], first[j]]))
    a, b = np.concatenate(links).T
    total = sum(counts)
    graph = coo_array((np.ones(len(a), dtype=np.bool_), (a, b)), shape=(total, total))
    chains, label = connected_components(graph, directed=False)
    owner = np.repeat(np.array(numbers, dtype=np.intp), counts)
    often = np.zeros((chains, len(views)), dtype=np.intp)
    np.add.at(often, (label, owner), 1)
    kept = np.nonzero((often == 1).sum(axis=1) >= MIN_TRACK)[0]
    uv = np.zeros((chains, len(views), 2))
    if total:
        uv[label, owner] = np.concatenate([features[k].uv for k in numbers])
    return uv[kept], often[kept] == 1


def match_features(
    one: TextureFeatures, other: TextureFeatures, view: View, other_view: View
) -> NDArray[np.intp]:
    """Return pairs (m, 2) of features of two views that are each other's best match on epipolar
    lines.
    """
    if not len(one.uv) or not len(other.uv):
        return np.zeros((0, 2), dtype=np.intp)
    lines = np.column_stack([one.uv, np.ones(len(one.uv))]) @ _epipolar(view, other_view).T
    lines /= np.maximum(np.hypot(lines[:, 0], lines[:, 1]), 1e-300)[:, None]
    off = lines.astype(np.float32) @ np.vstack([other.uv.T, np.ones(len(other.uv))]).astype(
        np.float32
    )
    near = np.abs(off) < LINE_SDS * np.sqrt(2) * CORNER_SD_PX
    likeness = np.where(near, one.patches @ other.patches.T, np.float32(-1.0))
    rows = np.arange(len(one.uv))
    best = likeness.argmax(axis=1)
    alike = likeness[rows, best]
    mutual = likeness.argmax(axis=0)[best] == rows
    likely = np.nonzero(mutual & (alike > MIN_CORRELATION))[0]
    rest, places = likeness[likely], other.uv.astype(np.float32)
    there = places[best[likely]]
    apart = np.abs(there[:, :1] - places[:, 0]) > APART_PX
    apart |= np.abs(there[:, 1:] - places[:, 1]) > APART_PX
    second = np.where(apart, rest, np.float32(-1.0)).max(axis=1)
    # For unit vectors, |a - b|² = 2 - 2 a·b.
    clear = 1.0 - alike[likely] < RATIO**2 * (1.0 - second)
    return np.stack([likely[clear], best[likely[clear]]], axis=1)


def _epipolar(view: View, other: View) -> FloatArray:
    # F (3, 3): a pixel of the first view has the line F (u, v, 1) in the other one.
    onto = other.projection[:, :3] @ np.linalg.inv(view.projection[:, :3])
    x, y, z = other.projection @ np.append(view.pose.centre, 1.0)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]) @ onto


@dataclass(frozen=True, eq=False, slots=True)
class TexturePoints:
    """Points (n, 3) of the scene, their covariances (n, 3, 3), and which view sees which (n, V)."""

    points: FloatArray
    covs: FloatArray
    seen: NDArray[np.bool_]

    @classmethod
    def none(cls, views: int) -> Self:
        """Return no points in so many views."""
        return cls(np.zeros((0, 3)), np.zeros((0, 3, 3)), np.zeros((0, views), dtype=np.bool_))

    def take(self, rows: NDArray[np.intp] | NDArray[np.bool_]) -> Self:
        """Return some of the points."""
        return type(self)(self.points[rows], self.covs[rows], self.seen[rows])


def texture_points(
    views: Sequence[View],
    maps: Sequence[EdgeMap],
    graph: ViewGraph,
    pixel: float,
) -> TexturePoints:
    """Return texture points seen in three views or more; `pixel` is a pixel's length at the focus.

    Only the views that are paired for depth take part.
    """
    direction = find_common_direction(views)
    paired = sorted({k for pair in graph.pairs for k in pair})
    if len(paired) < MIN_TRACK:
        return TexturePoints.none(len(views))
    features = {
        k: find_texture_features(views[k], maps[k], direction, graph.focus, pixel) for k in paired
    }
    uv, seen = link_features(features, views, graph.pairs)
    if not len(uv):
        return TexturePoints.none(len(views))
    return triangulated(views, uv, CORNER_SD_PX, seen)


def triangulated(
    views: Sequence[View], uv: FloatArray, sd_px: float, seen: NDArray[np.bool_]
) -> TexturePoints:
    """Return the points in front of the cameras with three inlier views or more, and these views.

    `uv` (n, V, 2) are pixels with this standard deviation, where `seen` (n, V).
    """
    cameras = Cameras.of([view.projection for view in views])
    cov = np.broadcast_to(sd_px**2 * np.eye(2), (*seen.shape, 2, 2))
    agreed = find_agreeing_views(cameras, Sightings.of(cameras, uv, cov, seen))
    rows = np.flatnonzero(agreed.stands & ~agreed.behind)
    points = cameras.origin + cameras.scale * agreed.points[rows]
    return TexturePoints(points, cameras.scale**2 * agreed.covs[rows], agreed.inliers[rows])
