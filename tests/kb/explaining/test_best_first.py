"""The order of names that hold."""

from dataclasses import dataclass

import pytest

from facetlog.kb.explaining.best_first import best_first
from facetlog.kb.explaining.proof import State

HOLDS, FAILS, UNKNOWN = State.HOLDS, State.FAILS, State.UNKNOWN


@dataclass
class _Verdict:
    model: str
    state: State
    degree: float
    confidence: float | None = None
    specialises: tuple[str, ...] = ()
    thing: str = "t1"
    rather_than: tuple[str, ...] = ()


@pytest.mark.parametrize(
    ("verdicts", "names"),
    [
        ((), []),
        ((_Verdict("a", FAILS, 0.9), _Verdict("b", UNKNOWN, 0.9)), []),
        ((_Verdict("a", HOLDS, 0.6), _Verdict("b", HOLDS, 0.9)), ["b", "a"]),
        ((_Verdict("a", HOLDS, 0.9), _Verdict("b", HOLDS, 0.9)), ["a", "b"]),
        ((_Verdict("a", HOLDS, 0.6, 0.9), _Verdict("b", HOLDS, 0.9, 0.8)), ["a", "b"]),
        ((_Verdict("a", HOLDS, 0.6, 0.9), _Verdict("b", HOLDS, 0.9)), ["b", "a"]),
    ],
)
def test_the_surest_of_what_holds_comes_first(
    verdicts: tuple[_Verdict, ...], names: list[str]
) -> None:
    assert [verdict.model for verdict in best_first(verdicts)] == names


def test_what_is_special_comes_before_what_it_is() -> None:
    shelf = _Verdict("shelf", HOLDS, 0.9, 0.8)
    bookcase = _Verdict("bookcase", HOLDS, 0.7, 0.6, ("shelf",))
    box = _Verdict("box", HOLDS, 0.9, 0.7)
    assert [v.model for v in best_first((box, shelf, bookcase))] == ["bookcase", "shelf", "box"]


def test_a_special_case_of_what_does_not_hold_stands_by_itself() -> None:
    shelf = _Verdict("shelf", HOLDS, 0.9, thing="t2")
    bookcase = _Verdict("bookcase", HOLDS, 0.7, specialises=("shelf",))
    assert [v.model for v in best_first((bookcase, shelf))] == ["shelf", "bookcase"]


@pytest.mark.parametrize(
    ("degree", "names"), [(0.9, ["cabinet", "box", "shelf"]), (0.5, ["box", "shelf", "cabinet"])]
)
def test_a_name_goes_before_another_where_it_is_more_probable_than_not(
    degree: float, names: list[str]
) -> None:
    box = _Verdict("box", HOLDS, 1.0, 0.84)
    cabinet = _Verdict("cabinet", HOLDS, degree, 0.82, rather_than=("box",))
    shelf = _Verdict("shelf", HOLDS, 1.0, 0.83)
    assert [v.model for v in best_first((box, shelf, cabinet))] == names


def test_a_name_goes_before_no_other_things_name() -> None:
    box = _Verdict("box", HOLDS, 1.0, 0.84, thing="t2")
    cabinet = _Verdict("cabinet", HOLDS, 1.0, 0.82, rather_than=("box",))
    assert [v.model for v in best_first((cabinet, box))] == ["box", "cabinet"]


def test_a_special_case_goes_before_what_its_general_model_goes_before() -> None:
    box = _Verdict("box", HOLDS, 1.0, 0.84)
    cabinet = _Verdict("cabinet", HOLDS, 0.9, 0.82, rather_than=("box",))
    wardrobe = _Verdict("wardrobe", HOLDS, 0.9, 0.8, ("cabinet",))
    assert [v.model for v in best_first((box, cabinet, wardrobe))] == ["wardrobe", "cabinet", "box"]
