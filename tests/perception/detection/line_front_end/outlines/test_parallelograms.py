"""Parallelograms that two sides propose."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.perception.detection.line_front_end.outlines.parallelograms import parallelograms
from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import PlaneHypothesis
from facetlog.perception.types import FloatArray

PIXEL = 0.01
LEVEL = PlaneHypothesis(np.array([0.0, 0.0, 1.0]), 2.0, np.arange(0))
RING = np.array([[0.0, 0, 2], [3, 0, 2], [3, 1, 2], [0, 1, 2]])
SIDES = np.stack([RING, np.roll(RING, -1, axis=0)], axis=1)


def off(found: FloatArray, ring: FloatArray) -> float:
    """How far the corners of one are from the other's, at most."""
    return float(np.linalg.norm(found[:, None] - ring, axis=-1).min(axis=1).max())


@pytest.mark.parametrize("corner", range(4))
def test_two_sides_that_meet_propose_the_other_two(corner: int) -> None:
    (found,) = parallelograms(SIDES[[corner - 1, corner]], LEVEL, PIXEL)
    assert off(found, RING) < 1e-9


@pytest.mark.parametrize("missing", range(4))
def test_three_sides_propose_the_fourth_though_one_ends_short_of_it(missing: int) -> None:
    short, base, whole = SIDES[[missing - 3, missing - 2, missing - 1]]
    short = np.array([0.6 * short[0] + 0.4 * short[1], short[1]])
    found = parallelograms(np.array([short, base, whole]), LEVEL, PIXEL)
    assert min(off(ring, RING) for ring in found) < 1e-9


def test_sides_that_do_not_meet_propose_nothing() -> None:
    assert parallelograms(SIDES[[0, 2]], LEVEL, PIXEL) == ()
    apart = np.array([SIDES[0], SIDES[1] + [1.0, 0, 0]])
    assert parallelograms(apart, LEVEL, PIXEL) == ()
    assert parallelograms(np.zeros((0, 2, 3)), LEVEL, PIXEL) == ()


def test_a_side_shorter_than_a_detector_sees_proposes_nothing() -> None:
    short = np.array([SIDES[0], SIDES[1] * 0.0 + [[3, 0, 2], [3, 0.05, 2]]])
    assert parallelograms(short, LEVEL, PIXEL) == ()


def test_sides_that_cross_propose_every_quarter() -> None:
    cross = np.array([[[-2.0, 0, 2], [1, 0, 2]], [[0, -1, 2], [0, 3, 2]]])
    found = parallelograms(cross, LEVEL, PIXEL)
    assert len(found) == 4


@given(st.floats(0.0, 6.28), st.integers(0, 3), st.floats(0.5, 30.0))
def test_turning_and_scaling_the_plane_changes_nothing(
    turn: float, missing: int, scale: float
) -> None:
    c, s = np.cos(turn), np.sin(turn)
    by = scale * np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    known = np.delete(SIDES, missing, axis=0) @ by.T
    plane = PlaneHypothesis(LEVEL.normal, 2.0 * scale, LEVEL.lines)
    assert off(parallelograms(known, plane, scale * PIXEL)[0], RING @ by.T) < 1e-6 * scale
