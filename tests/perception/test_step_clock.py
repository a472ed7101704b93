"""Nested, repeated and failing steps are each counted once."""

import itertools

import pytest

from facetlog.perception import step_clock
from facetlog.perception.step_clock import StepClock


def test_times_of_all_steps_add_up_to_the_time_that_was_measured(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seconds = itertools.count()
    monkeypatch.setattr(step_clock, "perf_counter", lambda: float(next(seconds)))
    clock = StepClock()
    for _ in range(2):
        with clock.step("outer"), pytest.raises(KeyError), clock.step("inner"):
            raise KeyError
    outer, inner = clock.times
    assert (outer.name, outer.calls, outer.wall) == ("outer", 2, 4.0)
    assert (inner.name, inner.calls, inner.wall) == ("inner", 2, 2.0)
    assert clock.total.wall == outer.wall + inner.wall
    assert clock.run.wall > clock.total.wall
