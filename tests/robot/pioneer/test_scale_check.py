"""Reports that agree, or not, on how far the robot drove."""

import math
import re
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.robot.pioneer.guard import ScaleCheck
from facetlog.robot.pioneer.parameters import MODELS
from facetlog.robot.pioneer.state import RobotState, SonarRange, StateMaker
from facetlog.robot.pose2 import Pose2
from tests.robot.pioneer.test_state import REPORT

P3DX = MODELS["p3dx"]
CYCLE = 0.1


def drive(
    *,
    speed: float = 0.3,
    seconds: float = 8.0,
    scale: float = 1.0,
    wall: float = 6.0,
    slant: float = 0.0,
    walks: float = 0.0,
    seed: int = 0,
) -> Iterator[RobotState]:
    """A robot that stands, then drives at a wall `slant` off square, whose positions and speeds
    are both `scale` times the true ones; `walks` (m/s) is how fast what is ahead comes nearer once
    a second has passed.
    """
    rng = np.random.default_rng(seed)
    state, _ = StateMaker(P3DX).state(REPORT, 0.0)
    x = now = v = 0.0
    while now < seconds:
        v = min(v + 0.3 * CYCLE, speed) if now >= 1.0 else 0.0
        x += v * CYCLE
        now += CYCLE
        left = (wall - x) * math.cos(slant) - walks * max(0.0, now - 1.5)
        sonars = tuple(
            SonarRange(i, round(left + rng.normal(0.0, 0.01), 3), now, P3DX.sonars[i])
            for i in (3, 4)
        )
        yield replace(
            state,
            at=now,
            pose=Pose2(scale * x, 0.0, 0.0),
            speed=scale * v,
            left_speed=scale * v,
            right_speed=scale * v,
            sonars=sonars,
        )


def find_fault(*drives: Iterator[RobotState]) -> str | None:
    check = ScaleCheck(P3DX)
    for number, states in enumerate(drives):
        for state in states:
            if fault := check.find_fault(replace(state, at=state.at + 100 * number)):
                return fault
    return None


@given(
    seed=st.integers(0, 1000),
    speed=st.floats(0.1, 0.5),
    slant=st.floats(0.0, math.radians(30.0)),
    wall=st.floats(3.0, 8.0),
)
def test_a_right_scale_is_not_doubted_before_a_wall(
    seed: int, speed: float, slant: float, wall: float
) -> None:
    drives = (drive(speed=speed, seed=seed + i, slant=slant, wall=wall) for i in range(2))
    assert find_fault(*drives) is None


@pytest.mark.parametrize("scale", [0.485, 2.06])
def test_a_scale_that_is_wrong_in_all_reports_shows_by_what_comes_nearer(scale: float) -> None:
    fault = find_fault(drive(scale=scale), drive(scale=scale, seed=1))
    assert fault is not None
    assert float(re.findall(r"by ([0-9.]+) times", fault)[0]) == pytest.approx(scale, rel=0.05)
    assert "sonars" in fault


def test_a_person_who_comes_nearer_is_no_fault_of_the_scale() -> None:
    assert find_fault(drive(walks=0.4, seconds=6.0), drive(seed=1), drive(walks=0.9)) is None


def test_headings_of_another_scale_are_named() -> None:
    state, _ = StateMaker(P3DX).state(REPORT, 0.0)
    turning = 0.5
    wheel = turning / P3DX.turning_per_speed
    turned = [
        replace(
            state,
            at=CYCLE * i,
            pose=Pose2(0.0, 0.0, 2.0 * turning * CYCLE * i),
            speed=0.0,
            left_speed=-wheel,
            right_speed=wheel,
        )
        for i in range(60)
    ]
    fault = find_fault(iter(turned))
    assert fault is not None
    assert "heading changes by 2.00 times" in fault
