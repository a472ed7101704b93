"""Faults of model files, and how they are shown."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import SequenceMatcher, get_close_matches
from enum import StrEnum
from typing import Protocol

from facetlog.grammar import syntax as s
from facetlog.grammar.source import Source, Span
from facetlog.grammar.units import UNITS, Dimension


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
    """Return a text after edits that do not overlap.

    >>> applied("between 9 and 4", [Edit(Span(8, 9), "4"), Edit(Span(14, 15), "9")])
    'between 4 and 9'
    """
    pieces, at = [], 0
    for edit in sorted(edits, key=lambda edit: edit.span):
        pieces += [text[at : edit.span.start], edit.text]
        at = edit.span.end
    return "".join([*pieces, text[at:]])


def make_insertion(title: str, at: int, text: str, *, sure: bool) -> Fix:
    """Return a fix that puts something in."""
    return Fix(title, (Edit(Span(at, at), text),), sure)


def make_removal(title: str, text: str, span: Span, *, sure: bool) -> tuple[Fix, ...]:
    """Return a fix that takes a statement out with its line; none if something else stands
    there."""
    start = text.rfind("\n", 0, span.start) + 1
    end = text.find("\n", span.end) + 1 or len(text)
    if text[start : span.start].strip() or text[span.end : end].strip():
        return ()
    return (Fix(title, (Edit(Span(start, end), ""),), sure),)


def swap(text: str, one: Span, other: Span, *, sure: bool) -> Fix:
    """Return a fix that changes two pieces round."""
    first, second = text[one.start : one.end], text[other.start : other.end]
    return Fix(
        f"change `{first}` and `{second}` round", (Edit(one, second), Edit(other, first)), sure
    )


SURELY_ALIKE = 0.8
"""difflib's ratio from which a word is surely meant: one slip in five letters."""

LEAD = 0.1
"""How much more alike than any other known word it must be."""


class Named(Protocol):
    """A word with its place."""

    @property
    def text(self) -> str:
        """The word."""

    @property
    def span(self) -> Span:
        """Where it stands."""


def alike(one: str, other: str) -> float:
    """Return difflib's ratio of two words: 1 if they are the same."""
    return SequenceMatcher(None, one, other).ratio()


def is_slip(word: str, meant: str) -> bool:
    """Return whether a word is another one with a slip of the pen, and not a name of its own.

    Names that differ in a figure, a word of theirs or their last letter are different on purpose;
    two letters that changed places are a slip however short the word.

    >>> is_slip("upwrad", "upward"), is_slip("corner_b", "corner_a"), is_slip("leg2", "leg")
    (True, False, False)
    >>> is_slip("titl", "tilt"), is_slip("angel", "angle")
    (True, True)
    """
    if any(word == _swap_letters(meant, at) for at in range(len(meant) - 1)):
        return not any(map(str.isdigit, word))
    if [c for c in word if c.isdigit()] != [c for c in meant if c.isdigit()]:
        return False
    if word.count("_") != meant.count("_"):
        return False
    if len(word) == len(meant) and word[:-1] == meant[:-1]:
        return False
    return alike(word, meant) >= SURELY_ALIKE


def _swap_letters(word: str, at: int) -> str:
    return f"{word[:at]}{word[at + 1]}{word[at]}{word[at + 2 :]}"


def make_respelling(name: Named, known: Iterable[str]) -> tuple[Fix, ...]:
    """Return the fix that writes the nearest known word; none if no word is like it."""
    found = get_close_matches(name.text, sorted(set(known)), n=2, cutoff=ALIKE)
    if not found:
        return ()
    best, *others = found
    clear = all(alike(name.text, best) >= alike(name.text, x) + LEAD for x in others)
    return (respell(name.span, best, sure=clear and is_slip(name.text, best)),)


def respell(span: Span, word: str, *, sure: bool) -> Fix:
    """Return the fix that writes a word in the place of another."""
    return Fix(f"write `{word}`", (Edit(span, word),), sure)


MOST_FAULTS = 50
"""Faults listed of one file: who has more has sent the wrong file."""

WIDTH = 140
"""Columns of a line that are shown with a fault."""

# difflib's own measure of likeness; at 0.6, its default, `adjoin` finds `adjoins` and `x` nothing.
ALIKE = 0.6


class Severity(StrEnum):
    """Errors keep a model from being used; warnings do not."""

    ERROR = "error"
    WARNING = "warning"


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault: what it is, where, and the way out.

    `code` is a stable name ("unknown-word"), `hint` a sentence that begins with a small letter, or
    empty. `fixes` are edits that put it right, the likeliest first; one at most is sure.
    """

    code: str
    message: str
    source: Source
    span: Span
    hint: str = ""
    severity: Severity = Severity.ERROR
    fixes: tuple[Fix, ...] = ()

    @property
    def sure_fix(self) -> Fix | None:
        """Return the fix that needs no question; None if there is none."""
        return next((fix for fix in self.fixes if fix.sure), None)

    @property
    def place(self) -> str:
        """File, line and column."""
        return self.source.place(self.span.start)

    def lines(self) -> Iterable[str]:
        """Iterate over the fault as text: place and message, the line, carets under the fault, the
        way out.
        """
        number, column = self.source.get_line_and_column(self.span.start)
        hint = f"; {self.hint}" if self.hint else ""
        yield f"{self.place}: {self.severity}: {self.message}{hint} [{self.code}]"
        text = self.source.line(number)
        if text.strip():
            # Of a long line the part round the fault.
            first = max(0, min(column - 1 - WIDTH // 2, len(text) - WIDTH))
            shown = text[first : first + WIDTH]
            at = column - 1 - first
            width = max(1, min(self.span.end - self.span.start, len(shown) - at))
            # Tabs stay tabs, so that the caret stands where the line shows it.
            lead = "".join("\t" if letter == "\t" else " " for letter in shown[:at])
            yield f"  {shown}"
            yield f"  {lead}{'^' * width}"


def said(word: str, known: Iterable[str]) -> str:
    """Return the hint that names the known word that is spelt most like it, or nothing.

    >>> said("adjoin", ["angle", "adjoins"])
    'did you mean `adjoins`?'
    """
    found = get_close_matches(word, sorted(set(known)), n=1, cutoff=ALIKE)
    return f"did you mean `{found[0]}`?" if found else ""


_USUAL = {
    Dimension.ANGLE: ("deg",),
    Dimension.LENGTH: ("cm", "m", "mm"),
    Dimension.AREA: ("m2", "cm2"),
}


def suggest_unit(
    node: s.Expression, wanted: Dimension, beside: Iterable[s.Expression | None]
) -> tuple[Fix, ...]:
    """Return the fixes that give a number a unit; `beside` are the quantities that it stands with.

    Sure if these have one unit of that dimension among them, and of an angle that is more than the
    full turn in radians.
    """
    if not isinstance(node, s.Quantity) or node.unit is not None:
        return ()
    near = {
        one.unit.text
        for one in beside
        if isinstance(one, s.Quantity) and one.unit is not None
        if one.unit.text in UNITS and UNITS[one.unit.text].dimension is wanted
    }
    units = (*sorted(near), *(u for u in _USUAL.get(wanted, ()) if u not in near))
    sure = len(near) == 1
    if not near and wanted is Dimension.ANGLE:
        sure = node.value > 2 * math.pi
    return tuple(
        make_insertion(f"write the unit `{unit}`", node.span.end, f" {unit}", sure=sure and i == 0)
        for i, unit in enumerate(units)
    )
