"""Model text into its syntax tree, with all faults of the text at once."""

from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import cache
from pathlib import Path

from lark import Lark, Tree
from lark import Token as LarkToken
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from facetlog.grammar import syntax as s
from facetlog.grammar.faults import MOST_FAULTS, Fault, Severity, is_slip, respell
from facetlog.grammar.phrase_hints import ORDER, SPOKEN_WORDS, find_phrase_hint
from facetlog.grammar.reading.layout import (
    STATEMENT_WORDS,
    Layout,
    Statement,
    Token,
    laid_out,
    pieces,
)
from facetlog.grammar.reading.mistakes import find_mistake, find_wrong_kind
from facetlog.grammar.reading.tree import TreeToSyntax
from facetlog.grammar.source import Source, Span
from facetlog.grammar.traversal import Node, children, moved

# Words of the language that a misspelt word may be meant for. A word of two letters is like too
# many others.
_KEYWORDS = STATEMENT_WORDS.union(
    """faces edges vertices elements where least most between about fading sharp each pair there
    holds fails unknown because separate exactly number known weakly strongly longest like from and
    not are any lowest highest smallest largest""".split()  # noqa: SIM905  a list of words is read more easily so
)
_SHORTEST = 3
ALIKE = 0.7
"""difflib's ratio from which a word may be a misspelt keyword: one slip in four letters."""

WORDS_TRIED = 12
"""Words before the fault that are tried as misspelt keywords."""

KINDS_HINT = (
    "a part is a `face`, a `board`, a `bar`, a `block`, a `piece`, an `opening` or a `hollow`"
)

MOST_WANTED = 8
"""Most alternatives that a message lists."""


@dataclass(frozen=True, slots=True)
class Parsing:
    """How far a text can be read (its length + 1 if all of it), and what may follow there."""

    reach: int
    expected: frozenset[str]


def explained(
    source: Source,
    statement: Statement,
    reach: Callable[[str], Parsing],
) -> Fault:
    """Return the fault of a statement that cannot be read.

    `reach` says how far another text of it could be: if respelling one word as a keyword gets the
    parser further, that word is blamed.
    """
    text = statement.text(source.text)
    base = statement.span.start
    here = reach(text)
    known = find_mistake(source, statement, here.reach)
    if known is not None:
        is_row = known.code == "each" and find_phrase_hint(text, len(text)) == ORDER
        return replace(known, hint=ORDER) if is_row else known
    meant = _find_misspelt(statement, text, here.reach, reach)
    if meant is not None:
        token, word = meant
        message = f"`{token.text}` is not a word of the language"
        span = Span(token.start, token.end)
        fix = respell(span, word, sure=is_slip(token.text, word))
        return Fault("misspelt", message, source, span, f"did you mean `{word}`?", fixes=(fix,))
    if here.reach >= len(text):
        span = Span(statement.span.end, statement.span.end)
        message, at = "the statement ends too early", len(text)
    else:
        token = _find_token(statement, base + here.reach)
        span = Span(token.start, token.end)
        message, at = f"`{token.text[:30]}` cannot stand here", token.start - base
    wanted = _describe_wanted(here.expected)
    phrase = find_phrase_hint(text, at)
    kind = find_wrong_kind(statement)
    if kind is not None:
        message, span = f"`{kind.text}` is no kind of part", Span(kind.start, kind.end)
        hint = SPOKEN_WORDS.get(kind.text) or phrase or KINDS_HINT
        return Fault("part", message, source, span, hint)
    hint = phrase or (f"expected {wanted}" if wanted else "")
    return Fault("syntax", message, source, span, hint)


def _find_token(statement: Statement, offset: int) -> Token:
    for token in statement.tokens:
        if token.end > offset:
            return token
    return statement.tokens[-1]


def _find_misspelt(
    statement: Statement, text: str, reached: int, reach: Callable[[str], Parsing]
) -> tuple[Token, str] | None:
    base = statement.span.start
    words = [t for t in statement.tokens if t.kind == "word" and t.start - base <= reached]
    best: tuple[int, Token, str] | None = None
    for token in words[-WORDS_TRIED:]:
        if token.text in _KEYWORDS or len(token.text) < _SHORTEST:
            continue
        for word in get_close_matches(token.text, sorted(_KEYWORDS), n=2, cutoff=ALIKE):
            start = token.start - base
            other = text[:start] + word + text[start + len(token.text) :]
            gained = reach(other).reach - (len(word) - len(token.text))
            if gained > reached and (best is None or gained > best[0]):
                best = gained, token, word
    return None if best is None else (best[1], best[2])


# Names of terminals in messages; several of one group are named once, by the group.
_GROUPS = {
    "a comparison (`= ... ± ...`, `at least`, `at most`, `between`, `about`, `is`)": {
        "EQUAL", "AT", "BETWEEN", "ABOUT", "IS",
    },
    "a sign (`+`, `-`, `*`, `/`)": {"PLUS", "MINUS", "STAR", "SLASH"},
    "a unit": {"UNIT"},
    "a kind (`face`, `edge`, `vertex`, `element`)": {
        "FACE", "FACES", "EDGE", "EDGES", "VERTEX", "VERTICES", "ELEMENT", "ELEMENTS", "PIECE",
    },
    "`lowest of` and its like": {"SUM", "MEAN", "LOWEST", "HIGHEST", "SMALLEST", "LARGEST"},
    "a number": {"NUMBER"},
    "a name": {"NAME"},
    "a text in quotes": {"STRING"},
    "`(`": {"LPAR"},
    "`)`": {"RPAR"},
    "`,`": {"COMMA"},
    "`:`": {"COLON"},
    "`.`": {"DOT"},
    "`±`": {"_PLUS_MINUS"},
    "`%`": {"PERCENT"},
    "the end of the line": {"$END"},
}  # fmt: skip


_SIGNS = {"EQUAL": "=", "PLUS": "+", "MINUS": "-", "STAR": "*", "SLASH": "/"}


def _describe_wanted(expected: Iterable[str]) -> str:
    left = set(expected)
    said = []
    for group, terminals in _GROUPS.items():
        # One of a group of several is named itself.
        if len(left & terminals) >= min(2, len(terminals)):
            said.append(group)
            left -= terminals
    said += [f"`{_SIGNS.get(name) or name.lower().replace('_', ' ')}`" for name in sorted(left)]
    if not said:
        return ""
    if len(said) > MOST_WANTED:
        said = [*said[:MOST_WANTED], "something else"]
    return ", ".join(said[:-1]) + (f" or {said[-1]}" if len(said) > 1 else said[0])


class Readable:
    """The places where the statements stand that became syntax."""

    def __init__(self, file: s.File) -> None:
        nodes: list[Node] = [*file.statements]
        for model in file.models:
            nodes += [model, *([] if model.doc is None else [model.doc]), *model.statements]
        # A model's own place begins behind its first word.
        self._starts = sorted(node.span.start for node in nodes)

    def has(self, span: Span) -> bool:
        """Return whether the statement at a place could be read."""
        at = bisect_left(self._starts, span.start)
        return at < len(self._starts) and self._starts[at] < span.end


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


class _WholeWords:
    """Refuses words that are run together: Lark would take `ofheight` for `of height`."""

    always_accept = ()

    def process(self, stream: Iterator[LarkToken]) -> Iterator[LarkToken]:
        before: LarkToken | None = None
        for token in stream:
            if (
                before is not None
                and before.type != "NUMBER"
                and before.end_pos == token.start_pos
                and f"{before[-1]}{token[0]}".replace("_", "a").isalnum()
            ):
                word = LarkToken.new_borrow_pos("NAME", before + token, before)
                raise UnexpectedToken(word, {})  # type: ignore[no-untyped-call]
            yield token
            before = token


@cache
def build_statement_parser(*, trees: bool = False) -> Lark:
    """Return the parser of one statement, which makes syntax, or trees, as it reduces."""
    grammar, maker = GRAMMAR.read_text(encoding="utf-8"), None if trees else TreeToSyntax()
    return Lark(
        grammar, parser="lalr", maybe_placeholders=True, transformer=maker, postlex=_WholeWords()
    )


def iter_statement_trees(source: Source) -> Iterator[Tree[LarkToken]]:
    """Iterate over the trees of the statements that can be read, as the grammar names rules."""
    for statement in laid_out(source).statements:
        with suppress(UnexpectedInput):
            yield build_statement_parser(trees=True).parse(statement.text(source.text))


def parse(source: Source) -> Parsed:
    """Return the syntax tree of a text; a faulty statement is left out, with a fault."""
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
        found += _iter_statements(source, layout, faults)
        comments += layout.comments
    if not found and not faults:
        hint = "begin with `model NAME`"
        message = "the file has no model"
        faults.append(Fault("empty-file", message, source, Span(0, 0), hint, Severity.WARNING))
    file = _make_file(source, tuple(comments), found, faults)
    return Parsed(file, tuple(sorted(faults, key=_order)))


def _order(fault: Fault) -> tuple[int, int]:
    return fault.span.start, fault.span.end


def _iter_statements(source: Source, layout: Layout, faults: list[Fault]) -> Iterator[object]:
    for statement in layout.statements:
        if len(faults) >= MOST_FAULTS:
            return
        if not statement.whole:
            # Its brackets or texts have a fault already.
            continue
        if len(statement.tokens) > LONGEST:
            faults.append(_report_too_deep(source, statement.span, "this statement is too long"))
            continue
        node = _parse_statement(source, statement, faults)
        if node is not None:
            yield node


def _parse_statement(source: Source, statement: Statement, faults: list[Fault]) -> object:
    try:
        node: object = build_statement_parser().parse(statement.text(source.text))
    except UnexpectedInput:
        faults.append(explained(source, statement, _reach))
        return None
    if len(statement.tokens) > DEEPEST and _measure_depth(node) > DEEPEST:
        faults.append(
            _report_too_deep(source, statement.span, "this statement is nested too deeply")
        )
        return None
    # The first word of a statement, which names its rule, belongs to it.
    node = moved(node, statement.span.start)
    return node if isinstance(node, s.Model | s.Text) else replace(node, span=statement.span)  # type: ignore[type-var]


def _report_too_deep(source: Source, span: Span, message: str) -> Fault:
    return Fault("too-deep", message, source, span, "use `define` and `let` for its parts")


def _reach(text: str) -> Parsing:
    """Return how far a statement's text can be read, and which words may follow there."""
    try:
        build_statement_parser().parse(text)
    except UnexpectedToken as error:
        at = len(text) if error.token.type == "$END" else error.token.start_pos or 0
        return Parsing(at, frozenset(error.accepts or error.expected))
    except UnexpectedCharacters as error:
        return Parsing(error.pos_in_stream or 0, frozenset(error.allowed or ()))
    return Parsing(len(text) + 1, frozenset())


def _measure_depth(node: object) -> int:
    deepest, waiting = 0, [(node, 1)]
    while waiting:
        one, depth = waiting.pop()
        deepest = max(deepest, depth)
        waiting.extend((child, depth + 1) for child in children(one))
    return deepest


# ------------------------------------------------------------------ assembly


def _make_file(
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
                    faults.append(_report_no_model(source, node))
                else:
                    target.append(node)  # type: ignore[arg-type]
    finish()
    return s.File(source, tuple(first), tuple(models), comments)


def _report_no_model(source: Source, node: object) -> Fault:
    message = "this stands before the first model: only `use`, `let` and `define` may"
    return Fault("no-model", message, source, node.span, "begin with `model NAME`")  # type: ignore[attr-defined]
