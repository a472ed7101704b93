"""Facts that are decoded when they are asked for: the same as those that were put in."""

from collections.abc import Iterator
from itertools import permutations
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.errors import EngineError
from facetlog.kb.batch_judge import BatchJudge
from facetlog.kb.loading.encode import Fact
from facetlog.kb.loading.facts_on_demand import encode_facts

NAMES = st.lists(st.text(st.characters(exclude_categories=["Cs"]), max_size=3), max_size=6)
VALUES = st.floats(-1e6, 1e6).map(lambda x: x + 0.0)
# Its sizes are all offsets: found with no name given, then asked for with both.
ASKS = """:- module(asks, []).
:- use_module(facetlog(vocabulary)).
model(asks, "Tells what the scene says of two names.", [a]).
candidate(asks, Thing, [Thing]).
condition(asks, so, "it is there", _, [_], all([])).
size(asks, _, _, First, offset(First, Second)) :- fact(offset(First, Second, _, _)).
size(asks, _, _, Second, offset(First, Second)) :-
    fact(offset(First, Second, _, _)),
    fact(offset(First, Second, V, _)),
    V > 0.
"""


@st.composite
def offsets(draw: st.DrawFn) -> list[Fact]:
    """Return offsets of each two of some names, in either order, most often in the order of the
    names."""
    names = draw(NAMES)
    found: list[Fact] = [
        (a, b, draw(VALUES), 0.5) for a, b in permutations(dict.fromkeys(names), 2)
    ]
    if found and draw(st.booleans()):
        found[draw(st.integers(0, len(found) - 1))] = ("f1", "f1", 1.0, 0.5)
    return found


@pytest.fixture(scope="module")
def judge(tmp_path_factory: pytest.TempPathFactory) -> Iterator[BatchJudge]:
    path: Path = tmp_path_factory.mktemp("rules") / "asks.pl"
    path.write_text(ASKS)
    with BatchJudge([path], trusted=True) as judge:
        yield judge


@settings(max_examples=80)
@given(offsets())
def test_what_is_known_of_two_names_arrives_exactly_and_in_order(
    judge: BatchJudge, rows: list[Fact]
) -> None:
    said = judge.judge({"thing": [("t1",)], "offset": rows})
    (sizes,) = [verdict.sizes for verdict in said if verdict.model == "asks"]
    named = [(a, value) for a, _, value, _ in rows]
    positive = [(b, value) for _, b, value, _ in rows if float(value) > 0]
    assert repr([(name, value) for name, value, _ in sizes]) == repr(named + positive)


def test_only_floats_of_each_two_names_become_a_matrix() -> None:
    each: list[Fact] = [(a, b, 1.0) for a, b in permutations("xyz", 2)]
    integer: list[Fact] = [*each[:-1], ("z", "y", 1)]
    twice: list[Fact] = [*each[:-1], ("x", "y", 1.0)]

    def header(rows: list[Fact]) -> str:
        return encode_facts("s", {("overlap", 3): tuple(zip(*rows, strict=True))}).partition("\n")[
            0
        ]

    assert "matrices(3,5,['overlap'-3])" in header(each)
    for rows in (integer, twice, each[:-1], each[1:] + each[:1], each[:2]):
        assert "matrices(0,0,[])" in header(rows)


@pytest.mark.parametrize("number", [float("nan"), float("inf")])
def test_a_number_that_is_none_is_refused(judge: BatchJudge, number: float) -> None:
    rows: list[Fact] = [(a, b, number, 0.5) for a, b in permutations("xyz", 2)]
    with pytest.raises(ValueError, match=str(number)):
        judge.judge({"thing": [("t1",)], "offset": rows})


def test_a_scene_does_not_see_the_matrix_of_the_one_before(judge: BatchJudge) -> None:
    rows: list[Fact] = [(a, b, 1.0, 0.5) for a, b in permutations("xyz", 2)]
    judge.judge({"thing": [("t1",)], "offset": rows})
    (sizes,) = [v.sizes for v in judge.judge({"thing": [("t1",)]}) if v.model == "asks"]
    assert sizes == ()


def test_a_value_that_is_no_fact_is_told_when_it_is_asked_for(judge: BatchJudge) -> None:
    with pytest.raises((EngineError, TypeError)):
        judge.judge({"thing": [(["t1"],)]})  # type: ignore[list-item]
