"""The rectangle round a plan: where it is, how it is turned, and how sure both are."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.mapping.plan_box import plan_box
from facetlog.perception.types import FloatArray

RING = np.array([(0, 1), (1, 2), (2, 3), (3, 0)])
NONE = np.zeros((0, 2), dtype=np.intp)
SD = 0.003


def _rectangle(x: float, y: float, heading: float, length: float, width: float) -> FloatArray:
    c, s = math.cos(heading), math.sin(heading)
    half = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * [length / 2, width / 2]
    corners: FloatArray = half @ np.array([[c, s], [-s, c]]) + [x, y]
    return corners


def _covs(count: int, sd: float = SD) -> FloatArray:
    return np.tile(sd**2 * np.eye(2), (count, 1, 1))


@given(
    st.floats(-5, 5), st.floats(-5, 5), st.floats(-1.5, 1.5), st.floats(0.6, 3), st.floats(0.1, 0.5)
)
@settings(max_examples=60)
def test_a_rectangle_is_found_where_it_is(
    x: float, y: float, heading: float, length: float, width: float
) -> None:
    box = plan_box(_rectangle(x, y, heading, length, width), _covs(4), RING)
    assert box is not None
    assert box.values == pytest.approx([x, y, heading, length, width], abs=1e-6)
    assert np.linalg.eigvalsh(box.cov).min() > -1e-12


def test_its_covariance_is_that_of_what_is_measured() -> None:
    """NEES over many seeds: of five numbers, five on average."""
    rng = np.random.default_rng(5)
    true = np.array([0.4, -1.0, 0.3, 0.9, 0.4])
    exact = _rectangle(*true.tolist())
    nees = []
    for _ in range(400):
        box = plan_box(exact + rng.normal(0.0, SD, exact.shape), _covs(4), RING)
        assert box is not None
        off = box.values - true
        nees.append(float(off @ np.linalg.solve(box.cov, off)))
    # The outermost of two equal corners reaches a little farther than either: one sd at most.
    assert 4.0 < np.mean(nees) < 7.0


def test_what_is_poorly_known_neither_turns_nor_widens_it() -> None:
    """A foot that seems to stand out by 5 cm, and is known to 4 cm."""
    exact = _rectangle(0.0, 0.0, 0.2, 1.0, 0.5)
    points = np.vstack([exact, [[0.6, 0.1], [0.52, 0.14]]])
    covs = np.concatenate([_covs(4), _covs(2, 0.04)])
    box = plan_box(points, covs, np.vstack([RING, [[4, 5]]]))
    assert box is not None
    assert box.values == pytest.approx([0.0, 0.0, 0.2, 1.0, 0.5], abs=0.002)


def test_a_sheet_is_a_line_and_a_point_is_nothing() -> None:
    line = plan_box(np.array([[0.0, 0.0], [1.0, 1.0], [0.5, 0.5]]), _covs(3), NONE)
    assert line is not None
    assert line.values == pytest.approx([0.5, 0.5, math.pi / 4, math.sqrt(2), 0.0], abs=1e-9)
    assert plan_box(np.zeros((3, 2)), _covs(3), NONE) is None
    assert plan_box(np.zeros((0, 2)), _covs(0), NONE) is None
