"""A verdict in lines: one reason for each condition, no line too long, all of it in the trace."""

import re
from collections.abc import Iterable
from functools import cache

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.kb.explaining.proof import Comparison, Note, Proof, Shortfall, Side, State, Within
from facetlog.kb.explaining.reasons import reason
from facetlog.kb.explaining.verdict import Condition, Part, Size, Verdict
from facetlog.kb.explaining.verdict_text import WIDTH
from facetlog.kb.explaining.wording import CAUSES
from facetlog.kb.knowledge_base import BUILTIN_MODELS
from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.surfaces.exact_solids.builders import build
from tests.kb.asked import asked

HOLDS, FAILS, UNKNOWN = State.HOLDS, State.FAILS, State.UNKNOWN
SOLIDS = ("cuboid", "table", "chair", "stool", "shelf", "cabinet", "stairs", "room_corner", "desk")


@cache
def judged(name: str) -> tuple[Verdict, ...]:
    """Return verdicts of all built-in models on a solid."""
    facts = [fact.row for fact in scene_facts(build(name, {}))]
    with asked(facts) as ask:
        return tuple(ask.judge(model) for model in BUILTIN_MODELS)


def steps(proof: Proof) -> Iterable[Proof]:
    yield proof
    for child in proof.children:
        yield from steps(child)


@settings(max_examples=len(SOLIDS))
@given(name=st.sampled_from(SOLIDS))
@pytest.mark.slow
def test_every_line_of_what_holds_gives_a_reason_that_is_in_the_trace(name: str) -> None:
    holding = [v for v in judged(name) if v.state is HOLDS]
    assert holding
    for verdict in holding:
        said: dict[str, str] = {}
        for line in verdict.lines():
            if begun := re.match(r"  \S (\w+( \d+)?)(.*)", line):
                label, said[label] = begun[1], begun[3]
            elif line.startswith("      ") and said:
                said[label] += line
        asked_of = [c for c in verdict.conditions if reason(c.proof) is not None]
        for condition in asked_of:
            found = reason(condition.proof)
            assert found is not None
            assert found.step in steps(condition.proof)
            texts = found.texts(verdict.length_unit)
            same = "for the same reason" in said[condition.label]
            assert same or any(text in said[condition.label] for text in texts)
        unsaid = len(verdict.conditions) - len(asked_of)
        last = list(verdict.lines())[-1]
        assert last.startswith(f"  + {unsaid} more condition") == (unsaid > 0)


@settings(max_examples=len(SOLIDS))
@given(name=st.sampled_from(SOLIDS))
def test_no_line_is_too_long_or_has_an_exponent(name: str) -> None:
    for verdict in judged(name):
        for line in verdict.lines():
            assert len(line) <= WIDTH
            assert not re.search(r"\de[-+]\d", line)


# ---- lines by hand


def compared(measure: str, value: float, limit: float, *, sd: float = 0.01) -> Proof:
    holds = value >= limit
    miss = None if holds else Shortfall(limit - value, sd, Side.BELOW)
    found = Comparison(measure, value, sd, "ratio", Within("at_least", (limit,)), miss)
    return Proof(HOLDS if holds else FAILS, 1, 1, "", found)


def verdict_of(*conditions: Condition, parts: tuple[Part, ...] = ()) -> Verdict:
    states = {c.proof.state for c in conditions}
    state = next(s for s in (FAILS, UNKNOWN, HOLDS) if s in states)
    sizes = (Size("length", 0.254, 7e-5), Size("width", 1.5, 0.02, "elevation(f1)"))
    return Verdict("slab", "t1", state, 1, 1, parts, sizes, conditions, length_unit="m")


def test_what_the_least_change_would_turn_is_told_first() -> None:
    far = Condition("far", "", compared("share(f1)", 0.1, 0.5))
    near = Condition("near", "", compared("fill(f1)", 0.48, 0.5))
    hopeless = Condition("hopeless", "", Proof(FAILS, 0, 0, "level(f1)", Note("fact", "false")))
    open_one = Condition("open", "", Proof(UNKNOWN, 0, 1, "level(f2)", Note("fact", "unknown")))
    good = Condition("good", "", compared("share(f2)", 0.9, 0.5))
    verdict = verdict_of(hopeless, open_one, far, near, good, parts=(Part("a", ("f1",)),))
    assert [line.split()[:2] for line in verdict.iter_miss_lines()][1:] == [
        ["-", "near"],
        ["-", "far"],
        ["-", "hopeless"],
        ["?", "open"],
        ["+", "holds:"],
    ]
    head, _, *lines = verdict.lines()
    assert head.startswith("t1 is no slab; fails: near – fill(f1) = 48 ± 1 %, needs")
    assert lines[1:] == list(verdict.iter_miss_lines())[1:]


def test_what_leaves_several_conditions_open_is_said_once() -> None:
    def open_of(label: str, cause: str) -> Condition:
        note = Note("missing", "tilt(f1)", "tilt(f1) is not known", CAUSES[cause])
        return Condition(label, "", Proof(UNKNOWN, 0, 1, "level(f1)", note))

    conditions = (open_of("level", "up"), open_of("high", "scale"), open_of("room", "up"))
    assert list(verdict_of(*conditions, parts=(Part("a", ("f1",)),)).iter_miss_lines()) == [
        "t1 may be a slab with a = f1: 3 of 3 conditions are unknown",
        "  ? level and room: not known, because which way is up was not given",
        "  ? high – tilt(f1) is not known, because the scale was not given",
    ]


def test_of_values_that_differ_by_rounding_the_first_is_the_reason() -> None:
    def said(*values: float) -> str:
        steps = tuple(compared(f"share(f{n})", v, 0.8) for n, v in enumerate(values, start=1))
        full = Condition("full", "", Proof(HOLDS, 1, 1, "", Note("all"), steps))
        return next(line for line in verdict_of(full).lines() if "full" in line)

    less = 0.9 - 1e-16
    assert said(0.9, less, 0.9) == said(less, 0.9, 0.9) == said(0.9, 0.9, less)
    assert "share(f1)" in said(0.9, less, 0.9)
    assert "share(f2)" in said(0.9, 0.85, 0.9)


def test_many_parts_are_shortened_not_cut() -> None:
    condition = Condition("wide", "", compared("share(f1)", 0.9, 0.5))
    few = verdict_of(condition, parts=(Part("top", ("f1",)), Part("leg", ("f2", "f3"))))
    assert list(few.lines())[1] == "  parts: top = f1; leg = f2, f3"
    faces = tuple(f"f{i}" for i in range(2, 40))
    row = verdict_of(condition, parts=(Part("leg", faces, is_group=True),))
    assert list(row.lines())[1] == "  parts: leg = f2–f39"
    assert ", f17, " in list(row.lines(full=True))[1]
    even = verdict_of(condition, parts=(Part("leg", faces[::2], is_group=True),))
    assert list(even.lines())[1] == "  parts: leg = 19 faces"


def test_what_hangs_on_unseen_space_says_both_values_and_what_is_needed() -> None:
    within = Within("at_least", (0.75,))
    found = Comparison("free_below(f1)", 0.3, 0.01, "ratio", within, unseen=(0.9, 0.3))
    text = found.sentence(UNKNOWN, "m")
    assert text == (
        "free_below(f1) = 90 % or 30 %, as what was not seen is free or full, needs at least 75 %"
    )
    shorter = found.sentences(UNKNOWN, "m")[1]
    assert shorter == "free_below(f1) = 90 % or 30 % (unseen space free or full), at least 75 %"
    assert found.to_json()["unseen"] == [0.9, 0.3]
