"""Which outlines are faces: shown whole by single views, of one surface, hiding no other face."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.detection.edge_maps import EdgeMap
from facetlog.perception.detection.line_front_end.face_inside import FACING_SINE, InsideJudge
from facetlog.perception.detection.line_front_end.ground_plane import Ground
from facetlog.perception.detection.line_front_end.line_support import hits, segment_samples
from facetlog.perception.detection.line_front_end.outline_search import Outline
from facetlog.perception.detection.line_front_end.plane_hypotheses import plane_basis
from facetlog.perception.detection.view_graph import ViewGraph
from facetlog.perception.ties import TIE, descending
from facetlog.perception.types import FloatArray, View

__all__ = ["MAX_BLOCKED", "SelectedFace", "blocked_share", "select_faces"]

# A view shows an outline when this share of its sides is found, the weakest side at least half so.
SHOWN = 0.75
# Distinct views that must show it.
MIN_SHOWN = 1.5
# Of the distinct views that face it, this share must show it: the rest may be hidden or too dark.
MIN_SHOWN_SHARE = 0.25
# Share of a face's inside where all views together rather show one surface than not: one looks
# through the rest, or it lies beyond the true border. True faces of 27 rendered sets have .82 and
# more, in each set; not tried on sets of another kind.
MIN_SURFACE = 0.75
# Overlap of two coplanar faces, as a share of the smaller.
MAX_OVERLAP = 0.15
# Two planes are one within this angle, and this many px at the face's middle.
SAME_PLANE_COSINE = np.cos(np.radians(10.0))
SAME_PLANE_PX = 6.0
# Share of the sight lines to what was seen that a face may block.
MAX_BLOCKED = 0.2
SIDE_SAMPLES = 12


@dataclass(frozen=True, eq=False, slots=True)
class SelectedFace:
    """An outline judged a face, its corners counter-clockwise seen from the side that views see.

    `shown` (V,) tells which views show it whole; `support` is the mean coverage in those.
    """

    corners: FloatArray
    lines: tuple[int, ...]
    normal: FloatArray
    shown: NDArray[np.bool_]
    support: float


def select_faces(
    outlines: Sequence[Outline],
    views: Sequence[View],
    maps: Sequence[EdgeMap],
    graph: ViewGraph,
    pixel: float,
    ground: Ground | None = None,
) -> tuple[SelectedFace, ...]:
    """Faces among the outlines, the worthiest first, none contradicting a worthier one.

    What lies on the ground, where that is known, is none.
    """
    inside = InsideJudge(views, maps, graph.weight)
    faces: list[SelectedFace] = []
    for n in descending(np.array([o.worth for o in outlines])):
        outline = outlines[n]
        if ground is not None and ground.holds(outline.corners):
            continue
        if any(_overlap(outline.corners, outline.normal, f, pixel) for f in faces):
            continue
        face = _judged(outline, views, maps, graph)
        if face is None or inside.surface_share(face.corners, face.normal) < MIN_SURFACE:
            continue
        if any(_blocks(face, f, views, pixel) or _blocks(f, face, views, pixel) for f in faces):
            continue
        faces.append(face)
    return tuple(faces)


def _judged(
    outline: Outline, views: Sequence[View], maps: Sequence[EdgeMap], graph: ViewGraph
) -> SelectedFace | None:
    corners = outline.corners
    sides = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    length = np.linalg.norm(sides[:, 1] - sides[:, 0], axis=1)
    samples = segment_samples(sides, SIDE_SAMPLES)
    middle = corners.mean(axis=0)
    cover = np.zeros(len(views))
    shown = np.zeros(len(views), np.bool_)
    sine = np.zeros(len(views))
    for k, (view, edges) in enumerate(zip(views, maps, strict=True)):
        ray = view.pose.centre - middle
        sine[k] = ray @ outline.normal / np.linalg.norm(ray)
        found, inside = hits(view, edges, samples)
        if not inside.all():
            continue
        by_side = found.mean(axis=1)
        cover[k] = (by_side * length).sum() / length.sum()
        shown[k] = cover[k] >= SHOWN and by_side.min() >= SHOWN / 2
    best: SelectedFace | None = None
    best_weight = 0.0
    for sign in (1.0, -1.0):
        facing = sign * sine > FACING_SINE
        weight = float((graph.weight * (shown & facing)).sum())
        possible = float((graph.weight * facing).sum())
        enough = max(MIN_SHOWN, MIN_SHOWN_SHARE * possible)
        # As often seen from behind as from the front: the front, in the order given.
        if weight >= enough * (1 - TIE) and weight > best_weight * (1 + TIE):
            best_weight = weight
            chosen = shown & facing
            normal = sign * outline.normal
            ring, lines = _counter_clockwise(corners, outline.lines, normal)
            best = SelectedFace(ring, lines, normal, chosen, float(cover[chosen].mean()))
    return best


def _counter_clockwise(
    corners: FloatArray, lines: tuple[int, ...], normal: FloatArray
) -> tuple[FloatArray, tuple[int, ...]]:
    area = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
    if area @ normal > 0:
        return corners, lines
    # Reversed, side i runs from the old corner k - i to k - i - 1: it is the old side k - i - 1.
    k = len(lines)
    return corners[::-1].copy(), tuple(lines[(k - 2 - i) % k] for i in range(k))


def _overlap(corners: FloatArray, normal: FloatArray, face: SelectedFace, pixel: float) -> bool:
    if abs(normal @ face.normal) < SAME_PLANE_COSINE:
        return False
    apart = np.abs((corners - face.corners.mean(axis=0)) @ face.normal)
    if apart.min() > SAME_PLANE_PX * pixel:
        return False
    basis = plane_basis(face.normal)
    a = shapely.Polygon(corners @ basis)
    b = shapely.Polygon(face.corners @ basis)
    return bool(a.intersection(b).area > MAX_OVERLAP * min(a.area, b.area))


def _blocks(near: SelectedFace, far: SelectedFace, views: Sequence[View], pixel: float) -> bool:
    # The far face's sides were seen; do those sight lines pass through the inside of the near one?
    sides = np.stack([far.corners, np.roll(far.corners, -1, axis=0)], axis=1)
    targets = segment_samples(sides, 6).reshape(-1, 3)
    centres = np.array([v.pose.centre for v, seen in zip(views, far.shown, strict=True) if seen])
    return blocked_share(near, targets, centres, SAME_PLANE_PX * pixel) > MAX_BLOCKED


def blocked_share(
    face: SelectedFace, targets: FloatArray, centres: FloatArray, margin: float
) -> float:
    """Share of the sight lines from centres (c, 3) to targets (s, 3) that pass through the face.

    Lines that pass within `margin` of its outline, or end within it of its plane, go free.
    """
    offset = face.normal @ face.corners.mean(axis=0)
    before = centres @ face.normal - offset  # (c,)
    behind = targets @ face.normal - offset  # (s,)
    crosses = (before[:, None] * behind < 0) & (np.abs(behind) > margin)
    if not crosses.any():
        return 0.0
    t = before[:, None] / np.where(crosses, before[:, None] - behind, 1.0)
    at = centres[:, None] + t[..., None] * (targets - centres[:, None])
    basis = plane_basis(face.normal)
    inner = shapely.Polygon(face.corners @ basis).buffer(-margin)
    flat = at @ basis
    inside = shapely.contains_xy(inner, flat[..., 0], flat[..., 1]) & crosses
    return float(inside.mean())
