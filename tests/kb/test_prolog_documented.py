"""Every exported predicate says how it is called, how often it succeeds, and what it means."""

import re
from pathlib import Path

import pytest

from facetlog.kb.engine.engine import house

PROLOG = house("kb") / "prolog"
LIBRARIES = ("vocabulary", "measures", "grouping", "line_labels")
FILES = (
    *sorted(PROLOG.rglob("*.pl")),
    *(house("rules") / f"{name}.pl" for name in LIBRARIES),
)
MODULE = re.compile(r"^:- module\(\s*\w+,\s*\[(.*?)\]\)\.", re.S | re.M)
EXPORT = re.compile(r"([a-z]\w*)\s*/\s*(\d+)")
MODE = re.compile(r"^%!\s+([a-z]\w*)(?:\((.*)\))? is (?:det|semidet|nondet|multi|failure)\.$", re.M)
CLOSED = re.compile(r"\([^()]*\)|\[[^\[\]]*\]")


def exports(text: str) -> set[tuple[str, int]]:
    """Return the predicates that a module exports, as (name, number of arguments)."""
    head = MODULE.search(text)
    assert head is not None
    bare = re.sub(r"%.*", "", head[1])
    return {(name, int(arity)) for name, arity in EXPORT.findall(bare)}


def documented(text: str) -> set[tuple[str, int]]:
    """Return the predicates with a mode line."""
    found = set()
    for name, arguments in MODE.findall(text):
        inner, before = arguments, ""
        while inner != before:
            inner, before = CLOSED.sub("", inner), inner
        found.add((name, inner.count(",") + 1 if arguments else 0))
    return found


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_all_exports_have_a_mode_line(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert exports(text) - documented(text) == set()
