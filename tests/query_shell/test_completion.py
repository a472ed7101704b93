"""What is proposed while typing, and the hint about the word at the cursor."""

from pathlib import Path

import pytest

from facetlog.query_shell.completion import hint_at, proposals
from facetlog.query_shell.lines import execute
from facetlog.query_shell.shell import Shell

from .scenes import write_block


def texts(shell: Shell, text: str) -> list[str]:
    return [proposal.text for proposal in proposals(shell, text)]


FACES = ["f1", "f2", "f3", "f4", "f5", "f6"]


@pytest.mark.parametrize(
    ("typed", "first"),
    [
        ("ang", ["angle("]),
        ("face(F), dihe", ["dihedral("]),
        ("angle(", FACES),
        ("angle(f1, ", FACES),
        ("edge(e1, v", [f"v{i}" for i in range(1, 9)]),
        ("part_of(f1, ", ["t1"]),
        ("holds(near(angle(f1, f", FACES),
        ("each(X, [f1, ", []),
        ("is_a(t1, ", ["bed", "bench", "bookcase"]),
        ("plays(", FACES),
        ("closes(", FACES),
        ("in(", ["block"]),
        ("angle(F1, F2, Deg, _), De", ["Deg"]),
        (":re", [":reload"]),
        (":help dihe", ["dihedral"]),
        (":facts t", ["t1"]),
        (":use ", ["block"]),
        ("why ta", ["table"]),
        ("why f", FACES),
        ("why box a=", FACES),
        ("why box ", ["t1"]),
        ("why box", ["box "]),
        (":lo", [":load "]),
        (":load", [":load "]),
        ("why", ["why "]),
        ("why_", ["why_not "]),
        ("why angle(f1, ", FACES),
    ],
)
@pytest.mark.slow
def test_what_fits_the_place_is_proposed_first(shell: Shell, typed: str, first: list[str]) -> None:
    assert texts(shell, typed)[: len(first)] == first


def test_words_are_not_proposed_twice_and_operators_get_no_bracket(shell: Shell) -> None:
    found = texts(shell, "a")
    assert len(found) == len(set(found))
    assert texts(shell, "X is 7 mo")[:1] != ["mod("]


def test_a_proposal_takes_the_place_of_what_was_typed(shell: Shell) -> None:
    (proposal,) = (p for p in proposals(shell, "dihed") if p.text == "dihedral(")
    assert proposal.length == len("dihed")
    assert "angle" in proposal.about


def test_names_follow_the_scenes_that_are_asked(shell: Shell, tmp_path: Path) -> None:
    assert texts(shell, "in(") == ["block"]
    execute(shell, f":load {write_block(tmp_path / 'x', name='odd name')}")
    assert texts(shell, "in(") == ["block", "'odd name'"]


def test_names_are_in_natural_order(shell: Shell) -> None:
    edges = texts(shell, "edge(e")[:12]
    assert edges == [f"e{i}" for i in range(1, 13)]


def test_files_are_proposed_after_load(shell: Shell, tmp_path: Path) -> None:
    (tmp_path / ".hidden").touch()
    (tmp_path / "one.pl").touch()
    assert set(texts(shell, f":load {tmp_path}/")) == {"block/", "one.pl", "XDG_CACHE_HOME/"}
    assert texts(shell, f":load {tmp_path}/.h") == [".hidden"]
    assert texts(shell, ":load /nowhere/") == []
    assert texts(shell, ":load ~nobody-of-that-name/") == []


@pytest.mark.parametrize(
    ("text", "place", "hint"),
    [
        ("angle(f1, f2, D, _)", 2, "angle(F1, F2, Angle, Sd)"),
        ("angle(f1, f2, D, _)", 12, "angle(F1, F2, Angle, Sd)"),
        ("face(F), angle", 14, "angle(F1, F2, Angle, Sd)"),
        (":reload", 4, ":reload"),
        ("nothing", 3, ""),
        ("", 0, ""),
    ],
)
def test_the_hint_is_about_the_word_or_the_call_at_the_cursor(
    shell: Shell, text: str, place: int, hint: str
) -> None:
    found = hint_at(shell, text, place)
    assert found.startswith(hint)
    assert bool(found) == bool(hint)
