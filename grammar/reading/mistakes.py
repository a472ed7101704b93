"""Statements that cannot be read for a known reason: labels, `if known:`, `each`, and parts."""

import re
from collections.abc import Sequence

from facetlog.grammar.faults import Edit, Fault, Fix, make_insertion
from facetlog.grammar.reading.layout import PIECE_WORDS, STATEMENT_WORDS, Statement, Token
from facetlog.grammar.source import Source, Span

_NAME = re.compile(r"[^\W\d]\w*")

_NO_LABELS = STATEMENT_WORDS.union(
    ("each", "if", "at", "exactly", "between", "any", "there", "not", "no")
) - {"expect"}
"""Words that begin a statement or a condition."""

_EVERY = frozenset({"each", "every", "all", "any", "for", "forall", "foreach"})
"""Words with which people begin what holds of each member of a set."""

_OPENERS = frozenset({"optional", "one", "at", "exactly", "between", "any"})
_NO_PARTS = STATEMENT_WORDS - {"face", "edge", "vertex", "element", "one", "optional"}


def find_mistake(source: Source, statement: Statement, reach: int) -> Fault | None:
    """Return the fault of a statement that can be read up to `reach`, if the reason is known."""
    tokens = statement.tokens
    at = next((i for i, t in enumerate(tokens) if t.end > statement.span.start + reach), None)
    texts = [token.text for token in tokens]
    return (
        _find_if_known(source, tokens, texts)
        or _find_each(source, tokens, texts, at)
        or _find_label(source, tokens, texts, at)
    )


def _span(tokens: Sequence[Token]) -> Span:
    return Span(tokens[0].start, tokens[-1].end)


def _find_if_known(source: Source, tokens: Sequence[Token], texts: list[str]) -> Fault | None:
    """Return the fault of an `if known:` that is not in its place before the conditions."""
    here = next((i for i in range(len(texts)) if texts[i : i + 3] == ["if", "known", ":"]), None)
    if here is None:
        return None
    before, after = texts[:here], texts[here + 3 :]
    span = _span(tokens[here : here + 3])
    if after[:1] == ["expect"] or after[1:2] == [":"]:
        first = "`expect:`" if after[0] == "expect" else "the label"
        message, hint = f"{first} stands before `if known:`", "write `label: expect: if known: ...`"
    elif before and not (before[-1] == ":" and ("expect" in before or len(before) == 2)):
        message = "`if known:` begins the conditions of a line"
        hint = "write it, and what it is about, in a line by itself"
    else:
        return None
    return Fault("if-known", message, source, span, hint)


def _find_each(
    source: Source, tokens: Sequence[Token], texts: list[str], at: int | None
) -> Fault | None:
    """Return the fault of an `each` that no set and colon follow, or that stands in a measure."""
    first = next((i for i, text in enumerate(texts[:4]) if text in _EVERY), None)
    here = max((i for i, t in enumerate(texts) if t == "each"), default=first)
    if (
        here is None
        or at is None
        or not here <= at <= here + 5
        or texts[here + 2 : here + 3] == ["of"]
    ):
        return None
    colon = texts.index(":", here) if ":" in texts[here : here + 6] else None
    words = [t for t in texts[here + 1 : colon or at + 1] if _NAME.fullmatch(t)]
    names = [t for t in words if t not in _EVERY and t not in ("of", "in", "the", "is", "are")]
    if not names or (texts[here] != "each" and colon is None):
        return None
    # `each x in SET:` goes through the last name, `each SET is ...` through the first.
    name = names[-1] if {"in", "of"} & set(words) else names[0]
    message = "`each`, the name of a set and a colon belong together"
    if texts[here - 1 : here] == ["("]:
        message = "`each` stands before a condition, not within"
    hint = f"write a colon, and name it again: `each {name}: {name} is ...`"
    return Fault("each", message, source, _span(tokens[here : here + 2]), hint)


def _find_label(
    source: Source, tokens: Sequence[Token], texts: list[str], at: int | None
) -> Fault | None:
    """Return the fault of what stands before a colon and is no label."""
    if texts[1:2] == [":"] and texts[0] in _NO_LABELS:
        message = f"`{texts[0]}` is a word of the language, and no label"
        insertion = make_insertion(f"write `{texts[0]}_`", tokens[0].end, "_", sure=False)
        hint = "choose another label"
        return Fault("label", message, source, _span(tokens[:1]), hint, fixes=(insertion,))
    if (
        at is None
        or texts[at] != ":"
        or at < 2
        or texts[0] in _NO_LABELS - {"not", "no"} | {"expect"}
    ):
        return None
    if not all(_NAME.fullmatch(t) or t.isdigit() or t in "-/.&" for t in texts[:at]):
        return None
    label = re.sub(r"\W+", "_", "_".join(texts[:at]).replace("_-_", "_"))
    label = label if _NAME.fullmatch(label) else ""
    message = "a label is one word of letters, digits and `_`, and begins with a letter"
    span = _span(tokens[:at])
    fixes = (Fix(f"write `{label}`", (Edit(span, label),), sure=False),) if label else ()
    hint = f"write `{label}: ...`" if label else ""
    return Fault("label", message, source, span, hint, fixes=fixes)


def find_wrong_kind(statement: Statement) -> Token | None:
    """Return the word of a part's line that is no kind of part: `plank seat`, `boards leg`."""
    kind, *rest = statement.tokens
    if not rest or kind.text in _NO_LABELS | PIECE_WORDS or not _NAME.fullmatch(rest[0].text):
        return None
    ends = len(rest) == 1 or rest[1].kind == "string" or rest[1].text == "where"
    return kind if ends else None


def list_declared_names(statement: Statement) -> frozenset[str]:
    """Return what a statement that cannot be read may have declared: its names before `where`."""
    texts = [token.text for token in statement.tokens]
    if texts[0] in _NO_PARTS or ":" in texts[:2]:
        return frozenset()
    head = texts[: texts.index("where")] if "where" in texts else texts
    # Without a `where`, misspelt or not, a part's line has few words.
    known = PIECE_WORDS | _OPENERS | STATEMENT_WORDS
    return frozenset(t for t in head[:8] if _NAME.fullmatch(t) and t not in known)
