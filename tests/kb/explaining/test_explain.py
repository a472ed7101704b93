"""Why a thing is or is not one: shortfalls, near misses and their order."""

import math
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.errors import QueryError
from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.verdict import Verdict
from facetlog.kb.knowledge_base import BUILTIN_MODELS
from facetlog.kb.loading.encode import Fact
from tests.kb.asked import asked

Build = Callable[..., tuple[Fact, ...]]

HEAD = """:- module(pair, []).
:- use_module(facetlog(vocabulary)).
model(pair, "Two square faces.", [a, b]).
tolerance(square, 15).
candidate(pair, Thing, [A, B]) :- face_of(Thing, A), face_of(Thing, B), A @< B.
"""
CONDITIONS = (
    'condition(pair, square, "the faces meet at right angles", _, [A, B],'
    " near(angle(A, B), 90, tolerance(square))).",
    'condition(pair, big, "the first is big", _, [A, _], at_least(area(A), 0.5*area(B))) :-'
    " fact(face(B)), B \\== A, \\+ ( fact(face(C)), C @< B, C \\== A ).",
    'condition(pair, steep, "the second is steep", _, [_, B], at_least(tilt(B), 60)).',
    'condition(pair, filled, "both fill their rectangle", _, [A, B],'
    " all([at_least(fill(A), 0.8), at_least(fill(B), 0.8)])).",
    'condition(pair, apart, "they share no edge, or the second is level", _, [A, B],'
    " any([not(adjoins(A, B)), level(B)])).",
)


def faces(angle: float, *, sd: float = 1.1, limit_sd: float = 0.0) -> list[Fact]:
    facts: list[Fact] = [("scene", "s"), ("scale", "metric"), ("thing", "t1")]
    for name in ("f2", "f3"):
        facts += [("face", name), ("part_of", name, "t1"), ("evidence", name, "measured")]
        facts += [("length", name, 3.0 if name == "f2" else 5.0, limit_sd)]
    return [*facts, ("angle", "f2", "f3", angle, sd), ("angle", "f3", "f2", angle, sd)]


def model_file(folder: Path, *conditions: str) -> Path:
    path = folder / "pair.pl"
    path.write_text(HEAD + "\n".join(conditions) + "\n")
    return path


def judge_pair(folder: Path, facts: list[Fact], *conditions: str) -> Verdict:
    with asked(facts, model_file(folder, *conditions)) as ask:
        return ask.judge("pair")


def test_a_shortfall_is_told_in_the_unit_and_in_deviations(tmp_path: Path) -> None:
    verdict = judge_pair(tmp_path, faces(71.2), CONDITIONS[0])
    text = "\n".join(verdict.lines(full=True))
    assert "angle(f2, f3) = 71.2° ± 1.1°, needs 90 ± 15: 3.8° short, 3.5 sd" in text
    (missed,) = verdict.to_json()["shortfalls"]
    assert missed["amount"] == pytest.approx(3.8)
    assert missed["sds"] == pytest.approx(3.8 / 1.1)
    assert (missed["side"], missed["kind"], missed["label"]) == ("below", "deg", "square")


def test_a_measured_limit_adds_its_deviation(tmp_path: Path) -> None:
    verdict = judge_pair(
        tmp_path,
        faces(90.0, limit_sd=0.1),
        'condition(pair, long, "long", _, [A, B], at_least(length(A), 2*length(B))).',
    )
    (missed,) = verdict.to_json()["shortfalls"]
    assert missed["amount"] == pytest.approx(7.0)
    assert missed["sd"] == pytest.approx(math.hypot(0.1, 0.2))


def test_no_deviation_claims_no_number_of_them(tmp_path: Path) -> None:
    verdict = judge_pair(tmp_path, faces(71.0, sd=0.0), CONDITIONS[0])
    assert "angle(f2, f3) = 71°, needs 90 ± 15: 4° short (" in verdict.summary
    assert verdict.to_json()["shortfalls"][0]["sds"] is None


# ---- near misses


def standing(verdict: Verdict) -> tuple[int, int]:
    return (
        -len(verdict.list_conditions_in_state(State.HOLDS)),
        len(verdict.list_conditions_in_state(State.FAILS)),
    )


def test_what_is_known_comes_before_what_is_not(tmp_path: Path) -> None:
    # f1 fails one condition of three; nothing is known of f2.
    facts: list[Fact] = [("scene", "s"), ("scale", "metric"), ("thing", "t1")]
    for name in ("f1", "f2"):
        facts += [("face", name), ("part_of", name, "t1"), ("evidence", name, "measured")]
    facts += [("share", "f1", 0.7, 0.01), ("fill", "f1", 0.9, 0.01), ("tilt", "f1", 1.0, 0.1)]
    path = tmp_path / "lid.pl"
    path.write_text(
        ":- module(lid, []).\n:- use_module(facetlog(vocabulary)).\n"
        'model(lid, "Lid.", [a]).\ncandidate(lid, T, [A]) :- face_of(T, A).\n'
        'condition(lid, share, "s", _, [A], at_least(share(A), 0.8)).\n'
        'condition(lid, fill, "f", _, [A], at_least(fill(A), 0.8)).\n'
        'condition(lid, level, "l", _, [A], level(A)).\n'
    )
    with asked(facts, path) as ask:
        misses = ask.why_not("lid")
        # But the thing is not refuted: f2 may be a lid.
        assert ask.judge("lid") == misses[1]
        assert misses[1].state is State.UNKNOWN
    assert [v.parts[0].faces for v in misses] == [("f1",), ("f2",)]


def test_near_misses_come_with_the_most_that_holds_first(facts_of: Build) -> None:
    with asked(facts_of("chair")) as ask:
        misses = ask.why_not("stool", count=6)
    assert [standing(v) for v in misses] == sorted(map(standing, misses))
    assert len({v.parts for v in misses}) == 6
    assert misses[0].parts[0].faces == ("f1",)
    assert [c.label for c in misses[0].list_conditions_in_state(State.FAILS)] == ["no_back"]


def test_given_parts_are_judged_even_if_no_candidate_has_them(facts_of: Build) -> None:
    with asked(facts_of("box")) as ask:
        # f0 and f1 are opposite: the model never proposes them together.
        (miss,) = ask.why_not("box", parts={"a": "f0", "b": "f1"}, count=1)
        why = ask.why("box", parts={"a": "f0", "b": "f1"})
    for verdict in (miss, why):
        assert [p.faces for p in verdict.parts[:2]] == [("f0",), ("f1",)]
        assert verdict.state is State.FAILS


def test_given_parts_choose_among_the_candidates(facts_of: Build) -> None:
    with asked(facts_of("box")) as ask:
        verdict = ask.why("box", parts={"a": "f1"})
    assert verdict.state is State.HOLDS
    assert verdict.parts[0].faces == ("f1",)


@pytest.mark.parametrize(
    ("thing", "parts", "message"),
    [
        ("t9", {}, "no thing t9"),
        (
            None,
            {"top": "f99"},
            r"no part f99 for this model: it has f\d+ to f\d+, e\d+ to e\d+$",
        ),
        (None, {"lid": "f1"}, "no part lid: it has top"),
    ],
)
def test_what_is_not_there_is_named(
    facts_of: Build, thing: str | None, parts: dict[str, str], message: str
) -> None:
    with asked(facts_of("table")) as ask:
        for question in (ask.why, ask.why_not):
            with pytest.raises(QueryError, match=message):
                question("table", thing=thing, parts=parts)


def test_where_nothing_is_proposed_the_faces_themselves_are_tried(facts_of: Build) -> None:
    with asked(facts_of("pyramid")) as ask:
        # That no face rises from a seat that was not found says nothing against it.
        verdict = ask.judge("chair")
        assert verdict.state is State.UNKNOWN
        assert "nothing was measured that could be its seat or back" in verdict.summary
        misses = ask.why_not("chair")
    assert {v.parts[0].faces for v in misses} == {(f"f{i}",) for i in range(5)}
    assert "tilt(f1) = 56.3° ± 0.4°, needs at most 20: 36.3° over" in "\n".join(
        line for v in misses for line in v.lines(full=True)
    )


def test_a_thing_without_a_measured_face_still_gets_an_answer(facts_of: Build) -> None:
    with asked([("scene", "s"), ("scale", "unknown"), ("thing", "t1")]) as ask:
        (miss,) = ask.why_not("box")
    assert miss.state is State.UNKNOWN
    assert all(not part.faces for part in miss.parts)


@settings(max_examples=12)
@given(
    conditions=st.permutations(CONDITIONS),
    seed=st.integers(0, 1000),
    name=st.sampled_from(["wedge", "step"]),
)
def test_ranking_depends_on_no_order(
    facts_of: Build,
    tmp_path_factory: pytest.TempPathFactory,
    conditions: list[str],
    seed: int,
    name: str,
) -> None:
    def ranking(lines: list[str], facts: list[Fact]) -> list[Any]:
        with asked(facts, model_file(tmp_path_factory.mktemp("rules"), *lines)) as ask:
            shown = (ask.judge("pair"), *ask.why_not("pair", count=12))
            return [(v.thing, v.parts, v.state) for v in shown]

    facts = list(facts_of(name))
    expected = ranking(list(CONDITIONS), facts)
    Random(seed).shuffle(facts)
    assert ranking(conditions, facts) == expected
    assert len(expected) == (11 if name == "wedge" else 13)


def test_one_absurd_value_does_not_dominate(tmp_path: Path) -> None:
    # f1 misses one condition absurdly, f2 both by little; f3 misses one by little.
    facts: list[Fact] = [("scene", "s"), ("scale", "metric"), ("thing", "t1")]
    for name, share, fill in (("f1", 1e-9, 0.9), ("f2", 0.79, 0.79), ("f3", 0.75, 0.9)):
        facts += [("face", name), ("part_of", name, "t1"), ("evidence", name, "measured")]
        facts += [("share", name, share, 0.001), ("fill", name, fill, 0.001)]
    path = tmp_path / "full.pl"
    path.write_text(
        ":- module(full, []).\n:- use_module(facetlog(vocabulary)).\n"
        'model(full, "Full.", [a]).\ncandidate(full, T, [A]) :- face_of(T, A).\n'
        'condition(full, share, "s", _, [A], at_least(share(A), 0.8)).\n'
        'condition(full, fill, "f", _, [A], at_least(fill(A), 0.8)).\n'
    )
    with asked(facts, path) as ask:
        order = [v.parts[0].faces[0] for v in ask.why_not("full")]
    assert order == ["f3", "f1", "f2"]


@settings(max_examples=10)
@given(
    name=st.sampled_from(["box", "wedge", "step", "table", "chair"]),
    model=st.sampled_from(BUILTIN_MODELS),
    seed=st.integers(0, 1000),
)
def test_what_is_judged_is_the_best_of_all_that_is_ranked(
    facts_of: Build, solid: Callable[[str], Any], name: str, model: str, seed: int
) -> None:
    random = Random(seed)
    faces = range(len(solid(name).faces))
    seen = tuple(sorted(random.sample(faces, random.randint(2, min(10, len(faces))))))
    with asked(facts_of(name, seen=seen)) as ask:
        shown = ask.judge(model)
        misses = ask.why_not(model, count=10_000)
        if shown.state is State.HOLDS or not any(part.faces for part in shown.parts):
            return
    assert [standing(v) for v in misses] == sorted(map(standing, misses))
    left_open = [v for v in misses if v.state is State.UNKNOWN]
    assert shown == (left_open or misses)[0]
