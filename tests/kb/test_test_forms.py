"""Faults of tests that a model may state, and models that ask for other models."""

from collections.abc import Iterable
from pathlib import Path

import pytest

from facetlog.errors import QueryError, RuleSyntaxError
from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.verdict import Verdict
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.loading.encode import Fact

HEAD = """:- module(m, []).
:- use_module(facetlog(vocabulary)).
"""
MODEL = """model({name}, "A model.", [a]).
candidate({name}, Thing, [Thing]).
condition({name}, line, "it is as asked", Thing, [_], {test}).
"""


def facts(**areas: tuple[float, float]) -> list[Fact]:
    """Return a thing with a face for each area; `up` is not given."""
    found: list[Fact] = [("scene", "s"), ("scale", "metric"), ("thing", "t1"), ("thing", "t2")]
    for name, (area, sd) in areas.items():
        found += [("face", name), ("part_of", name, "t1"), ("evidence", name, "measured")]
        found.append(("area", name, area, sd))
        found.append(("length", name, area, sd))
        found.append(("fill", name, area, sd))
    return found


def judged(folder: Path, scene: Iterable[Fact], **tests: str) -> Verdict:
    """Return the verdict of the first of the models, each of which has one condition."""
    path = folder / "m.pl"
    text = "".join(MODEL.format(name=name, test=test) for name, test in tests.items())
    path.write_text(HEAD + text)
    with KnowledgeBase() as base:
        base.load_rules(path, trusted=True)
        base.load_scene("s", scene)
        return base.judge("s", next(iter(tests)), "t1")


def test_a_width_of_another_dimension_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RuleSyntaxError, match="compares a length with a bare number"):
        judged(tmp_path, facts(f1=(1.0, 0.1)), m="fading(at_most(length(f1), metres(1)), 0.2)")


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
    tests = {
        "one": "all([is_a(t1, two), at_most(fill(f1), 0.5)])",
        "two": "any([not(is_a(t1, one))])",
    }
    path.write_text(HEAD + "".join(MODEL.format(name=n, test=t) for n, t in tests.items()))
    for order in (("one", "two"), ("two", "one"), ("one", "one", "two", "two")):
        with KnowledgeBase() as base:
            base.load_rules(path, trusted=True)
            base.load_scene("s", facts(f1=(0.8, 0.0)))
            states = {model: base.judge("s", model, "t1").state for model in order}
        assert states == {"one": State.FAILS, "two": State.HOLDS}
