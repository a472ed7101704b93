import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.robot.simulator.device import SerialOut, Slew

places = st.floats(-1e4, 1e4)


@given(places, places, st.floats(0.1, 1e4), st.floats(0, 1e5), st.floats(-10, 1e6))
def test_an_axis_is_never_beyond_its_ends(
    origin: float, target: float, speed: float, since: float, later: float
) -> None:
    slew = Slew(origin, target, speed, since)
    low, high = sorted((origin, target))
    span = 1e-9 * max(1.0, abs(low), abs(high))
    assert low - span <= slew.at(since + later) <= high + span
    assert slew.at(slew.end) == target
    assert slew.at(since) == pytest.approx(origin, abs=1e-6)


def test_an_axis_goes_on_from_where_it_is() -> None:
    slew = Slew.standing(0.0).to(100.0, 10.0, now=5.0)
    assert slew.end == 15.0
    back = slew.to(0.0, 20.0, now=8.0)
    assert (back.at(8.0), back.at(9.0), back.end) == (30.0, 10.0, 9.5)
    assert slew.stopped(7.0).at(1000.0) == 20.0


def test_bytes_wait_for_those_before_them() -> None:
    out = SerialOut(baud=10)
    out.say(b"ab", now=0.0)
    out.say(b"c", now=1.5)
    assert out.arrived(0.9) == b""
    assert out.arrived(1.0) == b"a"
    assert out.arrived(2.5) == b"b"
    assert out.arrived(3.0) == b"c"
    assert out.arrived(9.0) == b""
