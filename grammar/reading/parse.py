"""Model text into its syntax tree, with all faults of the text at once."""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from facetlog.grammar import syntax as s
from facetlog.grammar.faults import MOST_FAULTS, Fault, Severity
from facetlog.grammar.reading.layout import Layout, Statement, laid_out, pieces
from facetlog.grammar.reading.tree import TreeToSyntax
from facetlog.grammar.reading.unexpected import Parsing, explained
from facetlog.grammar.source import Source, Span

GRAMMAR = Path(__file__).parents[1] / "model.lark"

LARGEST = 4_000_000
"""Characters of a file: some thousand models. Larger files are no models and are not read."""

DEEPEST = 60
"""Expressions within expressions; what is deeper no person wrote."""

LONGEST = 4000
"""Words and signs of one statement."""


@dataclass(frozen=True, slots=True)
class Parsed:
    """A file as far as it could be read, and what is wrong with its text."""

    file: s.File
    faults: tuple[Fault, ...]


@cache
def statement_parser(*, trees: bool = False) -> Lark:
    """Return the parser of one statement, which makes syntax, or trees, as it reduces."""
    grammar, maker = GRAMMAR.read_text(encoding="utf-8"), None if trees else TreeToSyntax()
    return Lark(grammar, parser="lalr", maybe_placeholders=True, transformer=maker)


def statement_trees(source: Source) -> Iterator[Tree[Token]]:
    """Iterate over the trees of the statements that can be read, as the grammar names rules."""
    for statement in laid_out(source).statements:
        with suppress(UnexpectedInput):
            yield statement_parser(trees=True).parse(statement.text(source.text))


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
        layout = laid_out(source, span)
        faults.extend(layout.faults[: max(0, MOST_FAULTS - len(faults))])
        found += _statements(source, layout, faults)
        comments += layout.comments
    if not found and not faults:
        hint = "begin with `model NAME`"
        message = "the file has no model"
        faults.append(Fault("empty-file", message, source, Span(0, 0), hint, Severity.WARNING))
    file = _file(source, tuple(comments), found, faults)
    return Parsed(file, tuple(sorted(faults, key=_order)))


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
        node = _parse_statement(source, statement, faults)
        if node is not None:
            yield node


def _parse_statement(source: Source, statement: Statement, faults: list[Fault]) -> object:
    try:
        node: object = statement_parser().parse(statement.text(source.text))
    except UnexpectedInput:
        faults.append(explained(source, statement, _reach))
        return None
    if len(statement.tokens) > DEEPEST and _depth(node) > DEEPEST:
        faults.append(_too_deep(source, statement.span, "this statement is nested too deeply"))
        return None
    # The first word of a statement, which names its rule, belongs to it.
    node = s.moved(node, statement.span.start)
    return node if isinstance(node, s.Model | s.Text) else replace(node, span=statement.span)  # type: ignore[type-var]


def _too_deep(source: Source, span: Span, message: str) -> Fault:
    return Fault("too-deep", message, source, span, "use `define` and `let` for its parts")


def _reach(text: str) -> Parsing:
    """How far a statement's text can be read, and which words may follow there."""
    try:
        statement_parser().parse(text)
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
