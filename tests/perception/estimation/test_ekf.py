"""The recursion of equations (1) to (5): one state, many at once, and its own algebra."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.perception.estimation.ekf import (
    Linearised,
    State,
    linearise,
    recursion,
    run,
    step,
    step_all,
)
from facetlog.perception.estimation.point_filter import ray_measurement
from tests.perception.rigs import pictured, ring


def test_every_step_is_the_equations_of_the_paper():
    rng = np.random.default_rng(1)
    projections = ring(12)
    _, uv, cov, _ = pictured(rng, 1, projections)
    measurements = [ray_measurement(uv[0, v], projections[v], cov[0, v]) for v in range(12)]
    a, S = np.zeros(3), 100.0 * np.eye(3)
    states = recursion(State(a, S), measurements)
    for measurement, state in zip(measurements, states, strict=True):
        lin = measurement(a)
        K = S @ lin.M.T @ np.linalg.inv(lin.W + lin.M @ S @ lin.M.T)
        a, S = a + K @ (lin.y - lin.M @ a), (np.eye(3) - K @ lin.M) @ S
        np.testing.assert_allclose(state.mean, a, rtol=1e-4, atol=1e-7)
        np.testing.assert_allclose(state.cov, S, rtol=1e-4, atol=1e-9)


@given(st.integers(0, 2**32 - 1), st.integers(1, 4), st.integers(1, 3))
def test_many_steps_at_once_are_the_same_as_one_by_one(seed, n, p):
    rng = np.random.default_rng(seed)
    root, noise = rng.normal(size=(5, n, n)), rng.normal(size=(5, p, p))
    a, S = rng.normal(size=(5, n)), root @ root.swapaxes(1, 2) + 1e-3 * np.eye(n)
    y, M = rng.normal(size=(5, p)), rng.normal(size=(5, p, n))
    W = noise @ noise.swapaxes(1, 2) + 1e-3 * np.eye(p)
    means, covs = step_all(a, S, y, M, W)
    for k in range(5):
        one = step(State(a[k], S[k]), Linearised(y[k], M[k], W[k]))
        scale = np.sqrt(np.trace(one.cov))
        np.testing.assert_allclose(means[k], one.mean, rtol=1e-6, atol=1e-6 * scale)
        np.testing.assert_allclose(covs[k], one.cov, rtol=1e-6, atol=1e-6 * scale**2)


@given(st.integers(0, 2**32 - 1))
def test_covariance_stays_symmetric_positive_and_shrinks(seed):
    rng = np.random.default_rng(seed)
    A, B = rng.normal(size=(4, 4)), rng.normal(size=(2, 2))
    state = State(rng.normal(size=4), A @ A.T + 1e-3 * np.eye(4))
    lin = Linearised(rng.normal(size=2), rng.normal(size=(2, 4)), B @ B.T + 1e-6 * np.eye(2))
    after = step(state, lin)
    assert (after.cov == after.cov.T).all()
    assert np.linalg.eigvalsh(after.cov)[0] > 0
    assert np.linalg.eigvalsh(state.cov - after.cov)[0] > -1e-9 * np.trace(state.cov)
    # Equation (5) as printed
    K = state.cov @ lin.M.T @ np.linalg.inv(lin.W + lin.M @ state.cov @ lin.M.T)
    np.testing.assert_allclose(after.cov, (np.eye(4) - K @ lin.M) @ state.cov, atol=1e-7)


def _readings(sd):
    while True:
        yield lambda a: linearise([a[0] - 5.0], [[1.0]], [[-1.0]], [[sd**2]], a)


def test_run_stops_at_the_limit_and_says_after_how_many_views():
    # n readings of sd 1 give sd 1/sqrt(n): 0.25 takes 16. The readings never end.
    ended = run(State(np.zeros(1), 1e12 * np.eye(1)), _readings(1.0), sd_limit=0.2500001)
    assert (ended.used, ended.reached) == (16, True)
    assert ended.state.mean[0] == pytest.approx(5.0)
