"""Poses, points and lenses adjusted together: accuracy, honesty, gauge, and degenerate cases."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import least_squares

from facetlog.perception.estimation.bundle_adjustment.adjusted_points import (
    Adjusted,
    adjust,
    adjusted_points,
    remove_common_motion,
)
from facetlog.perception.estimation.bundle_adjustment.lens_unknowns import group_lenses
from facetlog.perception.estimation.bundle_adjustment.normal_equations import ROBUST_SD, Tracks
from facetlog.perception.estimation.pose_refinement.pose_chain import moved
from facetlog.perception.types import Camera, FloatArray, Pose, PoseErrorKind, PoseErrors, View
from facetlog.robot.rendering.solids import cuboid
from facetlog.robot.rendering.views import add_pose_noise, draw_similarity
from facetlog.robot.tour import make_ring_poses

CAMERA = Camera(640, 480, 600.0, 600.0, 319.5, 239.5)
CORNERS = np.array(cuboid(0.254, 0.203, 0.152).vertices)
PIXEL_SD = 0.1


def ring(count: int = 24) -> tuple[View, ...]:
    image = np.zeros((480, 640), np.uint8)
    poses = make_ring_poses([0.0, 0.0, 0.08], 0.7, (0.35, 0.5), count)
    return tuple(View(f"{k}.png", image, CAMERA, pose) for k, pose in enumerate(poses))


def pixels(views: tuple[View, ...], points: FloatArray) -> FloatArray:
    projections = np.array([v.projection for v in views])
    h = np.einsum("vij,nj->nvi", projections[:, :, :3], points) + projections[:, :, 3]
    return np.asarray(h[..., :2] / h[..., 2:])


def tracks_of(
    views: tuple[View, ...], seed: int, points: FloatArray = CORNERS, wrong: float = 0.0
) -> Tracks:
    rng = np.random.default_rng([seed, 1])
    uv = pixels(views, points)
    uv = uv + rng.normal(0.0, PIXEL_SD, uv.shape)
    used = rng.random(uv.shape[:2]) < 0.75
    used[:, :3] = True
    bad = rng.random(used.shape) < wrong
    uv = np.where(bad[..., None], uv + rng.uniform(-30, 30, uv.shape), uv)
    cov = np.tile(PIXEL_SD**2 * np.eye(2), (*used.shape, 1, 1))
    return Tracks(uv, cov, used, np.ones(len(views)))


def off(views: tuple[View, ...], seed: int, degrees: float, metres: float) -> tuple[View, ...]:
    rng = np.random.default_rng([seed, 2])
    return add_pose_noise(views, rng, position_sd=metres, angle_sd=np.radians(degrees))


def adjusted(seed: int, degrees: float, metres: float, count: int = 24) -> Adjusted:
    views = ring(count)
    start = CORNERS + np.random.default_rng([seed, 3]).normal(0.0, 0.003, CORNERS.shape)
    return adjust(tracks_of(views, seed), off(views, seed, degrees, metres), start)


def nees(points: FloatArray, covs: FloatArray) -> float:
    e = points - CORNERS
    return float(np.einsum("ni,nij,nj->n", e, np.linalg.inv(covs), e).mean()) / 3


def shape_rms(points: FloatArray) -> float:
    """Return what is left after the best rigid motion onto the true corners."""
    a, b = points - points.mean(axis=0), CORNERS - CORNERS.mean(axis=0)
    u, _, vt = np.linalg.svd(a.T @ b)
    rotation = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
    return float(np.sqrt(((a @ rotation - b) ** 2).sum(axis=1).mean()))


def test_exact_poses_stay_and_their_points_are_at_the_bound() -> None:
    found = [adjusted(seed, 0.0, 0.0) for seed in range(6)]
    assert max(np.degrees(f.sizes.pose_sd) for f in found) < 0.02
    assert np.mean([shape_rms(f.points) for f in found]) < 0.0001
    assert 0.5 < np.mean([nees(f.points, f.covs) for f in found]) < 1.5


@pytest.mark.parametrize(("degrees", "metres", "shape"), [(0.1, 0.001, 2e-4), (1.0, 0.01, 8e-4)])
@pytest.mark.slow
def test_independent_pose_errors_are_taken_out(degrees: float, metres: float, shape: float) -> None:
    # All points share the errors of the gauge, so that a run counts little more than one of them.
    found = [adjusted(seed, degrees, metres) for seed in range(12)]
    assert np.mean([shape_rms(f.points) for f in found]) < shape
    assert np.mean([nees(f.points, f.covs) for f in found]) < 1.5


def through(tracks: Tracks, radial: float) -> Tracks:
    """Return the tracks as seen by a lens with a radial distortion."""
    off = tracks.uv - [CAMERA.cx, CAMERA.cy]
    r2 = ((off / CAMERA.fx) ** 2).sum(axis=-1)
    return replace(tracks, uv=tracks.uv + off * (radial * r2)[..., None])


@pytest.mark.parametrize(("degrees", "metres"), [(0.0, 0.0), (1.0, 0.01)])
@pytest.mark.slow
def test_a_lens_as_stated_is_left_alone(degrees: float, metres: float) -> None:
    found = [adjusted(seed, degrees, metres) for seed in range(12)]
    assert not any(f.lens_errors for f in found)


@pytest.mark.parametrize(("degrees", "metres"), [(0.0, 0.0), (1.0, 0.01)])
@pytest.mark.parametrize(("stated", "radial"), [(0.9, 0.0), (1.0, -0.1)])
@pytest.mark.slow
def test_a_wrong_lens_is_found_whatever_the_poses(
    stated: float, radial: float, degrees: float, metres: float
) -> None:
    off_by, shapes = [], []
    for seed in range(3):
        views = off(ring(), seed, degrees, metres)
        wrong = tuple(replace(v, camera=v.camera.zoomed(stated)) for v in views)
        start = CORNERS + np.random.default_rng([seed, 3]).normal(0.0, 0.003, CORNERS.shape)
        found = adjust(through(tracks_of(ring(), seed), radial), wrong, start)
        error = found.lens_errors[0]
        off_by += [
            (error.focal * stated - 1.0) / (stated * error.focal_sd),
            (error.radial - radial) / error.radial_sd,
        ]
        shapes.append(shape_rms(found.points))
        assert error.focal_sd < 0.002
    assert np.abs(off_by).max() < 3.5
    assert max(shapes) < 1e-3


def test_a_lens_that_nobody_calibrated_is_in_the_covariances() -> None:
    tracks, views = tracks_of(ring(), 2), ring()
    sure = adjusted_points(tracks, views)
    unsure = adjusted_points(tracks, views, lens_is_off=True)
    assert unsure.adjusted is not None
    assert len(unsure.adjusted.lens_errors) == len(views)
    size = [np.sqrt(np.trace(found.covs, axis1=1, axis2=2)).mean() for found in (sure, unsure)]
    assert size[1] > 1.5 * size[0]
    assert nees(unsure.points, unsure.covs) < 1.5


def test_the_mean_of_the_poses_given_holds_the_gauge() -> None:
    views = off(ring(), 4, 0.3, 0.005)
    found = adjust(tracks_of(ring(), 4), views, CORNERS)
    moved = [p.centre - v.pose.centre for p, v in zip(found.poses, views, strict=True)]
    assert np.linalg.norm(np.mean(moved, axis=0)) < 0.2 * np.linalg.norm(moved, axis=1).mean()


def test_another_frame_and_scale_give_the_same_adjustment() -> None:
    views = off(ring(), 5, 0.3, 0.005)
    frame = draw_similarity(np.random.default_rng(5), scale=1000.0, reach=100.0)
    tracks = tracks_of(ring(), 5)
    here = adjust(tracks, views, CORNERS)
    start = frame.scale * CORNERS @ frame.rotation.T + frame.shift
    there = adjust(tracks, tuple(map(frame.view, views)), start)
    expected = frame.scale * here.points @ frame.rotation.T + frame.shift
    assert there.sizes.pose_sd == pytest.approx(here.sizes.pose_sd)
    np.testing.assert_allclose(there.points, expected, atol=1e-5 * frame.scale)


def test_the_order_of_the_views_does_not_matter() -> None:
    views, tracks = off(ring(), 6, 0.3, 0.005), tracks_of(ring(), 6)
    order = np.random.default_rng(0).permutation(len(views))
    turned = Tracks(tracks.uv[:, order], tracks.cov[:, order], tracks.used[:, order], tracks.weight)
    one = adjust(tracks, views, CORNERS)
    other = adjust(turned, tuple(views[k] for k in order), CORNERS)
    np.testing.assert_allclose(other.points, one.points, atol=1e-6)


def stated(
    views: tuple[View, ...], degrees: float, metres: float, kind: PoseErrorKind
) -> PoseErrors:
    cov = np.diag([metres**2] * 3 + [np.radians(degrees) ** 2] * 3)
    return PoseErrors(tuple(v.pose for v in views), np.tile(cov, (len(views), 1, 1)), kind)


def test_stated_errors_are_believed() -> None:
    views = off(ring(), 7, 0.3, 0.005)
    errors = stated(views, 0.3, 0.005, PoseErrorKind.INDEPENDENT)
    found = adjust(tracks_of(ring(), 7), views, CORNERS, errors)
    assert found.sizes.pose_sd < np.radians(0.1)
    assert shape_rms(found.points) < 4e-4
    assert nees(found.points, found.covs) < 3.0


def test_a_chain_carries_the_error_of_a_pose_on() -> None:
    # All poses are off alike: odometry allows that, and no picture shows it.
    views = ring()
    shift = np.array([0.05, 0.0, 0.0])
    moved_on = tuple(replace(v, pose=Pose(v.pose.rotation, v.pose.centre + shift)) for v in views)
    cov = np.diag([0.05**2] * 3 + [1e-8] * 3)
    errors = PoseErrors(tuple(v.pose for v in moved_on), np.tile(cov, (len(views), 1, 1)))
    found = adjust(tracks_of(views, 3), moved_on, CORNERS + shift, errors)
    sds = np.sqrt(np.trace(found.covs, axis1=1, axis2=2) / 3)
    np.testing.assert_allclose(sds, 0.05, rtol=0.2)
    assert shape_rms(found.points) < 2e-4


def test_the_adjustment_is_the_minimum_that_a_general_solver_finds() -> None:
    true, count = ring(5), 5
    views, tracks = off(true, 15, 0.3, 0.005), tracks_of(true, 15)
    about = CORNERS.mean(axis=0)
    errors = stated(views, 0.3, 0.005, PoseErrorKind.INDEPENDENT)
    found = adjust(tracks, views, CORNERS, errors)
    variance = PIXEL_SD**2 + found.sizes.extra_px**2
    distance = np.median([np.linalg.norm(v.pose.centre - about) for v in views])
    turn_sd = np.hypot(np.radians(0.3), found.sizes.pose_sd)
    place_sd = np.hypot(0.005, found.sizes.pose_sd * distance)

    def off_by(unknown: FloatArray) -> FloatArray:
        # The same in other terms: turn and place of each camera.
        twists = unknown[: 6 * count].reshape(-1, 6)
        placed = tuple(
            replace(v, pose=moved(v.pose, t, v.pose.centre))
            for v, t in zip(views, twists, strict=True)
        )
        error = (tracks.uv - pixels(placed, unknown[6 * count :].reshape(-1, 3)))[tracks.used]
        share = (error**2).sum(axis=-1) / variance / ROBUST_SD**2
        robust = error * np.sqrt(np.log1p(share) / np.maximum(share, 1e-12) / variance)[:, None]
        believed = twists / np.repeat([turn_sd, place_sd], 3)
        return np.concatenate([robust.ravel(), believed.ravel()])

    start = np.concatenate([np.zeros(6 * count), CORNERS.ravel()])
    oracle = least_squares(off_by, start, x_scale="jac", max_nfev=40)
    np.testing.assert_allclose(oracle.x[6 * count :].reshape(-1, 3), found.points, atol=5e-5)


def test_wrong_matches_have_no_say() -> None:
    views = ring()
    tracks = tracks_of(views, 8, wrong=0.1)
    found = adjusted_points(tracks, off(views, 8, 0.3, 0.005))
    assert found.ok.all()
    assert shape_rms(found.points) < 5e-4


def test_two_views_leave_finite_honest_covariances() -> None:
    views = ring()[:2]
    found = adjust(tracks_of(views, 10), off(views, 10, 0.1, 0.001), CORNERS)
    assert np.isfinite(found.points).all()
    assert (np.linalg.eigvalsh(found.covs) > 0).all()


def test_a_view_without_an_observation_stays_where_it_is() -> None:
    views, tracks = off(ring(), 11, 0.3, 0.005), tracks_of(ring(), 11)
    used = tracks.used.copy()
    used[:, 5] = False
    found = adjust(replace(tracks, used=used), views, CORNERS)
    np.testing.assert_allclose(found.poses[5].centre, views[5].pose.centre, atol=1e-9)


def test_identical_views_give_no_point_and_no_error() -> None:
    same = (ring()[0],) * 6
    views = tuple(replace(v, name=f"{k}.png") for k, v in enumerate(same))
    found = adjusted_points(tracks_of(views, 12), views)
    assert not found.ok.any()


def test_no_tracks_give_no_points() -> None:
    views = ring(4)
    none = Tracks(
        np.zeros((0, 4, 2)), np.zeros((0, 4, 2, 2)), np.zeros((0, 4), np.bool_), np.ones(4)
    )
    found = adjusted_points(none, views)
    assert found.points.shape == (0, 3)
    assert found.views == views


def test_views_almost_alike_make_points_less_sure() -> None:
    views = off(ring(), 13, 0.3, 0.0)
    tracks = tracks_of(ring(), 13)
    apart = adjust(tracks, views, CORNERS)
    alike = adjust(replace(tracks, weight=np.full(len(views), 0.25)), views, CORNERS)
    ratio = np.trace(alike.covs, axis1=1, axis2=2) / np.trace(apart.covs, axis1=1, axis2=2)
    assert 2.0 < np.median(ratio) < 5.0


def cloud(count: int = 8) -> FloatArray:
    return np.random.default_rng(0).normal(size=(count, 3))


def motions(points: FloatArray) -> FloatArray:
    """Return what a unit shift along and turn about each axis does to points: (n, 6, 3)."""
    turns = [np.cross(axis, points) for axis in np.eye(3)]
    shifts = [np.broadcast_to(axis, points.shape) for axis in np.eye(3)]
    return np.stack([*shifts, *turns], axis=1)


def test_a_common_shift_and_turn_are_not_in_them() -> None:
    points = cloud()
    shared = motions(points) * np.array([3.0, 1.0, 2.0, 0.1, 0.2, 0.3])[:, None]
    own = np.tile(1e-6 * np.eye(3), (len(points), 1, 1))
    covs = remove_common_motion(points, own, shared)
    assert np.trace(covs, axis1=1, axis2=2).max() < 3.1e-6


def test_they_are_those_of_points_moved_onto_the_truth() -> None:
    rng = np.random.default_rng(1)
    points, count = cloud(6), 20_000
    own = np.tile(np.eye(3), (6, 1, 1))
    shared = rng.normal(size=(6, 5, 3))
    errors = rng.normal(size=(count, 6, 3))
    errors += np.einsum("cm,nmi->cni", rng.normal(size=(count, 5)), shared)
    weight = 1.0 / np.trace(own + shared.transpose(0, 2, 1) @ shared, axis1=1, axis2=2)
    rows = motions(points).transpose(0, 2, 1).reshape(18, 6)
    root = np.repeat(np.sqrt(weight), 3)
    best = np.linalg.lstsq(rows * root[:, None], (errors.reshape(count, 18) * root).T, rcond=None)
    left = errors.reshape(count, 18) - (rows @ best[0]).T
    found = np.einsum("cni,cnj->nij", left.reshape(count, 6, 3), left.reshape(count, 6, 3)) / count
    np.testing.assert_allclose(remove_common_motion(points, own, shared), found, atol=0.15)


def test_one_point_is_nowhere_against_others() -> None:
    covs = remove_common_motion(np.ones((1, 3)), np.eye(3)[None], np.zeros((1, 2, 3)))
    np.testing.assert_allclose(covs, 0.0, atol=1e-12)
    assert remove_common_motion(
        np.zeros((0, 3)), np.zeros((0, 3, 3)), np.zeros((0, 2, 3))
    ).shape == (
        0,
        3,
        3,
    )


UV = np.array([[[319.5, 239.5], [50.0, 400.0], [600.0, 20.0]]]).transpose(1, 0, 2)


def two_cameras(count: int = 6) -> tuple[View, ...]:
    other = replace(CAMERA, fx=500.0, fy=510.0, cx=300.0)
    views = ring(count)
    return tuple(replace(v, camera=other) if k % 2 else v for k, v in enumerate(views))


def spread(uv: FloatArray, views: int) -> FloatArray:
    return np.tile(uv, (1, views, 1))


@given(focal=st.floats(-0.2, 0.2), radial=st.floats(-0.3, 0.3))
def test_a_pixel_freed_of_its_distortion_is_the_pinholes(focal: float, radial: float) -> None:
    lenses = group_lenses(ring(3))
    unknowns = np.array([[focal, radial]])
    seen, _, _ = lenses.seen(unknowns, spread(UV, 3))
    off = spread(UV, 3) - lenses.centre
    np.testing.assert_allclose(
        lenses.undistorted(unknowns, seen), lenses.centre + (1.0 + focal) * off, atol=1e-3
    )


@given(focal=st.floats(-0.2, 0.2), radial=st.floats(-0.3, 0.3))
def test_derivatives_are_those_of_differences(focal: float, radial: float) -> None:
    lenses = group_lenses(two_cameras())
    unknowns = np.array([[focal, radial], [radial / 2, focal]])
    uv, step = spread(UV, 6), 1e-6
    at, by_pixel, by_lens = lenses.seen(unknowns, uv)
    for axis in range(2):
        moved = uv + step * np.eye(2)[axis]
        change = (lenses.seen(unknowns, moved)[0] - at) / step
        np.testing.assert_allclose(by_pixel[..., axis], change, atol=1e-4)
        change = (lenses.seen(unknowns + step * np.eye(2)[axis], uv)[0] - at) / step
        np.testing.assert_allclose(by_lens[..., axis], change, atol=1e-2)


def test_a_camera_of_two_views_has_no_unknowns() -> None:
    views = two_cameras(4)
    lone = Camera(640, 480, 700.0, 700.0, 319.5, 239.5)
    views = (*ring(3), replace(views[0], camera=lone), replace(views[1], camera=lone))
    lenses = group_lenses(views)
    assert lenses.count == 1
    unknowns = np.array([[0.1, 0.1]])
    seen, _, by_lens = lenses.seen(unknowns, spread(UV, 5))
    np.testing.assert_array_equal(seen[:, 3:], spread(UV, 2))
    assert not by_lens[:, 3:].any()
    assert [e.focal_sd for e in lenses.errors(unknowns, unknowns)] == [0.1] * 3 + [0.0] * 2
