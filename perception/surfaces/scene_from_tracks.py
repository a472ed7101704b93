"""Tracks and loops into a scene: vertices by the filter, faces by the plane filter, edges."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.tracked_faces import TrackedFaces
from facetlog.perception.estimation.plane_filter import fit_plane
from facetlog.perception.estimation.point_filter import estimate_point, estimate_points
from facetlog.perception.estimation.shared_error import shared_error_factor, view_groups
from facetlog.perception.types import (
    Edge,
    Face,
    FloatArray,
    Observation,
    Scene,
    Track,
    Vertex,
    View,
)

__all__ = ["assemble", "pose_noise_px"]

# Start of the search for the poses' own error: what real poses have, px.
START_NOISE_PX = 1.0
# A vertex needs this many views in which its sides fix it; else its outline's place stands in.
MIN_FIXED = 3
# Median of a chi-square with two degrees of freedom, over its mean.
MEDIAN_OVER_MEAN = 2 * np.log(2) / 2


def assemble(
    tracked: TrackedFaces,
    views: Sequence[View],
    *,
    name: str,
    up: FloatArray | None,
    metric: bool,
    sd_limit: float | None = None,
) -> Scene:
    """The scene of the tracked faces; tracks without a point and faces without a plane drop out.

    Poses are never exact: what the residuals of all tracks show beyond the corners' own noise is
    added to it; views taken from almost one place share one error, not many, and what larger groups
    of them share widens all covariances alike (shared_error.py). With `sd_limit`
    a vertex takes its observations in the order of the views until its largest standard
    deviation is below; vertices that never get there are named in a warning.
    """
    projections = np.array([v.projection for v in views])
    uv, cov, seen = _as_arrays(tracked.tracks, len(views))
    # The ends of loose edges are hardly known along them: their residuals say nothing of the poses.
    corners = np.unique([k for face in tracked.faces for k in face.outline]).astype(np.intp)
    if not len(corners):
        corners = np.arange(len(uv))
    extra = pose_noise_px(uv[corners], cov[corners], seen[corners], projections) ** 2
    cov = cov + (extra / np.array(tracked.weight))[None, :, None, None] * np.eye(2)
    points, covs, used, ok = estimate_points(uv, cov, seen, projections)

    groups = view_groups(np.array([v.pose.centre for v in views]))
    factor = shared_error_factor(
        uv[corners], cov[corners], used[corners], projections, covs[corners], groups
    )
    cov, covs = cov * factor, covs * factor
    refused = [k for k in corners.tolist() if not ok[k] or used[k].sum() < MIN_FIXED]
    refused = [k for k in refused if k < len(tracked.stand_ins)]
    tracks = list(tracked.tracks)
    for k in refused:
        tracks[k] = tracked.stand_ins[k]
    uv[refused], cov[refused], seen[refused] = _as_arrays([tracks[k] for k in refused], len(views))
    again = estimate_points(uv[refused], cov[refused], seen[refused], projections)
    points[refused], covs[refused], used[refused], ok[refused] = again

    warnings = list(tracked.warnings)
    if sd_limit is not None:
        reached = _stop_at(sd_limit, uv, cov, used, ok, projections, points, covs)
        if reached < ok.sum():
            warnings.append(
                f"{ok.sum() - reached} of {ok.sum()} vertices did not reach the standard "
                f"deviation of {sd_limit:g}: more views are needed"
            )

    number = {int(k): n for n, k in enumerate(np.nonzero(ok)[0])}
    vertices = tuple(
        Vertex(
            points[k],
            covs[k],
            tuple(
                Observation(o.view, o.uv, cov[k, o.view])
                for o in tracks[k].observations
                if used[k, o.view]
            ),
            tracks[k].label,
        )
        for k in number
    )
    faces: list[Face] = []
    support: dict[tuple[int, int], float] = {}
    for face in tracked.faces:
        if not all(k in number for k in face.outline):
            continue
        loop = tuple(number[k] for k in face.outline)
        ring = np.array([vertices[k].point for k in loop])
        fit = fit_plane(ring, np.array([vertices[k].cov for k in loop]))
        if not fit:
            continue
        # Newell's normal: the loop runs counter-clockwise about the outward side.
        newell = np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0)
        plane = fit.plane if newell @ fit.plane.normal > 0 else fit.plane.flipped()
        faces.append(Face(loop, plane, support=face.support, coverage=face.coverage))
        for a, b in zip(loop, loop[1:] + loop[:1], strict=True):
            side = (min(a, b), max(a, b))
            support[side] = max(support.get(side, 0.0), face.support)
    for a, b in tracked.edges:
        if a in number and b in number:
            support.setdefault((min(number[a], number[b]), max(number[a], number[b])), 1.0)
    return Scene(
        name=name,
        views=tuple(v.name for v in views),
        vertices=vertices,
        edges=tuple(Edge(a, b, s) for (a, b), s in sorted(support.items())),
        faces=tuple(faces),
        up=up,
        metric=metric,
        warnings=tuple(warnings),
    )


def _stop_at(
    sd_limit: float,
    uv: FloatArray,
    cov: FloatArray,
    used: NDArray[np.bool_],
    ok: NDArray[np.bool_],
    projections: FloatArray,
    points: FloatArray,
    covs: FloatArray,
) -> int:
    # Runs the recursion view by view up to the limit and writes its results into the arrays;
    # returns how many points reached it.
    reached = 0
    for k in np.nonzero(ok)[0]:
        seen = [Observation(int(v), uv[k, v], cov[k, v]) for v in np.nonzero(used[k])[0]]
        estimate = estimate_point(seen, list(projections), sd_limit=sd_limit)
        if not estimate:
            continue
        points[k], covs[k] = estimate.point, estimate.cov
        used[k] = False
        used[k, [seen[i].view for i in estimate.used]] = True
        reached += estimate.views_needed is not None
    return reached


def pose_noise_px(
    uv: FloatArray, cov: FloatArray, seen: NDArray[np.bool_], projections: FloatArray
) -> float:
    """Standard deviation in px, per axis, of what the corners' own noise does not explain.

    Shapes as in `estimate_points`. Robust: from the median of the residuals over all tracks.
    """
    loose = cov + START_NOISE_PX**2 * np.eye(2)
    points, _, used, ok = estimate_points(uv, loose, seen, projections)
    used = used & ok[:, None]
    if not used.any():
        return START_NOISE_PX
    h = np.einsum("vij,nj->nvi", projections[:, :, :3], points) + projections[:, :, 3]
    with np.errstate(invalid="ignore"):
        residual = uv - h[..., :2] / h[..., 2:]
    # A point takes three of its observations' 2 n numbers for itself.
    freedom = np.maximum(1.0 - 1.5 / np.maximum(used.sum(axis=1), 2), 0.25)
    square = ((residual**2).sum(axis=-1) / 2 / freedom[:, None])[used]
    own = (np.trace(cov, axis1=2, axis2=3) / 2)[used]
    excess = np.median(square) / MEDIAN_OVER_MEAN - np.median(own)
    return float(np.sqrt(max(excess, 0.0)))


def _as_arrays(
    tracks: Sequence[Track], view_count: int
) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    shape = (len(tracks), view_count)
    uv, cov = np.zeros((*shape, 2)), np.tile(np.eye(2), (*shape, 1, 1))
    seen = np.zeros(shape, np.bool_)
    for n, track in enumerate(tracks):
        for o in track.observations:
            uv[n, o.view], cov[n, o.view], seen[n, o.view] = o.uv, o.cov, True
    return uv, cov, seen
