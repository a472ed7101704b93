"""Limits: the lower of the user's, the model's and the robot's own."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.robot.pioneer.limits import BRAKING_TIME, Limits
from facetlog.robot.pioneer.parameters import MODELS
from tests.robot.pioneer.scripted import CONFIGURATION

SPEEDS = st.floats(-10, 10)


@given(SPEEDS, SPEEDS)
def test_clipped_speeds_keep_to_the_limits_and_to_the_curve(speed: float, turning: float) -> None:
    limits = Limits()
    v, w = limits.clip(speed, turning)
    assert abs(v) <= limits.speed * (1 + 1e-12)
    assert abs(w) <= limits.turning * (1 + 1e-12)
    assert v * turning == pytest.approx(w * speed, abs=1e-9)
    assert v * speed >= 0
    assert w * turning >= 0


def test_the_robots_own_limits_go_before_the_users() -> None:
    slow = replace(CONFIGURATION, speed_top=200, turning_top=20, acceleration_top=500)
    limits = Limits(speed=1.0).restrict_to_robot(MODELS["p3dx"], slow)
    assert limits.speed == pytest.approx(0.2)
    assert limits.turning == pytest.approx(math.radians(20))
    assert limits.deceleration == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("given_v", "robots", "expected"), [(None, 0, 11.0), (None, 115, 11.5), (12.0, 115, 12.0)]
)
def test_the_batterys_limit_is_the_users_else_the_robots(
    given_v: float | None, robots: int, expected: float
) -> None:
    configuration = replace(CONFIGURATION, low_battery=robots)
    limits = Limits(battery_v=given_v).restrict_to_robot(MODELS["p3dx"], configuration)
    assert limits.battery_v == expected


def test_the_default_speeds_are_braked_from_in_time() -> None:
    limits = Limits()
    assert limits.can_brake_in_time(limits.speed, limits.turning)
    assert not limits.can_brake_in_time(limits.speed * 1.1, 0.0)
    assert not limits.can_brake_in_time(0.0, limits.turning * 1.1)
    assert BRAKING_TIME + 0.3 < 0.6


@pytest.mark.parametrize(
    ("name", "bad"),
    [("speed", 0.0), ("turning", math.nan), ("deceleration", math.inf), ("battery_v", -1.0)],
)
def test_an_impossible_limit_is_refused(name: str, bad: float) -> None:
    with pytest.raises(ValueError, match=name.removesuffix("_v")):
        Limits(**{name: bad})
