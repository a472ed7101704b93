"""Why a statement cannot be read: what stands there, what was expected, which word was meant."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from difflib import get_close_matches

from facetlog.grammar.faults import Fault
from facetlog.grammar.fixing.respelling import is_slip, respelt
from facetlog.grammar.reading.layout import STATEMENT_WORDS, Statement, Token
from facetlog.grammar.source import Source, Span
from facetlog.grammar.spoken import hint_of_phrase

__all__ = ["Parsing", "explained"]

# Words of the language that a misspelt word may be meant for. A word of two letters is like too
# many others.
_KEYWORDS = STATEMENT_WORDS.union(
    """faces edges vertices elements where least most between about fading sharp each pair there
    holds fails unknown because separate exactly number known weakly strongly longest like from and
    not are any""".split()  # noqa: SIM905  a list of words is read more easily so
)
_SHORTEST = 3
ALIKE = 0.7
"""difflib's ratio from which a word may be a misspelt keyword: one slip in four letters."""

WORDS_TRIED = 12
"""Words before the fault that are tried as misspelt keywords."""

MOST_WANTED = 8
"""Of what might stand there, so much is listed."""


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
    """The fault of a statement that cannot be read.

    `reach` says how far another text of it could be: if respelling one word as a keyword gets the
    parser further, that word is blamed.
    """
    text = statement.text(source.text)
    base = statement.span.start
    first, *rest = statement.tokens
    if first.text in STATEMENT_WORDS and rest and rest[0].text == ":" and first.text != "expect":
        message = f"`{first.text}` is a word of the language, and no label"
        span = Span(first.start, first.end)
        return Fault("syntax", message, source, span, "choose another label")
    here = reach(text)
    meant = _misspelt(statement, text, here.reach, reach)
    if meant is not None:
        token, word = meant
        message = f"`{token.text}` is not a word of the language"
        span = Span(token.start, token.end)
        fix = respelt(span, word, sure=is_slip(token.text, word))
        return Fault("misspelt", message, source, span, f"did you mean `{word}`?", fixes=(fix,))
    if here.reach >= len(text):
        span = Span(statement.span.end, statement.span.end)
        message, at = "the statement ends too early", len(text)
    else:
        token = _token_at(statement, base + here.reach)
        span = Span(token.start, token.end)
        message, at = f"`{token.text[:30]}` cannot stand here", token.start - base
    wanted = _wanted(here.expected)
    hint = hint_of_phrase(text, at) or (f"expected {wanted}" if wanted else "")
    return Fault("syntax", message, source, span, hint)


def _token_at(statement: Statement, offset: int) -> Token:
    for token in statement.tokens:
        if token.end > offset:
            return token
    return statement.tokens[-1]


def _misspelt(
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


# What terminals are called; several of one group are named once, by the group.
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


def _wanted(expected: Iterable[str]) -> str:
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
