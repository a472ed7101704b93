"""Corners of faces as tracks: in each view the fitted sides of a face meet in a measured corner."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.candidate_faces import SelectedFace
from facetlog.perception.detection.line_front_end.face_selection import TOUCH_PX
from facetlog.perception.detection.line_front_end.segments_3d.line_support import project_points
from facetlog.perception.detection.line_front_end.side_fit import SideFits
from facetlog.perception.detection.tracked_faces import Completion
from facetlog.perception.stable_order import ascending
from facetlog.perception.types import FloatArray, Observation, Track, View

# Corners of two faces that touch are one vertex within this share of a side that ends there, and
# within so many px of either's plane.
MERGE_SHARE = 0.25
ON_PLANE_PX = 4.0
# Standard deviation of the end of an edge along it, where no other edge ends it, px.
END_SD_PX = 4.0
# Standard deviation of a corner of an outline that its sides do not determine in the pictures, px:
# the cells in which regions are outlined (plane_regions.FINE_PX). The views share this error.
OUTLINE_SD_PX = 2.0
# An intersection farther than this from the outline's corner, px, is of other edges: three of those
# standard deviations.
MAX_OFF_PX = 6.0
# Two sides determine a corner when they cross at more than 15 degrees.
MIN_SPREAD = 1 - np.cos(np.radians(15.0))


@dataclass(frozen=True, eq=False, slots=True)
class Corners:
    """Vertices (n, 3) that faces share, each face's loop of them, and the loops of its holes."""

    points: FloatArray
    loops: tuple[tuple[int, ...], ...]
    holes: tuple[tuple[tuple[int, ...], ...], ...]

    @property
    def rings(self) -> tuple[tuple[int, tuple[int, ...]], ...]:
        """All loops, outlines and holes, each with the number of its face."""
        of_faces = enumerate(zip(self.loops, self.holes, strict=True))
        return tuple((k, ring) for k, (loop, holes) in of_faces for ring in (loop, *holes))

    @property
    def sides(self) -> tuple[tuple[int, int], ...]:
        """All different sides, as (smaller, larger) vertex."""
        return tuple(sorted({side for _, ring in self.rings for side in _sides(ring)}))

    @property
    def segments(self) -> FloatArray:
        """The sides (n, 2, 3) from the smaller to the larger vertex."""
        segments: FloatArray = self.points[np.array(self.sides)]
        return segments

    def find_shown_side_views(self, shown: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return which views show which side (n, V), by those that show its faces (faces, V)."""
        number = {side: k for k, side in enumerate(self.sides)}
        visible = np.zeros((len(number), shown.shape[1]), np.bool_)
        for face, ring in self.rings:
            for side in _sides(ring):
                visible[number[side]] |= shown[face]
        return visible


def _sides(ring: tuple[int, ...]) -> list[tuple[int, int]]:
    return [(min(a, b), max(a, b)) for a, b in zip(ring, ring[1:] + ring[:1], strict=True)]


def merge_corners(faces: Sequence[SelectedFace], pixel: float) -> Corners:
    """Merge corners of different faces that lie together into one vertex, nearest pairs first."""
    rings = [(k, ring) for k, f in enumerate(faces) for ring in (f.corners, *f.holes)]
    points = np.concatenate([ring for _, ring in rings])
    owner = np.repeat([k for k, _ in rings], [len(ring) for _, ring in rings])
    sides = [np.linalg.norm(ring - np.roll(ring, -1, axis=0), axis=1) for _, ring in rings]
    shorter = np.concatenate([np.minimum(side, np.roll(side, 1)) for side in sides])
    limit = np.minimum(TOUCH_PX * pixel, MERGE_SHARE * shorter)
    apart = np.linalg.norm(points[:, None] - points[None], axis=-1)
    # A vertex that two faces share lies on both planes.
    normals = np.array([f.normal for f in faces])
    distances = np.array([f.normal @ f.corners.mean(axis=0) for f in faces])
    off = np.abs(points @ normals.T - distances)[:, owner]  # of corner i from the plane of j's face
    on_both = np.maximum(off, off.T) < ON_PLANE_PX * pixel
    i, j = np.nonzero(np.triu((apart < np.minimum(limit[:, None], limit[None])) & on_both, 1))
    group = np.arange(len(points))
    for n in ascending(apart[i, j]):
        a, b = group[i[n]], group[j[n]]
        # A face keeps its corners apart.
        if a != b and not set(owner[group == a]) & set(owner[group == b]):
            group[group == b] = a
    _, vertex = np.unique(group, return_inverse=True)
    merged = np.array([points[vertex == k].mean(axis=0) for k in range(vertex.max() + 1)])
    ends = np.cumsum([len(ring) for _, ring in rings])[:-1]
    numbered = iter(tuple(int(v) for v in part) for part in np.split(vertex, ends))
    of_faces = [tuple(islice(numbered, 1 + len(f.holes))) for f in faces]
    return Corners(merged, tuple(r[0] for r in of_faces), tuple(r[1:] for r in of_faces))


def track_corners(
    corners: Corners, views: Sequence[View], fits: Sequence[SideFits]
) -> tuple[Track, ...]:
    """Return one track a vertex: where its sides meet in each view.

    `fits` are those of the corners' sides in the views that show them.
    """
    start, end = np.array(corners.sides).T
    found: list[list[Observation]] = [[] for _ in corners.points]
    for k, (view, lines) in enumerate(zip(views, fits, strict=True)):
        uv, _ = project_points(view.projection, corners.points)
        for vertex, place in enumerate(uv):
            ends = [(int(s), 0) for s in np.nonzero(lines.good & (start == vertex))[0]]
            ends += [(int(s), 1) for s in np.nonzero(lines.good & (end == vertex))[0]]
            corner = _meeting(place, ends, lines)
            if corner is not None and np.linalg.norm(corner[0] - place) < MAX_OFF_PX:
                found[vertex].append(Observation(k, *corner))
    return tuple(Track(tuple(seen)) for seen in found)


def track_outline_corners(
    corners: Corners, shown: NDArray[np.bool_], views: Sequence[View]
) -> tuple[Track, ...]:
    """Return one track a vertex: the corner of its faces' outlines in the views that show one of
    them.

    Used where the sides determine no corner, as on a curve or behind another thing. All the views
    together have the standard deviation OUTLINE_SD_PX: they share the outline's error.
    """
    tracks = []
    for vertex, point in enumerate(corners.points):
        faces = [face for face, ring in corners.rings if vertex in ring]
        seen = np.nonzero(shown[faces].any(axis=0))[0].tolist()
        cov = OUTLINE_SD_PX**2 * len(seen) * np.eye(2)
        placed = [(k, *project_points(views[k].projection, point)) for k in seen]
        tracks.append(Track(tuple(Observation(k, uv, cov) for k, uv, depth in placed if depth > 0)))
    return tuple(tracks)


def complete_corners(
    corners: Corners, faces: Sequence[SelectedFace], pixel: float
) -> tuple[Completion, ...]:
    """Return places of corners that belong only to faces whose planes are implied by their
    neighbours.

    Each relative to a corner of a neighbour, as accurate as an outline; `pixel` as before.
    """
    known = {v for face, ring in corners.rings if faces[face].plane_cov is not None for v in ring}
    found: dict[int, Completion] = {}
    for loop in corners.loops:
        for vertex, before, after in zip(
            loop, loop[-1:] + loop[:-1], loop[1:] + loop[:1], strict=True
        ):
            beside = [v for v in (before, after) if v in known]
            if vertex not in known and beside:
                offset = corners.points[vertex] - corners.points[beside[0]]
                sd = OUTLINE_SD_PX * pixel
                found.setdefault(vertex, Completion(vertex, beside[0], offset, sd))
    return tuple(found.values())


def track_ends(
    edges: FloatArray,
    visible: NDArray[np.bool_],
    views: Sequence[View],
    fits: Sequence[SideFits],
) -> tuple[Track, ...]:
    """Return two tracks for each loose edge (m, 2, 3): where its start and its end are in each
    view.

    `visible` (m, V) says which views show it, `fits` where. Across the edge an end has the standard
    deviation of the readings; along it END_SD_PX, an error that all the views share.
    """
    found: list[list[Observation]] = [[] for _ in range(2 * len(edges))]
    shared = END_SD_PX**2 * np.maximum(visible.sum(axis=1), 1)
    for k, (view, lines) in enumerate(zip(views, fits, strict=True)):
        uv, _ = project_points(view.projection, edges)
        for m in np.nonzero(lines.good)[0]:
            normal = lines.normal[m]
            along = np.array([normal[1], -normal[0]])
            for end in (0, 1):
                cov = lines.variance[m, end] * np.outer(normal, normal)
                cov += shared[m] * np.outer(along, along)
                place = uv[m, end] + lines.offset[m, end] * normal
                found[2 * m + end].append(Observation(k, place, cov))
    return tuple(Track(tuple(seen)) for seen in found)


def _meeting(
    place: FloatArray, ends: list[tuple[int, int]], lines: SideFits
) -> tuple[FloatArray, FloatArray] | None:
    # Each side says n · x = n · place + offset; least squares by their variances.
    if len(ends) < 2:
        return None
    normal = np.array([lines.normal[s] for s, _ in ends])
    if np.linalg.eigvalsh(normal.T @ normal)[0] < MIN_SPREAD:
        return None
    value = np.array([lines.offset[s, e] for s, e in ends]) + normal @ place
    weight = 1.0 / np.array([lines.variance[s, e] for s, e in ends])
    cov = np.linalg.inv((normal.T * weight) @ normal)
    return cov @ (normal.T * weight) @ value, cov
