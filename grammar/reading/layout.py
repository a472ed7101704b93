"""Text into statements: which lines belong together, and where the comments are.

Layout means nothing, except that a statement ends with its line. It goes on while a bracket is
open, after a word or sign that cannot end one, and where the next line begins with `and` or `or`.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

from facetlog.grammar.faults import Edit, Fault, Fix
from facetlog.grammar.source import Source, Span
from facetlog.grammar.syntax import Comment

STATEMENT_WORDS = frozenset(
    ("use model let define drop size example face edge vertex element one optional expect").split()  # noqa: SIM905  a list of words is read more easily so
)
"""Words that a statement begins with, and that nothing else may be called."""

PIECE_WORDS = frozenset({"piece", "board", "bar", "block", "opening", "hollow"})
"""Words for pieces and openings, where names follow them; elsewhere they are names like others."""

# Words after which a statement cannot end.
_OPEN_WORDS = frozenset(
    """and or not of where at least most between about is if each pair fading like from
    because""".split()  # noqa: SIM905
)
_OPEN_SIGNS = frozenset(",:+-*/=±.(")
_CLOSING = frozenset('“”‟«»‘’"')
"""Closing quotation marks of other programs and languages."""
_BRACKETS = ("(", ")")
DEEPEST = 40
"""Brackets within brackets; more is no sentence that a person reads."""

# Blanks before a token are read with it.
_TOKEN = re.compile(
    r"""
    (?:[^\S\n]|\ufeff)*(?:
      (?P<string>"[^"\n]*"?)
    | (?P<curly>[“”„‟«»‘’‚][^“”„‟«»‘’‚"\n]*[“”‟«»‘’"]?)
    | (?P<comment>\#[^\n]*)
    | (?P<newline>\n)
    | (?P<word>[^\W\d]\w*)
    | (?P<comma>(?<!,)[0-9]+,[0-9]+(?![0-9,]))
    | (?P<number>[0-9]+(?:\.[0-9]+)?(?:[eE][+-]?[0-9]+)?)
    | (?P<sign>\+/-|[^\s\ufeff])
    )
    """,
    re.VERBOSE,
)


_LABEL = re.compile(r"[^\W\d]\w*[ \t]*:")


class Token(NamedTuple):
    """A word, number, string, comment or sign: its kind, text and place."""

    kind: str
    text: str
    start: int

    @property
    def end(self) -> int:
        """The place after its last character."""
        return self.start + len(self.text)


@dataclass(frozen=True, slots=True)
class Statement:
    """The tokens of one statement, comments left out; `whole` if its brackets and texts are."""

    tokens: tuple[Token, ...]
    whole: bool

    @property
    def span(self) -> Span:
        """From its first token to its last."""
        return Span(self.tokens[0].start, self.tokens[-1].end)

    def text(self, source: str) -> str:
        """Return the text to parse: line ends and comments are blanks, so that places stay."""
        start, end = self.span.start, self.span.end
        piece = source[start:end]
        if "\n" not in piece:
            return piece
        pieces = []
        at = start
        for token in self.tokens:
            pieces.append(" " * (token.start - at))
            pieces.append(token.text)
            at = token.end
        return "".join(pieces)


@dataclass(frozen=True, slots=True)
class Layout:
    """The statements and comments of a text, and what is wrong with its brackets and texts."""

    statements: tuple[Statement, ...]
    comments: tuple[Comment, ...]
    faults: tuple[Fault, ...]


_MODEL = re.compile(r"^[^\S\n]*model\b", re.MULTILINE)


def pieces(text: str) -> Iterator[Span]:
    """Iterate over the text cut before each line that begins with `model`: each piece is laid out
    by itself.

    Such a line begins a statement, whatever was left open before.
    """
    starts = [match.start() for match in _MODEL.finditer(text) if match.start()]
    return map(Span, [0, *starts], [*starts, len(text)])


def laid_out(source: Source, piece: Span | None = None) -> Layout:
    """Return the statements and comments of a text, or of a piece of it."""
    lines = _Lines(source)
    lines.take(piece or Span(0, len(source.text)))
    return Layout(tuple(lines.statements), tuple(lines.comments), tuple(lines.faults))


class _Lines:
    """Tokens as they come, gathered into statements."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.statements: list[Statement] = []
        self.comments: list[Comment] = []
        self.faults: list[Fault] = []
        self._tokens: list[Token] = []
        self._open: list[Token] = []
        self._whole = True

    def take(self, piece: Span) -> None:
        """Take the tokens of a piece of the text, most of them without a call."""
        line_is_empty, fresh_line = True, False
        new = tuple.__new__
        for match in _TOKEN.finditer(self.source.text, *piece):
            kind: Any = match.lastgroup
            if kind == "newline":
                line_is_empty = fresh_line = True
                continue
            text, end = match[kind], match.end()
            token = new(Token, (kind, text, end - len(text)))
            if kind == "comment":
                span = Span(token.start, end)
                self.comments.append(Comment(text.rstrip(), span, line_is_empty))
                continue
            if fresh_line and self._tokens and not self._is_continued(token):
                self._end_statement()
            line_is_empty = fresh_line = False
            self._tokens.append(token)
            if kind in ("string", "curly", "comma") or text in _BRACKETS:
                self._check(token)
        self._end_statement()

    def _is_continued(self, token: Token) -> bool:
        """Return whether the statement goes on with this first token of a line."""
        if token.text in ("and", "or"):
            return True
        last = self._tokens[-1]
        if token.text in STATEMENT_WORDS or _LABEL.match(self.source.text, token.start):
            # A statement begins here: what was left open before is a fault of its own.
            return False
        if self._open:
            return True
        if last.kind == "word":
            return last.text in _OPEN_WORDS
        return last.kind == "sign" and (last.text in _OPEN_SIGNS or last.text == "+/-")

    def _check(self, token: Token) -> None:
        if token.kind == "string" and (len(token.text) < 2 or token.text[-1] != '"'):
            self._fault(
                "open-text", "this text has no end", token, 'close it with "', *_close_text(token)
            )
        elif token.kind == "curly":
            hint = 'write a text in quotes as "it is flat"'
            self._fault(
                "quote",
                f"`{token.text[0]}` is no quotation mark here",
                token,
                hint,
                *_fix_quotes(token),
            )
        elif token.kind == "comma":
            point = token.text.replace(",", ".")
            # 1,000 may be a thousand.
            sure = len(token.text.split(",")[1]) != 3
            fix = Fix(f"write `{point}`", (Edit(Span(token.start, token.end), point),), sure)
            hint = f"write `{point}`, and a blank behind the comma between two numbers"
            self._fault("decimal-comma", "decimals are written with a point", token, hint, fix)
        elif token.text == "(":
            self._open.append(token)
            if len(self._open) == DEEPEST + 1:
                self._fault(
                    "too-deep",
                    f"more than {DEEPEST} brackets are open here",
                    token,
                    "use `define` for what stands in them",
                )
        elif token.text == ")":
            if self._open:
                self._open.pop()
            else:
                self._fault("bracket", "this bracket was never opened", token, "")

    def _end_statement(self) -> None:
        if not self._tokens:
            return
        if self._open:
            self._fault("bracket", "this bracket is not closed", self._open[-1], "")
        self.statements.append(Statement(tuple(self._tokens), self._whole))
        self._tokens, self._open, self._whole = [], [], True

    def _fault(self, code: str, message: str, token: Token, hint: str, *fixes: Fix) -> None:
        self._whole = False
        span = Span(token.start, token.end)
        self.faults.append(Fault(code, message, self.source, span, hint, fixes=fixes))


def _fix_quotes(token: Token) -> Iterator[Fix]:
    """Iterate over the fix that puts a text between curly quotes into straight ones."""
    inside = token.text[1:-1]
    if len(token.text) > 1 and token.text[-1] in _CLOSING:
        text = f'"{inside}"'
        yield Fix(f"write `{text}`", (Edit(Span(token.start, token.end), text),), sure=True)


def _close_text(token: Token) -> Iterator[Fix]:
    """Iterate over the fix of a text that begins with a straight quote and ends with a curly
    one."""
    places = [at for at, sign in enumerate(token.text) if sign in _CLOSING and at]
    if places:
        at = token.start + places[-1]
        yield Fix('close it with `"`', (Edit(Span(at, at + 1), '"'),), sure=len(places) == 1)
