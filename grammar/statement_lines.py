"""A statement's tokens in lines: where blanks stand, and where a long statement is broken."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from facetlog.grammar import syntax as s
from facetlog.grammar.reading.layout import STATEMENT_WORDS, Token
from facetlog.grammar.source import Source

__all__ = ["WIDTH", "canonical", "has_reason", "kept_lines", "one_line", "over_lines"]

WIDTH = 100
"""Characters of a line; what has no place to be broken at may be longer."""

HANGING = "    "
"""What the further lines of a statement are indented by: more than statements, so that it shows."""

# Words before an opening bracket that it is no argument list of.
_BEFORE_BRACKET = frozenset(
    ("and", "or", "not", "of", "where", "at", "least", "most", "between", "about", "is", "fading")
)

_NO_GAP_BEFORE = frozenset(",:.)°")
_NO_GAP_AFTER = frozenset("(.")
_NO_REASON = ("use", "model", "example")


def canonical(token: Token) -> Token:
    """The token as it is written."""
    return token._replace(text="±") if token.text == "+/-" else token


def has_reason(tokens: Sequence[Token]) -> bool:
    """Whether a statement ends with a text that says why or what it is."""
    last = tokens[-1]
    return last.kind == "string" and len(tokens) > 1 and tokens[0].text not in _NO_REASON


def one_line(tokens: Sequence[Token]) -> str:
    """The tokens with a blank where people write one.

    >>> from facetlog.grammar.reading.layout import laid_out
    >>> one_line(laid_out(Source("", "angle( a ,b )=90deg±-5 %")).statements[0].tokens)
    'angle(a, b) = 90 deg ± -5 %'
    """
    return "".join(gap + token.text for gap, token in zip(_gaps(tokens), tokens, strict=True))


def _gaps(tokens: Sequence[Token]) -> Iterator[str]:
    """What stands before each token."""
    before: Token | None = None
    leads = False
    for token in tokens:
        bare = (
            before is None
            or leads
            or token.text in _NO_GAP_BEFORE
            or before.text in _NO_GAP_AFTER
            or (token.text == "(" and before.kind == "word" and before.text not in _BEFORE_BRACKET)
        )
        yield "" if bare else " "
        # A minus that no measure stands before turns the sign of what follows.
        leads = token.text == "-" and (before is None or _wants_measure(before))
        before = token


def _wants_measure(token: Token) -> bool:
    if token.kind == "sign":
        return token.text not in (")", "%", "°")
    return token.kind == "word" and token.text in _BEFORE_BRACKET


# ------------------------------------------------------------------- breaks


@dataclass(frozen=True, slots=True)
class _Break:
    """A place where a line may end: before which token; the loosest binding has the least rank."""

    token: int
    rank: tuple[int, int]


_COMMA, _OR, _AND, _TIGHT = range(4)


def over_lines(tokens: Sequence[Token], room: int, tail: str) -> Iterator[str]:
    """The tokens in lines of at most `room` characters, as far as there are places to break.

    Each line ends at the loosest comma, `or` or `and` that it has room for, the last one of these.
    `tail` stands behind the last token.
    """
    pieces = [gap + token.text for gap, token in zip(_gaps(tokens), tokens, strict=True)]
    places = [0]
    for piece in pieces:
        places.append(places[-1] + len(piece))
    breaks = list(_breaks(tokens))
    start, at, indent = 0, 0, ""
    while True:
        left = places[-1] - places[start] + len(tail)
        if left <= room - len(indent) or at >= len(breaks):
            break
        chosen = at
        for i in range(at + 1, len(breaks)):
            if places[breaks[i].token] - places[start] > room - len(indent):
                break
            if breaks[i].rank <= breaks[chosen].rank:
                chosen = i
        end = breaks[chosen].token
        yield indent + "".join(pieces[start:end]).strip()
        start, at, indent = end, chosen + 1, HANGING
    yield indent + "".join(pieces[start:]).strip() + tail


def _breaks(tokens: Sequence[Token]) -> Iterator[_Break]:
    """The places where a line may end and the statement go on: after commas, before `and`, `or`."""
    # Of each bracket that is open: the `between`s whose `and` is still to come.
    pending = [0]
    for i, token in enumerate(tokens):
        depth = len(pending)
        if token.text == "(":
            pending.append(0)
        elif token.text == ")":
            pending.pop()
        elif token.text == "between":
            pending[-1] += 1
        elif token.text == "and" and pending[-1]:
            pending[-1] -= 1
        elif token.text in ("and", "or") and i > 0:
            yield _Break(i, (depth, _AND if token.text == "and" else _OR))
        elif token.text == "," and _goes_on_at(tokens, i + 1):
            yield _Break(i + 1, (depth, _TIGHT if _joins_names(tokens, i) else _COMMA))


def _goes_on_at(tokens: Sequence[Token], i: int) -> bool:
    """Whether a line may begin with this token: not if it would begin a statement."""
    if i + 1 >= len(tokens):
        return i < len(tokens) and tokens[i].text not in STATEMENT_WORDS
    return tokens[i].text not in STATEMENT_WORDS and tokens[i + 1].text != ":"


def _joins_names(tokens: Sequence[Token], comma: int) -> bool:
    """Whether a comma stands in a list of names before `:`, `of` or `where`."""
    i = comma
    while i + 2 < len(tokens) and tokens[i].text == "," and tokens[i + 1].kind == "word":
        i += 2
    return tokens[i].text in (":", "of", "where")


# ----------------------------------------------------------------- comments


def kept_lines(
    source: Source, tokens: Sequence[Token], comments: Sequence[s.Comment]
) -> Iterator[str]:
    """The lines of a statement with comments in it, which keep their places."""
    lines: dict[int, list[Token]] = {}
    for token in tokens:
        lines.setdefault(source.line_and_column(token.start)[0], []).append(token)
    behind = {source.line_and_column(c.span.start)[0]: c.text for c in comments}
    indent = ""
    for number in sorted(lines.keys() | behind.keys()):
        texts = [one_line(lines.get(number, [])), behind.get(number, "")]
        yield indent + "  ".join(text for text in texts if text)
        indent = HANGING
