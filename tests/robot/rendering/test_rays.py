"""Rays against an independent reference: the slab method for boxes."""

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from facetlog.perception.types import Camera, FloatArray
from facetlog.robot.rendering.render import (
    BACKGROUND,
    find_facets_to_sun,
    find_first_hits,
    in_shadow,
    seen_by,
)
from facetlog.robot.rendering.solids import cuboid, room_corner
from facetlog.robot.rendering.world import Floor, Solid, World
from facetlog.robot.tour import make_pose_looking_at

CAMERA = Camera(64, 48, 40.0, 42.0, 31.0, 24.5)
SUN = np.array([0.4, -0.7, 1.0])

coordinate = st.floats(-9, 9)
eyes = st.tuples(coordinate, coordinate, st.floats(0.1, 9)).map(np.array)
aims = st.tuples(coordinate, coordinate, st.floats(-9, 9)).map(np.array)


def place_in_world(*solids: Solid, floor: bool = True) -> World:
    return World(solids, Floor(0.4) if floor else None, SUN)


def pixels() -> FloatArray:
    v, u = np.mgrid[0:48, 0:64].astype(np.float64)
    return np.stack([u.ravel(), v.ravel()])


def box_entry(
    origins: FloatArray, rays: FloatArray, low: FloatArray, high: FloatArray
) -> FloatArray:
    """Parameter at which rays enter a box along the axes, infinite where they do not."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        a, b = (low - origins) / rays, (high - origins) / rays
    enter, leave = np.minimum(a, b).max(axis=1), np.maximum(a, b).min(axis=1)
    return np.where((enter <= leave) & (enter > 0), enter, np.inf)


@settings(max_examples=60)
@given(eye=eyes, aim=aims)
def test_rays_meet_a_box_where_the_slab_method_says_even_across_the_near_plane(
    eye: FloatArray, aim: FloatArray
) -> None:
    low, high = np.array([-2.0, -1.5, 0.0]), np.array([2.0, 1.5, 3.0])
    assume(np.hypot(*(aim - eye)[:2]) > 1e-2)
    assume((np.maximum(low - eye, eye - high)).max() > 1e-2)  # outside the box
    world, pose = place_in_world(cuboid(4, 3, 3), floor=False), make_pose_looking_at(eye, aim)
    hits = find_first_hits(world, CAMERA, pose, seen_by(world, CAMERA, pose), pixels())
    expected = box_entry(eye[None], hits.directions.T, low, high)
    np.testing.assert_allclose(hits.depth, expected, rtol=1e-9)
    assert np.array_equal(hits.facet != BACKGROUND, np.isfinite(expected))


@settings(max_examples=30)
@given(eye=eyes, aim=aims)
def test_a_face_that_is_not_convex_is_met_like_the_two_boxes_it_is_made_of(
    eye: FloatArray, aim: FloatArray
) -> None:
    assume(np.hypot(*(aim - eye)[:2]) > 1e-2)
    boxes = (
        (np.array([-3.0, -2.0, 0.0]), np.array([3.0, -1.0, 2.0])),
        (np.array([-3.0, -2.0, 0.0]), np.array([-2.0, 2.0, 2.0])),
    )
    assume(all(np.maximum(low - eye, eye - high).max() > 1e-2 for low, high in boxes))
    world, pose = (
        place_in_world(room_corner(6, 4, 2, 1), floor=False),
        make_pose_looking_at(eye, aim),
    )
    hits = find_first_hits(world, CAMERA, pose, seen_by(world, CAMERA, pose), pixels())
    entries = [box_entry(eye[None], hits.directions.T, low, high) for low, high in boxes]
    np.testing.assert_allclose(hits.depth, np.minimum(*entries), rtol=1e-9)


def test_shadows_fall_where_the_slab_method_says() -> None:
    rng = np.random.default_rng(0)
    points = np.column_stack([rng.uniform(-8, 8, (4000, 2)), np.zeros(4000)])
    world = place_in_world(cuboid(4, 3, 3))
    low, high = np.array([-2.0, -1.5, 0.0]), np.array([2.0, 1.5, 3.0])
    outside = np.maximum(low - points, points - high).max(axis=1) > 0
    expected = np.isfinite(box_entry(points, world.sun[None], low, high))
    shadowed = in_shadow(world, find_facets_to_sun(world), points.T)
    assert 0.03 < expected[outside].mean() < 0.5
    assert np.array_equal(shadowed[outside], expected[outside])
