"""When a fault is laid to the line."""

import pytest

from facetlog.errors import DeviceError, DeviceTimeout
from facetlog.robot.collecting.line_faults import with_line
from facetlog.robot.pioneer.problems import Cause, Problem

FAULT = DeviceTimeout("the camera head does not answer: check that it has power")


def _quiet(*times: float) -> list[Problem]:
    return [Problem(Cause.QUIET, "no report", at) for at in times]


def test_a_fault_after_many_silences_is_laid_to_the_line() -> None:
    fault = with_line(FAULT, _quiet(5, 80, 85, 90), 100.0)
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
    assert with_line(fault, problems, 100.0) is fault
