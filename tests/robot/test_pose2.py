"""Poses on the floor are a group, and the heading stays within one turn."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.robot.pose2 import Pose2, wrapped

LENGTHS = st.floats(-100, 100)
ANGLES = st.floats(-math.pi, math.pi)
POSES = st.builds(Pose2, LENGTHS, LENGTHS, ANGLES)


def same(a: Pose2, b: Pose2) -> bool:
    return math.hypot(a.x - b.x, a.y - b.y) < 1e-9 and abs(wrapped(a.heading - b.heading)) < 1e-9


@given(POSES, POSES)
def test_what_is_between_leads_from_one_to_the_other(a: Pose2, b: Pose2) -> None:
    assert same(a.compose(a.between(b)), b)


@given(st.floats(-1e6, 1e6))
def test_a_wrapped_angle_is_the_same_direction_within_one_turn(angle: float) -> None:
    turned = wrapped(angle)
    assert -math.pi < turned <= math.pi
    assert math.isclose(math.cos(turned), math.cos(angle), abs_tol=1e-9)
    assert math.isclose(math.sin(turned), math.sin(angle), abs_tol=1e-9)


def test_a_quarter_turn_left_leads_ahead_to_the_left() -> None:
    assert same(Pose2(1, 2, math.pi / 2).compose(Pose2(3, 0, 0)), Pose2(1, 5, math.pi / 2))


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_what_is_no_number_is_no_pose(bad: float) -> None:
    with pytest.raises(ValueError, match="no place"):
        Pose2(0, bad, 0)
