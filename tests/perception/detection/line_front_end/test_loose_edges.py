"""Segments that bound no face: how far they reach, and which belong to a face."""

import numpy as np

from facetlog.perception.detection.line_front_end.candidate_faces import SelectedFace
from facetlog.perception.detection.line_front_end.corner_tracks import track_ends
from facetlog.perception.detection.line_front_end.faces_from_lines import find_loose_edges
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import LineCloud
from facetlog.perception.detection.line_front_end.side_fit import fit_sides
from facetlog.perception.types import FloatArray, View
from facetlog.robot.tour import make_ring_poses
from tests.perception.detection.drawings import project, view
from tests.perception.detection.line_front_end.block_rig import block_rig
from tests.perception.detection.line_front_end.ideal_lines import exact_ends, exact_profiles

PIXEL = 0.01
TOP = np.array([[0.0, 0, 1], [2, 0, 1], [2, 1, 1], [0, 1, 1]])
LEG = np.array([[0.2, 0.2, 0.9], [0.2, 0.2, 0.1]])


def cameras() -> tuple[View, ...]:
    return tuple(view(pose=p) for p in make_ring_poses([1.0, 0.5, 0.5], 4.0, (0.3, 2.0), 8))


def top() -> SelectedFace:
    normal = np.array([0.0, 0, 1])
    return SelectedFace(TOP, normal, np.ones(8, np.bool_), 1.0, TOP, np.ones(len(TOP)))


def loose(segments: FloatArray, seen: FloatArray | None = None):
    """Which of the segments (n, 2, 3) are loose edges under the top, seen by the low cameras."""
    count = len(segments)
    cloud = LineCloud(segments, exact_ends(segments), np.full(count, 8.0), np.zeros(count), PIXEL)
    low = np.array([v.pose.centre[2] < 1.0 for v in cameras()])
    shown = np.tile(low, (count, 1)) if seen is None else seen
    loops = [(0, 1, 2, 3)]
    profiles, up = exact_profiles(segments), np.array([0.0, 0, 1])
    return find_loose_edges(cloud, profiles, [top()], loops, cameras(), shown, up)


def test_what_stands_under_a_board_belongs_to_it() -> None:
    (edge,), (number,) = loose(LEG[None])
    assert number == 0
    assert np.abs(edge - LEG).max() < 0.1


def test_what_lies_on_the_face_or_before_it_or_beside_it_does_not() -> None:
    texture_on_it = np.array([[0.5, 0.5, 1.0], [1.5, 0.6, 1.0]])
    before_it = np.array([[0.5, 0.5, 1.2], [0.5, 0.5, 1.9]])
    beside_it = LEG + np.array([5.0, 0, 0])
    side_again = np.array([[0.0, 0.01, 0.98], [2, 0.01, 0.98]])
    found, numbers = loose(np.array([texture_on_it, before_it, beside_it, side_again, LEG]))
    assert numbers.tolist() == [4]
    assert len(found) == 1


def test_the_ends_of_an_edge_are_sure_across_it_and_unsure_along_it() -> None:
    rig = block_rig()
    fits = fit_sides(rig.edges, rig.shown_edges, rig.views, rig.maps)
    tracks = track_ends(rig.edges, rig.shown_edges, rig.views, fits)
    assert len(tracks) == 24
    for number, track in enumerate(tracks):
        edge, end = divmod(number, 2)
        for o in track.observations:
            assert rig.shown_edges[edge, o.view]
            pixels = project(rig.views[o.view], rig.edges[edge])
            along = (pixels[1] - pixels[0]) / np.linalg.norm(pixels[1] - pixels[0])
            across = np.array([-along[1], along[0]])
            assert along @ o.cov @ along > 16.0 - 1e-6
            assert across @ o.cov @ across < 1.0
            assert abs(across @ (o.uv - pixels[end])) < 1.0
