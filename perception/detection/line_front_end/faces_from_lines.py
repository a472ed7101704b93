"""From views to tracked faces by straight lines; the steps in their order."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

import numpy as np

from facetlog.perception.detection.coarse_pictures import coarse_pictures
from facetlog.perception.detection.edge_maps import EdgeMap, edge_map
from facetlog.perception.detection.line_front_end.corner_tracks import (
    complete_corners,
    merge_corners,
    track_corners,
    track_ends,
    track_outline_corners,
)
from facetlog.perception.detection.line_front_end.evidence.exposure import exposures
from facetlog.perception.detection.line_front_end.evidence.photo_consistency import GreyLevels
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.evidence.see_through import LinesBehind
from facetlog.perception.detection.line_front_end.evidence.side_evidence import SideJudge
from facetlog.perception.detection.line_front_end.evidence.texture_correlation import (
    find_surface_between,
)
from facetlog.perception.detection.line_front_end.face_selection import select_faces
from facetlog.perception.detection.line_front_end.loose_edges import find_loose_edges
from facetlog.perception.detection.line_front_end.neighbouring_faces import neighbouring_faces
from facetlog.perception.detection.line_front_end.planes.ground_plane import find_ground
from facetlog.perception.detection.line_front_end.planes.level_direction import level_direction
from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import plane_hypotheses
from facetlog.perception.detection.line_front_end.planes.texture_planes import (
    keep_shown_patches,
    texture_planes,
)
from facetlog.perception.detection.line_front_end.points_3d.texture_points import (
    texture_points,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import find_shown_lines
from facetlog.perception.detection.line_front_end.segments_3d.line_extent import (
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
from facetlog.perception.detection.line_front_end.selected_face import SelectedFace
from facetlog.perception.detection.line_front_end.side_fit import fit_sides
from facetlog.perception.detection.line_front_end.texture_faces import texture_faces
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
from facetlog.perception.types import FloatArray, View

# Places along a 3-D segment to which the views that show it see.
SIGHT_SAMPLES = 12

T = TypeVar("T")


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
        maps, segments = [], []
        noises = measure_working_noises(views, factors)
        for k, noise in enumerate(noises):
            if progress is not None:
                progress("features", k, len(views))
            image = working[k].image
            coarser = coarse_pictures(image, noise)
            maps.append(edge_map(image, own_noise=noise, coarser=coarser))
            segments.append(detect_segments(image, noise, coarser))
    return Pictures(working, factors, noises, tuple(maps), tuple(segments))


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
