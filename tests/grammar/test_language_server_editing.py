"""The language server while a model is written: fixes, colours, calls, folds, faulty requests."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from lsprotocol import types as lsp

from facetlog.grammar.language_server.code_actions import code_actions, fix_all
from facetlog.grammar.language_server.folding import folds
from facetlog.grammar.language_server.positions import EditorText
from facetlog.grammar.language_server.project import Project
from facetlog.grammar.language_server.semantic_tokens import LEGEND, semantic_tokens
from facetlog.grammar.language_server.signature_help import signature_help
from facetlog.grammar.source import Source, Span
from facetlog.grammar.units import Dimension
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
    return code_actions(project.analysis(path), project.faults(path), project.text(path), URI, span)


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


def test_names_have_colours() -> None:
    project, path = _project(MODEL)
    data = semantic_tokens(project.symbols(path), project.text(path), path)
    found: dict[tuple[str, str], int] = {}
    line = column = 0
    for down, right, length, colour, marks in zip(*[iter(data)] * 5, strict=True):
        line, column = line + down, right if down else column + right
        word = MODEL.splitlines()[line][column : column + length]
        found.setdefault((word, LEGEND.token_types[colour]), marks)
    assert found["board", "class"] == 1
    assert found["flat", "function"] == 1
    assert found["f", "parameter"] == 1
    assert found["top", "variable"] == 1
    assert found["adjoins", "method"] == 2
    assert ("cuboid", "type") in found


@pytest.mark.parametrize(
    ("line", "label", "active"),
    [
        ("  angle(", "angle(face/piece, face/piece): angle", 0),
        ("  angle(top, ", "angle(face/piece, face/piece): angle", 1),
        ("  2 * (angle(top, side) + height(", "height(edge/face/opening/piece/thing): length", 0),
        ("  flat(top, ", "flat(f, g)", 1),
        ('  example "y" of cuboid(width 3 cm, ', "cuboid(width, depth)", 1),
    ],
)
def test_calls_are_explained_while_they_are_written(line: str, label: str, active: int) -> None:
    text = MODEL.replace("  tilt(top) at most 5 degs", line)
    project, path = _project(text)
    offset = text.index(line) + len(line)
    builders = {"cuboid": dict.fromkeys(("width", "depth"), Dimension.LENGTH)}
    found = signature_help(project.analysis(path), text, offset, builders)
    assert found is not None
    assert (found.signatures[0].label, found.active_parameter) == (label, active)


def test_outside_of_calls_nothing_is_explained() -> None:
    project, path = _project(MODEL)
    for place in ("face top", "A level", "(top) at most"):
        offset = MODEL.index(place)
        assert signature_help(project.analysis(path), MODEL, offset, {}) is None


def test_models_statements_and_comments_fold() -> None:
    found = [(fold.start_line, fold.end_line, fold.kind) for fold in folds(Source("", MODEL))]
    assert found == [(0, 1, lsp.FoldingRangeKind.Comment), (2, 9, None), (6, 7, None)]


# ------------------------------------------------------------ over the wire


@pytest.fixture(scope="module")
def editor(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Editor]:
    with Editor(tmp_path_factory.mktemp("models")) as opened:
        opened.open("m.model", MODEL)
        yield opened


def _document(editor: Editor) -> dict[str, Any]:
    return {"textDocument": {"uri": editor.uri("m.model")}}


def test_the_server_says_what_it_can(editor: Editor) -> None:
    for name in ("codeAction", "semanticTokens", "signatureHelp", "foldingRange"):
        assert editor.capabilities[f"{name}Provider"]


def test_an_editor_is_answered(editor: Editor) -> None:
    place = {"line": 8, "character": 23}
    asked = {**_document(editor), "range": {"start": place, "end": place}}
    found = editor.ask("textDocument/codeAction", {**asked, "context": {"diagnostics": []}})
    assert [one["title"] for one in found] == ["write `deg`"]
    only = {"diagnostics": [], "only": ["source"]}
    found = editor.ask("textDocument/codeAction", {**asked, "context": only})
    assert [one["kind"] for one in found] == ["source.fixAll"]
    assert editor.ask("textDocument/semanticTokens/full", _document(editor))["data"]
    assert len(editor.ask("textDocument/foldingRange", _document(editor))) == 3
    found = editor.at("signatureHelp", "m.model", 8, 7)
    assert found["signatures"][0]["label"].startswith("tilt(")


def _given(editor: Editor, name: str, how: str = "full", **more: object) -> Any:
    document = {"textDocument": {"uri": editor.uri(name)}}
    return editor.ask(f"textDocument/semanticTokens/{how}", {**document, **more})


def test_an_editor_is_given_only_the_colours_that_are_new(editor: Editor) -> None:
    editor.open("colours.model", MODEL)
    before = _given(editor, "colours.model")
    numbers, name = list(before["data"]), before["resultId"]
    for text in (MODEL, f"\n\n{MODEL}", MODEL + "\nmodel more\n  face it\n", MODEL, ""):
        editor.change("colours.model", {"text": text})
        delta = _given(editor, "colours.model", "full/delta", previousResultId=name)
        for edit in delta["edits"]:
            start = edit["start"]
            numbers[start : start + edit["deleteCount"]] = edit.get("data", [])
        name = delta["resultId"]
        assert numbers == _given(editor, "colours.model", "full")["data"]
        name = _given(editor, "colours.model", "full/delta", previousResultId="forgotten")
        assert name["data"] == numbers
        name = name["resultId"]


def test_colours_of_a_piece_are_those_of_the_whole_that_stand_there(editor: Editor) -> None:
    editor.open("piece.model", MODEL)
    lines = range(MODEL.count("\n") + 1)
    together: list[list[int]] = []
    for line in lines:
        piece = {"start": {"line": line, "character": 0}, "end": {"line": line, "character": 999}}
        data = _given(editor, "piece.model", "range", range=piece)["data"]
        column = 0
        for i in range(0, len(data), 5):
            column += data[i + 1]
            together.append([data[i] if i == 0 else line, column, *data[i + 2 : i + 5]])
    whole, line, column = [], 0, 0
    data = _given(editor, "piece.model")["data"]
    for i in range(0, len(data), 5):
        column = data[i + 1] if data[i] else column + data[i + 1]
        line += data[i]
        whole.append([line, column, *data[i + 2 : i + 5]])
    assert together == whole


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
