"""The lease on a line: what is written when, in given time."""

import math

from hypothesis import given
from hypothesis import strategies as st

from facetlog.robot.pioneer.line.dead_man import REPEAT, STOPPING, DeadMan

STOP = b"stop"


def written(dead_man: DeadMan, start: float, end: float, step: float = 0.01) -> list[float]:
    """When stops are written, by somebody who looks as often as that."""
    looks = (start + i * step for i in range(round((end - start) / step) + 1))
    return [at for at in looks if dead_man.advance(at)]


def test_nothing_is_written_before_there_is_a_lease_or_after_it_was_given_back() -> None:
    dead_man = DeadMan()
    assert not dead_man.holds
    assert math.isinf(dead_man.due)
    assert written(dead_man, 0.0, 5.0) == []
    dead_man.hold(6.0, STOP, 5.0)
    assert dead_man.holds
    dead_man.release()
    assert written(dead_man, 5.0, 10.0) == []
    assert not dead_man.has_expired(10.0)


def test_a_driver_that_goes_is_followed_by_stops_until_the_watchdog_has_its_turn() -> None:
    dead_man = DeadMan()
    dead_man.hold(10.0, STOP, 0.0)
    dead_man.expire(1.0)
    times = written(dead_man, 1.0, 9.0)
    assert times[0] == 1.0
    assert STOPPING - 2 * REPEAT < times[-1] - times[0] <= STOPPING
    assert math.isinf(dead_man.due)


def test_a_lease_that_is_renewed_too_late_is_none() -> None:
    """As a program that is resumed sends what it had in hand when it was suspended."""
    dead_man = DeadMan()
    dead_man.hold(1.0, STOP, 0.7)
    assert dead_man.advance(1.0) == STOP
    dead_man.hold(1.05, STOP, 3.5)
    assert dead_man.has_expired(3.5)
    dead_man.hold(3.9, STOP, 3.6)
    assert not dead_man.has_expired(3.6)
    assert dead_man.advance(3.6) == b""


@given(st.lists(st.floats(0.0, 0.6), min_size=1, max_size=20), st.floats(0.0, 0.3))
def test_bytes_reach_the_robot_within_a_lease_and_a_stop_does_at_its_end(
    pauses: list[float], late: float
) -> None:
    """Of a driver that renews a lease of 0.3 s after pauses, some of them longer than that."""
    dead_man, now, until = DeadMan(), 0.0, math.inf
    for pause in pauses:
        now += pause
        assert dead_man.has_expired(now) == (now >= until)
        assert bool(dead_man.advance(now)) == (now >= until)
        until = now + 0.3
        dead_man.hold(until, STOP, now)
        assert not dead_man.has_expired(now)
    assert dead_man.due == until
    assert dead_man.advance(until - 1e-6) == b""
    assert dead_man.advance(until + late) == STOP
