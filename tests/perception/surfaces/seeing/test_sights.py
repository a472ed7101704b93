"""Sights of the views of a scene: shares of faces, what hides them, and how far one saw."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from facetlog.perception.detection.tracked_faces import Landmarks
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids.polyhedra import polyhedron
from facetlog.perception.surfaces.reconstruct import reconstruct
from facetlog.perception.surfaces.seeing.sights import add_sights
from facetlog.perception.types import FloatArray, Observation, Pose, View
from facetlog.robot.rendering.worlds import make_world
from tests.perception.detection.drawings import view as drawn
from tests.perception.detection.drawings import with_noise
from tests.rendered import get_solid_truth, tour

UP = np.array([0.0, 0.0, 1.0])
SOLID = get_solid_truth(make_world("block"))
CORNERS = np.array(SOLID.vertices)


@cache
def block() -> Scene:
    return reconstruct(tour("block"), name="block", up=UP)


def heights_over_faces(points: FloatArray) -> FloatArray:
    """Signed distances (n, f) of points from the planes of the true block, outwards."""
    away = []
    for face in SOLID.faces:
        a, b, c = CORNERS[list(face[:3])]
        normal = np.cross(b - a, c - b)
        away.append((points - a) @ (normal / np.linalg.norm(normal)))
    return np.array(away).T


def test_sight_lines_end_on_the_block_or_the_floor_and_pass_through_nothing() -> None:
    lines = block().lines_of_sight
    assert {line.view for line in lines} == set(range(24))
    for line in lines:
        assert line.view is not None
        np.testing.assert_allclose(line.origin, block().poses[line.view].centre, atol=1e-9)
        some = line.ends[:: 1 + len(line.ends) // 1000]
        outside = heights_over_faces(some).max(axis=1)
        # The floor's plane is that of the lines found on it, here the block's lower edges.
        away = np.linalg.norm(some - CORNERS.mean(axis=0), axis=1)
        on_block, on_floor = np.abs(outside) < 0.2, np.abs(some[:, 2]) < 0.1 + 0.005 * away
        assert (on_block | on_floor).all()
        if not on_floor.any():
            continue
        # Of the way to an end on the floor, points of which none is in the block.
        way = line.origin + (some[on_floor] - line.origin)[:, None] * np.linspace(
            0.5, 0.99, 60
        ).reshape(-1, 1)
        inside = heights_over_faces(way.reshape(-1, 3)).max(axis=1) < -0.1
        assert inside.mean() < 0.001
    # Floor and block were seen all round, most of the floor by most views.
    ends = np.concatenate([line.ends for line in block().sights])
    assert ends[:, 2].max() == pytest.approx(CORNERS[:, 2].max(), abs=0.2)
    by_place = sum(seen.shown.sum(axis=0) for seen in block().seen_ground)
    assert np.median(by_place) > 3


def square(distance: float, low: float, high: float) -> FloatArray:
    """Corners of a square across the z axis, seen from the origin counter-clockwise."""
    return np.array(
        [[low, low, distance], [low, high, distance], [high, high, distance], [high, low, distance]]
    )


def seen(*squares: FloatArray, landmarks: Landmarks | None = None) -> Scene:
    """Return squares as three views of noise, a little apart, show them."""
    loops = [list(range(4 * n, 4 * n + 4)) for n in range(len(squares))]
    places = [np.array([x, 0.0, 0.0]) for x in (-0.001, 0.0, 0.001)]
    views: list[View] = [
        replace(drawn(with_noise(drawn().image, 20.0), Pose(np.eye(3), at)), name=f"{n}.png")
        for n, at in enumerate(places)
    ]
    scene = polyhedron(np.concatenate(squares), loops, up=None)
    observations = tuple(Observation(k, np.zeros(2), np.eye(2)) for k in range(3))
    vertices = tuple(replace(vertex, observations=observations) for vertex in scene.vertices)
    named = replace(scene, vertices=vertices, views=tuple(view.name for view in views))
    return add_sights(named, views, (1.0,) * 3, None, landmarks)


def test_what_hides_a_face_is_named_with_its_share() -> None:
    behind, before = seen(square(3.0, -0.6, 0.6), square(1.5, 0.0, 0.6)).faces
    for sight in behind.sights:
        # The nearer square covers what lies right of and below the middle.
        ((by, share),) = sight.hidden
        assert by == 1
        assert share == pytest.approx(0.25, abs=0.05)
        assert sight.outside == 0.0
    assert all(not sight.hidden for sight in before.sights)


def test_sight_lines_go_to_the_vertices_that_no_face_hides() -> None:
    for line in seen(square(3.0, -0.6, 0.6), square(1.5, 0.0, 0.5)).sights:
        ends = line.ends.round(6).tolist()
        assert [-0.6, -0.6, 3.0] in ends
        assert [0.5, 0.5, 1.5] in ends
        # Matched by mistake: the nearer square is before it.
        assert [0.6, 0.6, 3.0] not in ends


def test_sight_lines_end_on_what_a_view_shows_that_is_no_face() -> None:
    post = np.array([[-0.2, 0.01 * k, 1.0] for k in range(-4, 5)])
    hidden = np.array([[0.5, 0.5, 3.0]])
    points = np.concatenate([post, hidden])
    by_two = np.tile([True, False, True], (len(points), 1))
    scene = seen(square(1.5, 0.0, 0.5), landmarks=Landmarks(points, by_two))
    ends = {line.view: line.ends.round(6).tolist() for line in scene.sights}
    for view in (0, 2):
        found = [p for p in post.tolist() if np.round(p, 6).tolist() in ends[view]]
        # Close together they are one line of sight.
        assert 0 < len(found) < len(post)
        assert hidden[0].tolist() not in ends[view]
    assert not any(end[2] == 1.0 for end in ends[1])


def test_a_face_that_reaches_past_the_camera_hides_what_is_behind_it() -> None:
    wall = np.array([[0.1, -5, -5], [0.1, -5, 1.5], [0.1, 5, 1.5], [0.1, 5, -5]])
    behind, _ = seen(square(3.0, -0.6, 0.6), wall).faces
    for sight in behind.sights:
        # Right of x = .2 at this distance the way leads through the wall.
        assert dict(sight.hidden)[1] == pytest.approx(0.4 / 1.2, abs=0.06)


def test_what_lies_beyond_the_border_is_outside_and_backs_are_not_seen() -> None:
    # At this distance the picture is 1.6 high and 2.13 wide.
    (face,) = seen(square(1.5, -0.8, 0.8)).faces
    assert [s.outside for s in face.sights] == pytest.approx([1 - 1.2 / 1.6] * 3, abs=0.05)
    (back,) = seen(square(3.0, -0.6, 0.6)[::-1]).faces
    assert back.sights == ()
    assert back.coverage == 0.0
