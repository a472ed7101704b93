"""Corners measured in each view, and how honest their covariance is."""

from dataclasses import replace

import numpy as np

from facetlog.perception.detection.line_front_end.candidate_faces import SelectedFace
from facetlog.perception.detection.line_front_end.corner_tracks import (
    Corners,
    merge_corners,
    track_corners,
    track_outline_corners,
)
from facetlog.perception.detection.line_front_end.side_fit import fit_sides
from facetlog.perception.types import FloatArray, Track
from tests.perception.detection.drawings import project
from tests.perception.detection.line_front_end.block_rig import Rig, block_rig

NOISE_GREY = 5.0


def face(corners: FloatArray) -> SelectedFace:
    normal = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
    normal = normal / np.linalg.norm(normal)
    return SelectedFace(corners, normal, np.ones(1, np.bool_), 1.0, corners, np.ones(len(corners)))


def seen_faces(rig: Rig) -> tuple[Corners, FloatArray]:
    """The true corners, the loops of faces that are seen, and which view shows which."""
    chosen = rig.shown_faces.any(axis=1)
    loops = tuple(f for f, seen in zip(rig.solid.faces, chosen, strict=True) if seen)
    return Corners(rig.points, loops, ((),) * len(loops)), rig.shown_faces[chosen]


def tracks_of(corners: Corners, shown: FloatArray, rig: Rig) -> tuple[Track, ...]:
    fits = fit_sides(corners.segments, corners.find_shown_side_views(shown), rig.views, rig.maps)
    return track_corners(corners, rig.views, fits)


def errors_and_nees(rig: Rig) -> tuple[FloatArray, FloatArray]:
    """Pixel errors (n, 2) of all corners in all views, and their squares over the covariance."""
    corners, shown = seen_faces(rig)
    errors, squares = [], []
    for point, track in zip(rig.points, tracks_of(corners, shown, rig), strict=True):
        for o in track.observations:
            error = o.uv - project(rig.views[o.view], point)
            errors.append(error)
            squares.append(error @ np.linalg.solve(o.cov, error))
    return np.array(errors), np.array(squares)


def test_corners_are_measured_to_a_fraction_of_a_pixel() -> None:
    errors, _ = errors_and_nees(block_rig())
    assert len(errors) > 45
    distance = np.hypot(*errors.T)
    assert np.median(distance) < 0.15
    assert np.quantile(distance, 0.9) < 0.5


def test_the_covariance_is_honest_over_seeds() -> None:
    squares = np.concatenate(
        [errors_and_nees(block_rig().noisy(seed, NOISE_GREY))[1] for seed in range(6)]
    )
    # Two degrees of freedom: mean 2, median 1.39. What interferes at corners is not noise, and
    # the scene's own pose noise takes it up (assemble).
    assert 0.5 < np.median(squares) / (2 * np.log(2)) < 2.0
    assert 1.0 < np.mean(np.minimum(squares, 30.0)) < 6.0


def test_corners_of_neighbouring_faces_become_one_vertex() -> None:
    rig = block_rig()
    rng = np.random.default_rng(0)
    faces = [
        face(rig.points[list(f)] + rig.pixel * rng.uniform(-1, 1, (4, 3))) for f in rig.solid.faces
    ]
    merged = merge_corners(faces, rig.pixel)
    assert merged.points.shape == (8, 3)
    assert len(merged.sides) == 12
    away = np.linalg.norm(merged.points[:, None] - rig.points[None], axis=-1).min(axis=1)
    assert away.max() < 1.8 * rig.pixel
    for loop, given in zip(merged.loops, faces, strict=True):
        assert (
            np.linalg.norm(merged.points[list(loop)] - given.corners, axis=1).max() < 4 * rig.pixel
        )


def test_a_corner_off_the_other_faces_plane_is_no_corner_of_that_face() -> None:
    # The inner side of a board five pixels thick, and the end of the board.
    inner = np.array([[0.0, 5, 0], [100, 5, 0], [100, 5, 80], [0, 5, 80]])
    outer = np.array([[0.0, 0, 0], [-60, 0, 0], [-60, 0, 80], [0, 0, 80]])
    merged = merge_corners([face(inner), face(outer)], pixel=1.0)
    assert len(merged.points) == 8


def test_merging_does_not_depend_on_the_unit() -> None:
    rig, scale = block_rig(), 1e3
    rng = np.random.default_rng(1)
    loops = [rig.points[list(f)] + rig.pixel * rng.uniform(-1, 1, (4, 3)) for f in rig.solid.faces]
    one = merge_corners([face(c) for c in loops], rig.pixel)
    other = merge_corners([face(scale * c) for c in loops], scale * rig.pixel)
    assert one.loops == other.loops
    np.testing.assert_allclose(other.points, scale * one.points)


def test_the_corners_of_a_hole_stay_apart_from_those_of_its_face() -> None:
    square = np.array([[0.0, 0, 0], [40, 0, 0], [40, 40, 0], [0, 40, 0]])
    hole = np.array([[2.0, 2, 0], [2, 38, 0], [38, 38, 0], [38, 2, 0]])
    framed = replace(face(square), holes=(hole,))
    beside = face(np.array([[0.0, 0, 0], [0, 0, 20], [40, 0, 20], [40, 0, 0]]))
    corners = merge_corners([framed, beside], 1.0)
    assert [len(loop) for loop in corners.loops] == [4, 4]
    ((ring,), nothing) = corners.holes
    assert nothing == ()
    np.testing.assert_allclose(corners.points[list(ring)], hole)
    assert not set(ring) & set(corners.loops[0])
    assert len(set(corners.loops[0]) & set(corners.loops[1])) == 2
    assert len(corners.sides) == 4 + 4 + 3


def test_an_outline_places_its_corners_in_the_views_that_show_it_no_surer_than_it_is() -> None:
    rig = block_rig()
    corners, shown = seen_faces(rig)
    for vertex, track in enumerate(track_outline_corners(corners, shown, rig.views)):
        faces = [k for k, loop in enumerate(corners.loops) if vertex in loop]
        seen = np.nonzero(shown[faces].any(axis=0))[0].tolist()
        assert [o.view for o in track.observations] == seen
        for o in track.observations:
            np.testing.assert_allclose(o.uv, project(rig.views[o.view], rig.points[vertex]))
        # All views together know it to 2 px.
        np.testing.assert_allclose(o.cov / len(seen), 4.0 * np.eye(2))
