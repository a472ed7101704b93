"""When a fault is laid to the line."""

from dataclasses import replace

import pytest

from facetlog.errors import DeviceError, DeviceTimeout
from facetlog.robot.collecting.simulated_robot import add_line_hint, describe_coasting
from facetlog.robot.pioneer.guard import Cause, Problem
from facetlog.robot.pioneer.parameters import find_parameters
from facetlog.robot.simulator.firmware.factory_settings import make_default_configuration

FAULT = DeviceTimeout("the camera head does not answer: check that it has power")


def _quiet(*times: float) -> list[Problem]:
    return [Problem(Cause.QUIET, "no report", at) for at in times]


def test_a_fault_after_many_silences_is_laid_to_the_line() -> None:
    fault = add_line_hint(FAULT, _quiet(5, 80, 85, 90), 100.0)
    assert isinstance(fault, DeviceTimeout)
    assert str(fault).startswith(str(FAULT))
    assert "3 times in 30 s no whole report" in str(fault)
    assert "check cable and baud rate" in str(fault)


@pytest.mark.parametrize(
    "problems",
    [
        [],
        _quiet(99),
        _quiet(5, 10, 15),
        [*_quiet(90, 95), Problem(Cause.LINK_LOST, "lost", 99)],
        [Problem(Cause.BUMPER, "bumper", 98), Problem(Cause.STALL, "stall", 99)],
    ],
)
def test_a_fault_with_another_reason_is_reported_unchanged(problems: list[Problem]) -> None:
    fault = DeviceError("the wheels are stalled")
    assert add_line_hint(fault, problems, 100.0) is fault


def test_how_far_a_robot_goes_on_when_its_line_is_cut_is_said_if_it_is_far() -> None:
    usual = make_default_configuration(find_parameters("p3dx"), "robot")
    assert "for 0.4 m before it brakes" in describe_coasting(usual, 0.2)
    assert describe_coasting(replace(usual, watchdog_ms=500), 0.4) == ""
    for unknown in (None, replace(usual, watchdog_ms=None)):
        assert "does not report its watchdog" in describe_coasting(unknown, 0.5)
    assert "would not stop" in describe_coasting(replace(usual, watchdog_ms=0), 0.5)
