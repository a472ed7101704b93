from collections.abc import Callable

import pytest

from facetlog.errors import DeviceTimeout
from facetlog.robot.head.head import Clock, Counts, wait_until_still


class Time:
    def __init__(self) -> None:
        self.now = 0.0

    def pass_by(self, seconds: float) -> None:
        self.now += seconds

    def settle(self, place: Callable[[float], int], target: int) -> tuple[Counts, bool]:
        clock = Clock(lambda: self.now, self.pass_by)
        return wait_until_still(lambda: (place(self.now),), (target,), (5,), 10.0, clock)


def test_a_head_that_creeps_past_two_equal_places_is_still_waited_for() -> None:
    time = Time()
    assert time.settle(lambda now: min(100, 97 + round(4 * now)), 100) == ((100,), True)


def test_a_head_that_comes_to_stand_close_by_has_arrived_there() -> None:
    assert Time().settle(lambda now: min(98, round(200 * now)), 100) == ((98,), True)


def test_a_head_that_begins_late_is_not_taken_for_one_that_stands() -> None:
    time = Time()
    assert time.settle(lambda now: 0 if now < 0.4 else 100, 100) == ((100,), True)


def test_a_head_that_never_stands_ends_in_a_time_out() -> None:
    time = Time()
    with pytest.raises(DeviceTimeout, match="not still"):
        time.settle(lambda now: round(1000 * now), 100)
    assert 10 < time.now < 11
