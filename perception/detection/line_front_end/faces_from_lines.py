"""From views to tracked faces by straight lines; the steps in their order.

Loose edges are 3-D segments that bound no face but belong to one: they lie behind it within its
outline, or rise from its rim.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.attached_edges import (
    find_risen_segments,
    find_segments_behind,
    find_segments_inside,
)
from facetlog.perception.detection.coarse_pictures import coarse_pictures
from facetlog.perception.detection.edge_maps import EdgeMap, edge_map
from facetlog.perception.detection.line_front_end.candidate_faces import SelectedFace
from facetlog.perception.detection.line_front_end.corner_tracks import (
    complete_corners,
    merge_corners,
    track_corners,
    track_ends,
    track_outline_corners,
)
from facetlog.perception.detection.line_front_end.evidence.beside_segments import exposures
from facetlog.perception.detection.line_front_end.evidence.face_conflicts import (
    MAX_BLOCKED,
    blocked,
)
from facetlog.perception.detection.line_front_end.evidence.photo_consistency import GreyLevels
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.evidence.see_through import LinesBehind
from facetlog.perception.detection.line_front_end.evidence.side_evidence import SideJudge
from facetlog.perception.detection.line_front_end.evidence.texture_correlation import (
    find_surface_between,
)
from facetlog.perception.detection.line_front_end.face_selection import select_faces
from facetlog.perception.detection.line_front_end.faces_without_edges import (
    neighbouring_faces,
    texture_faces,
)
from facetlog.perception.detection.line_front_end.planes.ground_plane import find_ground
from facetlog.perception.detection.line_front_end.planes.level_direction import level_direction
from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import (
    plane_basis,
    plane_hypotheses,
)
from facetlog.perception.detection.line_front_end.planes.texture_planes import (
    keep_shown_patches,
    texture_planes,
)
from facetlog.perception.detection.line_front_end.points_3d.texture_points import (
    texture_points,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import (
    LineCloud,
    find_shown_lines,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_extent import (
    LineProfiles,
    find_covered_extents,
    measure_line_profiles,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_support import segment_samples
from facetlog.perception.detection.line_front_end.segments_3d.pose_consistency import (
    check_consistency,
)
from facetlog.perception.detection.line_front_end.segments_3d.view_judgement import (
    find_contradicting_views,
    track_without,
)
from facetlog.perception.detection.line_front_end.side_fit import fit_sides
from facetlog.perception.detection.line_front_end.with_boards import with_boards
from facetlog.perception.detection.picture_noise import Noise
from facetlog.perception.detection.segments import detect_segments
from facetlog.perception.detection.tracked_faces import (
    FacePlane,
    Landmarks,
    TrackedFace,
    TrackedFaces,
)
from facetlog.perception.detection.view_graph import view_graph
from facetlog.perception.detection.working_size import (
    enlarge_to_working_size,
    measure_working_noises,
    to_own_pixels,
)
from facetlog.perception.estimation.pose_refinement.view_alignment import align_views
from facetlog.perception.step_clock import StepClock
from facetlog.perception.threads import map_on_threads
from facetlog.perception.types import FloatArray, Image, View

# Places along a 3-D segment to which the views that show it see.
SIGHT_SAMPLES = 12

T = TypeVar("T")
# A segment this near to a face, in px, lies on it: texture, or the face's own border.
ON_FACE_PX = 6.0
# Samples along an edge that the views must see.
EDGE_SAMPLES = 8
# A segment this near to the line of a side, in px, is that side again or its shadow.
ALONG_SIDE_PX = 10.0
# Loose edges shorter than this many px are dropped.
MIN_LENGTH_PX = 15.0
# A bar has two outlines, at least this many px apart, and at most this share of their length; they
# differ in direction by no more than this.
BAR_PX, SLENDER, PARALLEL = 3.0, 0.35, float(np.cos(np.deg2rad(10.0)))


def find_loose_edges(
    cloud: LineCloud,
    profiles: LineProfiles,
    faces: Sequence[SelectedFace],
    loops: Sequence[Sequence[int]],
    views: Sequence[View],
    seen: NDArray[np.bool_],
    up: FloatArray | None,
) -> tuple[FloatArray, NDArray[np.intp]]:
    """Return loose edges (m, 2, 3) and the segments of the cloud that they come from (m,).

    `loops` are the faces' corners, as numbers that they share. `seen` (segments, V) says which
    views show which segment: one seen through a face, as of texture at a wrong depth, is dropped.
    """
    extents = find_covered_extents(cloud.segments, profiles)
    keep = np.linalg.norm(extents[:, 1] - extents[:, 0], axis=1) > MIN_LENGTH_PX * cloud.pixel
    for face in faces:
        keep &= ~_lies_on(extents, face, ON_FACE_PX * cloud.pixel)
        keep &= ~_runs_along(extents, face, ALONG_SIDE_PX * cloud.pixel)
    # The ends are the least certain: whether a segment is inside is decided by its middle part.
    cores = segment_samples(extents, 5)[:, [1, 3]]
    belongs = np.zeros(len(extents), np.bool_)
    if up is not None:
        kept = np.flatnonzero(keep)
        bars = _are_bars(extents[kept], cloud.pixel)
        for face in faces:
            belongs[kept] |= find_risen_segments(extents[kept], face.corners, face.normal, up, bars)
    for k, face in enumerate(faces):
        inside = find_segments_behind(extents, face.corners, face.normal)
        beside = (n for n in range(len(faces)) if n != k and _share_a_side(loops[k], loops[n]))
        for other in (faces[n] for n in beside if _is_convex(face, faces[n])):
            # A segment behind two sides of one solid at once would be seen inside it; one before
            # the other side is not part of the solid.
            depth = (extents - other.corners.mean(axis=0)) @ other.normal
            inside &= (depth < ON_FACE_PX * cloud.pixel).all(axis=1)
            inside &= ~find_segments_inside(cores, other.corners, other.normal)
        belongs |= inside
    margin = ON_FACE_PX * cloud.pixel
    centres = np.array([v.pose.centre for v in views])
    for k in np.nonzero(keep & belongs)[0].tolist():
        targets = segment_samples(extents[k : k + 1], EDGE_SAMPLES)[0]
        shares = (
            blocked(f.corners, f.normal, targets, centres[seen[k]], margin, f.holes).mean()
            for f in faces
        )
        keep[k] = max(shares) <= MAX_BLOCKED
    chosen = np.nonzero(keep & belongs)[0]
    return extents[chosen], chosen


def _are_bars(segments: FloatArray, pixel: float) -> NDArray[np.bool_]:
    """Return which segments (n, 2, 3) are an outline of a bar: another runs along them beside."""
    span = segments[:, 1] - segments[:, 0]
    length = np.linalg.norm(span, axis=1)
    unit = span / length[:, None]
    middles = segments.mean(axis=1)
    between = middles[None] - middles[:, None]
    along = (between * unit[:, None]).sum(axis=-1)
    away = np.sqrt(np.maximum((between**2).sum(axis=-1) - along**2, 0.0))
    shorter = np.minimum(length[:, None], length)
    beside = np.abs(along) < np.maximum(length[:, None], length) / 2.0
    parallel = np.abs(unit @ unit.T) > PARALLEL
    apart = (away > BAR_PX * pixel) & (away < SLENDER * shorter)
    found: NDArray[np.bool_] = (parallel & beside & apart).any(axis=1)
    return found


def _lies_on(segments: FloatArray, face: SelectedFace, tolerance: float) -> NDArray[np.bool_]:
    middle = face.corners.mean(axis=0)
    basis = plane_basis(face.normal)
    near = np.abs((segments - middle) @ face.normal) < tolerance
    flat = (segments - middle) @ basis
    polygon = shapely.Polygon((face.corners - middle) @ basis).buffer(tolerance)
    inside = shapely.contains_xy(polygon, flat[..., 0], flat[..., 1])
    lies: NDArray[np.bool_] = np.logical_and(near, inside).all(axis=1)
    return lies


def _runs_along(segments: FloatArray, face: SelectedFace, tolerance: float) -> NDArray[np.bool_]:
    # Both ends near the line of one side: the side itself again, or the shadow at its foot.
    along = np.zeros(len(segments), np.bool_)
    for start, end in zip(face.corners, np.roll(face.corners, -1, axis=0), strict=True):
        unit = (end - start) / np.linalg.norm(end - start)
        relative = segments - start
        away = relative - (relative @ unit)[..., None] * unit
        along |= (np.linalg.norm(away, axis=-1) < tolerance).all(axis=1)
    return along


def _share_a_side(loop: Sequence[int], other: Sequence[int]) -> bool:
    sides = {frozenset(pair) for pair in zip(loop, (*loop[1:], loop[0]), strict=True)}
    return any(frozenset(pair) in sides for pair in zip(other, (*other[1:], other[0]), strict=True))


def _is_convex(face: SelectedFace, other: SelectedFace) -> bool:
    # Each lies behind the other.
    away = other.corners.mean(axis=0) - face.corners.mean(axis=0)
    return bool(away @ face.normal < 0 < away @ other.normal)


@dataclass(frozen=True, eq=False, slots=True)
class Pictures:
    """Views at working size, by which factors they were enlarged, their noise before that, and the
    edges and segments of each.
    """

    views: tuple[View, ...]
    factors: tuple[int, ...]
    noises: tuple[Noise, ...]
    maps: tuple[EdgeMap, ...]
    segments: tuple[FloatArray, ...]

    def select(self, kept: Sequence[int]) -> "Pictures":
        """Return the chosen pictures."""

        def those(all_: tuple[T, ...]) -> tuple[T, ...]:
            return tuple(all_[k] for k in kept)

        return Pictures(
            those(self.views),
            those(self.factors),
            those(self.noises),
            those(self.maps),
            those(self.segments),
        )

    def extend_by(self, others: "Pictures") -> "Pictures":
        """Return these pictures and others after them."""
        return Pictures(
            (*self.views, *others.views),
            (*self.factors, *others.factors),
            (*self.noises, *others.noises),
            (*self.maps, *others.maps),
            (*self.segments, *others.segments),
        )


def line_front_end(
    views: Sequence[View],
    up: FloatArray | None,
    clock: StepClock,
    progress: Callable[[str, int, int], None] | None = None,
) -> TrackedFaces:
    """Find faces with their corners tracked through the views, by lines first.

    Poses are corrected until the views' segments agree, so that correspondences are found; the
    tracks are pixels, and the corrected poses are used for nothing else.
    """
    pictures = prepare_pictures(views, clock, progress)
    return tracked_faces(pictures, up, clock)


def prepare_pictures(
    views: Sequence[View],
    clock: StepClock,
    progress: Callable[[str, int, int], None] | None = None,
) -> Pictures:
    """Find the edges and segments of each view."""
    working, factors = enlarge_to_working_size(views)
    with clock.step("features"):
        noises = measure_working_noises(views, factors)
        images = [view.image for view in working]
        maps, segments = [], []
        for edges, found in map_on_threads(_find_edges, tuple(zip(images, noises, strict=True))):
            maps.append(edges)
            segments.append(found)
            if progress is not None:
                progress("features", len(maps), len(views))
    return Pictures(working, factors, noises, tuple(maps), tuple(segments))


def _find_edges(picture: tuple[Image, Noise]) -> tuple[EdgeMap, FloatArray]:
    image, noise = picture
    coarser = coarse_pictures(image, noise)
    edges = edge_map(image, own_noise=noise, coarser=coarser)
    return edges, detect_segments(image, noise, coarser)


def tracked_faces(pictures: Pictures, up: FloatArray | None, clock: StepClock) -> TrackedFaces:
    """Find the tracked faces of prepared pictures, as `line_front_end` does."""
    views, maps, segments = pictures.views, pictures.maps, pictures.segments
    with clock.step("3-D segments"):
        cloud, use = find_shown_lines(views, maps, segments)
    with clock.step("poses"):
        placed = align_views(views, maps, segments, cloud.segments, use)
        if placed is not None:
            views = placed
            cloud, use = find_shown_lines(views, maps, segments)
    graph = view_graph(views)
    with clock.step("3-D segments"):
        wrong = find_contradicting_views(
            cloud.segments,
            use,
            graph.weight,
            views,
            maps,
            segments,
            lambda kept: _lines_of(pictures.select(kept), [views[k] for k in kept]),
        )
    if wrong:
        return track_without(
            wrong,
            views,
            lambda kept: tracked_faces(pictures.select(kept), up, clock),
        )
    with clock.step("texture points"):
        texture = texture_points(views, maps, graph, cloud.pixel)
    with clock.step("faces"):
        planes = plane_hypotheses(cloud.segments, cloud.end_covs, cloud.support, cloud.pixel)
        profiles = measure_line_profiles(cloud.segments, views, maps, use, graph.weight)
        side_judge = SideJudge(views, maps, graph.weight)
        score = side_judge.score(cloud.segments)
        ground = find_ground(planes, cloud, score, views, graph.distance, up)
        if ground is None and up is None:
            upwards = level_direction(cloud.segments, score, views)
            if upwards is not None:
                ground = find_ground(planes, cloud, score, views, graph.distance, upwards)
        exposure = exposures(cloud.segments, use, views)
        levels = GreyLevels(views, maps, exposure, pictures.noises)
        photos = PhotometricViews(views, levels, graph.weight)
        if ground is not None:
            texture = texture.take(~ground.holds(texture.points))
        surface = partial(find_surface_between, photos, views, cloud.pixel)
        patches = keep_shown_patches(texture_planes(texture, cloud.pixel), texture, surface)
        extents = find_covered_extents(cloud.segments, profiles)
        behind = LinesBehind.of(cloud, extents, photos, side_judge)
        faces, taken = select_faces(
            planes,
            cloud,
            score,
            views,
            profiles,
            ground,
            photos,
            side_judge,
            behind,
            texture,
            patches,
        )
        faces = with_boards(faces, photos, side_judge, taken, ground, behind, cloud.pixel)
        faces += neighbouring_faces(faces, photos, side_judge, taken, ground, cloud.pixel)
        faces += texture_faces(patches, texture, faces, views, photos, taken, ground, cloud)
    weight = tuple(float(w) for w in graph.weight)
    level = None if ground is None else (ground.normal, ground.height)
    places = segment_samples(extents, SIGHT_SAMPLES)
    landmarks = Landmarks(
        np.concatenate([places.reshape(-1, 3), texture.points]),
        np.concatenate([np.repeat(use, SIGHT_SAMPLES, axis=0), texture.seen]),
    )
    if not faces:
        check_consistency(cloud.segments, use, graph.weight, views, segments)
        return TrackedFaces((), (), weight, ground=level, landmarks=landmarks)
    with clock.step("corner tracks"):
        corners = merge_corners(faces, cloud.pixel)
        shown = np.array([f.shown for f in faces])
        upwards = up if ground is None else ground.normal
        loose, of_cloud = find_loose_edges(
            cloud, profiles, faces, corners.loops, views, use, upwards
        )
        sides = np.concatenate([corners.segments, loose])
        bounded = shown & np.array([f.has_edges for f in faces])[:, None]
        visible = np.concatenate([corners.find_shown_side_views(bounded), use[of_cloud]])
        fits = fit_sides(sides, visible, views, maps)
        count = len(corners.sides)
        tracks = track_corners(corners, views, [f.part(0, count) for f in fits])
        outlined = track_outline_corners(corners, shown, views)
        ends = track_ends(loose, use[of_cloud], views, [f.part(count, len(sides)) for f in fits])
    tracked = tuple(map(_build_tracked_face, corners.loops, corners.holes, faces))
    first = len(tracks)
    edges = tuple((first + 2 * k, first + 2 * k + 1) for k in range(len(loose)))
    own = tuple(to_own_pixels(track, pictures.factors) for track in (*tracks, *ends))
    stand_ins = tuple(to_own_pixels(track, pictures.factors) for track in outlined)
    completions = complete_corners(corners, faces, cloud.pixel)
    return TrackedFaces(
        own,
        tracked,
        weight,
        edges,
        stand_ins,
        completions,
        ground=level,
        landmarks=landmarks,
    )


def _lines_of(pictures: Pictures, views: Sequence[View]) -> FloatArray:
    """Return 3-D segments (n, 2, 3) of pictures with the poses of these views."""
    cloud, _ = find_shown_lines(views, pictures.maps, pictures.segments)
    return cloud.segments


def _build_tracked_face(
    loop: tuple[int, ...], holes: tuple[tuple[int, ...], ...], face: SelectedFace
) -> TrackedFace:
    plane = None
    if face.plane_cov is not None:
        plane = FacePlane(face.normal, float(face.normal @ face.corners[0]), face.plane_cov)
    implied = not face.shown.any()
    return TrackedFace(loop, face.support, plane, implied=implied, holes=holes)
