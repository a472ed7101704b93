"""The list of all kinds of faults."""

import ast
import re
from pathlib import Path

import pytest

import facetlog.grammar
from facetlog.grammar.analysis import analyse
from facetlog.grammar.fault_codes import FAULT_KINDS, FaultKind, build_example_file
from facetlog.grammar.faults import Fault

ROOM = Path(facetlog.grammar.__path__[0])
CODE = re.compile(r"[a-z]+(-[a-z]+)*")

MAKERS = frozenset({"Fault", "fault", "_fault", "_warning"})
"""The functions that make faults: their first text that is a code is one."""


def _codes(path: Path) -> set[str]:
    """The codes that are given to what makes faults in a module."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Call) and node.args:
            name = getattr(node.func, "attr", getattr(node.func, "id", ""))
            first = getattr(node.args[0], "value", None)
            if name in MAKERS and isinstance(first, str) and CODE.fullmatch(first):
                found.add(first)
    return found


def test_every_code_in_use_is_listed() -> None:
    # The inner function of own_words.py takes the name of a part of its pattern.
    modules = [p for p in sorted(ROOM.rglob("*.py")) if p.name != "own_words.py"]
    codes = set[str]().union(*map(_codes, modules))
    assert {"syntax", "arity", "never-holds", "unknown-builder"} <= codes
    assert sorted(codes - FAULT_KINDS.keys()) == []


def test_every_kind_is_reported_in_one_sentence() -> None:
    for kind in FAULT_KINDS.values():
        assert kind.meaning[0].isupper()
        assert kind.meaning.endswith(".")


def _faults(kind: FaultKind) -> tuple[Fault, ...]:
    text = build_example_file(kind)
    if kind.code == "own-word":
        main = 'use "own.pl"\nmodel a\n  face b\n  ok: b is level\n'
        return analyse(Path("a.model"), main, read=lambda _: text).faults
    return analyse(Path("a.model"), text).faults


SHOWN = [kind for kind in FAULT_KINDS.values() if kind.example]


@pytest.mark.parametrize("kind", SHOWN, ids=lambda kind: kind.code)
def test_the_example_of_a_kind_shows_it(kind: FaultKind) -> None:
    faults = [f for f in _faults(kind) if f.code == kind.code]
    assert [f.severity for f in faults] == [kind.severity]


def test_what_has_no_example_needs_more_than_a_text() -> None:
    without = {kind.code for kind in FAULT_KINDS.values() if not kind.example}
    assert without == {
        "empty-file",
        "same-name",
        "too-large",
        "unreadable",
        "unknown-builder",
        "unknown-size",
    }
