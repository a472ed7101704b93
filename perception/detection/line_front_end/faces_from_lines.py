"""From views to tracked faces by straight lines; the steps in their order."""

from collections.abc import Callable, Sequence

import numpy as np

from facetlog.perception.detection.edge_maps import edge_map
from facetlog.perception.detection.line_front_end.corner_tracks import (
    merge_corners,
    outlined_tracks,
    track_corners,
    track_ends,
)
from facetlog.perception.detection.line_front_end.face_selection import select_faces
from facetlog.perception.detection.line_front_end.line_cloud import SUPPORTED, reconstruct_lines
from facetlog.perception.detection.line_front_end.line_extent import line_profiles
from facetlog.perception.detection.line_front_end.line_support import coverage
from facetlog.perception.detection.line_front_end.loose_edges import find_loose_edges
from facetlog.perception.detection.line_front_end.plane_hypotheses import plane_hypotheses
from facetlog.perception.detection.line_front_end.pose_consistency import check_consistency
from facetlog.perception.detection.line_front_end.view_judgement import (
    contradicting_views,
    without_them,
)
from facetlog.perception.detection.segments import detect_segments
from facetlog.perception.detection.tracked_faces import TrackedFace, TrackedFaces
from facetlog.perception.detection.view_graph import view_graph
from facetlog.perception.detection.working_size import at_working_size, in_own_pixels
from facetlog.perception.step_clock import StepClock
from facetlog.perception.types import FloatArray, View

__all__ = ["line_front_end"]


def line_front_end(
    views: Sequence[View],
    up: FloatArray | None,
    clock: StepClock,
    progress: Callable[[str, int, int], None] | None = None,
) -> TrackedFaces:
    """Faces with their corners tracked through the views, found by lines first."""
    given = views
    views, factor = at_working_size(views)
    with clock.step("features"):
        maps, segments = [], []
        for k, view in enumerate(views):
            if progress is not None:
                progress("features", k, len(views))
            maps.append(edge_map(view.image))
            segments.append(detect_segments(view.image))
    graph = view_graph(views)
    with clock.step("3-D segments"):
        cloud = reconstruct_lines(views, maps, segments, graph)
        use = np.nan_to_num(coverage(cloud.segments, views, maps)) > SUPPORTED
        wrong = contradicting_views(cloud.segments, use, graph.weight, views, segments)
    if wrong:
        return without_them(wrong, given, lambda rest: line_front_end(rest, up, clock, progress))
    with clock.step("faces"):
        planes = plane_hypotheses(cloud.segments, cloud.end_covs, cloud.support, cloud.pixel)
        profiles = line_profiles(cloud.segments, views, maps, use, graph.weight)
        faces = select_faces(planes, cloud, views, maps, graph, profiles, up)
    weight = tuple(float(w) for w in graph.weight)
    if not faces:
        check_consistency(cloud.segments, use, views, segments)
        return TrackedFaces((), (), weight)
    with clock.step("corner tracks"):
        corners = merge_corners(faces, cloud.pixel)
        shown = np.array([f.shown for f in faces])
        tracks = track_corners(corners, shown, views, maps)
        outlined = outlined_tracks(corners, shown, views)
        loose, of_cloud = find_loose_edges(cloud, profiles, faces, corners.loops, views, use)
        ends = track_ends(loose, use[of_cloud], views, maps)
    tracked = tuple(
        TrackedFace(loop, f.support) for loop, f in zip(corners.loops, faces, strict=True)
    )
    first = len(tracks)
    edges = tuple((first + 2 * k, first + 2 * k + 1) for k in range(len(loose)))
    own = tuple(in_own_pixels(track, factor) for track in (*tracks, *ends))
    stand_ins = tuple(in_own_pixels(track, factor) for track in outlined)
    return TrackedFaces(own, tracked, weight, edges, stand_ins)
