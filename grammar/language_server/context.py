"""What stands before the cursor: the statement's words so far, and what the grammar lets follow."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

from lark.exceptions import UnexpectedInput
from lark.lexer import PatternStr

from facetlog.grammar.reading.layout import PIECE_WORDS, Token, laid_out
from facetlog.grammar.reading.parse import LONGEST, statement_parser
from facetlog.grammar.source import Source

__all__ = ["Context", "context_at"]

# What is put where the cursor stands, so that the layout says to which statement it belongs. It is
# no word that a statement begins with.
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

    def ends_with(self, *words: str) -> bool:
        """Whether these are the last words."""
        return tuple(t.text for t in self.tokens[-len(words) :]) == words

    @property
    def after_measure(self) -> bool:
        """Whether a name, a call or another measure has just ended: `is` may follow."""
        return "IS" in self.terminals


def context_at(text: str, offset: int) -> Context | None:
    """What stands before a place; None within texts and comments."""
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
    follow, terminals = _following(tokens[:-1])
    return Context(tokens[:-1], follow, terminals, model)


@cache
def _written() -> dict[str, str]:
    """The words of the language by the names of their terminals."""
    patterns = {terminal.name: terminal.pattern for terminal in statement_parser().terminals}
    return {
        name: pattern.value
        for name, pattern in patterns.items()
        if isinstance(pattern, PatternStr) and pattern.value.isalpha()
    }


def _following(tokens: Sequence[Token]) -> tuple[frozenset[str], frozenset[str]]:
    """The words that may follow these tokens, and the names of the terminals."""
    if len(tokens) > LONGEST:
        return frozenset(), frozenset()
    state = statement_parser().parse_interactive(" ".join(token.text for token in tokens))
    try:
        state.exhaust_lexer()
        accepted = frozenset(state.accepts())  # type: ignore[no-untyped-call]
    except UnexpectedInput:
        return frozenset(), frozenset()
    words = frozenset(_written()[name] for name in accepted if name in _written())
    return words | (PIECE_WORDS if "PIECE" in accepted else frozenset()), accepted
