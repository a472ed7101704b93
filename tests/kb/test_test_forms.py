"""Tests that a model may state: where-then, fading edges, counts of groups, other models."""

import math
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from facetlog.errors import QueryError, RuleSyntaxError
from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.verdict import Verdict
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.loading.encode import Fact

FloatArray = NDArray[np.float64]

HEAD = """:- module(m, []).
:- use_module(facetlog(vocabulary)).
"""
MODEL = """model({name}, "A model.", [a]).
candidate({name}, Thing, [Thing]).
condition({name}, line, "it is as asked", Thing, [_], {test}).
"""


def facts(**areas: tuple[float, float]) -> list[Fact]:
    """A thing with a face for each area; `up` is not given."""
    found: list[Fact] = [("scene", "s"), ("scale", "metric"), ("thing", "t1"), ("thing", "t2")]
    for name, (area, sd) in areas.items():
        found += [("face", name), ("part_of", name, "t1"), ("evidence", name, "measured")]
        found.append(("area", name, area, sd))
        found.append(("length", name, area, sd))
        found.append(("fill", name, area, sd))
    return found


def judged(folder: Path, scene: Iterable[Fact], **tests: str) -> Verdict:
    """What the first of the models says, each of which has one condition."""
    path = folder / "m.pl"
    text = "".join(MODEL.format(name=name, test=test) for name, test in tests.items())
    path.write_text(HEAD + text)
    with KnowledgeBase() as base:
        base.load_rules(path, trusted=True)
        base.load_scene("s", scene)
        return base.judge("s", next(iter(tests)), "t1")


def said(verdict: Verdict) -> str:
    return "\n".join(verdict.lines(full=True))


# ---- where ... then ...

BIG, SMALL, OPEN = "at_least(fill(f1), 0.5)", "at_most(fill(f1), 0.5)", "level(f1)"


@pytest.mark.parametrize(
    ("where", "then", "state"),
    [
        (BIG, BIG, State.HOLDS),
        (BIG, SMALL, State.FAILS),
        (BIG, OPEN, State.UNKNOWN),
        (SMALL, SMALL, State.HOLDS),
        (SMALL, OPEN, State.HOLDS),
        (OPEN, BIG, State.HOLDS),
        (OPEN, SMALL, State.UNKNOWN),
    ],
)
def test_implies_is_not_the_first_or_the_second(
    tmp_path: Path, where: str, then: str, state: State
) -> None:
    scene = facts(f1=(0.8, 0.2))
    mine = judged(tmp_path, scene, mine=f"implies({where}, {then})")
    same = judged(tmp_path, scene, same=f"any([not({where}), {then}])")
    assert mine.state is same.state is state
    assert (mine.degree, mine.degree_at_most) == (same.degree, same.degree_at_most)


def test_implies_reads_as_where_and_then(tmp_path: Path) -> None:
    scene = facts(f1=(0.8, 0.0))
    fails = said(judged(tmp_path, scene, m=f"implies({BIG}, {SMALL})"))
    assert (
        "- where fill(f1) = 80 %, at least 50 %, then fill(f1) = 80 %, needs at most 50 %" in fails
    )
    void = said(judged(tmp_path, scene, m=f"implies({SMALL}, {BIG})"))
    assert "30 % over, nothing is required" in void
    tree = said(judged(tmp_path, scene, m=f"implies({BIG}, all([{BIG}, {SMALL}]))"))
    assert "at least 50 %, then:\n        + fill(f1)" in tree


def test_only_what_should_have_held_is_a_shortfall(tmp_path: Path) -> None:
    verdict = judged(tmp_path, facts(f1=(0.8, 0.1)), m=f"implies({OPEN}, {SMALL})")
    (short,) = verdict.to_json()["shortfalls"]
    assert short["amount"] == pytest.approx(0.3)


# ---- fading

REGIONS = {
    "at_least(fill(f1), 0.5)": (0.5, math.inf),
    "at_most(fill(f1), 0.5)": (-math.inf, 0.5),
    "between(fill(f1), 0.4, 0.6)": (0.4, 0.6),
    "near(fill(f1), 0.5, 0.1)": (0.4, 0.6),
}
WIDTHS = (0.1, 0.01)


def membership(x: FloatArray, low: float, high: float, width: float) -> FloatArray:
    return np.clip(1 - np.maximum(low - x, x - high) / width, 0, 1)


@pytest.fixture(scope="module")
def fading(tmp_path_factory: pytest.TempPathFactory) -> Iterator[KnowledgeBase]:
    """A model f<i>_<j> for each region and width."""
    path = tmp_path_factory.mktemp("fading") / "m.pl"
    models = (
        MODEL.format(name=f"f{i}_{j}", test=f"fading({test}, {width})")
        for i, test in enumerate(REGIONS)
        for j, width in enumerate(WIDTHS)
    )
    path.write_text(HEAD + "".join(models))
    with KnowledgeBase() as base:
        base.load_rules(path, trusted=True)
        yield base


@pytest.mark.parametrize("sd", [0.0, 1e-7, 0.03, 0.2, 5.0])
@pytest.mark.parametrize("value", [0.31, 0.37, 0.5, 0.66, 0.9])
def test_the_degree_of_a_fading_edge_is_the_expected_membership(
    fading: KnowledgeBase, sd: float, value: float
) -> None:
    fading.load_scene("s", facts(f1=(value, sd)))
    # Equally probable slices, each by its middle.
    slices = stats.norm.ppf((np.arange(20_000) + 0.5) / 20_000, value, sd) if sd else value
    for i, (low, high) in enumerate(REGIONS.values()):
        for j, width in enumerate(WIDTHS):
            expected = float(np.mean(membership(np.asarray(slices), low, high, width)))
            verdict = fading.judge("s", f"f{i}_{j}", "t1")
            assert verdict.degree == pytest.approx(expected, abs=2e-4)
            assert verdict.degree_at_most == verdict.degree
            at_value = float(membership(np.asarray(value), low, high, width))
            if at_value < 0.5:
                assert verdict.state is State.FAILS
            else:
                assert verdict.state is (State.HOLDS if expected >= 0.5 else State.UNKNOWN)


def test_a_shortfall_is_told_from_the_middle_of_the_slope(tmp_path: Path) -> None:
    verdict = judged(
        tmp_path, facts(f1=(1.3, 0.02)), m="fading(at_most(length(f1), metres(1)), metres(0.2))"
    )
    assert "needs at most 1 fading over 0.2 m: 0.2 m over" in said(verdict)
    data = verdict.to_json()
    assert data["shortfalls"][0]["amount"] == pytest.approx(0.2)
    assert data["conditions"][0]["because"]["within"]["fading"] == pytest.approx(0.2)


def test_what_a_fading_comparison_lacks_is_named(tmp_path: Path) -> None:
    verdict = judged(tmp_path, facts(), m="fading(near(tilt(f1), 90, 10), 5)")
    assert verdict.state is State.UNKNOWN
    assert "tilt(f1) is not known" in said(verdict)


def test_a_width_of_another_dimension_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RuleSyntaxError, match="compares a length with a bare number"):
        judged(tmp_path, facts(f1=(1.0, 0.1)), m="fading(at_most(length(f1), metres(1)), 0.2)")


# ---- at least, at most so many

GROUPS = "[[f1, f2], [f3], [f4, f5]]"
AREAS = {"f1": 0.2, "f2": 0.9, "f3": 0.6, "f4": 0.1, "f5": 0.3}


def counting(bound: str, count: int, test: str = "at_least(fill(X), 0.5)") -> str:
    return f"{bound}_of({count}, X, {GROUPS}, {test})"


@pytest.mark.parametrize(
    ("bound", "count", "state"),
    [
        ("at_least", 0, State.HOLDS),
        ("at_least", 2, State.HOLDS),
        ("at_least", 3, State.UNKNOWN),
        ("at_least", 9, State.UNKNOWN),
        ("at_most", 0, State.FAILS),
        ("at_most", 1, State.FAILS),
        ("at_most", 2, State.HOLDS),
        ("at_most", 9, State.HOLDS),
    ],
)
def test_groups_count_once_by_their_best_member(
    tmp_path: Path, bound: str, count: int, state: State
) -> None:
    sd = 0.1
    scene = facts(**{name: (area, sd) for name, area in AREAS.items()})
    verdict = judged(tmp_path, scene, m=counting(bound, count))
    assert verdict.state is state
    mass = sorted((stats.norm.sf(0.5, a, sd) for a in (0.9, 0.6, 0.3)), reverse=True)
    if bound == "at_least":
        low = 1.0 if count == 0 else mass[count - 1] if count <= 3 else 0.0
        high = low if state is State.HOLDS else 1.0
    else:
        low = high = 1 - mass[count] if count < 3 else 1.0
    assert (verdict.degree, verdict.degree_at_most) == pytest.approx((low, high), abs=1e-9)


def test_more_than_so_many_are_unknown_where_one_is(tmp_path: Path) -> None:
    test = "all([at_least(fill(X), 0.5), if_known(measured(X)), not(all([level(X)]))])"
    scene = facts(**{name: (area, 0.0) for name, area in AREAS.items()})
    verdict = judged(tmp_path, scene, m=counting("at_most", 1, test))
    assert verdict.state is State.UNKNOWN
    assert (verdict.degree, verdict.degree_at_most) == (0.0, 1.0)
    assert "none was found, 2 more may be, at most 1 is wanted; f3 decides" in said(verdict)


def test_a_count_names_the_member_that_decides(tmp_path: Path) -> None:
    scene = facts(**{name: (area, 0.1) for name, area in AREAS.items()})
    holds = said(judged(tmp_path, scene, m=counting("at_least", 2)))
    assert "2 that stand apart were found, at least 2 are wanted; f3 decides" in holds
    assert "fill(f2)" in holds
    assert "fill(f5)" not in holds
    lacking = judged(tmp_path, scene, m=counting("at_least", 3))
    assert "but there may be more; f5 comes next" in lacking.summary
    (short,) = lacking.to_json()["shortfalls"]
    assert short["of"] == "fill(f5)"
    many = said(judged(tmp_path, scene, m=counting("at_most", 1)))
    assert "2 that stand apart were found, at most 1 is wanted; f3 is one too many" in many


@pytest.mark.parametrize(
    ("test", "fault"),
    [
        ("at_least_of(1.5, X, [[f1]], measured(X))", "how many is a whole number"),
        ("at_most_of(-1, X, [[f1]], measured(X))", "how many is a whole number"),
        ("at_least_of(1, X, [f1], measured(X))", "a list of lists is wanted"),
        ("at_least_of(1, X, [[f1]], measurd(X))", "did you mean measured"),
        ("fading(measured(f1), 3)", "a comparison is wanted"),
        ("fading(fading(near(fill(f1), 1, 1), 3), 3)", "a comparison is wanted"),
        ("fading(near(fil(f1), 1, 1), 3)", "did you mean fill"),
        ("implies(measured(f1), shell(ls))", "no test of the vocabulary"),
        ("is_a(t1, 3)", "a model's name is a small word"),
    ],
)
def test_faults_of_the_new_forms_are_told(test: str, fault: str) -> None:
    with KnowledgeBase() as base:
        base.load_scene("s", facts())
        with pytest.raises(QueryError, match=fault):
            base.query(f"holds({test})")


# ---- other models


def test_another_model_is_asked_as_a_test(tmp_path: Path) -> None:
    scene = facts(f1=(0.8, 0.3))
    verdict = judged(tmp_path, scene, m="is_a(t1, other)", other=BIG)
    other = judged(tmp_path, scene, other=BIG)
    assert verdict.state is State.HOLDS
    assert verdict.degree == other.degree < 1
    assert "+ t1 is an other" in said(verdict)
    assert judged(tmp_path, scene, m="not(is_a(t1, other))", other=BIG).state is State.FAILS


def test_a_model_of_a_thing_that_is_not_there_is_unknown(tmp_path: Path) -> None:
    for thing, cause in (("unseen", "the thing was not seen"), ("t9", "no such thing")):
        verdict = judged(tmp_path, facts(), m=f"is_a({thing}, box)")
        assert verdict.state is State.UNKNOWN
        assert cause in verdict.summary


def test_a_model_that_is_not_loaded_is_named(tmp_path: Path) -> None:
    with pytest.raises(RuleSyntaxError, match="asks for the model throne, which is not loaded"):
        judged(tmp_path, facts(), m="is_a(t1, throne)")


@pytest.mark.parametrize("first", ["one", "two", "three"])
def test_models_that_ask_for_each_other_end_and_say_so(tmp_path: Path, first: str) -> None:
    tests = {"one": "is_a(t1, two)", "two": "is_a(t1, three)", "three": "is_a(t1, one)"}
    ordered = {first: tests[first], **tests}
    verdict = judged(tmp_path, facts(), **ordered)
    assert verdict.state is State.UNKNOWN
    assert (verdict.degree, verdict.degree_at_most) == (0.0, 1.0)
    own = judged(tmp_path, facts(), me="is_a(t1, me)")
    assert "that model is itself being judged" in own.summary


def test_what_a_circle_leaves_open_is_not_remembered(tmp_path: Path) -> None:
    """Asked on its own, two holds by its second way, whatever was asked before."""
    path = tmp_path / "m.pl"
    tests = {"one": f"all([is_a(t1, two), {SMALL}])", "two": "any([not(is_a(t1, one))])"}
    path.write_text(HEAD + "".join(MODEL.format(name=n, test=t) for n, t in tests.items()))
    for order in (("one", "two"), ("two", "one"), ("one", "one", "two", "two")):
        with KnowledgeBase() as base:
            base.load_rules(path, trusted=True)
            base.load_scene("s", facts(f1=(0.8, 0.0)))
            states = {model: base.judge("s", model, "t1").state for model in order}
        assert states == {"one": State.FAILS, "two": State.HOLDS}
