"""Warnings that a comment allows."""

from pathlib import Path

import pytest

from facetlog.grammar.analysis import analyse
from facetlog.grammar.faults import applied
from facetlog.grammar.format import formatted
from facetlog.grammar.lint.allowed import allow_fix
from facetlog.grammar.source import Source
from tests.grammar.linted import codes, complete, faults_of

HEAD = "face top, side\nok: top is level, top adjoins side\n"


@pytest.mark.parametrize(
    "lines",
    [
        "side adjoins top  # lint: allow said-twice",
        "# lint: allow said-twice\nside adjoins top",
        "# lint: allow said-twice\n# for the sake of clarity\n\nside adjoins top",
        "side adjoins top  #lint:allow said-twice",
        "side adjoins top, tilt(top) = 3 deg ± 0 deg  # lint: allow said-twice, zero-tolerance",
    ],
)
def test_a_warning_is_allowed_on_its_line_or_the_one_above(lines: str) -> None:
    assert codes(HEAD + lines) == []


def test_other_warnings_and_other_lines_are_reported() -> None:
    line = "side adjoins top, tilt(top) = 3 deg ± 0 deg"
    assert codes(f"{HEAD}{line}  # lint: allow said-twice") == ["zero-tolerance"]
    twice = f"{HEAD}side adjoins top  # lint: allow said-twice\ntop adjoins side"
    assert codes(twice) == ["said-twice"]


def test_errors_cannot_be_allowed() -> None:
    body = f"{HEAD}top is upright  # lint: allow contradiction"
    assert codes(body) == ["contradiction"]


def test_comments_of_another_kind_say_nothing() -> None:
    assert codes(f"{HEAD}side adjoins top  # allow said-twice") == ["said-twice"]


def test_formatting_keeps_what_is_allowed() -> None:
    text = complete(f"{HEAD}side adjoins top  # lint: allow said-twice")
    assert faults_of(formatted(Source("", text))) == ()


@pytest.mark.parametrize("comment", ["", "  # why", "  # lint: allow zero-tolerance"])
def test_the_editor_can_write_the_comment(comment: str) -> None:
    line = f"side adjoins top, tilt(top) = 3 deg ± 0 deg{comment}"
    text = complete(HEAD + line)
    for _ in range(2):
        analysis = analyse(Path("test.model"), text)
        if not analysis.faults:
            break
        fix = allow_fix(analysis.faults[0], analysis.file.comments)
        text = applied(text, fix.edits)
    assert faults_of(text) == ()
