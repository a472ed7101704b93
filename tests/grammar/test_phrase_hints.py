"""What a newcomer writes first gets the language's own way to say it."""

import re
from pathlib import Path

import pytest

from facetlog.grammar.analysis import analyse
from facetlog.grammar.faults import Fault
from facetlog.grammar.phrase_hints import SPOKEN_WORDS, find_phrase_hint
from facetlog.grammar.vocabulary import VOCABULARY

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
        ("top is perpendicular", "`angle(a, b) = 90 deg ± 10 deg`"),
        ("perpendicular(top, back)", "`angle(a, b) = 90 deg ± 10 deg`"),
        ("leg is crosswise", "`angle(a, b) = 90 deg ± 10 deg`"),
        ("top lengthwise", "`parallel(a, b, 10 deg)`"),
        ("top is tilted", "`tilt(leg) between 60 deg and 85 deg`"),
        ("top leans on wall", "`tilt(leg) between 60 deg and 85 deg`"),
        ("top is lying", "write `a is level`"),
        ("top touching wall", "write `a joins b`"),
        ("top is in the middle of wall", "`distance(a, b) at most 10 % of width(b)`"),
        ("top is symmetric", "`inset(left, seat) about inset(right, seat)`"),
        ("top same size as wall", "`length(a) about length(b)`"),
        ("apart: evenly spaced leg", "`smallest step of elevation(rung)"),
        ("top is seen", "write `measured`"),
        ("top stands_on ground", "write `leg is on_ground`"),
        ("top stands on the ground", "write `leg is on_ground`"),
        ("opening in top", "name it: `opening way`"),
        (
            "height(top) from 20 % to 80 % of height(this)",
            "`between 20 % and 80 % of height(this)`",
        ),
        ("height(top) is 20-30 cm", "`between 20 and 30 cm`"),
        ("height(top) is between 20 cm and 30 cm", "write `between` without `is`"),
        ("height(top) at least 2 cm and at most 3 cm", "`between 2 cm and 3 cm`"),
        ("legs are sorted by length", "`order of length(key)"),
        ("each leg is shorter than the one before", "`order of length(key)"),
        ("wheel front", "`piece wheel where curved(wheel) at least 80 %, wheel is upright`"),
        ("at least 4 wheels w where w is on_ground", "`piece wheel where"),
        ("there is a wheel x where x below top", "`piece wheel where"),
        ("top is a wheel", "leave the article out"),
        ("deck floor", "`board slat`"),
        ("plinth base", "`piece plinth where plinth is on_ground`"),
        ("shaft well", "`hollow shaft where shaft is open_at_top`"),
        ("corners(top) = 4", "`corner_inset(leg, top) at most 15 % of width(top)`"),
        ("a leg at each corner of the top", "`corner_inset(leg, top)"),
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
        ("all legs are upright", "`each leg: leg is ...`"),
        ("the legs are upright", "`each leg: leg is ...`"),
        ("top is parallel to wall", "`parallel(back, front, 10 deg)`"),
        ("wall is perpendicular to top", "`angle(back, seat) = 90 deg ± 10 deg`"),
        ("top is on top of wall", "`back above seat`"),
        ("top is wider than long", "`length(top) at least 120 % of length(seat)`"),
        ("width(top) is 40 cm", "write `about 40 cm`"),
        ("top is 40 cm wide", "`width(top) about 40 cm`"),
        ("there is nothing above top", "`there is no piece x where x above ...`"),
        ("nothing above top", "`there is no piece x where x above top`"),
        ("top is under wall", "`shelf below top`"),
        ("four bars post where post is upright", "`exactly 4 bars ...`"),
        ("height(top) ~ 40 cm", "write `about`"),
        ("top is facing up", "write `upward`"),
        ("top is big", "say how much"),
        ("top is round", "`curved(top)"),
        ("top overlaps wall", "`overlap(top, seat) at least 10 %`"),
        ("top touches wall", "`a joins b`"),
        ("the top is level", "leave the article out: `top`"),
        ("space below top", "`free_below(top) at least 60 %`"),
        ("there is room under top", "`room_below(top) at least 40 cm`"),
        ("clearance above top at least 60 cm", "`room_above(top) at least 40 cm`"),
        ("open from a side", "`open_from_two_sides(top) at least 30 %`"),
        ("closed at one rim", "`closed_behind(seat) at least 70 %`"),
        ("closed on all sides", "`enclosed(floor) at least 85 %`"),
        ("enclosed by walls", "`enclosed(floor) at least 85 %`"),
        ("at least 2 shelves below top", "`shelves_below(top) at least 2`"),
        ("two shelves under top", "`shelves_below(top) at least 2`"),
        ("lamp hangs from beam", "`lamp hangs_from beam`"),
        ("leg is suspended from top", "`lamp hangs_from beam`"),
        ("leg is inside top", "`lamp inside way`"),
        ("top rests on leg", "`leg carries top`"),
        ("gap", "`opening way`; of two things say `gap(table, seat) at most 10 cm`"),
        ("gap between leg and top", "`opening way`"),
        ("leg is evenly spaced", "`smallest step of elevation(rung) at least 80 % of"),
        ("leg is set back from top", "`inset(plinth, body) at least 2 cm`"),
        ("top is made of boards", "`cover(slat) at least 60 %`"),
        ("hole in top", "`opening way`"),
        ("wall has an opening", "`opening way`"),
        ("top is closed behind", "`closed_behind(seat) at least 70 %`"),
        ("surrounded by walls", "`enclosed(floor) at least 85 %`"),
        ("top is hanging from wall", "`lamp hangs_from beam`"),
        ("top sits on wall", "`leg carries top`"),
        ("top is 4 cm thick", "`thickness`"),
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
    assert find_phrase_hint(line, len(line)) == ""


def test_a_phrase_before_the_fault_is_not_blamed() -> None:
    assert find_phrase_hint("the top is level ? no", len("the top is level ")) == ""


CODE = re.compile(r"`([^`]+)`")


def test_what_hints_say_to_write_are_words_of_the_language() -> None:
    for hint in SPOKEN_WORDS.values():
        for call in re.findall(r"(\w+)\(", " ".join(CODE.findall(hint))):
            assert call in VOCABULARY, hint


@pytest.mark.parametrize(
    ("line", "count"),
    [
        ("apart: evenly spaced leg", 1),
        ("leg is crosswise", 1),
        ("top stands upright", 1),
        ("top touches wall", 1),
        ("topp joinz wall", 2),
        ("evenly spaced leg, top is tilted", 2),
    ],
)
def test_a_broken_statement_has_one_error_for_each_mistake_of_its_own(
    line: str, count: int
) -> None:
    assert len(errors(line)) == count


def test_what_the_others_are_found_from_is_of_a_kind_of_the_text() -> None:
    text = "model m\n  at least 3 boards slat where slat is level\n  count(slat) at least 3\n"
    (fault,) = analyse(Path("m.model"), text).errors
    assert "`board first`" in fault.hint
