"""What a newcomer writes first gets the language's own way to say it."""

from pathlib import Path

import pytest

from facetlog.grammar.analysis import analyse
from facetlog.grammar.faults import Fault
from facetlog.grammar.spoken import hint_of_phrase

PARTS = "model m\n  board top\n  face wall\n  at least 2 bars leg where leg carries top\n  "


def errors(line: str) -> tuple[Fault, ...]:
    """Those of a model of some parts, a line, and one more condition."""
    text = f"{PARTS}{line}\n  top is measured\n"
    return tuple(analyse(Path("m.model"), text).errors)


@pytest.mark.parametrize(
    ("line", "hint"),
    [
        ("top is horizontal", "write `level`"),
        ("wall is vertical", "write `upright`"),
        ("top is thin", "call it a `board`"),
        ("top is seen", "write `measured`"),
        ("top stands_on ground", "write `leg is on_ground`"),
        ("top stands on the ground", "write `leg is on_ground`"),
        ("opening in top", "name it: `opening way`"),
        ("height(top) >= 40 cm", "write `at least`"),
        ("height(top) < 40 cm", "write `at most`"),
        ("4 bars post where post is upright", "write `exactly 4 bars ...`"),
        ("bars post where post carries top", "say how many: `any number of bars post where ...`"),
        ("at least 3 post where post carries top", "`at least 3 bars post where ...`"),
        ("panel side", "`board side`"),
        ("each leg is upright", "`each leg: leg is ...`"),
        ("there is a shelf below top", "`there is a shelf x where x below ...`"),
        ("no piece above top", "`there is no piece x where x above ...`"),
        ("length of top at least 40 cm", "write `length(top)`"),
        ("top has length 40 cm", "write `length(top) about 40 cm`"),
        ("the top is level", "leave the article out: `top`"),
    ],
)
def test_what_people_say_is_answered_by_what_to_write(line: str, hint: str) -> None:
    assert hint in errors(line)[0].hint


@pytest.mark.parametrize(
    "line",
    [
        "top is level",
        "wall is upright",
        "top is measured",
        "each leg: leg is on_ground",
        "height(top) at least 40 cm",
        "exactly 4 bars post where post is upright",
        "any number of bars post where post carries top",
        "board side",
        "there is no piece x where x above top",
        "length(top) about 40 cm",
    ],
)
def test_what_is_said_to_be_written_is_the_language(line: str) -> None:
    assert not errors(line)


@pytest.mark.parametrize("line", ["top is", "size top", "length(top) at", "use"])
def test_a_statement_that_only_ends_too_early_is_no_phrase(line: str) -> None:
    assert hint_of_phrase(line, len(line)) == ""


def test_a_phrase_before_the_fault_is_not_blamed() -> None:
    assert hint_of_phrase("the top is level ? no", len("the top is level ")) == ""
