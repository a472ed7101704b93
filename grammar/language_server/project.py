"""The files of an editor: open texts before those on disk, analyses, and faults with fixes."""

import os
import re
from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from lsprotocol import types as lsp
from pygls import uris

from facetlog.grammar import syntax as s
from facetlog.grammar.analysis import Analysis, analyse
from facetlog.grammar.checking.same_names import SameNames
from facetlog.grammar.example_scenes import Builders, find_all_faults
from facetlog.grammar.fault_codes import FAULT_KINDS
from facetlog.grammar.faults import Edit, Fault, Fix, Severity
from facetlog.grammar.fix_all import Check, fixed
from facetlog.grammar.language_server.symbols import Occurrences, occurrences
from facetlog.grammar.library import BUILTIN, read_text
from facetlog.grammar.lint.allowed import allow_fix
from facetlog.grammar.source import Span, find_changed_spans

UTF_16 = "utf-16"

# Line ends of the protocol: section "Text Documents" of its specification 3.17.
_LINE_END = re.compile(r"\r\n|\n|\r")


@dataclass(frozen=True, slots=True, eq=False)
class EditorText:
    """A text with its lines; `encoding` says in which units columns are counted."""

    text: str
    encoding: str = UTF_16
    _starts: list[int] = field(init=False, repr=False)
    _ends: list[int] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        ends = list(_LINE_END.finditer(self.text))
        object.__setattr__(self, "_starts", [0, *(match.end() for match in ends)])
        object.__setattr__(self, "_ends", [*(m.start() for m in ends), len(self.text)])

    def offset(self, position: lsp.Position) -> int:
        """Return the character at a position; past the end of a line or the text, that end.

        >>> EditorText("a\\n😀b").offset(lsp.Position(1, 2))
        3
        """
        if position.line >= len(self._starts):
            return len(self.text)
        at, end = self._starts[position.line], self._ends[position.line]
        left = position.character
        while at < end and left > 0:
            left -= self._count_units(self.text[at])
            at += 1
        return at

    def position(self, offset: int) -> lsp.Position:
        """Return the position of a character.

        >>> EditorText("a\\n😀b").position(3)
        1:2
        """
        offset = min(max(offset, 0), len(self.text))
        line = bisect_right(self._starts, offset) - 1
        before = self.text[self._starts[line] : min(offset, self._ends[line])]
        units = len(before) if before.isascii() else sum(map(self._count_units, before))
        return lsp.Position(line, units)

    def range(self, span: Span) -> lsp.Range:
        """Return the range of a span."""
        return lsp.Range(self.position(span.start), self.position(span.end))

    def whole(self) -> lsp.Range:
        """Return the range of all of the text."""
        return self.range(Span(0, len(self.text)))

    def changed(self, change: lsp.TextDocumentContentChangeEvent) -> "EditorText":
        """Return the text after a change of a piece, or of all of it."""
        text = change.text
        if isinstance(change, lsp.TextDocumentContentChangePartial):
            start, end = self.offset(change.range.start), self.offset(change.range.end)
            text = self.text[:start] + change.text + self.text[max(start, end) :]
        return EditorText(text, self.encoding)

    def _count_units(self, letter: str) -> int:
        if self.encoding == UTF_16:
            return 2 if ord(letter) > 0xFFFF else 1
        # Half of a surrogate pair has no UTF-8; it counts as the three bytes it would take.
        return len(letter.encode("utf-8", "surrogatepass")) if self.encoding == "utf-8" else 1


MOST_SEARCHED = 5000
"""Files and folders of the workspace that are looked at for models; who has more is in a home."""

ANALYSES = 50
"""Analyses that are kept until a text changes."""


@dataclass(slots=True)
class Project:
    """Open texts by path, the folders of the workspace, and analyses as long as nothing changes."""

    encoding: str = UTF_16
    builders: Builders = field(default_factory=dict)
    folders: tuple[Path, ...] = ()
    _open: dict[Path, EditorText] = field(default_factory=dict)
    _uris: dict[Path, str] = field(default_factory=dict)
    _analyses: dict[Path, Analysis] = field(default_factory=dict)
    _symbols: dict[Path, Occurrences] = field(default_factory=dict)
    _same_names: SameNames | None = None

    # ------------------------------------------------------------- texts

    def open(self, uri: str, text: str) -> Path:
        """Note that the editor opened a text; return its path."""
        path = get_path(uri)
        self._open[path] = EditorText(text, self.encoding)
        self._uris[path] = uri
        self.forget()
        return path

    def change(self, uri: str, changes: Iterable[lsp.TextDocumentContentChangeEvent]) -> Path:
        """Return the text as the changes leave it, one after the other; returns its path."""
        path = get_path(uri)
        text = self.text(path)
        for change in changes:
            text = text.changed(change)
        return self.open(uri, text.text)

    def close(self, uri: str) -> Path:
        """Forget the editor's text of a file, so that the one on disk counts; return its path."""
        path = get_path(uri)
        self._open.pop(path, None)
        self._uris.pop(path, None)
        self.forget()
        return path

    def forget(self) -> None:
        """Forget all results that depend on texts."""
        self._analyses.clear()
        self._symbols.clear()
        self._same_names = None

    @property
    def open_models(self) -> tuple[Path, ...]:
        """The model files that are open; a file without a name has no ending."""
        return tuple(path for path in self._open if path.suffix != ".pl")

    def uri(self, path: Path) -> str:
        """Return the editor's own name of a file."""
        return self._uris.get(path) or uris.from_fs_path(str(path)) or str(path)

    def read(self, path: Path) -> str:
        """Return the text of a file as the editor has it; OSError or ValueError if it cannot be
        read.
        """
        opened = self._open.get(path)
        return read_text(path) if opened is None else opened.text

    def text(self, path: Path) -> EditorText:
        """Return the text of a file with its lines; empty if it cannot be read."""
        opened = self._open.get(path)
        if opened is not None:
            return opened
        try:
            return EditorText(read_text(path), self.encoding)
        except (OSError, ValueError):
            return EditorText("", self.encoding)

    # ---------------------------------------------------------- analyses

    def analysis(self, path: Path) -> Analysis:
        """Return the analysis of a file, computed once for each state of the texts."""
        found = self._analyses.get(path)
        if found is None:
            if len(self._analyses) >= ANALYSES:
                self.forget()
            found = analyse(path, self.text(path).text, read=self.read)
            self._analyses[path] = found
        return found

    def faults(self, path: Path) -> tuple[Fault, ...]:
        """Return the faults of a file, as `model check` of all open files reports them."""
        analysis = self.analysis(path)
        if self._same_names is None:
            self._same_names = SameNames(self.read, self.open_models)
        return (*self._with_scenes(analysis), *self._same_names.faults(analysis))

    def _with_scenes(self, analysis: Analysis) -> tuple[Fault, ...]:
        return find_all_faults(analysis, self.builders) if self.builders else analysis.faults

    def check_of(self, path: Path) -> Callable[[str], tuple[Fault, ...]]:
        """Return the function that finds the faults of a file with another text."""
        return lambda text: self._with_scenes(analyse(path, text, read=self.read))

    def symbols(self, path: Path) -> Occurrences:
        """Return the symbols of a file; found once for each state of the texts."""
        found = self._symbols.get(path)
        if found is None:
            found = self._symbols[path] = occurrences(self.analysis(path))
        return found

    def find_files_with_word(self, word: str) -> Iterator[Path]:
        """Iterate over the model files, open, beside these or in the workspace, in whose text a
        word occurs.
        """
        folders = [*self.folders, *(path.parent for path in self._open if path.is_absolute())]
        seen = set(self._open)
        candidates = [*self._open]
        left = MOST_SEARCHED
        for folder in dict.fromkeys(folders):
            for path in _iter_model_files(folder, deep=folder in self.folders):
                if left <= 0:
                    break
                left -= 1
                if path.suffix == ".model" and path not in seen:
                    seen.add(path)
                    candidates.append(path)
        for path in candidates:
            if path.suffix != ".pl" and word in self.text(path).text:
                yield path


def get_path(uri: str) -> Path:
    """Return the path of a file; of a text that is no file, a path by its name alone."""
    return Path(uris.to_fs_path(uri) or uri.rpartition(":")[2].lstrip("/") or "untitled")


def is_builtin(path: Path) -> bool:
    """Return whether a file came with facetlog."""
    return BUILTIN in path.parents


def _iter_model_files(folder: Path, *, deep: bool) -> Iterator[Path]:
    """Iterate over all files of a folder, hidden folders left out; what cannot be read is passed
    over.
    """
    for base, folders, names in os.walk(folder):
        folders[:] = sorted(name for name in folders if deep and not name.startswith("."))
        yield from (Path(base, name) for name in sorted(names))


SOURCE = "facetlog"

_SEVERITIES = {
    Severity.ERROR: lsp.DiagnosticSeverity.Error,
    Severity.WARNING: lsp.DiagnosticSeverity.Warning,
}


def diagnostics(project: Project, path: Path) -> list[lsp.Diagnostic]:
    """Return the faults of a file; those of the files that it uses stand where it says `use`."""
    analysis = project.analysis(path)
    text = project.text(path)
    own = [fault for fault in project.faults(path) if fault.source.name == str(path)]
    return [diagnostic(fault, text) for fault in own] + list(
        _iter_of_others(project, analysis, text)
    )


def diagnostic(fault: Fault, text: EditorText) -> lsp.Diagnostic:
    """Return a fault of the text."""
    message = f"{fault.message}; {fault.hint}" if fault.hint else fault.message
    return lsp.Diagnostic(
        text.range(fault.span),
        message,
        severity=_SEVERITIES[fault.severity],
        code=fault.code,
        code_description=lsp.CodeDescription(FAULT_KINDS[fault.code].address),
        source=SOURCE,
    )


def _iter_of_others(
    project: Project, analysis: Analysis, text: EditorText
) -> Iterator[lsp.Diagnostic]:
    others: dict[str, list[Fault]] = {}
    for fault in analysis.errors:
        if fault.source.name != analysis.file.source.name:
            others.setdefault(fault.source.name, []).append(fault)
    for name, faults in others.items():
        first = faults[0]
        many = "1 fault" if len(faults) == 1 else f"{len(faults)} faults"
        there = project.text(Path(name)).range(first.span)
        place = lsp.Location(project.uri(Path(name)), there)
        yield lsp.Diagnostic(
            text.range(_use_of(analysis, name)),
            f"{Path(name).name} has {many}: {first.message}",
            severity=lsp.DiagnosticSeverity.Error,
            code=first.code,
            source=SOURCE,
            related_information=[lsp.DiagnosticRelatedInformation(place, first.message)],
        )


def _use_of(analysis: Analysis, name: str) -> Span:
    """Return where a file is used; if only by another, the first `use` that there is."""
    uses = analysis.file.uses
    base = Path(analysis.file.source.name).parent
    named: list[s.Use] = [u for u in uses if str(base / u.path.value) == name]
    return (named or list(uses))[0].path.span if uses else Span(0, 0)


KINDS = (lsp.CodeActionKind.QuickFix, lsp.CodeActionKind.SourceFixAll)


def list_code_actions(
    analysis: Analysis, faults: Iterable[Fault], text: EditorText, uri: str, span: Span
) -> list[lsp.CodeAction]:
    """Return fixes of the faults that touch a span, the likeliest first."""
    source = analysis.file.source
    own = [fault for fault in faults if fault.source is source]
    here = [f for f in own if f.span.start <= span.end and span.start <= f.span.end]
    found = [
        _make_action(fault, fix, text, uri)
        for fault in here
        for fix in _iter_fixes(fault, analysis)
    ]
    return sorted(found, key=lambda action: not action.is_preferred)


def fix_all(text: EditorText, uri: str, check: Check) -> list[lsp.CodeAction]:
    """Return all that is sure at once, as `model check --fix` does it; nothing if that is
    nothing."""
    after = fixed(text.text, check).text
    if after == text.text:
        return []
    kind = lsp.CodeActionKind.SourceFixAll
    old, new = find_changed_spans(text.text, after)
    edit = _make_edit([Edit(old, after[new.start : new.end])], text, uri)
    return [lsp.CodeAction("put right all that is sure", kind=kind, edit=edit)]


def _iter_fixes(fault: Fault, analysis: Analysis) -> Iterator[Fix]:
    yield from fault.fixes
    if fault.severity is Severity.WARNING:
        yield allow_fix(fault, analysis.file.comments)


def _make_action(fault: Fault, fix: Fix, text: EditorText, uri: str) -> lsp.CodeAction:
    return lsp.CodeAction(
        fix.title,
        kind=lsp.CodeActionKind.QuickFix,
        diagnostics=[diagnostic(fault, text)],
        is_preferred=fix.sure,
        edit=_make_edit(fix.edits, text, uri),
    )


def _make_edit(edits: Iterable[Edit], text: EditorText, uri: str) -> lsp.WorkspaceEdit:
    changes = [lsp.TextEdit(text.range(edit.span), edit.text) for edit in edits]
    return lsp.WorkspaceEdit(changes={uri: changes})
