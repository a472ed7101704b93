"""Views into a scene: accuracy, and what must not matter."""

from dataclasses import replace
from functools import cache

import cv2
import numpy as np
import pytest

from facetlog.errors import InconsistentViewsError, InputError
from facetlog.perception.facts.all_facts import fact_rows
from facetlog.perception.reading.lens import Distortion, Lens
from facetlog.perception.scene import Scene
from facetlog.perception.step_clock import StepClock
from facetlog.perception.surfaces.reconstruct import UP_OF_GROUND, reconstruct
from facetlog.perception.types import (
    FloatArray,
    Pose,
    PoseErrorKind,
    PoseErrors,
    StoredPicture,
    View,
)
from facetlog.robot.rendering.views import Similarity, draw_similarity, shuffled, views_of
from facetlog.robot.rendering.world import World
from facetlog.robot.rendering.worlds import make_world
from facetlog.robot.tour import tour_camera, tour_poses
from tests.rendered import get_solid_truth, tour

FRONT_ENDS = ("lines", "paper")
UP = np.array([0.0, 0.0, 1.0])
TRUE = np.array(get_solid_truth(make_world("block")).vertices)
FRAME = draw_similarity(np.random.default_rng(11), scale=1000.0, reach=1e4)


def scene_of(views: tuple[View, ...], front_end: str, up: FloatArray = UP) -> Scene:
    return reconstruct(views, name="block", up=up, front_end=front_end)


@cache
def block_scene(front_end: str) -> Scene:
    return scene_of(tour("block"), front_end)


def errors(scene: Scene, true: FloatArray = TRUE) -> FloatArray:
    """Distances of the scene's vertices from the nearest true ones, each taken once."""
    away = np.linalg.norm(scene.points[:, None] - true[None], axis=-1)
    assert len(set(away.argmin(axis=1))) == len(away)
    return away.min(axis=1)


def rms(scene: Scene, true: FloatArray = TRUE) -> float:
    return float(np.sqrt((errors(scene, true) ** 2).mean()))


def loops(scene: Scene, frame: Similarity | None = None) -> set[frozenset[int]]:
    """Each face as the set of the true corners that it has."""
    true = TRUE if frame is None else frame.scale * TRUE @ frame.rotation.T + frame.shift
    owner = np.linalg.norm(scene.points[:, None] - true[None], axis=-1).argmin(axis=1)
    return {frozenset(int(owner[v]) for v in f.outline) for f in scene.faces}


@pytest.mark.parametrize("front_end", FRONT_ENDS)
@pytest.mark.slow
def test_a_wrong_focal_length_is_named_and_the_right_one_used(front_end: str) -> None:
    views = tuple(replace(v, camera=v.camera.zoomed(0.95)) for v in tour("block"))
    scene = scene_of(views, front_end)
    assert len(scene.vertices) == 8
    assert rms(scene) < 0.1
    focal = views[0].camera.fx / 0.95
    assert all(e.focal == pytest.approx(1 / 0.95, rel=2e-3) for e in scene.lenses)
    (said,) = scene.warnings
    assert f"focal length of {focal:.0f}."[:-2] in said
    assert scene.views == tuple(v.name for v in views)


@pytest.mark.slow
def test_what_a_bent_lens_shows_is_seen_straight() -> None:
    lens = Lens(tour("block")[0].camera, Distortion.POLYNOMIAL, (0.2, 0.0, 0.0, 0.0))
    # Straight pictures of a pinhole that are bent the other way show what such a lens does.
    bent = tuple(replace(v, image=lens.undistort(v.image)) for v in tour("block"))
    scene = scene_of(bent, "lines")
    assert len(scene.vertices) == 8
    assert rms(scene) < 0.1
    assert scene.lenses[0].radial == pytest.approx(-0.2, abs=0.05)


@pytest.mark.parametrize("front_end", FRONT_ENDS)
def test_the_block_is_found_and_its_stated_deviations_are_of_the_errors_size(
    front_end: str,
) -> None:
    scene = block_scene(front_end)
    assert len(scene.vertices) == 8
    assert rms(scene) < 0.1
    assert errors(scene).max() < 0.2
    assert scene.warnings == ()
    true = {frozenset(f) for f in get_solid_truth(make_world("block")).faces}
    assert len(loops(scene)) == len(scene.faces) == 5
    assert loops(scene) < true
    assert all(face.plane.distance(TRUE.mean(axis=0)) < -2.0 for face in scene.faces)
    nearest = np.linalg.norm(scene.points[:, None] - TRUE[None], axis=-1).argmin(axis=1)
    off = scene.points - TRUE[nearest]
    squares = [e @ np.linalg.solve(v.cov, e) for e, v in zip(off, scene.vertices, strict=True)]
    # Three degrees of freedom and eight vertices: loose bounds.
    assert 0.3 < np.median(squares) < 9.0


@pytest.mark.parametrize("metric", [True, False])
@pytest.mark.slow
def test_an_error_of_the_unit_is_in_the_deviation_of_every_length(metric: bool) -> None:
    off, scale_sd = 1.015, 0.01
    views = tuple(
        replace(v, pose=replace(v.pose, centre=off * v.pose.centre)) for v in tour("block")
    )
    nothing = np.zeros((len(views), 6, 6))
    stated = PoseErrors(tuple(v.pose for v in views), nothing, PoseErrorKind.INDEPENDENT, scale_sd)
    scene = reconstruct(views, name="block", up=UP, metric=metric, errors=stated)
    lengths = [row[1:] for row in fact_rows(scene, {"edge_length"})["edge_length"]]
    sides = {float(np.linalg.norm(a - b)) for a in TRUE for b in TRUE}
    for length, sd in lengths:
        true = min(sides, key=lambda side, found=length: abs(off * side - found))
        if metric:
            assert sd >= 0.95 * scale_sd * length
            assert abs(length - true) < 3.0 * sd
        else:  # of an unknown unit nothing is off
            assert sd < 0.3 * scale_sd * length


@pytest.mark.parametrize("front_end", FRONT_ENDS)
@pytest.mark.slow
def test_another_frame_and_scale_give_the_same_scene(front_end: str) -> None:
    views = tuple(FRAME.view(v) for v in tour("block"))
    moved, scene = scene_of(views, front_end, FRAME.rotation @ UP), block_scene(front_end)
    assert loops(moved, FRAME) == loops(scene)
    true = FRAME.scale * TRUE @ FRAME.rotation.T + FRAME.shift
    assert rms(moved, true) < 0.1 * FRAME.scale
    expected = FRAME.scale * scene.points @ FRAME.rotation.T + FRAME.shift
    away = np.linalg.norm(moved.points[:, None] - expected[None], axis=-1).min(axis=1)
    assert away.max() < 0.02 * FRAME.scale


@pytest.mark.parametrize("front_end", FRONT_ENDS)
@pytest.mark.slow
def test_the_order_of_the_views_does_not_matter(front_end: str) -> None:
    order = np.random.default_rng(0).permutation(24)
    scene = block_scene(front_end)
    other = scene_of(tuple(tour("block")[k] for k in order), front_end)
    assert loops(other) == loops(scene)
    away = np.linalg.norm(other.points[:, None] - scene.points[None], axis=-1).min(axis=1)
    assert away.max() < 0.02


@pytest.mark.slow
def test_one_picture_at_all_poses_is_named_as_what_contradicts_them() -> None:
    first = tour("block")[0]
    views = tuple(replace(v, image=first.image) for v in tour("block"))
    with pytest.raises(
        InconsistentViewsError, match=r"all 24 pictures .* one and the same"
    ) as said:
        scene_of(views, "lines")
    assert "\n" not in str(said.value)


def test_pictures_without_anything_are_reported() -> None:
    flat = np.full((480, 640), 90, np.uint8)
    views = tuple(View(v.name, flat, v.camera, v.pose) for v in tour("block")[:6])
    with pytest.raises(InputError, match="all 6 pictures are of one grey level"):
        scene_of(views, "lines")


@pytest.mark.parametrize(("turn", "scale"), [(-1.0, 1.0), (1.0, 1e30)])
def test_one_gross_pose_is_named_and_the_rest_used(turn: float, scale: float) -> None:
    views = list(tour("block")[::2])
    pose = views[5].pose
    wrong = Pose(pose.rotation @ np.diag([turn, 1.0, turn]), scale * pose.centre)
    views[5] = replace(views[5], pose=wrong)
    scene = scene_of(tuple(views), "lines")
    assert rms(scene) < 0.1
    assert loops(scene) == loops(block_scene("lines"))
    (warning,) = scene.warnings
    assert warning.startswith(f"{views[5].name}: pose and picture contradict the other views")
    assert views[5].name not in scene.views


def test_many_pictures_from_two_places_are_too_few_views_and_no_contradiction() -> None:
    one, other = tour("block")[0], tour("block")[3]
    scene = scene_of((*[replace(one, name=f"{k}") for k in range(8)], other), "lines")
    assert not scene.faces
    (warning,) = scene.warnings
    assert "at least three views from different places" in warning


@pytest.mark.slow
def test_large_pictures_are_answered_in_their_own_pixels() -> None:
    large = tour_camera().resized(1600, 1200)

    def kept(k: int) -> View:
        view = tour("block")[k]
        image = np.asarray(cv2.resize(view.image, (1600, 1200)), dtype=np.uint8)
        return replace(view, stored=StoredPicture(large, lambda: image))

    scene = scene_of(tuple(map(kept, range(24))), "lines")
    assert loops(scene) == loops(block_scene("lines"))
    off = []
    for vertex in scene.vertices:
        point = TRUE[np.linalg.norm(TRUE - vertex.point, axis=1).argmin()]
        for seen in vertex.observations:
            pose = tour("block")[seen.view].pose
            pixel = large.matrix @ pose.rotation.T @ (point - pose.centre)
            off.append(np.linalg.norm(seen.uv - pixel[:2] / pixel[2]))
    assert np.median(off) < 0.5


@pytest.mark.parametrize("front_end", FRONT_ENDS)
@pytest.mark.slow
def test_shuffled_poses_are_reported(front_end: str) -> None:
    views = shuffled(tour("block"), np.random.default_rng(1))
    with pytest.raises(InconsistentViewsError, match="24 views"):
        scene_of(views, front_end)


@pytest.mark.parametrize("front_end", FRONT_ENDS)
def test_steps_are_timed_and_progress_is_reported(front_end: str) -> None:
    clock = StepClock()
    calls: list[tuple[str, int, int]] = []
    reconstruct(
        tour("block")[:3],
        name="block",
        up=UP,
        front_end=front_end,
        progress=lambda *call: calls.append(call),
        clock=clock,
    )
    assert "vertices and planes" in {step.name for step in clock.times}
    assert {total for _, _, total in calls} == {3}


def sheared(degrees: float) -> World:
    """The block with its plan pushed out of square."""
    world = make_world("block")
    (solid,) = world.solids
    middle = solid.vertices.mean(axis=0)
    push = np.eye(3)
    push[0, 1] = np.tan(np.radians(degrees))
    return replace(
        world, solids=(replace(solid, vertices=middle + (solid.vertices - middle) @ push.T),)
    )


@pytest.mark.slow
def test_views_left_out_for_another_lens_are_taken_when_it_is_corrected() -> None:
    # Most views have a focal length a fifth too short; the others, which are right, do not agree
    # with them before that is known.
    views = tuple(
        replace(v, camera=v.camera.zoomed(0.78)) if k % 8 else v
        for k, v in enumerate(tour("block"))
    )
    scene = scene_of(views, "lines")
    assert rms(scene) < 0.1
    focal = {v.name: v.camera.fx for v in views}
    true = tour("block")[0].camera.fx
    for name, lens in zip(scene.views, scene.lenses, strict=True):
        assert lens.focal * focal[name] == pytest.approx(true, rel=0.01)


@pytest.mark.slow
def test_a_block_out_of_square_is_not_made_square() -> None:
    world = sheared(8.0)
    scene = scene_of(views_of(world, tour_poses(), tour_camera(), seed=0), "lines")
    true = np.array(get_solid_truth(world).vertices)
    away = np.linalg.norm(scene.points[:, None] - true[None], axis=-1)
    assert len(scene.faces) == 5
    assert away.min(axis=1).max() < 0.1


@pytest.mark.parametrize("find_up", [True, False])
@pytest.mark.slow
def test_up_is_that_of_the_ground_unless_it_is_to_stay_unknown(find_up: bool) -> None:
    scene = reconstruct(tour("block"), name="block", find_up=find_up)
    assert (UP_OF_GROUND in scene.warnings) == find_up
    if find_up:
        assert scene.up is not None
        assert float(scene.up @ UP) > np.cos(np.deg2rad(1.0))
        np.testing.assert_allclose(scene.points, block_scene("lines").points)
    else:
        assert scene.up is None
