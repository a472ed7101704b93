"""Statements that were read before: they become what they would be if read anew."""

import random
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

import facetlog.rules
from facetlog.grammar import syntax as s
from facetlog.grammar.reading.parse import forget, parse
from facetlog.grammar.source import Source, Span

TEXTS = [p.read_text("utf-8") for p in sorted(Path(facetlog.rules.__path__[0]).glob("*.model"))]


def _nodes(text: str, name: str = "a.model") -> object:
    file = parse(Source(name, text)).file
    return file.statements, file.models, file.comments


@given(st.integers(0, 10**9))
def test_a_changed_text_is_read_as_if_anew(seed: int) -> None:
    chance = random.Random(seed)
    text = chance.choice(TEXTS)
    _nodes(text)
    lines = text.split("\n")
    at = chance.randrange(len(lines))
    lines[at : at + chance.randint(0, 1)] = chance.choice([[], ["# what"], ["  face new_one"]])
    changed = "\n".join(lines)
    found = _nodes(changed)
    forget()
    assert found == _nodes(changed)


def test_no_node_stands_in_two_places() -> None:
    text = "model a\n  face x\n  x is level\nmodel b\n  face x\n  x is level\n"
    first, second = (_nodes(text, name) for name in ("a.model", "b.model"))
    assert first == second
    models = [file[1] for file in (first, second)]  # type: ignore[index]
    nodes = [node for both in models for model in both for node in s.walk(model)]
    assert len({id(node) for node in nodes}) == len(nodes)


def test_moving_a_node_moves_all_in_it() -> None:
    ((), (model,), ()) = _nodes("model a\n  face x\n  x is level\n")  # type: ignore[misc]
    there = s.moved(model, 7)
    assert [node.span for node in s.walk(there)] == [
        Span(node.span.start + 7, node.span.end + 7) for node in s.walk(model)
    ]
    assert s.moved(there, -7) == model
