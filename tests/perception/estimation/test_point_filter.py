"""Points from views: accuracy, honesty, wrong matches, and views that determine no point."""

import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.stats import chi2 as chi2_of

from facetlog.errors import CalibrationError
from facetlog.perception.estimation.ekf import largest_sd
from facetlog.perception.estimation.point_filter import (
    PointFailure,
    estimate_point,
    estimate_points,
    measure_pixel,
)
from facetlog.perception.pan_tilt import projection_matrix
from facetlog.perception.types import Observation
from tests.perception.rigs import (
    INTRINSICS,
    PIXEL_SD,
    moved,
    observations,
    pictured,
    project,
    ring,
    rotation,
)

SEEDS = st.integers(0, 2**32 - 1)


def _nees(points, covs, truth):
    error = points - truth
    return np.einsum("ni,nij,nj->n", error, np.linalg.inv(covs), error)


def _bound(points, projections, sd=PIXEL_SD):
    """Cramér-Rao bound of the points, (n, 3, 3), by numerical derivatives."""
    step = 1e-5
    J = np.stack(
        [
            (project(projections, points + step * e) - project(projections, points - step * e))
            / (2 * step)
            for e in np.eye(3)
        ],
        axis=-1,
    ).reshape(len(points), -1, 3)
    return np.linalg.inv(J.transpose(0, 2, 1) @ J / sd**2)


def _interval(count, dof):
    """Where the mean of `count` chi-squares lies in all but one in 10,000 runs."""
    return chi2_of.ppf([5e-5, 1 - 5e-5], count * dof) / count


def _sd_off(a, b, cov):
    return float(np.sqrt((a - b) @ np.linalg.solve(cov, a - b)))


@pytest.mark.parametrize(
    ("views", "arc", "wrong"),
    [
        (24, 2 * np.pi, 0.0),
        (24, 2 * np.pi, 0.3),
        (24, np.radians(6.0), 0.0),  # a quarter of a degree of parallax a view
        (2, np.radians(40.0), 0.0),
    ],
)
def test_estimates_reach_the_bound_and_their_covariance_is_honest(views, arc, wrong):
    count = 200
    projections = ring(views, arc)
    truth, uv, cov, bad = pictured(np.random.default_rng(views), count, projections, wrong)
    points, covs, used, ok = estimate_points(uv, cov, np.ones((count, views), bool), projections)
    assert ok.all()
    assert not (used & bad).any()
    low, high = _interval(count, 3)
    assert low < _nees(points, covs, truth).mean() < high
    bound = np.trace(_bound(truth, projections), axis1=1, axis2=2)
    ratio = np.sqrt((((points - truth) ** 2).sum(axis=1) / bound).mean())
    # Lost views cost 1/sqrt(1 - wrong); the rest is chance.
    assert ratio < 1.15 / np.sqrt(1 - wrong)


@settings(max_examples=25)
@given(SEEDS, st.floats(-4, 4), st.floats(0, 3))
def test_a_similarity_of_the_world_moves_the_estimate_with_it(seed, log_scale, log_shift):
    rng = np.random.default_rng(seed)
    projections = ring(10)
    _, uv, cov, _ = pictured(rng, 1, projections, wrong=0.1)
    scale = 10.0**log_scale
    R, shift = rotation(rng), scale * 10.0**log_shift * rng.normal(size=3)
    seen = observations(uv[0], cov[0])
    here = estimate_point(seen, list(projections))
    there = estimate_point(seen, list(moved(projections, R, shift, scale)))
    assert here.used == there.used
    np.testing.assert_allclose(R.T @ (there.point - shift) / scale, here.point, atol=1e-6)
    np.testing.assert_allclose(
        R.T @ there.cov @ R / scale**2, here.cov, atol=1e-3 * np.abs(here.cov).max()
    )


def test_many_at_once_equal_one_by_one_and_filterpy():
    rng = np.random.default_rng(7)
    projections = ring(9)
    _, uv, cov, _ = pictured(rng, 12, projections, wrong=0.1)
    seen = rng.random((12, 9)) < 0.8
    uv[~seen] = np.nan
    points, covs, used, ok = estimate_points(uv, cov, seen, projections)
    assert ok.any()
    for i in range(12):
        views = np.flatnonzero(seen[i])
        single = estimate_point([Observation(v, uv[i, v], cov[i, v]) for v in views], projections)
        assert bool(single) == ok[i]
        if not single:
            assert np.isnan(points[i]).all()
            assert not used[i].any()
            continue
        assert list(views[list(single.used)]) == list(np.flatnonzero(used[i]))
        assert _sd_off(single.point, points[i], covs[i]) < 1e-3
        np.testing.assert_allclose(single.cov, covs[i], rtol=1e-4, atol=1e-4 * covs[i].max())
        reference = ExtendedKalmanFilter(dim_x=3, dim_z=2)
        reference.x, reference.P = points[i].copy(), 1e4 * np.eye(3)
        for v in np.flatnonzero(used[i]):
            lin = measure_pixel(uv[i, v], projections[v], cov[i, v], points[i])(points[i])
            reference.update(
                lin.y, lambda _, m: m, lambda x, m: m @ x, R=lin.W, args=lin.M, hx_args=lin.M
            )
        assert _sd_off(reference.x, points[i], covs[i]) < 1e-3
        np.testing.assert_allclose(reference.P, covs[i], rtol=1e-4, atol=1e-4 * covs[i].max())


def test_limit_stops_the_recursion_and_says_how_many_views_it_took():
    projections = ring(24)
    _, uv, cov, _ = pictured(np.random.default_rng(13), 1, projections)
    seen = observations(uv[0], cov[0])
    whole = estimate_point(seen, list(projections))
    limit = 1.5 * largest_sd(whole.cov)
    stopped = estimate_point(seen, list(projections), sd_limit=limit)
    assert stopped.views_needed == len(stopped.used) < len(whole.used)
    assert largest_sd(stopped.cov) <= limit
    assert whole.views_needed is None
    assert estimate_point(seen, list(projections), sd_limit=1e-9).views_needed is None


def test_the_papers_projection_will_do_with_skew():
    poses = [(36.5, 98.5, 2.793), (27.5, 97.5, 3.1416), (20.0, 96.0, 3.23), (7.0, 95.0, 3.49)]
    projections = np.array(
        [projection_matrix(x, y, 28.5, a, -1.974, 0.2, 15.5) for x, y, a in poses]
    )
    truth = np.array([[23.0, 56.0, 6.0]])
    uv = project(projections, truth)[0]
    found = estimate_point(observations(uv, np.tile(1e-4 * np.eye(2), (4, 1, 1))), projections)
    np.testing.assert_allclose(found.point, truth[0], atol=1e-6)


@pytest.mark.parametrize("count", [0, 1])
def test_one_view_is_too_few(count):
    seen = observations(np.full((count, 2), 100.0), np.tile(np.eye(2), (count, 1, 1)))
    failed = estimate_point(seen, list(ring(2)))
    assert not failed
    assert failed.reason is PointFailure.FEW_VIEWS


def test_two_views_that_contradict_give_no_point():
    projections = ring(2, np.radians(60.0))
    uv = project(projections, np.zeros((1, 3)))[0] + [[0.0, 40.0], [0.0, -40.0]]
    failed = estimate_point(observations(uv, np.tile(np.eye(2), (2, 1, 1))), list(projections))
    assert failed.reason is PointFailure.INCONSISTENT


def test_two_views_that_agree_alone_do_not_outvote_a_third():
    projections = ring(3)
    uv = project(projections, np.zeros((1, 3)))[0]
    uv[2] += 60.0
    failed = estimate_point(observations(uv, np.tile(np.eye(2), (3, 1, 1))), list(projections))
    assert failed.reason is PointFailure.INCONSISTENT


def _side_by_side(baseline, views=4):
    K = np.diag([600.0, 600.0, 1.0])
    steps = np.linspace(0.0, baseline, views)
    return [K @ np.column_stack([np.eye(3), [-x, 0.0, 0.0]]) for x in steps]


def test_rays_that_meet_behind_the_cameras_give_no_point():
    projections = _side_by_side(1.0)
    h = np.array([p @ [0.3, 0.1, -4.0, 1.0] for p in projections])  # behind every camera
    failed = estimate_point(
        observations(h[:, :2] / h[:, 2:], np.tile(np.eye(2), (4, 1, 1))), projections
    )
    assert failed.reason is PointFailure.BEHIND


@pytest.mark.parametrize("seed", range(3))
def test_parallel_rays_give_no_point(seed):
    uv = np.array([50.0, 20.0]) + 0.3 * np.random.default_rng(seed).normal(size=(4, 2))
    failed = estimate_point(observations(uv, np.tile(np.eye(2), (4, 1, 1))), _side_by_side(1.0))
    assert failed.reason is PointFailure.PARALLEL


@pytest.mark.parametrize("place", [0.0, 1e4])
def test_views_from_one_place_have_no_parallax(place):
    K = np.diag([600.0, 600.0, 1.0])
    centre = np.array([place, -place, 2.0])
    projections, uv = [], []
    for angle in (0.0, 0.1, 0.2):
        c, s = np.cos(angle), np.sin(angle)
        R = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
        projections.append(K @ np.column_stack([R, -R @ centre]))
        h = projections[-1] @ [*(centre + np.array([0.1, 0.1, 3.0])), 1.0]
        uv.append(h[:2] / h[2])
    failed = estimate_point(observations(np.array(uv), np.tile(np.eye(2), (3, 1, 1))), projections)
    assert failed.reason is PointFailure.NO_PARALLAX


def test_bad_arguments_are_refused():
    projections = ring(3)
    uv = project(projections, np.zeros((1, 3)))
    cov = np.tile(np.eye(2), (1, 3, 1, 1))
    seen = np.ones((1, 3), dtype=bool)
    with pytest.raises(CalibrationError, match="pinhole"):
        estimate_points(uv, cov, seen, np.where(np.arange(3)[:, None, None] == 1, 1.0, projections))
    with pytest.raises(ValueError, match="positive definite"):
        estimate_points(uv, 0 * cov, seen, projections)
    with pytest.raises(ValueError, match="do not fit"):
        estimate_points(uv[:, :2], cov, seen, projections)
    with pytest.raises(ValueError, match="projections"):
        estimate_points(uv, cov, seen, projections[:2])
    with pytest.raises(ValueError, match="positive"):
        estimate_point(observations(uv[0], cov[0]), projections, sd_limit=-1.0)


SEEDS = st.integers(0, 2**32 - 1)


def _square_sd_off(points, covs, truth):
    error = points - truth
    return np.einsum("ni,nij,nj->n", error, np.linalg.inv(covs), error)


@pytest.mark.parametrize("arc_deg", [3.0, 360.0])
def test_points_seen_from_a_narrow_arc_survive_two_wrong_matches_in_five(arc_deg):
    count, views = 150, 24
    projections = ring(views, np.radians(arc_deg))
    truth, uv, cov, _ = pictured(np.random.default_rng(19), count, projections, wrong=0.4)
    points, covs, _, ok = estimate_points(uv, cov, np.ones((count, views), bool), projections)
    assert ok.mean() >= 0.95
    square = _square_sd_off(points[ok], covs[ok], truth[ok])
    assert square.max() < 36.0
    assert 0.8 < square.mean() / 3 < 1.25


@settings(max_examples=25)
@given(SEEDS, st.sampled_from([3.0, 20.0, 360.0]), st.sampled_from([5, 9, 24]))
def test_the_order_of_views_does_not_matter_among_wrong_matches(seed, arc_deg, views):
    rng = np.random.default_rng(seed)
    projections = ring(views, np.radians(arc_deg))
    _, uv, cov, _ = pictured(rng, 4, projections, wrong=0.4)
    everywhere = np.ones((4, views), bool)
    order = rng.permutation(views)
    points, covs, used, ok = estimate_points(uv, cov, everywhere, projections)
    other, _, theirs, also = estimate_points(uv[:, order], cov, everywhere, projections[order])
    np.testing.assert_array_equal(ok, also)
    np.testing.assert_array_equal(used[:, order], theirs)
    assert (_square_sd_off(other[ok], covs[ok], points[ok]) < 1e-3**2).all()


@pytest.mark.parametrize("turn", [0, 3])
def test_two_points_of_equal_likelihood_are_none_whatever_the_order(turn):
    projections = ring(6)
    truths = np.array([[0.1, 0.0, 0.0], [-0.1, 0.1, 0.2]])
    both = project(projections, truths)
    uv = np.where(np.arange(6)[:, None] % 2 == 0, both[0], both[1])
    order = np.roll(np.arange(6), turn)
    seen = observations(uv[order], np.tile(PIXEL_SD**2 * np.eye(2), (6, 1, 1)))
    failed = estimate_point(seen, list(projections[order]))
    assert failed.reason is PointFailure.INCONSISTENT


def test_the_likelier_of_two_points_wins():
    projections = ring(8)
    truths = np.array([[0.1, 0.0, 0.0], [-0.1, 0.1, 0.2]])
    both = project(projections, truths)
    uv = np.where(np.isin(np.arange(8), [1, 4, 6])[:, None], both[1], both[0])
    found = estimate_point(
        observations(uv, np.tile(PIXEL_SD**2 * np.eye(2), (8, 1, 1))), list(projections)
    )
    np.testing.assert_allclose(found.point, truths[0], atol=1e-6)
    assert found.rejected == (1, 4, 6)


def test_points_are_kept_where_the_noise_is_three_times_the_stated_one():
    projections = ring(24)
    rng = np.random.default_rng(31)
    truth, uv, cov, _ = pictured(rng, 100, projections, wrong=0.2, sd=3 * PIXEL_SD)
    points, _, _, ok = estimate_points(uv, cov / 9, np.ones((100, 24), bool), projections)
    assert ok.mean() >= 0.95
    assert np.sqrt(((points - truth)[ok] ** 2).sum(axis=1).mean()) < 0.01


def _camera(centre, to):
    z = np.subtract(to, centre) / np.linalg.norm(np.subtract(to, centre))
    x = np.cross(z, [0.0, 0.0, 1.0] if abs(z[2]) < 0.9 else [1.0, 0.0, 0.0])
    x /= np.linalg.norm(x)
    R = np.array([x, np.cross(z, x), z])
    return INTRINSICS @ np.column_stack([R, -R @ np.asarray(centre, dtype=np.float64)])


def _pixels(projections, point):
    """Where the point appears, also behind a camera; at a pinhole, and beside it, somewhere."""
    h = projections[:, :, :3] @ point + projections[:, :, 3]
    depth = np.where(np.abs(h[:, 2:]) < 1e-9, 1e-9, h[:, 2:])
    return np.clip(h[:, :2] / depth, -1e5, 1e5)


PLACES = st.tuples(*[st.integers(-3, 3)] * 3)


@settings(max_examples=40)
@given(
    st.lists(PLACES, min_size=2, max_size=7),
    PLACES,
    st.sampled_from(["round", "one place", "one line", "through the point"]),
    st.sampled_from([0.0, 0.5]),
    SEEDS,
)
@example([(0, 0, -1), (0, 1, 2)], (0, 0, 3), "round", 0.0, 0)  # the gain is lost in rounding
@example(
    [(3, 1, -2), (3, 0, 0), (0, 0, 0), (-3, 0, 0), (2, 0, 0)],
    (-1, -1, 1),
    "through the point",
    0.0,
    2014,
)  # there is none
def test_whatever_the_views_a_point_is_estimated_or_refused_with_its_reason(
    places, point, kind, sd, seed
):
    # On a coarse grid cameras coincide, look along one line, sit in the point or beside it.
    centres = np.array(places, dtype=np.float64)
    point = np.array(point, dtype=np.float64)
    if kind == "one place":
        centres[:] = centres[0]
    elif kind == "one line":
        centres[:, 1:] = centres[0, 1:]
    elif kind == "through the point":
        centres = point + centres[:, :1] * (centres[0] - point)
    rng = np.random.default_rng(seed)
    aims = centres + rng.integers(-1, 2, centres.shape) + np.array([0.0, 0.0, 0.1])
    projections = np.array([_camera(c, a) for c, a in zip(centres, aims, strict=True)])
    uv = _pixels(projections, point) + sd * rng.normal(size=(len(places), 2))
    cov = np.tile(PIXEL_SD**2 * np.eye(2), (len(places), 1, 1))
    alone = estimate_point(observations(uv, cov), list(projections))
    assert alone or alone.reason in PointFailure
    if kind in ("one place", "through the point"):
        assert not alone or not (projections[:, 2, :3] @ point + projections[:, 2, 3] > 1e-6).all()
    # Nor does it harm a sound point beside it.
    good = ring(len(places), np.radians(200.0))
    shared = np.concatenate([projections, good])
    seen = np.zeros((2, len(shared)), bool)
    seen[0, : len(places)] = seen[1, len(places) :] = True
    pixels = np.concatenate([uv, project(good, np.zeros((1, 3)))[0]])
    points, covs, used, ok = estimate_points(
        np.tile(pixels, (2, 1, 1)),
        np.tile(PIXEL_SD**2 * np.eye(2), (*seen.shape, 1, 1)),
        seen,
        shared,
    )
    assert ok[1]
    np.testing.assert_allclose(points[1], 0.0, atol=1e-6)
    assert np.isfinite(points[ok]).all()
    assert (np.linalg.eigvalsh(covs[ok]) > 0).all()
    assert not used[~ok].any()
