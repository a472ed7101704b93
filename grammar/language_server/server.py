"""The server: each request of the protocol, and the module that answers it."""

import asyncio
from collections.abc import Iterable, Iterator, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lsprotocol import types as lsp
from pygls.exceptions import (
    JsonRpcException,
    JsonRpcInvalidParams,
    JsonRpcInvalidRequest,
    JsonRpcParseError,
    JsonRpcServerNotInitialized,
)
from pygls.lsp.server import LanguageServer
from pygls.protocol.language_server import LanguageServerProtocol, lsp_method
from pygls.uris import to_fs_path

from facetlog.grammar import syntax as s
from facetlog.grammar.example_scenes import Builders
from facetlog.grammar.format import formatted
from facetlog.grammar.language_server.completion import TRIGGERS, completions
from facetlog.grammar.language_server.hover import find_hover_text, limit_text
from facetlog.grammar.language_server.project import (
    KINDS,
    EditorText,
    Project,
    diagnostics,
    fix_all,
    get_path,
    list_code_actions,
)
from facetlog.grammar.language_server.rename import Refusal, explain_fixed_name, references, renamed
from facetlog.grammar.language_server.symbols import Occurrence
from facetlog.grammar.limits import limit_at
from facetlog.grammar.source import Source, Span

if TYPE_CHECKING:
    from pygls.server import ServerErrors


class Protocol(LanguageServerProtocol):
    """The library's protocol, where it falls short.

    It keeps changed texts itself, breaks lines where the protocol does not (U+2028, form feed), and
    clips the ranges of a change in place, so that no handler sees what was sent: texts are kept by
    `Project` alone. And it drops requests that it cannot read, so that editors wait, and answers
    those that come before `initialize`.
    """

    @lsp_method(lsp.TEXT_DOCUMENT_DID_CHANGE)
    def lsp_text_document__did_change(
        self, params: lsp.DidChangeTextDocumentParams
    ) -> Iterator[object]:
        """Hand the change on."""
        yield self.fm.features[lsp.TEXT_DOCUMENT_DID_CHANGE], (params,), None

    def structure_message(self, data: dict[str, Any]) -> Any:
        """Return the data as it is: it is called for objects within messages, too."""
        return data

    def handle_message(self, message: Any) -> None:
        """Give a message to its handler, or says why it is refused."""
        try:
            self._refuse_misplaced(message)
            structured = self._parse_message(message)
        except JsonRpcException as refusal:
            self._refuse(refusal, message)
        else:
            super().handle_message(structured)

    def refuse_unreadable(self) -> None:
        """Answer what is no JSON: nobody knows which request it was."""
        self._send_error(None, JsonRpcParseError())

    def _parse_message(self, message: dict[str, Any]) -> Any:
        try:
            return super().structure_message(message)
        except JsonRpcException as error:
            raise JsonRpcInvalidParams from error

    def _refuse_misplaced(self, message: Any) -> None:
        """Raise what a message is answered with if it is none, or none for now."""
        if not isinstance(message, dict) or message.get("jsonrpc") != self.VERSION:
            raise JsonRpcInvalidRequest
        if "method" not in message:
            return  # the editor's answer to a request of ours
        method = message["method"]
        is_request = "id" in message
        if not isinstance(method, str) or (is_request and not _is_number(message["id"])):
            raise JsonRpcInvalidRequest
        if method == lsp.EXIT:
            return
        is_open = self._workspace is not None
        if self._shutdown or (is_open and method == lsp.INITIALIZE):
            raise JsonRpcInvalidRequest
        if not is_open and method != lsp.INITIALIZE:
            raise JsonRpcServerNotInitialized
        if is_request:
            self._get_handler(method)  # JsonRpcMethodNotFound if there is none

    def _refuse(self, refusal: JsonRpcException, message: Any) -> None:
        """Answer a request with an error; a notification and an answer get none."""
        data = message if isinstance(message, dict) else {"id": None, "method": None}
        if "id" in data and "method" in data:
            number = data["id"] if _is_number(data["id"]) else None
            self._send_error(number, refusal)

    def _send_error(self, number: int | str | None, error: JsonRpcException) -> None:
        # The library leaves a number out that is null; the protocol wants it.
        answer = {"jsonrpc": self.VERSION, "id": number, "error": error.to_response_error()}
        self._send_data(answer)


def _is_number(number: object) -> bool:
    """Return whether a request may have this number: the protocol allows texts, too."""
    return isinstance(number, int | str)


_KINDS = lsp.SymbolKind

LONGEST_NAME = 60
"""Letters of a line that has no label, as an outline shows it."""


def outline(file: s.File, text: EditorText) -> list[lsp.DocumentSymbol]:
    """Return the constants and definitions before the first model, and the models with what they
    hold.
    """
    found = list(_iter_symbols(file.statements, text))
    for i, model in enumerate(file.models):
        following = file.models[i + 1].span.start if i + 1 < len(file.models) else len(text.text)
        end = max([model.span.end, *(x.span.end for x in model.statements)])
        if model.doc is not None:
            end = max(end, model.doc.span.end)
        span = Span(text.text.rfind("\n", 0, model.span.start) + 1, min(end, following))
        found.append(
            lsp.DocumentSymbol(
                model.name.text,
                _KINDS.Class,
                text.range(span),
                text.range(model.name.span),
                detail="" if model.parent is None else f"{model.ancestry} {model.parent}",
                children=list(_iter_symbols(model.statements, text)),
            )
        )
    return found


def _iter_symbols(
    statements: Iterable[s.Statement], text: EditorText
) -> Iterator[lsp.DocumentSymbol]:
    for statement in statements:
        for name, kind, span in _named(statement, text):
            whole = text.range(Span(min(statement.span.start, span.start), statement.span.end))
            yield lsp.DocumentSymbol(name, kind, whole, text.range(span))


def _named(statement: s.Statement, text: EditorText) -> Iterator[tuple[str, lsp.SymbolKind, Span]]:
    match statement:
        case s.Part(names=names):
            for name in names:
                yield name.text, _KINDS.Field, name.span
        case s.Let(name=name):
            yield name.text, _KINDS.Constant, name.span
        case s.Define(name=name):
            yield name.text, _KINDS.Function, name.span
        case s.Line(label=label) if label is not None:
            yield label.text, _KINDS.Property, label.span
        case s.Line(span=span):
            words = " ".join(text.text[span.start : span.end].split())
            short = words if len(words) <= LONGEST_NAME else words[: LONGEST_NAME - 1] + "…"
            yield short, _KINDS.Property, span
        case s.Example(title=title):
            yield title.value.strip() or "example", _KINDS.Event, title.span
        case _:
            pass


PAUSE_S = 0.15
"""Seconds without typing after which faults are sent: shorter than a person pauses to look."""

REFUSED = -32803
"""RequestFailed of the protocol: the request was understood and cannot be fulfilled."""


class ModelServer(LanguageServer):
    """A server with the texts of one editor."""

    protocol: Protocol

    def __init__(self, builders: Builders) -> None:
        super().__init__("facetlog-model", _get_version(), protocol_cls=Protocol)
        self.builders = builders
        self.project = Project(builders=builders)
        self._waiting: asyncio.TimerHandle | None = None
        self._published: set[Path] = set()

    def publish_soon(self, delay: float = PAUSE_S) -> None:
        """Send the faults of all open files after a pause; restart a pause that has begun."""
        if self._waiting is not None:
            self._waiting.cancel()
        self._waiting = asyncio.get_running_loop().call_later(delay, self._publish_all)

    def _publish_all(self) -> None:
        self._waiting = None
        for path in self.project.open_models:
            self._publish(path, diagnostics(self.project, path))
        for path in self._published - set(self.project.open_models):
            self._publish(path, [])
        self._published = set(self.project.open_models)

    def report_server_error(self, error: Exception, source: "ServerErrors") -> None:
        """Answer what is no JSON; shows the editor's user anything else that went wrong."""
        if isinstance(error, ValueError | RecursionError) and source is JsonRpcException:
            self.protocol.refuse_unreadable()
        else:
            super().report_server_error(error, source)

    def _publish(self, path: Path, found: list[lsp.Diagnostic]) -> None:
        self.text_document_publish_diagnostics(
            lsp.PublishDiagnosticsParams(self.project.uri(path), found)
        )

    def at(
        self, document: lsp.TextDocumentIdentifier, position: lsp.Position
    ) -> tuple[Path, Occurrence | None]:
        """Return the file, and the symbol at a position of it."""
        path = get_path(document.uri)
        offset = self.project.text(path).offset(position)
        return path, self.project.symbols(path).at(offset)

    def location(self, path: Path, one: Occurrence) -> lsp.Location:
        """Return where a symbol stands."""
        return lsp.Location(self.project.uri(path), self.project.text(path).range(one.span))


def build_model_server(builders: Builders) -> ModelServer:
    """Return a server that is ready to be started; `builders` are the things that examples can
    build.
    """
    server = ModelServer(builders)
    _serve_texts(server)
    _serve_questions(server)
    _serve_names(server)
    return server


def _get_version() -> str:
    try:
        return version("facetlog")
    except PackageNotFoundError:
        return "0"


# -------------------------------------------------------------------- texts


def _serve_texts(server: ModelServer) -> None:
    project = server.project

    @server.feature(lsp.INITIALIZED)
    def initialized(_: lsp.InitializedParams) -> None:
        encoding = server.server_capabilities.position_encoding
        if encoding is not None:
            project.encoding = encoding.value if hasattr(encoding, "value") else str(encoding)
        on_folders_changed(None)

    @server.feature(lsp.WORKSPACE_DID_CHANGE_WORKSPACE_FOLDERS)
    def on_folders_changed(_: lsp.DidChangeWorkspaceFoldersParams | None) -> None:
        uris = [*server.workspace.folders] or [server.workspace.root_uri or ""]
        paths = [to_fs_path(uri) for uri in uris]
        project.folders = tuple(Path(path) for path in paths if path)

    @server.feature(lsp.TEXT_DOCUMENT_DID_OPEN)
    def opened(params: lsp.DidOpenTextDocumentParams) -> None:
        project.open(params.text_document.uri, params.text_document.text)
        server.publish_soon(0)

    @server.feature(lsp.TEXT_DOCUMENT_DID_CHANGE)
    def changed(params: lsp.DidChangeTextDocumentParams) -> None:
        project.change(params.text_document.uri, params.content_changes)
        server.publish_soon()

    @server.feature(lsp.TEXT_DOCUMENT_DID_CLOSE)
    def closed(params: lsp.DidCloseTextDocumentParams) -> None:
        project.close(params.text_document.uri)
        server.publish_soon()

    @server.feature(lsp.TEXT_DOCUMENT_DID_SAVE)
    @server.feature(lsp.WORKSPACE_DID_CHANGE_WATCHED_FILES)
    def on_files_changed(_: object) -> None:
        project.forget()
        server.publish_soon()

    @server.feature(lsp.TEXT_DOCUMENT_FORMATTING)
    def formatting(params: lsp.DocumentFormattingParams) -> list[lsp.TextEdit]:
        text = project.text(get_path(params.text_document.uri))
        after = formatted(Source("", text.text))
        return [] if after == text.text else [lsp.TextEdit(text.whole(), after)]


# ---------------------------------------------------------------- questions


def _serve_questions(server: ModelServer) -> None:
    project = server.project

    @server.feature(
        lsp.TEXT_DOCUMENT_COMPLETION, lsp.CompletionOptions(trigger_characters=list(TRIGGERS))
    )
    def complete(params: lsp.CompletionParams) -> lsp.CompletionList:
        path = get_path(params.text_document.uri)
        text = project.text(path)
        offset = text.offset(params.position)
        items = completions(project.analysis(path), text.text, offset, server.builders)
        return lsp.CompletionList(is_incomplete=False, items=items)

    @server.feature(lsp.TEXT_DOCUMENT_HOVER)
    def hover(params: lsp.HoverParams) -> lsp.Hover | None:
        path, one = server.at(params.text_document, params.position)
        analysis, text = project.analysis(path), project.text(path)
        limit = limit_at(analysis, text.offset(params.position))
        said = [] if one is None else [find_hover_text(analysis, one.symbol, server.builders)]
        said += [] if limit is None else [limit_text(limit)]
        span = one.span if one is not None else limit.node.span if limit is not None else None
        if span is None or not any(said):
            return None
        value = "\n\n".join(filter(None, said))
        return lsp.Hover(lsp.MarkupContent(lsp.MarkupKind.Markdown, value), text.range(span))

    @server.feature(lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
    def symbols(params: lsp.DocumentSymbolParams) -> list[lsp.DocumentSymbol]:
        path = get_path(params.text_document.uri)
        return outline(project.analysis(path).file, project.text(path))

    @server.feature(
        lsp.TEXT_DOCUMENT_CODE_ACTION, lsp.CodeActionOptions(code_action_kinds=list(KINDS))
    )
    def actions(params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
        path, uri = get_path(params.text_document.uri), params.text_document.uri
        text = project.text(path)
        span = Span(text.offset(params.range.start), text.offset(params.range.end))
        wanted = params.context.only
        found: list[lsp.CodeAction] = []
        if wanted is None or _is_of(lsp.CodeActionKind.QuickFix, wanted):
            found += list_code_actions(
                project.analysis(path), project.faults(path), text, uri, span
            )
        # It costs a look after each fix: done on demand, not at each step of the cursor.
        if wanted is not None and _is_of(lsp.CodeActionKind.SourceFixAll, wanted):
            found += fix_all(text, uri, project.check_of(path))
        return found


def _is_of(own: lsp.CodeActionKind, kinds: Sequence[lsp.CodeActionKind | str]) -> bool:
    """Return whether a kind is of one of some kinds: `source.fixAll` is of `source`, too."""
    wanted = [str(getattr(kind, "value", kind)) for kind in kinds]
    return any(own == kind or not kind or own.startswith(f"{kind}.") for kind in wanted)


# -------------------------------------------------------------------- names


def _serve_names(server: ModelServer) -> None:
    project = server.project

    @server.feature(lsp.TEXT_DOCUMENT_DEFINITION)
    def definition(params: lsp.DefinitionParams) -> lsp.Location | None:
        _, one = server.at(params.text_document, params.position)
        if one is None or one.symbol.home is None:
            return None
        home = one.symbol.home
        return lsp.Location(project.uri(home.path), project.text(home.path).range(home.span))

    @server.feature(lsp.TEXT_DOCUMENT_REFERENCES)
    def find_references(params: lsp.ReferenceParams) -> list[lsp.Location]:
        path, one = server.at(params.text_document, params.position)
        if one is None:
            return []
        found = references(project, one.symbol, path)
        wanted = params.context.include_declaration
        home = one.symbol.home
        return [
            server.location(where, other)
            for where, other in found
            if wanted or home is None or (where, other.span) != (home.path, home.span)
        ]

    @server.feature(lsp.TEXT_DOCUMENT_PREPARE_RENAME)
    def prepare_rename(params: lsp.PrepareRenameParams) -> lsp.Range:
        path, one = server.at(params.text_document, params.position)
        fixed = "there is no name here" if one is None else explain_fixed_name(one.symbol)
        if one is None or fixed:
            raise JsonRpcException(fixed, REFUSED)
        return project.text(path).range(one.span)

    @server.feature(lsp.TEXT_DOCUMENT_RENAME, lsp.RenameOptions(prepare_provider=True))
    def rename(params: lsp.RenameParams) -> lsp.WorkspaceEdit:
        path, one = server.at(params.text_document, params.position)
        if one is None:
            raise JsonRpcException("there is no name here", REFUSED)
        try:
            found = renamed(project, one.symbol, params.new_name, path)
        except Refusal as refusal:
            raise JsonRpcException(str(refusal), REFUSED) from None
        changes: dict[str, list[lsp.TextEdit]] = {}
        for r in found:
            edit = lsp.TextEdit(project.text(r.path).range(r.span), r.text)
            changes.setdefault(project.uri(r.path), []).append(edit)
        return lsp.WorkspaceEdit(changes=changes)
