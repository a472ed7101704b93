"""A fix: edits of a text that put a fault right. `--fix`, editors and SARIF are all made of it."""

from collections.abc import Iterable
from dataclasses import dataclass

from facetlog.grammar.source import Span

__all__ = ["Edit", "Fix", "applied", "insertion", "removal", "swap"]


@dataclass(frozen=True, slots=True)
class Edit:
    """A piece of a text, and what takes its place; an empty span is a place between letters."""

    span: Span
    text: str


@dataclass(frozen=True, slots=True)
class Fix:
    """Edits of the text in which a fault stands; no two of them overlap.

    `title` says what is done, as a command ("write `deg`"). Only what is `sure` is done without
    asking: that the author meant something else is then hardly possible.
    """

    title: str
    edits: tuple[Edit, ...]
    sure: bool

    @property
    def span(self) -> Span:
        """From the first edit to the last."""
        first, *rest = sorted(edit.span for edit in self.edits)
        return first.to(rest[-1]) if rest else first


def applied(text: str, edits: Iterable[Edit]) -> str:
    """A text after edits that do not overlap.

    >>> applied("between 9 and 4", [Edit(Span(8, 9), "4"), Edit(Span(14, 15), "9")])
    'between 4 and 9'
    """
    pieces, at = [], 0
    for edit in sorted(edits, key=lambda edit: edit.span):
        pieces += [text[at : edit.span.start], edit.text]
        at = edit.span.end
    return "".join([*pieces, text[at:]])


def insertion(title: str, at: int, text: str, *, sure: bool) -> Fix:
    """A fix that puts something in."""
    return Fix(title, (Edit(Span(at, at), text),), sure)


def removal(title: str, text: str, span: Span, *, sure: bool) -> tuple[Fix, ...]:
    """A fix that takes a statement out with its line; none if something else stands there."""
    start = text.rfind("\n", 0, span.start) + 1
    end = text.find("\n", span.end) + 1 or len(text)
    if text[start : span.start].strip() or text[span.end : end].strip():
        return ()
    return (Fix(title, (Edit(Span(start, end), ""),), sure),)


def swap(text: str, one: Span, other: Span, *, sure: bool) -> Fix:
    """A fix that changes two pieces round."""
    first, second = text[one.start : one.end], text[other.start : other.end]
    return Fix(
        f"change `{first}` and `{second}` round", (Edit(one, second), Edit(other, first)), sure
    )
