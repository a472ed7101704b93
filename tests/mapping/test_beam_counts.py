"""Where beams passed and where they ended, by their majority."""

import math

import pytest

from facetlog.mapping.beam_counts import BeamCounts
from facetlog.mapping.sonar_beams import Beam, iter_new_beams
from facetlog.robot.pioneer.parameters import SonarPlace
from facetlog.robot.pioneer.state import SonarRange
from facetlog.robot.pose2 import Pose2


def _counts() -> BeamCounts:
    return BeamCounts((0.0, -2.0), 0.1, (40, 40))


def _is(cells: object, x: float, y: float) -> bool:
    return bool(cells[math.floor((y + 2.0) / 0.1), math.floor(x / 0.1)])  # type: ignore[index]


def test_beams_that_go_on_narrow_the_arc_of_an_echo() -> None:
    counts = _counts()
    counts.add(Beam(0.05, 0.05, 0.0, 1.5, True))
    assert _is(counts.echoed, 1.5, 0.35)
    for _ in range(2):
        counts.add(Beam(0.05, 0.05, math.radians(25.0), 3.0, False))
    assert not _is(counts.echoed, 1.5, 0.35)
    assert _is(counts.echoed, 1.55, 0.05)


def test_each_measurement_is_one_beam_from_where_its_sonar_is_in_the_world() -> None:
    ahead, unknown = SonarPlace(0.2, 0.0, 0.0), None
    sonars = [
        SonarRange(0, 1.0, 5.0, ahead),
        SonarRange(1, 5.0, 5.0, ahead),
        SonarRange(2, 1.0, 5.0, unknown),
        SonarRange(3, 0.05, 5.0, ahead),
    ]
    known: dict[int, float] = {}
    robot = Pose2(1.0, 2.0, math.pi / 2)
    echo, nothing = iter_new_beams(robot, sonars, known)
    assert (echo.x, echo.y, echo.heading) == pytest.approx((1.0, 2.2, math.pi / 2))
    assert (echo.echo, nothing.echo) == (True, False)
    assert list(iter_new_beams(robot, sonars, known)) == []
