"""Points among wrong matches: narrow arcs, rivals, and views that leave nothing to be solved."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from facetlog.perception.estimation.point_filter import (
    PointFailure,
    estimate_point,
    estimate_points,
)
from tests.perception.rigs import INTRINSICS, PIXEL_SD, observations, pictured, project, ring

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
