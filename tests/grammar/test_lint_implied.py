"""Models that are others, though nobody says so."""

import pytest

from tests.grammar.linted import complete, faults_of

BOARD = "face top\ntop is level, share(top) at least 50 %"


def _codes(*models: str) -> list[str]:
    return [f.code for f in faults_of("".join(models))]


@pytest.mark.parametrize(
    "other",
    [
        "face plate\nplate is level, share(plate) at least 50 %, plate is upward",
        "face plate\nplate is level, share(plate) at least 80 %, plate is upward",
        "face plate\nplate is level, plate is upward\nshare(plate) = 80 % ± 10 %",
        "face side, plate\nside adjoins plate, plate is level, share(plate) at least 60 %",
        "define flat(f): f is level, share(f) at least 60 %\nface p, q\np adjoins q, flat(q)",
    ],
)
def test_a_model_that_follows_from_another_is_reported_at_its_name(other: str) -> None:
    text = complete(BOARD, "board") + complete(other, "more")
    (fault,) = faults_of(text)
    assert (fault.code, fault.severity) == ("implied-model", "warning")
    assert fault.message.startswith("every `more` is a `board`")
    assert text[fault.span.start : fault.span.end] == "board"


@pytest.mark.parametrize(
    "other",
    [
        "face plate\nplate is level, share(plate) at least 40 %, plate is upward",
        "face plate\nplate is upright, share(plate) at least 80 %",
        "face plate\nplate is level\nif known: share(plate) at least 80 %",
        "face plate\nplate is level\nexpect: share(plate) at least 80 %",
        "face side, plate\nside adjoins plate, side is level, share(plate) at least 60 %",
        "face side\noptional face plate where plate adjoins side\nside is measured\n"
        "plate is level, share(plate) at least 60 %",
    ],
)
def test_a_model_that_does_not_follow_is_no_fault(other: str) -> None:
    faults = faults_of(complete(BOARD, "board") + complete(other, "more"))
    assert not [f for f in faults if f.message.startswith("every `more`")]


def test_what_is_said_already_is_no_fault() -> None:
    heir = 'model more is board\n  "It."\n  top is upward\n  example "one" of cuboid() fails\n'
    assert _codes(complete(BOARD, "board"), heir) == []


def test_two_equal_models_are_reported_once_at_the_later() -> None:
    same = "face plate\nshare(plate) at least 50 %, plate is level"
    text = complete(BOARD, "board") + complete(same, "plate_model")
    (fault,) = faults_of(text)
    assert fault.code == "implied-model"
    assert text[fault.span.start : fault.span.end] == "plate_model"
    assert "no more and no less" in fault.message


def test_what_is_said_of_all_other_faces_depends_on_which_are_parts() -> None:
    few = "face a\na is level\neach face x: x adjoins a"
    more = "face a, b\nb is upright, a is level\neach face x: x adjoins a"
    assert "implied-model" not in _codes(complete(few, "few"), complete(more, "more"))


SETS = "face top\nat least {} faces leg where leg is upright, leg adjoins top\ntop is level\n"


def test_sets_must_be_the_same() -> None:
    three, four = complete(SETS.format(3), "three"), complete(SETS.format(4), "four")
    assert _codes(three, four) == ["implied-model"]
    other = complete(SETS.format(4).replace("upright", "level"), "four")
    assert _codes(three, other) == []


def test_what_is_said_of_each_member_must_follow() -> None:
    three = complete(SETS.format(3) + "each leg: width(leg) at most 20 % of height(this)", "three")
    four = (
        SETS.format(4).replace("leg", "post")
        + "each post: width(post) at most {} % of height(this)"
    )
    assert _codes(three, complete(four.format(20), "four")) == ["implied-model"]
    assert _codes(three, complete(four.format(30), "four")) == []


def test_convex_faces_adjoin() -> None:
    adjoining = complete("face a, b\na adjoins b, a is level", "adjoining")
    bulging = complete("face a, b\nconvex(a, b), b is level", "bulging")
    assert _codes(adjoining, bulging) == ["implied-model"]
    assert _codes(bulging, adjoining) == ["implied-model"]
