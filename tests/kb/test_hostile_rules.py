"""Hostile rule texts: refused with file and line, or ended by a limit; never with an effect."""

import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from facetlog.errors import EngineError, InputError, RuleSyntaxError
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.limits import Limits
from tests.patience import allowed

from .hostile_cases import GOOD, Aviary, cases

# Small, so that what never ends is soon over; what ends by itself takes milliseconds.
LIMITS = Limits(seconds=1.0, inferences=2_000_000, stack_mb=64)

REFUSED = cases("refused_rules.txt")
BOUNDED = cases("bounded_rules.txt")

# What is too long to be written down, or no text.
MADE = {
    "ten million characters": (b"% " + b"x" * 10_000_000, "too long"),
    "a text longer than any model": (b"% " + b"x" * 300_000, "too long"),
    "parentheses that overrun C's stack": (
        b"candidate(slab, _, [X]) :- X = " + b"(" * 90_000 + b"1" + b")" * 90_000 + b".",
        "too many brackets",
    ),
    "parentheses that are not closed": (b"p :- " + b"(" * 100_000, "too many brackets"),
    "lists in lists": (b"p(" + b"[" * 4_900 + b"]" * 4_900 + b").", "nested too deeply"),
    "braces in braces": (b"p(" + b"{" * 4_900 + b"}" * 4_900 + b").", "nested too deeply"),
    "ninety thousand signs": (b"p(" + b"- " * 90_000 + b"a).", "nested too deeply"),
    "sixty thousand negations": (b"p :- " + b"\\+ " * 60_000 + b"true.", "nested too deeply"),
    "sixty thousand alternatives": (b"p :- " + b"!;" * 60_000 + b"true.", "nested too deeply"),
    "sixty thousand conditions": (b"p :- " + b"!->" * 60_000 + b"true.", "nested too deeply"),
    "sixty thousand summands": (b"p(X) :- X is " + b"1+" * 60_000 + b"1.", "nested too deeply"),
    "two thousand levels": (b"p(" + b"f(" * 2_000 + b"x" + b")" * 2_000 + b").", "more than 1,000"),
    "ten thousand unknown words": (b"p :- q.\n" * 10_000, "and more of the kind"),
    "ten thousand faulty clauses": (b"p :- .\n" * 10_000, "and more of the kind"),
    "a predicate of 40,000 arguments": (b"p(" + b"_," * 39_999 + b"_).", "too large for Prolog"),
    "NUL": (b"candidate(slab, _, [a\0b]).", "a control character (code 0)"),
    "no UTF-8": (b"candidate(slab, _, ['\xff\xfe']).", "this is no UTF-8 text"),
    "UTF-16": ("candidate(slab, _, [a]).".encode("utf-16"), "this is no UTF-8 text"),
    "half a character": (b"p('\xed\xa0\x80').", "this is no UTF-8 text"),
    "half a character, escaped": (b"p('\\xD800\\').", "syntax error"),
}


@pytest.fixture(scope="module")
def aviary(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Aviary]:
    with KnowledgeBase(LIMITS) as base:
        yield Aviary(base, tmp_path_factory.mktemp("rules"))


def load(aviary: Aviary, data: bytes) -> None:
    """Loads the text and asks what can be asked of it."""
    path = aviary.folder / "slab.pl"
    path.write_bytes(data)
    try:
        rules = aviary.base.load_rules(path)
        try:
            aviary.base.judge("s", "slab", "t1")
        finally:
            aviary.base.unload_rules(rules)
    finally:
        path.unlink()


def test_there_are_enough_hostile_texts() -> None:
    assert len(REFUSED) + len(BOUNDED) + len(MADE) >= 60


@pytest.mark.parametrize(("title", "message", "text"), REFUSED, ids=[c[0] for c in REFUSED])
def test_a_hostile_text_is_refused_with_its_line(
    aviary: Aviary, title: str, message: str, text: str
) -> None:
    with aviary.unchanged(), pytest.raises(RuleSyntaxError) as caught:
        load(aviary, (GOOD + text + "\n").encode())
    path = aviary.folder / "slab.pl"
    assert f"{path}:{message}" in str(caught.value)


@pytest.mark.parametrize(("title", "message", "text"), BOUNDED, ids=[c[0] for c in BOUNDED])
def test_a_text_without_end_ends_at_a_limit(
    aviary: Aviary, title: str, message: str, text: str
) -> None:
    begin = time.monotonic()
    with aviary.unchanged(), pytest.raises((EngineError, InputError), match=message):
        load(aviary, (GOOD + text + "\n").encode())
    # Two songs are sung in the same time.
    assert time.monotonic() - begin < allowed(LIMITS.seconds)


@pytest.mark.parametrize("title", MADE)
def test_a_monstrous_text_is_refused_at_once(aviary: Aviary, title: str) -> None:
    data, message = MADE[title]
    begin = time.monotonic()
    with aviary.unchanged(), pytest.raises(RuleSyntaxError) as caught:
        load(aviary, GOOD.encode() + data + b"\n")
    assert time.monotonic() - begin < allowed(LIMITS.seconds)
    assert message in str(caught.value)
    assert len(str(caught.value)) < 10_000


def test_the_slowest_text_that_fits_takes_a_second_or_two(aviary: Aviary) -> None:
    begin = time.process_time()  # reading cannot be interrupted, so other work must not count
    load(aviary, GOOD.encode() + b"far(" + b"7" * 199_000 + b").")
    assert time.process_time() - begin < 3.0


def test_a_clause_of_a_hundred_thousand_variables_does_no_harm(aviary: Aviary) -> None:
    with aviary.unchanged():
        many = ",".join(f"V{i}" for i in range(30_000))
        load(aviary, (GOOD + f"far([{many}]) :- true.\n").encode())


def test_a_refused_file_leaves_the_one_before_in_force(aviary: Aviary, tmp_path: Path) -> None:
    path = tmp_path / "slab.pl"
    path.write_text(GOOD)
    rules = aviary.base.load_rules(path)
    path.write_text(GOOD + "candidate(slab, _, [X]) :- shell(X).\n")
    with pytest.raises(RuleSyntaxError):
        aviary.base.load_rules(path)
    assert aviary.rows("is_a(T, slab)") != []
    aviary.base.unload_rules(rules)


@pytest.mark.parametrize(
    "text",
    [
        "".join(f"a{i:x}.\n" for i in range(20_000)),
        "".join(f"a{i:x}.\n" for i in range(10_000)) + "z :- " + "a270e, " * 10_000 + "true.",
    ],
    ids=["facts", "calls"],
)
def test_a_file_of_thousands_of_predicates_loads_in_its_time(aviary: Aviary, text: str) -> None:
    begin = time.process_time()  # loading alone: other work must not count
    load(aviary, (GOOD + text + "\n").encode())
    assert time.process_time() - begin < allowed(5.0)  # looked up one by one, it took 24 s
