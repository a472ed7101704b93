"""The language server while a model is written: fixes, allowed warnings, faulty requests."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from lsprotocol import types as lsp

from facetlog.grammar.language_server.project import EditorText, Project, fix_all, list_code_actions
from facetlog.grammar.source import Span
from tests.grammar.editor import Editor, RequestRefused

URI = "file:///nowhere/m.model"

MODEL = """\
# A board
# that lies.
model board
  "A level board."
  define flat(f, g): f is level, f adjoins g   "flat beside another"
  face top, side
  ok: top is level, flat(top, side),
      top adjoins side
  tilt(top) at most 5 degs
  example "x" of cuboid(width 70 cm) holds

model other is board
"""


def _project(text: str) -> tuple[Project, Path]:
    project = Project()
    return project, project.open(URI, text)


def _after(text: str, action: lsp.CodeAction) -> str:
    assert action.edit is not None
    assert action.edit.changes is not None
    editor = EditorText(text)
    (edits,) = action.edit.changes.values()
    for edit in sorted(edits, key=lambda e: editor.offset(e.range.start), reverse=True):
        start, end = editor.offset(edit.range.start), editor.offset(edit.range.end)
        text = text[:start] + edit.new_text + text[end:]
    return text


def _actions(text: str, at: str) -> list[lsp.CodeAction]:
    project, path = _project(text)
    start = text.index(at)
    span = Span(start, start + len(at))
    return list_code_actions(
        project.analysis(path), project.faults(path), project.text(path), URI, span
    )


def test_a_fault_is_offered_its_fix() -> None:
    (first,) = _actions(MODEL, "degs")
    assert (first.title, first.kind, first.is_preferred) == ("write `deg`", "quickfix", True)
    assert "at most 5 deg\n" in _after(MODEL, first)


def test_all_that_is_sure_is_done_at_once_as_the_command_does_it() -> None:
    text = MODEL.replace("is level,", "is levl,")
    project, path = _project(text)
    (everything,) = fix_all(project.text(path), URI, project.check_of(path))
    assert everything.kind == lsp.CodeActionKind.SourceFixAll
    right = MODEL.replace("degs", "deg")
    assert _after(text, everything) == right
    assert fix_all(EditorText(right), URI, project.check_of(path)) == []


def test_a_warning_can_be_allowed() -> None:
    text = MODEL.replace("degs", "deg").replace("  face", "  let spare = 3\n  face")
    left_out, allowed = _actions(text, "spare")
    assert "spare" not in _after(text, left_out)
    assert "  let spare = 3  # lint: allow unused-constant\n" in _after(text, allowed)


# ------------------------------------------------------------ over the wire


@pytest.fixture(scope="module")
def editor(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Editor]:
    with Editor(tmp_path_factory.mktemp("models")) as opened:
        opened.open("m.model", MODEL)
        yield opened


def _document(editor: Editor) -> dict[str, Any]:
    return {"textDocument": {"uri": editor.uri("m.model")}}


def test_an_editor_is_answered(editor: Editor) -> None:
    place = {"line": 8, "character": 23}
    asked = {**_document(editor), "range": {"start": place, "end": place}}
    found = editor.ask("textDocument/codeAction", {**asked, "context": {"diagnostics": []}})
    assert [one["title"] for one in found] == ["write `deg`"]
    only = {"diagnostics": [], "only": ["source"]}
    found = editor.ask("textDocument/codeAction", {**asked, "context": only})
    assert [one["kind"] for one in found] == ["source.fixAll"]


NO_JSON, INVALID, UNKNOWN, PARAMETERS = -32700, -32600, -32601, -32602
TOO_EARLY = -32002
HOVER = "textDocument/hover"


@pytest.mark.parametrize(
    ("message", "code"),
    [
        ({"method": HOVER, "params": {}}, PARAMETERS),
        ({"method": HOVER, "params": {"textDocument": 3, "position": "here"}}, PARAMETERS),
        ({"method": "textDocument/completion", "params": [1, 2]}, PARAMETERS),
        ({"method": "textDocument/codeAction", "params": None}, PARAMETERS),
        ({"method": "textDocument/rename"}, PARAMETERS),
        ({"method": "textDocument/what", "params": {}}, UNKNOWN),
        ({"method": "textDocument/what"}, UNKNOWN),
        ({"method": "textDocument/what", "params": [{"jsonrpc": "2.0"}]}, UNKNOWN),
        # A request of the protocol that this server does not say it answers.
        ({"method": "textDocument/codeLens", "params": {"textDocument": 3}}, UNKNOWN),
        ({"method": "$/what", "params": {}}, UNKNOWN),
        ({"method": 7, "params": {}}, INVALID),
        ({"method": HOVER, "params": {}, "jsonrpc": "1.0"}, INVALID),
        ({"method": HOVER, "params": {}, "jsonrpc": None}, INVALID),
        ({"method": "initialize", "params": {"capabilities": {}, "processId": None}}, INVALID),
    ],
)
def test_every_faulty_request_is_refused(
    editor: Editor, message: dict[str, object], code: int
) -> None:
    with pytest.raises(RequestRefused) as refused:
        editor.ask_as(message)
    assert refused.value.code == code
    assert editor.at("hover", "m.model", 8, 3)["contents"]


@pytest.mark.parametrize(
    ("body", "code"),
    [
        (b"{nonsense", NO_JSON),
        (b'{"id": \xff}', NO_JSON),
        (b"[" * 100_000, NO_JSON),
        (b"[]", INVALID),
        (b"7", INVALID),
        (b'{"jsonrpc": "2.0", "id": null, "method": "textDocument/hover"}', INVALID),
        (b'{"jsonrpc": "2.0", "id": [1], "method": "textDocument/hover"}', INVALID),
    ],
)
def test_what_is_no_request_is_answered_without_a_number(
    editor: Editor, body: bytes, code: int
) -> None:
    editor.send_raw(body)
    with pytest.raises(RequestRefused) as refused:
        editor.answer(None)
    assert refused.value.code == code
    assert editor.at("hover", "m.model", 8, 3)["contents"]


def test_requests_come_after_the_beginning_and_before_the_shutdown(tmp_path: Path) -> None:
    opened = Editor(tmp_path, initialize=False)
    for method in (HOVER, "textDocument/what", "shutdown"):
        with pytest.raises(RequestRefused) as refused:
            opened.ask(method, {})
        assert refused.value.code == TOO_EARLY
    opened.initialize()
    opened.ask("shutdown", None)
    for method in (HOVER, "textDocument/what", "shutdown"):
        with pytest.raises(RequestRefused) as refused:
            opened.ask(method, {})
        assert refused.value.code == INVALID
    opened.tell("exit", None)
    opened.leave()
