"""What the step clock promises."""

import time

import pytest

from facetlog.perception.step_clock import StepClock


def test_times_of_nested_steps_are_counted_once() -> None:
    clock = StepClock()
    start = time.perf_counter()
    with clock.step("outer"):
        time.sleep(0.01)
        with clock.step("inner"):
            time.sleep(0.02)
    elapsed = time.perf_counter() - start
    outer, inner = clock.times
    assert (outer.name, inner.name) == ("outer", "inner")
    assert inner.wall >= 0.02
    assert outer.wall == pytest.approx(clock.total.wall - inner.wall)
    assert clock.total.wall <= elapsed


def test_a_step_that_fails_is_still_counted() -> None:
    clock = StepClock()
    with pytest.raises(KeyError), clock.step("broken"):
        raise KeyError
    assert clock.times[0].calls == 1


def test_repeated_steps_add_up() -> None:
    clock = StepClock()
    for _ in range(3):
        with clock.step("again"):
            pass
    assert [t.calls for t in clock.times] == [3]


def test_the_run_has_what_is_in_no_step() -> None:
    clock = StepClock()
    time.sleep(0.02)
    with clock.step("one"):
        pass
    assert clock.run.wall >= clock.total.wall + 0.02
    assert clock.run.cpu >= clock.total.cpu
