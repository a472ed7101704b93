"""Completions at a place: words of the language, of the vocabulary, and names."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache

from lark.exceptions import UnexpectedInput
from lsprotocol import types as lsp

from facetlog.grammar import syntax as s
from facetlog.grammar.analysis import Analysis
from facetlog.grammar.checking.model import STATED
from facetlog.grammar.example_scenes import PLACES, Builders
from facetlog.grammar.language_server.hover import (
    describe_model,
    describe_unit,
    describe_word,
    show_constant_value,
)
from facetlog.grammar.library import list_builtin_names
from facetlog.grammar.reading.layout import PIECE_WORDS, Token, laid_out
from facetlog.grammar.reading.parse import LONGEST, build_statement_parser
from facetlog.grammar.resolve import FlatModel, Owned
from facetlog.grammar.scope import THIS
from facetlog.grammar.source import Source
from facetlog.grammar.units import UNITS
from facetlog.grammar.vocabulary import Kind, Word

# Placeholder at the cursor, so that the layout tells to which statement it belongs. No statement
# begins with it.
_CURSOR = "cursor_9f3a"


_MODEL = re.compile(r"^[ \t]*model\b", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Context:
    """The tokens of a statement before the cursor (without the word that is being written).

    `follow` are the words of the language that may follow, `terminals` the names of all terminals
    that may; both are empty if what stands there cannot be read. `model` is the nearest one above.
    """

    tokens: tuple[Token, ...]
    follow: frozenset[str]
    terminals: frozenset[str]
    model: str

    @property
    def last(self) -> str:
        """The last word or sign, empty at the beginning of a statement."""
        return self.tokens[-1].text if self.tokens else ""

    @property
    def first(self) -> str:
        """The first word, empty at the beginning of a statement."""
        return self.tokens[0].text if self.tokens else ""

    def is_after(self, *words: str) -> bool:
        """Return whether these are the last words."""
        return tuple(t.text for t in self.tokens[-len(words) :]) == words

    @property
    def after_measure(self) -> bool:
        """Whether a name, a call or another measure has just ended: `is` may follow."""
        return "IS" in self.terminals


def find_context(text: str, offset: int) -> Context | None:
    """Return the tokens before a position, or None inside texts and comments."""
    start = offset
    while start > 0 and (text[start - 1].isalnum() or text[start - 1] == "_"):
        start -= 1
    # A line that begins with `model` begins a statement, so nothing before it matters.
    models = [match.start() for match in _MODEL.finditer(text, 0, start)]
    base = models[-1] if models else 0
    layout = laid_out(Source("", text[base:start] + _CURSOR))
    if not layout.statements:
        return None
    tokens = layout.statements[-1].tokens
    if tokens[-1].kind != "word" or tokens[-1].text != _CURSOR or tokens[-1].start != start - base:
        return None
    model = ""
    for statement in reversed(layout.statements):
        if statement.tokens[0].text == "model" and len(statement.tokens) > 1:
            model = statement.tokens[1].text
            break
    follow, terminals = _find_following(tokens[:-1])
    return Context(tokens[:-1], follow, terminals, model)


UNLESS_LABEL = r"\b(?!\s*:)"
"""Ends the terminals of words that are labels before a colon."""


@cache
def _get_keywords() -> dict[str, str]:
    """Return the words of the language by the names of their terminals."""
    words = {
        terminal.name: terminal.pattern.value.removesuffix(UNLESS_LABEL)
        for terminal in build_statement_parser().terminals
    }
    return {name: word for name, word in words.items() if word.isalpha()}


def _find_following(tokens: Sequence[Token]) -> tuple[frozenset[str], frozenset[str]]:
    """Return the words that may follow these tokens, and the names of the terminals."""
    if len(tokens) > LONGEST:
        return frozenset(), frozenset()
    state = build_statement_parser().parse_interactive(" ".join(token.text for token in tokens))
    try:
        state.exhaust_lexer()
        accepted = frozenset(state.accepts())  # type: ignore[no-untyped-call]
    except UnexpectedInput:
        return frozenset(), frozenset()
    words = frozenset(_get_keywords()[name] for name in accepted if name in _get_keywords())
    return words | (PIECE_WORDS if "PIECE" in accepted else frozenset()), accepted


TRIGGERS = (" ", ".", "(", ":", ",")
"""Signs after which names may stand, so that editors ask."""

_KINDS = lsp.CompletionItemKind

_KIND_WORDS = ("face", "faces", "edge", "edges", "vertex", "vertices", "element", "elements")
_SEVERAL_PIECES = tuple(f"{word}s" for word in sorted(PIECE_WORDS))


# The end of a statement in which the parts are listed that `each` goes through.
_RANGE = re.compile(r"\beach (pair \w+ , )?\w+ of( \w+ ,)*\Z")


def completions(
    analysis: Analysis, text: str, offset: int, builders: Builders
) -> list[lsp.CompletionItem]:
    """Return the completions at a place, likelier kinds first; none in texts and comments."""
    context = find_context(text, offset)
    if context is None:
        return []
    found: dict[str, lsp.CompletionItem] = {}
    for item in _Completer(analysis, context, builders).items():
        found.setdefault(item.label, item)
    return list(found.values())


def _make_item(
    label: str, kind: lsp.CompletionItemKind, detail: str = "", documentation: str = ""
) -> lsp.CompletionItem:
    text = lsp.MarkupContent(lsp.MarkupKind.Markdown, documentation) if documentation else None
    return lsp.CompletionItem(label, kind=kind, detail=detail or None, documentation=text)


@dataclass(slots=True)
class _Completer:
    analysis: Analysis
    context: Context
    builders: Builders
    model: FlatModel | None = field(init=False)

    def __post_init__(self) -> None:
        self.model = self.analysis.all_models.get(self.context.model)

    def items(self) -> Iterator[lsp.CompletionItem]:
        context = self.context
        if context.last == ".":
            yield from self._complete_members()
            return
        if context.first == "example" and "NAME" in context.terminals:
            yield from self._complete_example()
        elif "UNIT" in context.terminals:
            yield from self._complete_units()
        elif "NAME" in context.terminals:
            yield from self._complete_names()
        for word in sorted(context.follow):
            yield _make_item(word, _KINDS.Keyword)

    # -------------------------------------------------------- by context

    def _complete_names(self) -> Iterator[lsp.CompletionItem]:
        context = self.context
        match context.first:
            case "model":
                if context.last in ("is", "like"):
                    yield from self._complete_models(but=context.model)
                return
            case "drop":
                yield from self._complete_labels()
                return
            case "let":
                if context.last != "let":
                    yield from self._complete_constants()
                return
            case "define" if ":" not in self._get_texts():
                return
        if context.last == "one" and context.first in ("one", "optional"):
            yield from self._complete_models()
        elif context.last == "is" or context.is_after("is", "not"):
            yield from self._complete_properties()
        elif context.after_measure:
            yield from self._complete_relations()
        elif self._wants_members():
            yield from self._complete_models()
            yield from (_make_item(word, _KINDS.Keyword) for word in _SEVERAL_PIECES)
        elif self._is_new_name():
            if context.last == "each":
                yield from self._complete_parts(sets=True)
        elif self._wants_parts():
            yield from self._complete_parts()
            yield from self._complete_locals()
        else:
            yield from self._complete_operands()

    def _get_texts(self) -> tuple[str, ...]:
        return tuple(token.text for token in self.context.tokens)

    def _wants_members(self) -> bool:
        """Return whether a count has just been said: faces, edges, or things of a model follow."""
        return {"faces", "vertices"} <= self.context.follow

    def _is_new_name(self) -> bool:
        """Return whether the author gives a name here: behind a kind, or in the list of a part's
        names.
        """
        texts, tokens = self._get_texts(), self.context.tokens
        if texts[-1:] and texts[-1] in (*_KIND_WORDS, *_SEVERAL_PIECES, "each", "pair"):
            return True
        declares = tokens[1:2] if texts[:1] == ("optional",) else tokens[:1]
        return "where" not in texts and any(
            token.text in _KIND_WORDS or token.text in PIECE_WORDS for token in declares
        )

    def _wants_parts(self) -> bool:
        """Return whether a list of parts is being written: after `each x of`, `pair x, y of`."""
        return bool(_RANGE.search(" ".join(self._get_texts())))

    def _complete_example(self) -> Iterator[lsp.CompletionItem]:
        texts = self._get_texts()
        if "because" in texts:
            yield from self._complete_labels()
        elif texts[-1:] in (("of",), ("and",)):
            for name, dimensions in sorted(self.builders.items()):
                yield _make_item(name, _KINDS.Constructor, f"{name}({', '.join(dimensions)})")
        elif "UNIT" in self.context.terminals:
            yield from self._complete_units()
        elif "(" in texts:
            opened = len(texts) - 1 - texts[::-1].index("(")
            builder = texts[opened - 1]
            sizes = STATED if "from" in texts else (*self.builders.get(builder, ()), *PLACES)
            for name in sizes:
                if name not in texts[opened:]:
                    yield _make_item(name, _KINDS.Field, f"of {builder}")

    # ----------------------------------------------------- what there is

    def _complete_units(self) -> Iterator[lsp.CompletionItem]:
        for name in UNITS:
            yield _make_item(name, _KINDS.Unit, describe_unit(name))

    def _complete_models(self, but: str = "") -> Iterator[lsp.CompletionItem]:
        for name, model in self.analysis.all_models.items():
            if name != but:
                yield _make_item(name, _KINDS.Class, "model", describe_model(model))
        own = [name for words in self.analysis.library.words.values() for name in words.models]
        for name in [*own, *sorted(list_builtin_names())]:
            yield _make_item(name, _KINDS.Class, "model")

    def _complete_properties(self) -> Iterator[lsp.CompletionItem]:
        for word in self.analysis.words.values():
            if word.is_condition and len(word.arguments) == 1 and not word.many:
                yield self._make_word_item(word, _KINDS.Property)
        yield from self._complete_definitions(parameters=1)
        yield from self._complete_models()

    def _complete_relations(self) -> Iterator[lsp.CompletionItem]:
        for word in self.analysis.words.values():
            if word.is_condition and len(word.arguments) == 2 and not word.number_last:
                yield self._make_word_item(word, _KINDS.Operator)
        yield from self._complete_definitions(parameters=2)

    def _complete_operands(self) -> Iterator[lsp.CompletionItem]:
        yield from self._complete_locals()
        yield from self._complete_parts()
        yield from self._complete_constants()
        yield from self._complete_definitions()
        for word in self.analysis.words.values():
            yield self._make_word_item(word, _KINDS.Function)
        yield _make_item(
            "count", _KINDS.Function, "count(set): count", "how many members a set has"
        )
        yield _make_item(THIS, _KINDS.Variable, "the thing itself")

    def _make_word_item(self, word: Word, kind: lsp.CompletionItemKind) -> lsp.CompletionItem:
        return _make_item(word.name, kind, word.signature, describe_word(word))

    def _complete_parts(self, *, sets: bool = False) -> Iterator[lsp.CompletionItem]:
        scope = self.analysis.scopes.get(self.context.model)
        if scope is None:
            return
        for part in () if sets else scope.singular:
            yield _make_item(part.name, _KINDS.Variable, part.model or _format_kinds(part.kinds))
        for several in scope.sets:
            kind = several.model or _format_kinds(several.kinds)
            yield _make_item(several.name, _KINDS.Variable, f"set of {kind}")

    def _complete_locals(self) -> Iterator[lsp.CompletionItem]:
        for name in _iter_introduced(self._get_texts()):
            yield _make_item(name, _KINDS.Variable, "named in this statement")

    def _complete_constants(self) -> Iterator[lsp.CompletionItem]:
        for name, owned in self._get_lets().items():
            yield _make_item(
                name, _KINDS.Constant, show_constant_value(owned.node, self._get_lets())
            )

    def _get_lets(self) -> Mapping[str, Owned[s.Let]]:
        if self.model is not None:
            return self.model.lets
        file = self.analysis.file
        return {x.name.text: Owned(x, file, "") for x in file.statements if isinstance(x, s.Let)}

    def _complete_definitions(self, parameters: int | None = None) -> Iterator[lsp.CompletionItem]:
        defines: Iterable[s.Define]
        if self.model is not None:
            defines = [owned.node for owned in self.model.defines.values()]
        else:
            defines = [x for x in self.analysis.file.statements if isinstance(x, s.Define)]
        for node in defines:
            if parameters in (None, len(node.parameters)):
                names = ", ".join(map(str, node.parameters))
                doc = node.doc.value if node.doc else ""
                yield _make_item(node.name.text, _KINDS.Function, f"{node.name}({names})", doc)

    def _complete_members(self) -> Iterator[lsp.CompletionItem]:
        texts = self._get_texts()
        scope = self.analysis.scopes.get(self.context.model)
        owner = scope.symbols.get(texts[-2]) if scope and len(texts) > 1 else None
        if scope is not None and owner is not None:
            for name in scope.roles.get(owner.model, ()):
                yield _make_item(name, _KINDS.Field, f"part of {owner.model}")

    def _complete_labels(self) -> Iterator[lsp.CompletionItem]:
        if self.model is None:
            return
        parent = self.model.written.parent
        model: FlatModel | None = self.model
        if self.context.first == "drop":
            model = self.analysis.all_models.get(parent.text) if parent else None
        for label, owned in model.lines if model else ():
            if owned.node.label is not None:
                reason = owned.node.reason.value if owned.node.reason else ""
                yield _make_item(label, _KINDS.Reference, reason)


def _format_kinds(kinds: Iterable[Kind]) -> str:
    return "/".join(sorted(kinds))


def _iter_introduced(texts: tuple[str, ...]) -> Iterator[str]:
    """Iterate over the names that `each`, `there` and parameters bring before a place."""
    for i, word in enumerate(texts[:-1]):
        rest = texts[i + 1 :]
        if word == "each" and rest[:1] == ("pair",):
            yield from (name for name in (rest[1:2] + rest[3:4]) if name.isidentifier())
        elif (word == "each" and rest[1:2] == ("of",)) or (_is_kind(texts, i) and i > 0 and rest):
            yield rest[0]
    if texts[:1] == ("define",) and ")" in texts:
        yield from (name for name in texts[2 : texts.index(")")] if name.isidentifier())


def _is_kind(texts: tuple[str, ...], i: int) -> bool:
    """Return whether the word there says what is gone through; those for pieces may be names,
    too.
    """
    if texts[i] in PIECE_WORDS:
        return texts[i - 1] in ("each", "a", "an", "no") or texts[i - 1].isdigit()
    return texts[i] in (*_KIND_WORDS, *_SEVERAL_PIECES)
