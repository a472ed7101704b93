"""Proposals while typing, and the hint about the word at the cursor."""

import pytest

from facetlog.query_shell.lines import execute
from facetlog.query_shell.prompt import find_hint, proposals
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
        ("edge(e1, v", [f"v{i}" for i in range(1, 9)]),
        ("part_of(f1, ", ["t1"]),
        ("holds(near(angle(f1, f", FACES),
        ("each(X, [f1, ", []),
        ("is_a(t1, ", ["bed", "bench", "bookcase"]),
        ("in(", ["block"]),
        ("angle(F1, F2, Deg, _), De", ["Deg"]),
        (":re", [":reload"]),
        (":facts t", ["t1"]),
        (":use ", ["block"]),
        ("why ta", ["table"]),
        ("why box a=", FACES),
        ("why box", ["box "]),
        (":lo", [":load "]),
        ("why angle(f1, ", FACES),
    ],
)
@pytest.mark.slow
def test_what_fits_the_place_is_proposed_first(shell, typed, first):
    assert texts(shell, typed)[: len(first)] == first


def test_names_follow_the_scenes_that_are_asked(shell, tmp_path):
    assert texts(shell, "in(") == ["block"]
    execute(shell, f":load {write_block(tmp_path / 'x', name='odd name')}")
    assert texts(shell, "in(") == ["block", "'odd name'"]


def test_files_are_proposed_after_load(shell, tmp_path):
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
def test_the_hint_is_about_the_word_or_the_call_at_the_cursor(shell, text, place, hint):
    found = find_hint(shell, text, place)
    assert found.startswith(hint)
    assert bool(found) == bool(hint)
