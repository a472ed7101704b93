"""Model text into its syntax tree, with all faults of the text at once."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Generic, TypeVar

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from facetlog.grammar import syntax as s
from facetlog.grammar.faults import MOST_FAULTS, Fault, Severity
from facetlog.grammar.reading.lalr import NotParsed, TableParser
from facetlog.grammar.reading.layout import Layout, Statement, laid_out, pieces
from facetlog.grammar.reading.tree import TreeToSyntax
from facetlog.grammar.reading.unexpected import Parsing, explained
from facetlog.grammar.source import Source, Span

__all__ = ["GRAMMAR", "LARGEST", "Parsed", "forget", "parse", "statement_trees"]

GRAMMAR = Path(__file__).parents[1] / "model.lark"

LARGEST = 4_000_000
"""Characters of a file: some thousand models. Larger files are no models and are not read."""

DEEPEST = 60
"""Expressions within expressions; what is deeper no person wrote."""

MOST_STATEMENTS = 20_000
MOST_PIECES = 500
"""What is kept of what was read, some 40 MB: the statements of five hundred models."""

LONGEST = 4000
"""Words and signs of one statement."""


T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Parsed:
    """A file as far as it could be read, and what is wrong with its text."""

    file: s.File
    faults: tuple[Fault, ...]


@cache
def _parser() -> TableParser:
    return TableParser(_tree_parser(), TreeToSyntax())


@cache
def _tree_parser() -> Lark:
    grammar = GRAMMAR.read_text(encoding="utf-8")
    return Lark(grammar, parser="lalr", maybe_placeholders=True)


def parse(source: Source) -> Parsed:
    """The syntax tree of a text; a faulty statement is left out, with a fault."""
    if len(source.text) > LARGEST:
        size = f"{len(source.text) / 1e6:.1f} million characters"
        message = f"a model file of {size} is not read: {LARGEST / 1e6:.0f} million at most"
        fault = Fault("too-large", message, source, Span(0, 0), "cut it into several files")
        return Parsed(s.File(source, (), (), ()), (fault,))
    faults: list[Fault] = []
    found: list[object] = []
    comments: list[s.Comment] = []
    for span in pieces(source.text):
        text = source.text[span.start : span.end]
        piece = _PIECES.take(text, source.name, span.start)
        if piece is None:
            before = len(faults)
            piece = _read_anew(source, span, faults)
            if len(faults) == before:
                _PIECES.keep(text, source.name, span.start, piece)
        found += piece.nodes
        comments += piece.comments
    if not found and not faults:
        hint = "begin with `model NAME`"
        message = "the file has no model"
        faults.append(Fault("empty-file", message, source, Span(0, 0), hint, Severity.WARNING))
    file = _file(source, tuple(comments), found, faults)
    return Parsed(file, tuple(sorted(faults, key=_order)))


@dataclass(frozen=True, slots=True)
class _Piece:
    """The statements and comments of a piece of a text."""

    nodes: tuple[object, ...]
    comments: tuple[s.Comment, ...]


def _read_anew(source: Source, span: Span, faults: list[Fault]) -> _Piece:
    layout = laid_out(source, span)
    faults.extend(layout.faults[: max(0, MOST_FAULTS - len(faults))])
    return _Piece(tuple(_statements(source, layout, faults)), layout.comments)


def _piece_moved(piece: _Piece, by: int) -> _Piece:
    nodes = tuple(s.moved(node, by) for node in piece.nodes)
    return _Piece(nodes, tuple(s.moved(comment, by) for comment in piece.comments))


def statement_trees(source: Source) -> Iterator[Tree[Token]]:
    """The trees of the statements that can be read, as the grammar names their rules."""
    for statement in laid_out(source).statements:
        try:
            tree = _tree_parser().parse(statement.text(source.text))
        except UnexpectedInput:
            continue
        yield tree


def _order(fault: Fault) -> tuple[int, int]:
    return fault.span.start, fault.span.end


def _statements(source: Source, layout: Layout, faults: list[Fault]) -> Iterator[object]:
    for statement in layout.statements:
        if len(faults) >= MOST_FAULTS:
            return
        if not statement.whole:
            # Its brackets or texts have a fault already.
            continue
        if len(statement.tokens) > LONGEST:
            faults.append(_too_deep(source, statement.span, "this statement is too long"))
            continue
        node = _parsed(source, statement, faults)
        if node is not None:
            yield node


@dataclass(slots=True)
class _Known(Generic[T]):
    """What was read before, by its text, with the file and place of the last.

    `moved` makes a copy of it that stands elsewhere.
    """

    most: int
    moved: Callable[[T, int], T]
    found: dict[str, tuple[T, str, int]] = field(default_factory=dict)

    def take(self, text: str, name: str, start: int) -> T | None:
        """What would be read there; None if it was not read before.

        No node stands in two places: some are compared by identity.
        """
        known = self.found.get(text)
        if known is None:
            return None
        node, before, at = known
        if (before, at) != (name, start):
            node = self.moved(node, start - at)
            self.found[text] = node, name, start
        return node

    def keep(self, text: str, name: str, start: int, node: T) -> None:
        """Keeps what was read, and forgets all else where it is too much."""
        if len(self.found) >= self.most:
            self.found.clear()
        self.found[text] = node, name, start


_STATEMENTS: _Known[object] = _Known(MOST_STATEMENTS, s.moved)
_PIECES: _Known[_Piece] = _Known(MOST_PIECES, _piece_moved)


def forget() -> None:
    """Forgets what was read before, so that all is read anew: for measurements and tests."""
    _STATEMENTS.found.clear()
    _PIECES.found.clear()


def _parsed(source: Source, statement: Statement, faults: list[Fault]) -> object:
    start, end = statement.span
    text = source.text[start:end]
    node = _STATEMENTS.take(text, source.name, start)
    if node is None:
        node = _parsed_anew(source, statement, faults)
        if node is not None:
            _STATEMENTS.keep(text, source.name, start, node)
    return node


def _parsed_anew(source: Source, statement: Statement, faults: list[Fault]) -> object:
    try:
        node: object = _parser().parse(statement.tokens)
    except NotParsed:
        faults.append(explained(source, statement, _reach))
        return None
    if len(statement.tokens) > DEEPEST and _depth(node) > DEEPEST:
        faults.append(_too_deep(source, statement.span, "this statement is nested too deeply"))
        return None
    # The first word of a statement, which names its rule, belongs to it.
    return node if isinstance(node, s.Model | s.Text) else replace(node, span=statement.span)  # type: ignore[type-var]


def _too_deep(source: Source, span: Span, message: str) -> Fault:
    return Fault("too-deep", message, source, span, "use `define` and `let` for its parts")


def _reach(text: str) -> Parsing:
    """How far a statement's text can be read, and which words may follow there."""
    try:
        _tree_parser().parse(text)
    except UnexpectedToken as error:
        at = len(text) if error.token.type == "$END" else error.token.start_pos or 0
        return Parsing(at, frozenset(error.accepts or error.expected))
    except UnexpectedCharacters as error:
        return Parsing(error.pos_in_stream or 0, frozenset(error.allowed or ()))
    return Parsing(len(text) + 1, frozenset())


def _depth(node: object) -> int:
    deepest, waiting = 0, [(node, 1)]
    while waiting:
        one, depth = waiting.pop()
        deepest = max(deepest, depth)
        waiting.extend((child, depth + 1) for child in s.children(one))
    return deepest


# ------------------------------------------------------------------ assembly


def _file(
    source: Source, comments: tuple[s.Comment, ...], found: list[object], faults: list[Fault]
) -> s.File:
    first: list[s.Statement] = []
    models: list[s.Model] = []
    statements: list[s.Statement] = []

    def finish() -> None:
        if models:
            models[-1] = replace(models[-1], statements=tuple(statements))

    for node in found:
        match node:
            case s.Model():
                finish()
                models.append(node)
                statements = []
            case s.Text():
                if models and not statements and models[-1].doc is None:
                    models[-1] = replace(models[-1], doc=node)
                else:
                    message = "a text alone says what a model is"
                    hint = "it stands once, right after the line with `model`"
                    faults.append(Fault("stray-text", message, source, node.span, hint))
            case _:
                target = statements if models else first
                if not models and not isinstance(node, (s.Use, s.Let, s.Define)):
                    faults.append(_no_model(source, node))
                else:
                    target.append(node)  # type: ignore[arg-type]
    finish()
    return s.File(source, tuple(first), tuple(models), comments)


def _no_model(source: Source, node: object) -> Fault:
    message = "this stands before the first model: only `use`, `let` and `define` may"
    return Fault("no-model", message, source, node.span, "begin with `model NAME`")  # type: ignore[attr-defined]
