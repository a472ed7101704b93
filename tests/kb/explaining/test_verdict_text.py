"""A verdict in lines: one reason for each condition, no line too long, all of it in the trace."""

import re
from collections.abc import Callable, Iterable
from functools import cache
from random import Random
from typing import Any

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
    """What all built-in models say of a solid."""
    facts = [fact.row for fact in scene_facts(build(name, {}))]
    with asked(facts) as ask:
        return tuple(ask.judge(model) for model in BUILTIN_MODELS)


@cache
def missed(name: str) -> tuple[Verdict, ...]:
    """What comes near being a thing of another kind."""
    facts = [fact.row for fact in scene_facts(build(name, {}))]
    with asked(facts) as ask:
        return tuple(v for model in ("box", "table") for v in ask.why_not(model, count=3))


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


@settings(max_examples=15)
@given(
    name=st.sampled_from(["box", "wedge", "step", "table", "chair", "pyramid", "room"]),
    up=st.sampled_from([(0.0, 0.0, 1.0), None]),
    metric=st.booleans(),
    seed=st.integers(0, 1000),
)
@pytest.mark.slow
def test_nor_of_things_of_which_a_part_was_seen(
    facts_of: Callable[..., Any],
    solid: Callable[[str], Any],
    name: str,
    up: tuple[float, float, float] | None,
    metric: bool,
    seed: int,
) -> None:
    random = Random(seed)
    faces = range(len(solid(name).faces))
    seen = tuple(sorted(random.sample(faces, random.randint(1, min(8, len(faces))))))
    with asked(facts_of(name, seen=seen, up=up, metric=metric)) as ask:
        for model in BUILTIN_MODELS:
            verdict = ask.judge(model)
            for line in (*verdict.lines(), *verdict.miss_lines()):
                assert len(line) <= WIDTH
                assert not re.search(r"\de[-+]\d", line)
            for condition in verdict.conditions:
                found = reason(condition.proof)
                assert found is None or found.step in steps(condition.proof)
                assert found is not None or condition.proof.state is HOLDS


@pytest.mark.parametrize("name", ["cuboid", "stool", "stairs"])
def test_near_misses_are_told_in_short_lines(name: str) -> None:
    assert missed(name)
    for verdict in missed(name):
        head, *lines = verdict.miss_lines()
        assert head.startswith(f"{verdict.thing} ")
        assert max(map(len, (head, *lines))) <= WIDTH
        marks = [line.strip()[0] for line in lines if not line.startswith("   ")]
        fails, open_ones = (len(verdict.conditions_that(s)) for s in (FAILS, UNKNOWN))
        assert marks == ["-"] * fails + ["?"] * open_ones + ["+"] * (len(marks) > fails + open_ones)


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


def lines_of(said: str, *, low: float = 1.0) -> list[str]:
    proof = Proof(HOLDS, low, 1, "", compared("share(f1)", 0.9, 0.5).detail)
    condition = Condition("wide", said, proof, "slab.model:9", "share(a) at least 50 %")
    return list(verdict_of(condition).lines())[2:]


def test_a_reason_that_has_no_room_beside_what_is_asked_has_a_line_of_its_own() -> None:
    whole, place = "share(f1) = 90 ± 1 %, at least 50 %", " [slab.model:9]"
    room = WIDTH - len(f"  + wide:  – {whole}{place}")
    assert lines_of("x" * room) == [f"  + wide: {'x' * room} – {whole}{place}"]
    said = "x" * (room + len(place))
    assert lines_of(said) == [f"  + wide: {said} – {whole}"]
    said += "x"
    assert lines_of(said) == [f"  + wide: {said}{place}", f"      {whole}"]
    assert lines_of("x" * WIDTH) == ["  + wide", f"      {whole}"]


@pytest.mark.parametrize(("low", "shown"), [(0.994, " (99%)"), (0.995, ""), (0.25, " (25%)")])
def test_a_degree_is_said_where_it_is_not_certain(low: float, shown: str) -> None:
    assert lines_of("it is wide", low=low)[0].startswith(f"  + wide: it is wide{shown} – share(f1)")


def test_sizes_have_each_their_unit() -> None:
    condition = Condition("wide", "", compared("share(f1)", 0.9, 0.5))
    lines = list(verdict_of(condition).lines())
    assert "  sizes: length 254.0 ± 0.07 mm, width 1.50 ± 0.02 m (of f1's middle)" in lines
    assert lines[-1] == "  + wide – share(f1) = 90 ± 1 %, at least 50 %"


def test_conditions_that_are_not_asked_are_counted() -> None:
    void = Condition("void", "", Proof(HOLDS, 1, 1, "", Note("all")))
    real = Condition("wide", "", compared("share(f1)", 0.9, 0.5))
    assert list(verdict_of(real, void).lines())[-1] == "  + 1 more condition holds"
    assert list(verdict_of(real, void, void).lines())[-1] == "  + 2 more conditions hold"
    assert list(verdict_of(void).lines())[-1] == "  + 1 condition holds"


def test_what_the_least_change_would_turn_is_told_first() -> None:
    far = Condition("far", "", compared("share(f1)", 0.1, 0.5))
    near = Condition("near", "", compared("fill(f1)", 0.48, 0.5))
    hopeless = Condition("hopeless", "", Proof(FAILS, 0, 0, "level(f1)", Note("fact", "false")))
    open_one = Condition("open", "", Proof(UNKNOWN, 0, 1, "level(f2)", Note("fact", "unknown")))
    good = Condition("good", "", compared("share(f2)", 0.9, 0.5))
    verdict = verdict_of(hopeless, open_one, far, near, good, parts=(Part("a", ("f1",)),))
    assert [line.split()[:2] for line in verdict.miss_lines()][1:] == [
        ["-", "near"],
        ["-", "far"],
        ["-", "hopeless"],
        ["?", "open"],
        ["+", "holds:"],
    ]
    head, _, *lines = verdict.lines()
    assert head.startswith("t1 is no slab; fails: near – fill(f1) = 48 ± 1 %, needs")
    assert lines[1:] == list(verdict.miss_lines())[1:]


def test_what_leaves_several_conditions_open_is_said_once() -> None:
    def open_of(label: str, cause: str) -> Condition:
        note = Note("missing", "tilt(f1)", "tilt(f1) is not known", CAUSES[cause])
        return Condition(label, "", Proof(UNKNOWN, 0, 1, "level(f1)", note))

    conditions = (open_of("level", "up"), open_of("high", "scale"), open_of("room", "up"))
    assert list(verdict_of(*conditions, parts=(Part("a", ("f1",)),)).miss_lines()) == [
        "t1 may be a slab with a = f1: 3 of 3 conditions are unknown",
        "  ? level and room: not known, because which way is up was not given",
        "  ? high – tilt(f1) is not known, because the scale was not given",
    ]


def test_a_share_says_what_it_is_a_share_of() -> None:
    def first(measure: str) -> str:
        wide = Condition("wide", "", compared(measure, 0.9, 0.5))
        return next(line for line in verdict_of(wide).lines() if "wide" in line)

    assert "width(f1) = 90 ± 1 % of length(f1), at least 50 %" in first("width(f1)/length(f1)")
    assert "angle(f1, f2) = 90 ± 1 % of 90, at least 50 %" in first("angle(f1, f2)/90")
    assert "height of f1's middle = 90 ± 1 % of width(f2)" in first("elevation(f1)/width(f2)")


def test_of_values_that_differ_by_rounding_the_first_is_the_reason() -> None:
    def said(*values: float) -> str:
        steps = tuple(compared(f"share(f{n})", v, 0.8) for n, v in enumerate(values, start=1))
        full = Condition("full", "", Proof(HOLDS, 1, 1, "", Note("all"), steps))
        return next(line for line in verdict_of(full).lines() if "full" in line)

    less = 0.9 - 1e-16
    assert said(0.9, less, 0.9) == said(less, 0.9, 0.9) == said(0.9, 0.9, less)
    assert "share(f1)" in said(0.9, less, 0.9)
    assert "share(f2)" in said(0.9, 0.85, 0.9)


def test_what_is_expected_and_not_so_has_a_mark_of_its_own() -> None:
    inside = compared("height(f1)", 0.2, 0.5)
    lapsed = Proof(HOLDS, 0.5, 1, "", Note("expect"), (inside,))
    (line, reason_line) = list(verdict_of(Condition("usual", "it is high", lapsed, "")).lines())[2:]
    assert line.startswith("  ~ usual: it is high (50%)")
    assert reason_line.endswith(", not required")


def test_what_holds_as_it_does_not_apply_is_counted_in_a_miss() -> None:
    failing = Condition("wide", "it is wide", compared("share(f1)", 0.3, 0.5), "")
    holding = Condition("high", "it is high", compared("fill(f1)", 0.9, 0.5), "")
    unknown = Proof(UNKNOWN, 0, 1, "", Note("missing"))
    beside = Condition("third", "seen", Proof(HOLDS, 0.5, 1, "", Note("expect"), (unknown,)), "")
    assert (
        list(verdict_of(failing, holding, beside).miss_lines())[-1] == "  + holds: high (+ 1 more)"
    )


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


def test_in_full_the_place_and_the_text_of_the_line_are_told() -> None:
    condition = Condition(
        "wide", "it is wide", compared("share(f1)", 0.9, 0.5), "slab.model:9", "share(a) at least"
    )
    assert list(verdict_of(condition).lines(full=True))[-2:] == [
        "  + wide: it is wide (100%) [slab.model:9: share(a) at least]",
        "      + share(f1) = 90 ± 1 %, at least 50 %",
    ]


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
