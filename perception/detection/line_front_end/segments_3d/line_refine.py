"""3-D segments fitted to the pictures' own gradients, all of them at once."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.edge_maps import EdgeMap
from facetlog.perception.detection.line_front_end.segments_3d.line_support import (
    project_points,
    segment_samples,
)
from facetlog.perception.types import FloatArray, View

SAMPLES = 24
# Half the width searched across a projected segment, px, in successive passes.
SEARCH_PX = (4.0, 3.0, 2.0)
STEP_PX = 0.5
# A reading counts as an edge when its gradient across the segment exceeds this many noise sd.
MIN_GRADIENT_SD = 3.0
# Two numbers determine a straight line in a picture: so many of its readings are independent.
READINGS_A_VIEW = 2
# Scale of the robust (Cauchy) weight, px: pose errors and texture beside an edge, not pixel noise.
ROBUST_PX = 1.0


@dataclass(frozen=True, eq=False, slots=True)
class EdgeReadings:
    """Edges measured across projected 3-D segments in one view.

    `offset` (n, m): distance in px of the edge from each sample along `normal` (n, 2), NaN where
    no edge was found; `uv` (n, m, 2) where the samples project; `strength` (n, m) the gradient in
    noise sd; `visible` (n, m) whether the sample is in the picture.
    """

    offset: FloatArray
    uv: FloatArray
    normal: FloatArray
    strength: FloatArray
    visible: NDArray[np.bool_]


def read_edges(view: View, edges: EdgeMap, points: FloatArray, search_px: float) -> EdgeReadings:
    """Return the strongest edge within `search_px` across each sample of segments, points (n, m,
    3).
    """
    uv, depth = project_points(view.projection, points)
    height, width = view.image.shape
    visible = (
        (depth > 0)
        & (uv[..., 0] >= 0)
        & (uv[..., 0] <= width - 1)
        & (uv[..., 1] >= 0)
        & (uv[..., 1] <= height - 1)
    )
    along = uv[:, -1] - uv[:, 0]
    norm = np.hypot(along[:, 0], along[:, 1])
    safe = np.where(norm > 0, norm, 1.0)
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1) / safe[:, None]
    reach = np.arange(-search_px - STEP_PX, search_px + 1.5 * STEP_PX, STEP_PX)
    across = np.zeros((*visible.shape, len(reach)), dtype=np.float32)
    u, v = (
        (np.where(visible, uv[..., k], -1e6)[..., None] + reach * normal[:, None, k, None])
        .astype(np.float32)
        .reshape(len(uv), -1)
        for k in (0, 1)
    )
    for k, slope in enumerate((edges.gx, edges.gy)):
        there = cv2.remap(slope, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
        across += there.reshape(across.shape) * normal[:, None, k, None].astype(np.float32)
    offset, strength = peak(np.abs(across), reach)
    strength = strength / edges.gradient_noise
    found = visible & (strength > MIN_GRADIENT_SD) & (norm > 0)[:, None]
    return EdgeReadings(np.where(found, offset, np.nan), uv, normal, strength, visible)


def peak(response: FloatArray, reach: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return places (...) of the highest maxima of responses (..., k) at `reach` (k,), and their
    heights.

    A height of 0 says that there is none, but at the rim, where it belongs to another edge. Steps
    of `reach` are STEP_PX.
    """
    # Refined by a parabola through it and what lies 1 px to either side: nearer ones share its
    # pixels, and would pull it by up to a sixth of one.
    n = round(1 / STEP_PX)
    k = np.argmax(response[..., n:-n], axis=-1) + n
    left, mid, right = (
        np.take_along_axis(response, (k + d)[..., None], -1)[..., 0] for d in (-n, 0, n)
    )
    curve = left - 2 * mid + right
    inner = response[..., n - 1 : response.shape[-1] - n + 1].max(axis=-1)
    peak = (mid >= inner) & (mid >= left) & (mid >= right) & (curve < 0)
    shift = np.where(peak, 0.5 * (left - right) / np.where(peak, curve, -1.0), 0.0)
    return reach[k] + shift * (reach[n] - reach[0]), np.where(peak, mid, 0.0)


def refine_segments(
    segments: FloatArray,
    views: Sequence[View],
    maps: Sequence[EdgeMap],
    use: NDArray[np.bool_],
    weight: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return segments (n, 2, 3) moved across themselves to the edges of the views in `use` (n, V).

    Gauss-Newton over four numbers a segment (both ends move in the plane across it), Cauchy
    weights. Return the segments, the covariance of their ends across themselves (n, 2, 3, 3) and
    the robust rms of their residuals in px (n,); both are NaN where no edge was read.
    """
    segments = segments.copy()
    rms = np.full(len(segments), np.nan)
    end_covs = np.zeros((len(segments), 2, 3, 3))
    for search in SEARCH_PX:
        basis = build_across_basis(segments)
        h = np.zeros((len(segments), 4, 4))
        g = np.zeros((len(segments), 4))
        total = np.zeros(len(segments))
        square = np.zeros(len(segments))
        points = segment_samples(segments, SAMPLES)
        for k, (view, edges) in enumerate(zip(views, maps, strict=True)):
            chosen = np.nonzero(use[:, k])[0]
            if not len(chosen):
                continue
            r = read_edges(view, edges, points[chosen], search)
            jacobian = compute_ends_jacobian(
                compute_point_jacobian(view, points[chosen], r), basis[chosen]
            )
            found = np.isfinite(r.offset)
            e = np.where(found, r.offset, 0.0)
            w = weight[k] * found / (1.0 + (e / ROBUST_PX) ** 2)
            h[chosen] += np.einsum("nm,nma,nmb->nab", w, jacobian, jacobian)
            g[chosen] += np.einsum("nm,nma,nm->na", w, jacobian, e)
            total[chosen] += w.sum(axis=1)
            square[chosen] += (w * e**2).sum(axis=1)
        step = _solve(h, g)
        segments[:, 0] += np.einsum("nka,na->nk", basis, step[:, :2])
        segments[:, 1] += np.einsum("nka,na->nk", basis, step[:, 2:])
        rms = np.sqrt(np.where(total > 0, square / np.where(total > 0, total, 1.0), np.nan))
        end_covs = _end_covs(h, basis, rms)
    return segments, end_covs, rms


def _end_covs(h: FloatArray, basis: FloatArray, rms: FloatArray) -> FloatArray:
    # The readings of a segment in one view share the error of the view's pose: all together they
    # count as READINGS_A_VIEW.
    scale = np.trace(h, axis1=1, axis2=2)[:, None, None]
    cov = np.linalg.inv(h + (1e-6 * scale + 1e-300) * np.eye(4))
    cov *= (rms**2 * SAMPLES / READINGS_A_VIEW)[:, None, None]
    ends = np.stack([cov[:, :2, :2], cov[:, 2:, 2:]], axis=1)
    covs: FloatArray = basis[:, None] @ ends @ basis.transpose(0, 2, 1)[:, None]
    return covs


def build_across_basis(segments: FloatArray) -> FloatArray:
    """Return two unit vectors (n, 3, 2) at right angles to each segment (n, 2, 3)."""
    along = segments[:, 1] - segments[:, 0]
    along = along / np.linalg.norm(along, axis=1, keepdims=True)
    least = np.eye(3)[np.argmin(np.abs(along), axis=1)]
    first = np.cross(along, least)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(along, first)], axis=-1)


def compute_point_jacobian(view: View, points: FloatArray, r: EdgeReadings) -> FloatArray:
    """Return d(normal · uv) / d(point), (n, m, 3), of samples (n, m, 3) of segments."""
    # n · (rows of the projection - uv · its depth row) / depth
    p = view.projection[:, :3]
    depth = points @ p[2] + view.projection[2, 3]
    safe = np.where(depth > 0, depth, np.inf)
    rows = p[:2] - r.uv[..., None] * p[2]
    jacobian: FloatArray = np.einsum("nk,nmkx->nmx", r.normal, rows) / safe[..., None]
    return jacobian


def compute_ends_jacobian(by_point: FloatArray, basis: FloatArray) -> FloatArray:
    """Return d(normal · uv) / d(both ends across the segment), (n, m, 4).

    `by_point` (n, m, 3) is `compute_point_jacobian` at samples as `segment_samples` has them,
    `basis` `build_across_basis`; the four numbers are those of the start, then those of the end.
    """
    samples = by_point.shape[1]
    t = (np.arange(samples) + 0.5) / samples  # a sample is (1 - t) start + t end
    by_basis = np.einsum("nmx,nxa->nma", by_point, basis)
    return np.concatenate([(1 - t)[:, None] * by_basis, t[:, None] * by_basis], axis=-1)


def _solve(h: FloatArray, g: FloatArray) -> FloatArray:
    # A little damping: a segment read in too few places does not move where it is undetermined.
    scale = np.trace(h, axis1=1, axis2=2)[:, None, None]
    damped = h + (1e-6 * scale + 1e-300) * np.eye(4)
    solution: FloatArray = np.linalg.solve(damped, g[..., None])[..., 0]
    return solution
