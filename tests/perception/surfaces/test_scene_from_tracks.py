"""Tracks and loops into a scene."""

from dataclasses import replace

import numpy as np
import pytest

from facetlog.perception.detection.tracked_faces import FacePlane, TrackedFace, TrackedFaces
from facetlog.perception.estimation.pose_noise import estimate_pose_noise_px
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.scene_from_tracks import Stated, assemble
from facetlog.perception.surfaces.scene_json.scene_checks import find_scene_faults
from facetlog.perception.types import (
    Camera,
    FloatArray,
    Observation,
    Pose,
    Track,
    View,
)
from facetlog.robot.rendering.solids import cuboid
from facetlog.robot.tour import make_ring_poses

CAMERA = Camera(640, 480, 600.0, 600.0, 319.5, 239.5)
BLOCK = cuboid(10.0, 8.0, 6.0)
PIXEL_SD = 0.2
NAMES = ("uv", "cov")
BOTTOM = next(k for k, f in enumerate(BLOCK.faces) if not BLOCK.vertices[list(f), 2].any())


def cameras(count: int = 12) -> tuple[View, ...]:
    image = np.zeros((480, 640), np.uint8)
    poses = make_ring_poses([0.0, 0.0, 3.0], 30.0, (15.0, 22.0), count)
    return tuple(View(f"{k}.png", image, CAMERA, pose) for k, pose in enumerate(poses))


def turned_a_little(views: tuple[View, ...], rng: np.random.Generator, px: float):
    """The views, each with its picture shifted by normal errors of `px` pixels per axis."""
    moved = []
    for view in views:
        a, b = px / CAMERA.fx * rng.normal(size=2)
        turn = np.array([[1, 0, a], [0, 1, b], [-a, -b, 1]])
        q, r = np.linalg.qr(turn)
        q = q * np.sign(np.diag(r))
        moved.append(replace(view, pose=Pose(view.pose.rotation @ q, view.pose.centre)))
    return tuple(moved)


def track_to(
    views: tuple[View, ...],
    point: FloatArray,
    rng: np.random.Generator | None = None,
    sd: float = PIXEL_SD,
) -> Track:
    """Return what the views show of a point, exactly or with noise of that many px (sd)."""
    seen = []
    for k, view in enumerate(views):
        h = view.projection @ np.append(point, 1.0)
        noise = np.zeros(2) if rng is None else sd * rng.normal(size=2)
        seen.append(Observation(k, h[:2] / h[2] + noise, sd**2 * np.eye(2)))
    return Track(tuple(seen))


def tracked(views: tuple[View, ...], seed: int = 0, sd: float = PIXEL_SD) -> TrackedFaces:
    faces = tuple(TrackedFace(f, support=0.8) for k, f in enumerate(BLOCK.faces) if k != BOTTOM)
    rng = np.random.default_rng(seed)
    tracks = tuple(track_to(views, point, rng, sd) for point in BLOCK.vertices)
    return TrackedFaces(tracks, faces, (1.0,) * len(views))


def scene_of(found: TrackedFaces, views: tuple[View, ...], **given: object) -> Scene:
    return assemble(found, views, Stated("block", **given)).scene


def vertex_errors(scene: Scene) -> FloatArray:
    """Distances of the vertices from the block's corners, which come in the same order."""
    return np.linalg.norm(scene.points - BLOCK.vertices, axis=1)


@pytest.mark.parametrize("px", [0.0, 1.0])
def test_the_poses_own_error_is_measured(px: float) -> None:
    views = cameras(16)
    noise = []
    for seed in range(8):
        found = tracked(views, seed).tracks
        uv, cov = (
            np.array([[getattr(o, k) for o in t.observations] for t in found]) for k in NAMES
        )
        recorded = turned_a_little(views, np.random.default_rng([seed, 1]), px)
        projections = np.array([v.projection for v in recorded])
        noise.append(estimate_pose_noise_px(uv, cov, np.ones(uv.shape[:2], np.bool_), projections))
    assert np.mean(noise) == pytest.approx(px, rel=0.25, abs=0.4 * PIXEL_SD)


def test_the_scene_is_the_block() -> None:
    views = cameras()
    scene = scene_of(tracked(views), views)
    assert np.sqrt((vertex_errors(scene) ** 2).mean()) < 0.01
    assert len(scene.faces) == 5
    assert len(scene.edges) == 12
    assert scene.views == tuple(v.name for v in views)
    assert {e.support for e in scene.edges} == {0.8}
    for face in scene.faces:
        corners = scene.points[list(face.outline)]
        newell = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
        assert newell @ face.plane.normal > 0
        assert face.plane.distance(scene.points.mean(axis=0)) < 0
        assert np.abs(face.plane.distance(corners)).max() < 0.05


@pytest.mark.parametrize("px", [0.0, 1.0])
def test_covariances_of_vertices_are_honest(px: float) -> None:
    views = cameras()
    squares = []
    for seed in range(12):
        recorded = turned_a_little(views, np.random.default_rng([seed, 2]), px) if px else views
        scene = scene_of(tracked(views, seed), recorded)
        for vertex, point in zip(scene.vertices, BLOCK.vertices, strict=True):
            error = vertex.point - point
            squares.append(error @ np.linalg.solve(vertex.cov, error))
    # Three degrees of freedom; the errors of a pose are common to the vertices that it sees.
    assert 1.5 < np.mean(squares) < 5.0


def test_the_scene_lies_on_its_pictures_at_its_own_poses() -> None:
    views = cameras()
    recorded = turned_a_little(views, np.random.default_rng(2), 5.0)
    scene = scene_of(tracked(views), recorded)
    assert len(scene.poses) == len(scene.views) == len(views)
    for vertex in scene.vertices:
        for seen in vertex.observations:
            placed = replace(views[seen.view], pose=scene.poses[seen.view])
            h = placed.projection @ np.append(vertex.point, 1.0)
            np.testing.assert_allclose(h[:2] / h[2], seen.uv, atol=6 * PIXEL_SD)


def test_angles_of_planes_are_honest_where_all_poses_are_off() -> None:
    # What moves all vertices alike is in their covariances and in no angle.
    views = cameras()
    square = []
    for seed in range(8):
        recorded = turned_a_little(views, np.random.default_rng([seed, 3]), 3.0)
        planes = [f.plane for f in scene_of(tracked(views, seed), recorded).faces]
        for k, one in enumerate(planes):
            for other in planes[:k]:
                cosine = float(one.normal @ other.normal)
                if abs(cosine) < 0.5:
                    a, b = one.cov[:3, :3], other.cov[:3, :3]
                    variance = other.normal @ a @ other.normal + one.normal @ b @ one.normal
                    square.append(cosine**2 / variance)
    assert 0.3 < np.mean(square) < 1.6


def test_views_from_one_place_share_one_error() -> None:
    views = cameras()
    wrong = turned_a_little(views, np.random.default_rng(5), 1.0)
    found = tracked(views)
    alike = scene_of(replace(found, weight=(0.25,) * len(views)), wrong)
    apart = scene_of(found, wrong)
    ratio = [
        np.trace(a.cov) / np.trace(b.cov)
        for a, b in zip(alike.vertices, apart.vertices, strict=True)
    ]
    assert 2.5 < np.median(ratio) < 4.5


def test_faces_without_all_vertices_or_without_area_drop_out() -> None:
    views = cameras()
    found = tracked(views)
    line = [track_to(views, np.array([k, 0.0, 1.0])) for k in (0.0, 1.0, 2.0)]
    lost = (Track(found.tracks[0].observations[:1]), *found.tracks[1:], *line)
    scene = scene_of(
        replace(found, tracks=lost, faces=(*found.faces, TrackedFace((8, 9, 10)))), views
    )
    whole = [f for k, f in enumerate(BLOCK.faces) if k != BOTTOM and 0 not in f]
    corners = [scene.points[list(face.outline)] for face in scene.faces]
    assert len(corners) == len(whole)
    for outline, points in zip(whole, corners, strict=True):
        np.testing.assert_allclose(points, BLOCK.vertices[list(outline)], atol=0.05)


def test_an_observation_that_disagrees_is_left_out() -> None:
    views = cameras()
    found = tracked(views)
    first = found.tracks[0].observations
    wrong = Observation(4, first[4].uv + np.array([50.0, -30.0]), first[4].cov)
    track = Track((*first[:4], wrong, *first[5:]))
    scene = scene_of(replace(found, tracks=(track, *found.tracks[1:])), views)
    assert 4 not in {o.view for o in scene.vertices[0].observations}
    assert vertex_errors(scene)[0] < 0.05


def with_its_top_known(found: TrackedFaces, sd: float, correlation: float = 0.0) -> TrackedFaces:
    """The same, the plane of the block's top known beside its corners, which share its error."""
    up, height = np.array([0.0, 0.0, 1.0]), 6.0
    cov = sd**2 * (correlation * np.ones((4, 4)) + (1 - correlation) * np.eye(4))
    known = [
        replace(face, plane=FacePlane(up, height, cov))
        if (BLOCK.vertices[list(face.outline), 2] == height).all()
        else face
        for face in found.faces
    ]
    return replace(found, faces=tuple(known))


def test_a_corner_off_its_faces_plane_stands_where_the_outline_has_it() -> None:
    # The sides' edges were another thing's, in all views alike: their meeting is 1 in too high.
    views = cameras()
    right = tracked(views)
    wrong = int(np.argmax(BLOCK.vertices[:, 2]))
    high = track_to(views, BLOCK.vertices[wrong] + [0.0, 0.0, 1.0])
    tracks = [*right.tracks[:wrong], high, *right.tracks[wrong + 1 :]]
    found = replace(right, tracks=tuple(tracks), stand_ins=right.tracks)
    assert vertex_errors(scene_of(found, views))[wrong] > 0.9
    assert vertex_errors(scene_of(with_its_top_known(found, 0.05), views))[wrong] < 0.1
    # A plane that is hardly known says nothing against it.
    assert vertex_errors(scene_of(with_its_top_known(found, 5.0), views))[wrong] > 0.8


def test_a_corner_on_one_of_its_faces_is_not_refused_for_another_that_is_off() -> None:
    views = cameras()
    found = with_its_top_known(replace(tracked(views), stand_ins=tracked(views).tracks), 0.05)
    side = next(k for k, f in enumerate(found.faces) if f.plane is None)
    corners = BLOCK.vertices[list(found.faces[side].outline)]
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[1])
    normal = normal / np.linalg.norm(normal)
    wrong = FacePlane(normal, float(normal @ corners[0]) + 0.5, 0.05**2 * np.eye(len(corners)))
    faces = list(found.faces)
    faces[side] = replace(faces[side], plane=wrong)
    # The stand-ins of all corners would be 2 px off.
    moved = tuple(
        Track(tuple(replace(o, uv=o.uv + 2.0) for o in track.observations))
        for track in found.stand_ins
    )
    scene = scene_of(replace(found, faces=tuple(faces), stand_ins=moved), views)
    top = np.flatnonzero(BLOCK.vertices[:, 2] == 6.0)
    assert vertex_errors(scene)[top].max() < 0.06


def test_a_corner_that_is_hardly_known_comes_to_lie_on_its_faces_plane() -> None:
    views = cameras()
    right = tracked(views)
    dim = int(np.argmax(BLOCK.vertices[:, 2]))
    seen = [
        replace(o, uv=o.uv + np.array([0.0, 8.0]), cov=8.0**2 * np.eye(2))
        for o in right.tracks[dim].observations
    ]
    tracks = [*right.tracks[:dim], Track(tuple(seen)), *right.tracks[dim + 1 :]]
    found = replace(right, tracks=tuple(tracks))
    free, known = scene_of(found, views), scene_of(with_its_top_known(found, 0.02), views)
    assert abs(free.points[dim, 2] - 6.0) > 0.2
    assert abs(known.points[dim, 2] - 6.0) < 0.05
    assert known.vertices[dim].cov[2, 2] < 0.03**2 < free.vertices[dim].cov[2, 2]
    others = np.arange(len(BLOCK.vertices)) != dim
    np.testing.assert_allclose(known.points[others], free.points[others], atol=0.01)


def test_a_face_whose_plane_is_shifted_and_not_tilted_is_as_level_as_its_plane() -> None:
    # Its corners are noisy, the shift of its plane is known worse: they say it, and no tilt.
    views = cameras()
    found = tracked(views, sd=2.0)
    top = np.flatnonzero(BLOCK.vertices[:, 2] == 6.0)
    free = scene_of(found, views)
    shifted = scene_of(with_its_top_known(found, 0.5, 0.9999), views)
    assert np.ptp(shifted.points[top, 2]) < 0.3 * np.ptp(free.points[top, 2])
    (face,) = (f for f in shifted.faces if set(f.outline) == set(top.tolist()))
    (before,) = (f for f in free.faces if set(f.outline) == set(top.tolist()))
    tilt = [np.sqrt(np.linalg.eigvalsh(f.plane.cov[:3, :3])[2]) for f in (face, before)]
    assert tilt[0] < 0.3 * tilt[1]


def test_loose_edges_are_kept_beside_the_faces_sides() -> None:
    views = cameras()
    scene = scene_of(replace(tracked(views), faces=(), edges=((5, 1), (2, 3))), views)
    ends = scene.points[[(e.start, e.end) for e in scene.edges]]
    np.testing.assert_allclose(ends, BLOCK.vertices[[(1, 5), (2, 3)]], atol=0.05)
    assert len(scene.vertices) == 4
    assert scene.faces == ()


def test_a_limit_of_the_standard_deviation_ends_the_filter_early() -> None:
    views = cameras(24)
    found = tracked(views)
    full = scene_of(found, views)
    limit = 3.0 * max(float(np.sqrt(np.linalg.eigvalsh(v.cov)[2])) for v in full.vertices)
    early = scene_of(found, views, sd_limit=limit)
    assert early.warnings == ()
    for vertex, fewer in zip(full.vertices, early.vertices, strict=True):
        assert len(fewer.observations) < len(vertex.observations)
        assert np.sqrt(np.linalg.eigvalsh(fewer.cov)[2]) <= limit
    (warning,) = scene_of(found, views, sd_limit=1e-6).warnings
    assert "8 of 8 vertices" in warning


def with_hole(views: tuple[View, ...], low: float, high: float) -> TrackedFaces:
    """The block with a square hole in its top, from `low` to `high` along both sides."""
    found = tracked(views)
    (top,) = (
        k for k, f in enumerate(found.faces) if (BLOCK.vertices[list(f.outline), 2] > 0).all()
    )
    square = np.array([[low, low, 6.0], [low, high, 6.0], [high, high, 6.0], [high, low, 6.0]])
    tracks = [track_to(views, point) for point in square]
    first = len(found.tracks)
    holed = replace(found.faces[top], holes=(tuple(range(first, first + 4)),))
    faces = (*found.faces[:top], holed, *found.faces[top + 1 :])
    return replace(found, tracks=(*found.tracks, *tracks), faces=faces)


def test_a_hole_comes_with_its_face_and_has_edges_of_its_own() -> None:
    views = cameras()
    scene = scene_of(with_hole(views, -2.0, 2.0), views)
    (hole,) = [ring for f in scene.faces for ring in f.holes]
    assert len(scene.edges) == 12 + 4
    np.testing.assert_allclose(np.abs(scene.points[list(hole), :2]), 2.0, atol=0.02)


@pytest.mark.parametrize("seen", [True, False])
def test_a_hole_that_reaches_beyond_its_face_or_is_not_seen_whole_is_none(seen: bool) -> None:
    views = cameras()
    found = with_hole(views, 2.0, 7.0) if seen else with_hole(views, -2.0, 2.0)
    scene = scene_of(
        found if seen else replace(found, tracks=(*found.tracks[:-1], Track(()))), views
    )
    assert len(scene.faces) == 5
    assert not list(find_scene_faults(scene))
    assert not any(f.holes for f in scene.faces)
