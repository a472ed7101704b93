"""Numbers in the unit that suits them."""

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.kb.explaining.amounts import choose_unit_for, deviation, measured
from facetlog.kb.explaining.proof import Comparison, Shortfall, Side, State, Within

SIZES = st.floats(min_value=1e-4, max_value=1e3)


@pytest.mark.parametrize(
    ("unit", "values", "expected"),
    [
        ("m", (0.254,), "cm"),
        ("m", (0.254, 7e-5), "mm"),
        ("m", (0.0099,), "mm"),
        ("m", (0.01,), "cm"),
        ("m", (1.0,), "m"),
        ("m", (1.0, 0.0099), "cm"),
        ("m", (1.0, 0.01), "m"),
        ("m", (0.5, 1e-6), "cm"),
        ("m", (0.0, 4e-5), "mm"),
        ("m", (), "mm"),
        ("m", (math.inf, 2.0), "m"),
        ("m²", (0.1,), "m²"),
        ("m²", (0.09,), "cm²"),
        ("m²", (0.2, 1e-5), "cm²"),
        ("°", (1e-5,), "°"),
        ("", (1e-5,), ""),
    ],
)
def test_the_unit_of_numbers_that_stand_together(
    unit: str, values: tuple[float, ...], expected: str
) -> None:
    assert choose_unit_for(unit, *values).name == expected


@given(value=SIZES, sd=SIZES)
def test_sizes_of_things_have_no_exponent_and_keep_their_value(value: float, sd: float) -> None:
    unit = choose_unit_for("m", value, sd)
    number, spread = measured(unit.of(value), sd / unit.size), deviation(value, sd / unit.size)
    assert "e" not in number + spread
    assert float(number) * unit.size == pytest.approx(value, rel=6e-4, abs=sd)
    if spread:
        assert float(spread) * unit.size == pytest.approx(sd, rel=0.06)


def test_one_unit_for_value_limits_and_what_is_missing() -> None:
    found = Comparison("width(f1)", 0.2, 0.001, "length", Within("between", (0.1, 1.5)))
    assert found.sentence(State.HOLDS, "m") == "width(f1) = 20.0 ± 0.1 cm, within 10 to 150 cm"
    area = Comparison("area(f1)", 0.05, 0.001, "area", Within("at_least", (0.02,)))
    assert area.sentence(State.HOLDS, "m") == "area(f1) = 500 ± 10 cm², at least 200 cm²"
    assert area.sentence(State.HOLDS, None) == "area(f1) = 0.050 ± 0.001, at least 0.02"


@given(
    st.floats(0.02, 3.0),
    st.floats(1e-5, 1e-2),
    st.sampled_from([0.0, 1e-4, 0.03]),
    st.sampled_from(["length", "ratio", "deg"]),
    st.booleans(),
)
def test_what_misses_a_limit_is_written_so_that_it_does(
    limit: float, by: float, sd: float, kind: str, below: bool
) -> None:
    side, sort = (Side.BELOW, "at_least") if below else (Side.ABOVE, "at_most")
    value = limit - by if below else limit + by
    found = Comparison("m", value, sd, kind, Within(sort, (limit,)), Shortfall(by, sd, side))
    text = found.sentence(State.FAILS, "m")
    numbers = re.fullmatch(r"m = ([\d.]+).*at \w+ ([\d.]+).*: ([\d.]+).*", text)
    assert numbers is not None
    shown, needed, missing = map(float, numbers.groups())
    assert shown < needed if below else shown > needed
    assert missing > 0
