"""The figures that the paper prints (section 5.3), to every printed digit."""

import numpy as np
import pytest

from facetlog.paper.page import printed
from facetlog.perception.estimation.ekf import State
from facetlog.perception.estimation.plane_filter import Chart, plain_plane_recursion
from facetlog.perception.estimation.point_filter import run_printed_recursion
from facetlog.perception.pan_tilt import projection_matrix
from facetlog.perception.types import Observation

GOLDEN = printed()
POINT, PLANE = GOLDEN["point"], GOLDEN["plane"]


def _point_states(uv="uv", pose="pose", s0=POINT["s0"]):
    cases = POINT["iteration"]
    projections = [projection_matrix(*case[pose], POINT["focal"]) for case in cases]
    noise = POINT["noise"] * np.eye(2)
    seen = [Observation(i, case[uv], noise) for i, case in enumerate(cases)]
    return list(run_printed_recursion(seen, projections, State(np.zeros(3), s0 * np.eye(3))))


@pytest.mark.parametrize("iteration", [0, 1])
def test_point_iteration_of_section_5_3(iteration):
    printed, state = POINT["iteration"][iteration], _point_states()[iteration]
    assert (np.abs(state.mean - printed["point"]) <= printed["point_tolerance"]).all()
    unit = 2 * printed["cov_tolerance"]
    for (i, j), figure in np.ndenumerate(np.array(printed["cov"])):
        if [i, j] in printed["truncated"]:
            assert np.trunc(state.cov[i, j] / unit) * unit == pytest.approx(figure, abs=1e-9)
        else:
            assert state.cov[i, j] == pytest.approx(figure, abs=printed["cov_tolerance"])


def test_inputs_round_to_the_printed_inputs():
    for case in POINT["iteration"]:
        np.testing.assert_allclose(case["uv"], case["printed_uv"], atol=0.0006)
        np.testing.assert_allclose(case["pose"], case["printed_pose"], atol=0.005)


def test_inputs_as_printed_come_close():
    # Measured: coordinates move by up to 0.32, variances by 1.5 %.
    for case, state in zip(
        POINT["iteration"], _point_states("printed_uv", "printed_pose", 1e4), strict=True
    ):
        np.testing.assert_allclose(state.mean, case["point"], atol=0.35)
        np.testing.assert_allclose(np.diag(state.cov), np.diag(case["cov"]), rtol=0.02)


@pytest.mark.parametrize("iteration", [0, 1])
def test_plane_iteration_of_section_5_3(iteration):
    start = State(np.zeros(3), PLANE["s0"] * np.eye(3))
    points = [case["point"] for case in PLANE["iteration"]]
    states = list(plain_plane_recursion(points, PLANE["noise"] * np.eye(3), start, Chart.Z))
    printed = PLANE["iteration"][iteration]
    np.testing.assert_allclose(
        states[iteration].mean, printed["parameters"], atol=printed["tolerance"]
    )
