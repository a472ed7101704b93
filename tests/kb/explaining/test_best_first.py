"""The order of names that hold."""

from dataclasses import dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.kb.explaining.best_first import best_first
from facetlog.kb.explaining.proof import State

HOLDS, FAILS, UNKNOWN = State.HOLDS, State.FAILS, State.UNKNOWN


@dataclass
class _Verdict:
    model: str
    state: State
    degree: float
    specialises: tuple[str, ...] = ()
    thing: str = "t1"
    rather_than: tuple[str, ...] = ()
    own: bool = False


@pytest.mark.parametrize(
    ("verdicts", "names"),
    [
        ((), []),
        ((_Verdict("a", FAILS, 0.9), _Verdict("b", UNKNOWN, 0.9)), []),
        ((_Verdict("a", HOLDS, 0.6), _Verdict("b", HOLDS, 0.9)), ["b", "a"]),
        ((_Verdict("a", HOLDS, 0.9), _Verdict("b", HOLDS, 0.9)), ["a", "b"]),
        # The same sum in another order.
        ((_Verdict("a", HOLDS, 0.3), _Verdict("b", HOLDS, 0.1 + 0.2)), ["a", "b"]),
    ],
)
def test_the_highest_degree_of_what_holds_comes_first(
    verdicts: tuple[_Verdict, ...], names: list[str]
) -> None:
    assert [verdict.model for verdict in best_first(verdicts)] == names


def test_what_is_special_comes_before_what_it_is() -> None:
    shelf = _Verdict("shelf", HOLDS, 0.9)
    bookcase = _Verdict("bookcase", HOLDS, 0.7, ("shelf",))
    box = _Verdict("box", HOLDS, 0.8)
    assert [v.model for v in best_first((box, shelf, bookcase))] == ["bookcase", "shelf", "box"]


@pytest.mark.parametrize(
    ("degree", "names"), [(0.9, ["cabinet", "box", "shelf"]), (0.5, ["box", "shelf", "cabinet"])]
)
def test_a_name_goes_before_another_where_it_is_more_probable_than_not(
    degree: float, names: list[str]
) -> None:
    box = _Verdict("box", HOLDS, 1.0)
    cabinet = _Verdict("cabinet", HOLDS, degree, rather_than=("box",))
    shelf = _Verdict("shelf", HOLDS, 1.0)
    assert [v.model for v in best_first((box, shelf, cabinet))] == names


def test_users_own_models_come_before_built_in_ones_of_the_same_thing() -> None:
    table = _Verdict("table", HOLDS, 1.0)
    trolley = _Verdict("trolley", HOLDS, 0.6, own=True)
    box = _Verdict("box", HOLDS, 0.8, thing="t2")
    assert [v.model for v in best_first((table, box, trolley))] == ["trolley", "table", "box"]


def test_a_built_in_special_case_comes_before_what_a_user_calls_the_general_one() -> None:
    desk = _Verdict("desk", HOLDS, 0.6, ("table",))
    stool = _Verdict("stool", HOLDS, 0.7)
    table = _Verdict("table", HOLDS, 0.9, own=True)
    assert [v.model for v in best_first((stool, desk, table))] == ["desk", "table", "stool"]


_verdicts = st.lists(
    st.builds(
        _Verdict,
        st.sampled_from("abcdef"),
        st.sampled_from((HOLDS, HOLDS, FAILS)),
        st.sampled_from((0.2, 0.5, 0.8, 1.0)),
        st.lists(st.sampled_from("abcdef"), max_size=2).map(tuple),
        st.sampled_from(("t1", "t2")),
        st.lists(st.sampled_from("abcdef"), max_size=2).map(tuple),
        st.booleans(),
    ),
    max_size=8,
)


@given(_verdicts)
def test_any_verdicts_are_ordered_once_and_the_same_again(verdicts: list[_Verdict]) -> None:
    found = best_first(verdicts)
    holding = [v for v in verdicts if v.state is HOLDS]
    assert sorted(map(id, found)) == sorted(map(id, holding))
    assert best_first(verdicts) == found
    if not any(v.specialises or v.rather_than for v in verdicts):
        assert found[:1] == sorted(holding, key=lambda v: -v.degree)[:1] or found[0].own


def test_users_own_models_come_first_whatever_thing_they_are_of() -> None:
    table = _Verdict("table", HOLDS, 1.0, thing="t1")
    trolley = _Verdict("trolley", HOLDS, 0.6, thing="t2", own=True)
    desk = _Verdict("desk", HOLDS, 0.7, ("trolley",), thing="t2")
    assert best_first((table, trolley)) == [trolley, table]
    assert best_first((table, trolley, desk)) == [desk, trolley, table]
