"""What the language server answers, worked out without an editor: whatever the text, an answer."""

from collections.abc import Iterable
from pathlib import Path
from random import Random

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from lsprotocol import types as lsp

from facetlog.grammar.language_server.completion import completions
from facetlog.grammar.language_server.hover import find_hover_text
from facetlog.grammar.language_server.project import EditorText, Project, diagnostics
from facetlog.grammar.language_server.rename import Refusal, Replacement, renamed
from facetlog.grammar.language_server.server import outline
from facetlog.grammar.language_server.symbols import SymbolKind, occurrences
from facetlog.grammar.vocabulary import VOCABULARY
from tests.grammar.model_texts import model_files, mutated_files

URI = "file:///nowhere/m.model"


@example("model a\n  at least 0.5 faces a\n", Random(0))
@settings(max_examples=40)
@given(mutated_files(), st.randoms(use_true_random=False))
def test_every_text_gets_answers_everywhere(text: str, chance) -> None:  # type: ignore[no-untyped-def]
    project = Project()
    path = project.open(URI, text)
    analysis = project.analysis(path)
    found = diagnostics(project, path)
    assert len(found) >= bool(analysis.faults)
    assert all(d.code_description.href.endswith(f"#{d.code}") for d in found)  # type: ignore[union-attr]
    outline(analysis.file, project.text(path))
    known = occurrences(analysis)
    for one in known.every:
        assert text[one.span.start : one.span.end] == one.symbol.name
        find_hover_text(analysis, one.symbol, {})
    for _ in range(5):
        offset = chance.randint(0, len(text))
        known.at(offset)
        completions(analysis, text, offset, {"cuboid": ("width",)})


@settings(max_examples=40)
@given(model_files(), st.randoms(use_true_random=False))
def test_a_name_that_is_given_and_taken_back_leaves_the_text_as_it_was(  # type: ignore[no-untyped-def]
    text: str, chance
) -> None:
    project = Project()
    path = project.open(URI, text)
    every = occurrences(project.analysis(path)).every
    symbols = [o.symbol for o in every if o.symbol.name not in VOCABULARY]
    if not symbols:
        return
    symbol = chance.choice(symbols)
    try:
        there = renamed(project, symbol, "quite_new", path)
    except Refusal:
        return
    assert symbol.kind not in (SymbolKind.UNIT, SymbolKind.FILE, SymbolKind.BUILDER)
    after = _replaced(text, there)
    other = Project()
    other.open(URI, after)
    if len(other.analysis(path).errors) < len(project.analysis(path).errors):
        # The old name was a fault, and is not given back.
        return
    again = [o.symbol for o in occurrences(other.analysis(path)).every if o.sure]
    new = next(s for s in again if s.name == "quite_new")
    assert _replaced(after, renamed(other, new, symbol.name, path)) == text


def _replaced(text: str, replacements: Iterable[Replacement]) -> str:
    for one in sorted(replacements, key=lambda r: r.span, reverse=True):
        text = text[: one.span.start] + one.text + text[one.span.end :]
    return text


@given(st.text(st.sampled_from("a😀é\n\r\u2028\t"), max_size=30), st.data())
def test_positions_and_places_are_each_others_inverse(text: str, data: st.DataObject) -> None:
    lines = EditorText(text, data.draw(st.sampled_from(["utf-8", "utf-16", "utf-32"])))
    offset = data.draw(st.integers(0, len(text)))
    in_line_end = text[offset - 1 : offset + 1] == "\r\n"
    assert lines.offset(lines.position(offset)) == offset - in_line_end


@given(st.text(st.sampled_from("a😀\n\r"), max_size=20), st.data())
def test_a_change_replaces_what_its_range_says(text: str, data: st.DataObject) -> None:
    lines = EditorText(text)
    start = data.draw(st.integers(0, len(text)))
    end = data.draw(st.integers(start, len(text)))
    change = lsp.TextDocumentContentChangePartial(
        lsp.Range(lines.position(start), lines.position(end)), "new"
    )
    start, end = lines.offset(change.range.start), lines.offset(change.range.end)
    assert lines.changed(change).text == text[:start] + "new" + text[end:]


@pytest.mark.parametrize(
    ("line", "column", "offset"), [(0, 99, 2), (9, 0, 7), (1, 1, 4), (1, 2, 4), (1, 3, 5)]
)
def test_places_beyond_a_line_or_the_text_are_its_end(line: int, column: int, offset: int) -> None:
    # The second half of a letter of two units is behind it.
    assert EditorText("ab\n😀cd\n").offset(lsp.Position(line, column)) == offset


def test_files_of_folders_are_searched_and_hidden_ones_are_not(tmp_path: Path) -> None:
    for name in ("a.model", "deep/b.model", ".hidden/c.model", "d.txt"):
        file = tmp_path / name
        file.parent.mkdir(exist_ok=True)
        file.write_text("model board\n")
    (tmp_path / "deep" / "no-text.model").write_bytes(b"board \xff")
    project = Project(folders=(tmp_path,))
    found = [
        path.relative_to(tmp_path).as_posix() for path in project.find_files_with_word("board")
    ]
    assert found == ["a.model", "deep/b.model"]
