"""Analyses with the memory of the last text: the same faults as without."""

import random
from pathlib import Path

from hypothesis import given, settings
from hypothesis import strategies as st

import facetlog.rules
from facetlog.grammar.analysis import Memory, analyse

TEXTS = [p.read_text("utf-8") for p in sorted(Path(facetlog.rules.__path__[0]).glob("*.model"))]
EDITS = (
    ("at least", "at most"),
    ("%", "cm"),
    (" is level", " is levl"),
    ("face ", "face spare, "),
    ("let ", "let unused = 3\n  let "),
    ("\n", "\n\n"),
    ("model ", "model new_"),
    ('"', ""),
)


def _library(chance: random.Random) -> str:
    return "\n".join(chance.sample(TEXTS, 4))


def _edited(text: str, chance: random.Random) -> str:
    old, new = chance.choice(EDITS)
    places = [at for at in range(len(text)) if text.startswith(old, at)]
    if not places:
        return text
    at = chance.choice(places)
    return text[:at] + new + text[at + len(old) :]


@settings(max_examples=25)
@given(st.integers(0, 10**9))
def test_edit_after_edit_tells_what_a_fresh_look_would(seed: int) -> None:
    chance = random.Random(seed)
    memory, path = Memory(), Path("library.model")
    text = first = _library(chance)
    for _ in range(6):
        found = analyse(path, text, memory=memory)
        fresh = analyse(path, text)
        listed = [
            [(f.code, f.span, f.message, f.hint, f.severity, f.fixes) for f in one.faults]
            for one in (found, fresh)
        ]
        assert listed[0] == listed[1]
        assert all(
            f.source is found.file.source for f in found.faults if f.source.name == str(path)
        )
        text = chance.choice([_edited(text, chance), _edited(text, chance), first])


def test_lines_that_messages_name_move_with_their_text() -> None:
    body = 'face b\n  ok: b is level\n  b is level\n  example "e" of table() fails\n'
    model = f'model a\n  "It."\n  {body}'
    memory, path = Memory(), Path("a.model")
    (before,) = analyse(path, model, memory=memory).faults
    (after,) = analyse(path, f"# above\n{model}", memory=memory).faults
    assert "line 4" in before.message
    assert "line 5" in after.message
