"""Fixes: what each kind of fault offers, and texts with all that is sure put right."""

import random
import re
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import facetlog.rules
from facetlog.grammar.analysis import analyse
from facetlog.grammar.faults import Fault, Severity, applied
from facetlog.grammar.fix_all import UNREAD, fixed
from tests.grammar.linted import complete, faults_of

HEAD = "face top, side\nok: top is measured, top adjoins side\n"
RULES = [p.read_text("utf-8") for p in sorted(Path(facetlog.rules.__path__[0]).glob("*.model"))]


def _faults(text: str) -> tuple[Fault, ...]:
    return analyse(Path("test.model"), text).faults


def _mended(line: str) -> str:
    """A statement after --fix."""
    text = complete(f"{HEAD}{line}")
    found = fixed(text, _faults)
    return found.text.splitlines()[4].strip()


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("tilt(top) at leest 5 deg", "tilt(top) at least 5 deg"),
        ("tilt(top) at most 5 degs", "tilt(top) at most 5 deg"),
        ("top is levl", "top is level"),
        ("topp is level", "top is level"),
        ("tilt(top) at most 15", "tilt(top) at most 15 deg"),
        (
            "if known: length(top) between 40 and 60 cm",
            "if known: length(top) between 40 cm and 60 cm",
        ),
        ("if known: height(top) = 74 cm ± 10", "if known: height(top) = 74 cm ± 10 cm"),
        ("tilt(top) between 40 deg and 20 deg", "tilt(top) between 20 deg and 40 deg"),
        (
            "between 4 and 2 faces leg where leg adjoins top",
            "between 2 and 4 faces leg where leg adjoins top",
        ),
        ("tilt(top) = 30 deg ± -5 deg", "tilt(top) = 30 deg ± 5 deg"),
        ("tiltt(top) at leest 5 degs", "tilt(top) at least 5 deg"),
        # What shows by a fix may have one of its own.
        ("tiltt(top) between 40 deg and 20 deg", "tilt(top) between 20 deg and 40 deg"),
    ],
)
def test_what_is_sure_is_put_right(before: str, after: str) -> None:
    assert _mended(before) == after


@pytest.mark.parametrize(
    "line",
    [
        "side_b is level",  # a part that is still to be named
        "side2 is level",
        "tilt(top) at most 1.5",  # radians?
        "length(top) at most 40",  # which unit?
        "x is level",
        "tilt(top) = 5 deg",
        "let square = 15 deg",
        "length(top) between length(side) and width(side)",
        # With the unit that stands beside it this would never hold: which one was meant?
        "if known: length(top) between 400 and 90 cm",
        # What a statement shows once it can be read would be more than before.
        "foo(top) at leest bar(side)",
        "lenght(top) at most 40",
    ],
)
def test_what_is_not_sure_is_left_alone(line: str) -> None:
    assert _mended(line) == line


def test_likely_fixes_are_offered_though_they_are_not_sure() -> None:
    (fault,) = [f for f in faults_of(complete(f"{HEAD}length(top) at most 40")) if f.fixes]
    assert [fix.title for fix in fault.fixes] == [
        "write the unit `cm`",
        "write the unit `m`",
        "write the unit `mm`",
    ]
    assert fault.sure_fix is None


def test_each_fix_is_reported_with_its_place() -> None:
    found = fixed(complete(f"{HEAD}top is levl"), _faults)
    (one,) = found.done
    assert (one.line, one.code, one.title) == (5, "unknown-word", "write `level`")


def test_a_text_without_faults_stays() -> None:
    for text in RULES:
        assert fixed(text, _faults).text == text


def _slip(text: str, chance: random.Random) -> str:
    """A text with one slip: letters changed round, a unit lost, a word lost, ends changed round."""
    found = [
        list(re.finditer(pattern, text))
        for pattern in (r"\b[a-z_]{4,}\b", r"(?<=\d) (?:deg|cm|m)\b", r"\b\d+ %", r" \S+")
    ]
    kind = chance.randrange(4)
    if not found[kind]:
        return text
    match = chance.choice(found[kind])
    word = match[0]
    if kind == 0:
        at = chance.randrange(len(word) - 1)
        word = word[:at] + word[at + 1] + word[at] + word[at + 2 :]
    else:
        word = "" if kind != 2 else f"-{word}"
    return text[: match.start()] + word + text[match.end() :]


@settings(max_examples=60)
@given(st.integers(0, 10**9))
@example(365)  # two limits of which either order never holds
@example(2265)
@pytest.mark.slow
def test_a_fixed_text_is_never_worse_and_stays_when_fixed_again(seed: int) -> None:
    chance = random.Random(seed)
    text = chance.choice(RULES)
    for _ in range(chance.randint(1, 4)):
        text = _slip(text, chance)
    before = _faults(text)
    found = fixed(text, _faults)
    after = _faults(found.text)
    assert after == found.faults or len(after) == len(found.faults)
    errors = [sum(f.severity is Severity.ERROR for f in some) for some in (before, after)]
    assert errors[1] <= errors[0]
    unread = [sum(f.code in UNREAD for f in some) for some in (before, after)]
    assert unread[1] <= unread[0]
    # Lint looks only where no errors are, so warnings may show where one is gone; what could not be
    # read may have faults.
    assert len(after) <= len(before) or errors[1] < errors[0] or unread[1] < unread[0]
    assert bool(found.done) == (found.text != text)
    assert fixed(found.text, _faults).text == found.text


@settings(max_examples=40)
@given(st.integers(0, 10**9))
def test_every_fix_is_of_pieces_of_the_text_that_do_not_overlap(seed: int) -> None:
    chance = random.Random(seed)
    text = chance.choice(RULES)
    for _ in range(3):
        text = _slip(text, chance)
    for fault in _faults(text):
        for fix in fault.fixes:
            ends = sorted((edit.span.start, edit.span.end) for edit in fix.edits)
            assert all(one[1] <= other[0] for one, other in pairwise(ends))
            assert ends[0][0] >= 0
            assert ends[-1][1] <= len(text)
            assert applied(text, fix.edits) != text
