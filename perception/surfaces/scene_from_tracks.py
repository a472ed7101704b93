"""Tracks and loops into a scene: vertices by the filter, faces by the plane filter, edges."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.segments_3d.line_support import project_to_views
from facetlog.perception.detection.tracked_faces import Completion, FacePlane, TrackedFaces
from facetlog.perception.estimation.bundle_adjustment.adjusted_points import (
    AdjustedPoints,
    adjusted_points,
    estimate_points_at,
)
from facetlog.perception.estimation.bundle_adjustment.normal_equations import Tracks
from facetlog.perception.estimation.plane_filter import fit_plane, propagate_common_errors
from facetlog.perception.estimation.point_filter import estimate_point
from facetlog.perception.flat_faces import compute_vector_area, make_plane_axes
from facetlog.perception.scene import Edge, Evidence, Face, Scene, Vertex
from facetlog.perception.types import FloatArray, Observation, PoseErrors, Track, View

# A vertex needs this many views in which its sides fix it, and lies on its faces' planes within so
# many standard deviations; else its outline's place stands in.
MIN_FIXED = 3
OFF_SDS = 3.0


@dataclass(frozen=True, eq=False, slots=True)
class Stated:
    """Statements about a scene beside its views: name, world frame, unit and errors of poses.

    With `sd_limit` a vertex takes its observations in the order of the views until its largest
    standard deviation is below. `lens_is_off` says that the lenses are known not to be as stated.
    """

    name: str
    up: FloatArray | None = None
    metric: bool = False
    sd_limit: float | None = None
    errors: PoseErrors | None = None
    lens_is_off: bool = False


@dataclass(frozen=True, eq=False, slots=True)
class Assembled:
    """A scene, and how much less sure its views are than their pixels say: `factor` times a
    variance to which `extra_px` was added (AdjustedPoints).
    """

    scene: Scene
    extra_px: float
    factor: float


def assemble(tracked: TrackedFaces, views: Sequence[View], stated: Stated) -> Assembled:
    """Return the scene of the tracked faces, without tracks that have no point or plane.

    Poses are never exact: they are adjusted together with the corners of the faces, by what is
    stated of their errors and what the residuals show beyond that (bundle_adjustment/); so are
    lenses that the residuals show to be off, or that are known to be. All else is estimated at the
    adjusted poses, and all covariances have what these are off. Vertices that never get below the
    stated limit of their standard deviation are counted in a warning.
    """
    tracks = list(tracked.tracks)
    seen = _make_track_arrays(tracks, tracked.weight)
    # The ends of loose edges are hardly known along them: their residuals say nothing of the poses.
    corners = np.unique([k for face in tracked.faces for k in face.corners]).astype(np.intp)
    if not len(corners):
        corners = np.arange(len(tracks))
    placed = adjusted_points(seen.rows(corners), views, stated.errors, stated.lens_is_off)

    few = placed.used.sum(axis=1) < MIN_FIXED
    corner = {int(k): n for n, k in enumerate(corners)}
    moved_px = _measure_moved_px(placed, views)
    planes = [_widen_plane_cov(face.plane, moved_px) for face in tracked.faces]
    # A corner that lies on one of its faces is right, however far off the other ones are: a thin
    # face beside a broad one says little.
    of_planes, on = np.zeros((2, len(corners)), dtype=np.bool_)
    for face, known in zip(tracked.faces, planes, strict=True):
        if known is not None:
            rows = [corner[k] for k in face.corners]
            of_planes[rows] = True
            on[rows] |= ~_off(known, placed.points[rows], placed.covs[rows])
    few |= of_planes & ~on
    refused = [k for k in corners[few].tolist() if k < len(tracked.stand_ins)]
    for k in refused:
        tracks[k] = tracked.stand_ins[k]
    seen = _make_track_arrays(tracks, tracked.weight)
    found = estimate_points_at(seen, placed)
    left_open = [
        None if known is None else _pull_onto_plane(known, face.corners, found)
        for face, known in zip(tracked.faces, planes, strict=True)
    ]
    for c in tracked.completions:
        _complete(c, found)
    points, covs, used, ok = found.points, found.covs, found.used, found.ok
    cov = found.factor * seen.noise(found.extra_px)

    warnings = list(tracked.warnings)
    if stated.sd_limit is not None:
        reached = _stop_at(stated.sd_limit, seen.uv, cov, found)
        if reached < ok.sum():
            warnings.append(
                f"{ok.sum() - reached} of {ok.sum()} vertices did not reach the standard "
                f"deviation of {stated.sd_limit:g}: more views are needed"
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
    measured: set[tuple[int, int]] = set()
    for face, off_plane in zip(tracked.faces, left_open, strict=True):
        if not all(k in number for k in face.outline):
            continue
        loop = tuple(number[k] for k in face.outline)
        ring = np.array([vertices[k].point for k in loop])
        # What moves all of the scene alike is in no plane's covariance (plane_filter.py).
        fit = fit_plane(ring, found.shape_covs[list(face.outline)])
        if not fit:
            continue
        plane = fit.plane
        if off_plane is not None:
            of_outline = off_plane[: len(loop), : len(loop)]
            plane = propagate_common_errors(plane, ring, of_outline)
        # Newell's normal: the loop runs counter-clockwise about the outward side.
        if compute_vector_area(ring) @ plane.normal < 0:
            plane = plane.flipped()
        evidence = Evidence.IMPLIED if face.implied else Evidence.MEASURED
        inner = [tuple(number[k] for k in h) for h in face.holes if all(k in number for k in h)]
        holes = _choose_sound_holes(loop, inner, plane.normal, vertices)
        faces.append(Face(loop, plane, holes, face.support, evidence=evidence))
        rings = (loop, *holes)
        for a, b in chain.from_iterable(zip(r, r[1:] + r[:1], strict=True) for r in rings):
            side = (min(a, b), max(a, b))
            support[side] = max(support.get(side, 0.0), face.support)
            if not face.implied:
                measured.add(side)
    for a, b in tracked.edges:
        if a in number and b in number:
            side = (min(number[a], number[b]), max(number[a], number[b]))
            support.setdefault(side, 1.0)
            measured.add(side)
    scene = Scene(
        name=stated.name,
        views=tuple(v.name for v in views),
        vertices=vertices,
        edges=tuple(
            Edge(*side, s, Evidence.MEASURED if side in measured else Evidence.IMPLIED)
            for side, s in sorted(support.items())
        ),
        faces=tuple(faces),
        up=stated.up,
        metric=stated.metric,
        warnings=tuple(warnings),
        poses=tuple(v.pose for v in found.views),
        cameras=tuple(v.camera for v in found.views),
        lenses=() if found.adjusted is None else found.adjusted.lens_errors,
    )
    return Assembled(drop_unused(scene, scene.edges), found.extra_px, found.factor)


def drop_unused(scene: Scene, edges: Sequence[Edge]) -> Scene:
    """Return the scene with these of its edges, and without vertices that nothing has any more."""
    rings = [ring for face in scene.faces for ring in (face.outline, *face.holes)]
    used = sorted(
        {k for ring in rings for k in ring} | {k for e in edges for k in (e.start, e.end)}
    )
    new = {k: n for n, k in enumerate(used)}
    return replace(
        scene,
        vertices=tuple(scene.vertices[k] for k in used),
        edges=tuple(replace(e, start=new[e.start], end=new[e.end]) for e in edges),
        faces=tuple(
            replace(
                face,
                outline=tuple(new[k] for k in face.outline),
                holes=tuple(tuple(new[k] for k in hole) for hole in face.holes),
            )
            for face in scene.faces
        ),
    )


def _choose_sound_holes(
    outline: tuple[int, ...],
    holes: Sequence[tuple[int, ...]],
    normal: FloatArray,
    vertices: Sequence[Vertex],
) -> tuple[tuple[int, ...], ...]:
    # The holes that lie within the outline, apart from one another, now that their corners are
    # estimated one by one.
    corners = np.array([vertices[k].point for k in outline])
    axes = make_plane_axes(normal, corners[1] - corners[0])
    kept: list[tuple[int, ...]] = []
    flat: list[FloatArray] = []
    for hole in holes:
        ring = np.array([vertices[k].point for k in hole]) @ axes.T
        polygon = shapely.Polygon(corners @ axes.T, [*flat, ring])
        if polygon.is_valid and not shapely.is_ccw(shapely.LinearRing(ring)):
            kept.append(hole)
            flat.append(ring)
    return tuple(kept)


def _measure_moved_px(placed: AdjustedPoints, views: Sequence[View]) -> float:
    # By how much the adjustment of the poses moved what the views show of the corners, rms.
    before, after = (
        project_to_views(np.array([v.projection for v in these]), placed.points)
        for these in (views, placed.views)
    )
    both = placed.used.T & (before[1] > 0) & (after[1] > 0)
    moved = ((after[0] - before[0]) ** 2).sum(axis=2)[both]
    return float(np.sqrt(moved.mean())) if moved.size else 0.0


def _widen_plane_cov(plane: FacePlane | None, moved_px: float) -> FacePlane | None:
    # The front end found the plane at the views' poses before, by lines that it took to be known to
    # a pixel.
    if plane is None:
        return None
    return replace(plane, cov=plane.cov * (1.0 + moved_px**2))


def _off(plane: FacePlane, points: FloatArray, covs: FloatArray) -> NDArray[np.bool_]:
    # Which corners (n, 3) of a face are farther from its plane than both are known.
    normal, height = plane.normal, plane.height
    variance = np.einsum("i,nij,j->n", normal, covs, normal) + np.diagonal(plane.cov)
    apart: NDArray[np.bool_] = np.abs(points @ normal - height) > OFF_SDS * np.sqrt(variance)
    return apart


def _pull_onto_plane(plane: FacePlane, of_face: Sequence[int], found: AdjustedPoints) -> FloatArray:
    # Kalman's update of a face's corners by its plane, which all of them have in common: they come
    # to lie on one that is shifted and tilted as far as they and it are known. Returns the
    # covariance (k, k) of how far that plane may still be off at the corners that have a point.
    ok = found.ok[list(of_face)]
    corners, cov = np.array(of_face)[ok], plane.cov[np.ix_(ok, ok)]
    apart = plane.height - found.points[corners] @ plane.normal
    _, weight = _update_corner_covs(found.shape_covs, corners, plane.normal, cov)
    gain, _ = _update_corner_covs(found.covs, corners, plane.normal, cov)
    found.points[corners] += np.einsum("kxj,j->kx", gain, apart)
    left: FloatArray = cov - cov @ weight @ cov
    return left


def _update_corner_covs(
    covs: FloatArray, corners: NDArray[np.intp], normal: FloatArray, plane_cov: FloatArray
) -> tuple[FloatArray, FloatArray]:
    # Updates the corners' covariances (3, 3) in place. Returns the gain (k, 3, k) and the inverse
    # (k, k) of the covariance of how far corners and plane are apart.
    across = covs[corners] @ normal
    weight = np.asarray(np.linalg.inv(plane_cov + np.diag(across @ normal)), dtype=np.float64)
    gain: FloatArray = across[:, :, None] * weight[:, None]
    own = np.einsum("kxk->kx", gain)
    covs[corners] -= own[:, :, None] * across[:, None]
    return gain, weight


def _complete(completion: Completion, found: AdjustedPoints) -> None:
    # Where the pictures show a corner too little, what its face's neighbours say of it.
    new, beside = completion.track, completion.beside
    if found.ok[beside] and not found.ok[new]:
        found.points[new] = found.points[beside] + completion.offset
        for covs in (found.covs, found.shape_covs):
            covs[new] = covs[beside] + completion.sd**2 * np.eye(3)
        found.ok[new] = True


def _stop_at(sd_limit: float, uv: FloatArray, cov: FloatArray, found: AdjustedPoints) -> int:
    # Runs the recursion view by view up to the limit and writes its results into the arrays;
    # returns how many points reached it.
    reached = 0
    projections = [v.projection for v in found.views]
    for k in np.nonzero(found.ok)[0]:
        views = np.nonzero(found.used[k])[0]
        observations = [Observation(int(v), uv[k, v], cov[k, v]) for v in views]
        estimate = estimate_point(observations, projections, sd_limit=sd_limit)
        if not estimate:
            continue
        found.points[k], found.covs[k] = estimate.point, estimate.cov
        found.used[k] = False
        found.used[k, views[list(estimate.used)]] = True
        reached += estimate.views_needed is not None
    return reached


def _make_track_arrays(tracks: Sequence[Track], weight: Sequence[float]) -> Tracks:
    shape = (len(tracks), len(weight))
    uv, cov = np.zeros((*shape, 2)), np.tile(np.eye(2), (*shape, 1, 1))
    seen = np.zeros(shape, np.bool_)
    for n, track in enumerate(tracks):
        for o in track.observations:
            uv[n, o.view], cov[n, o.view], seen[n, o.view] = o.uv, o.cov, True
    return Tracks(uv, cov, seen, np.array(weight))
