"""Which word was meant, and whether that is sure."""

from collections.abc import Iterable
from difflib import SequenceMatcher, get_close_matches
from typing import Protocol

from facetlog.grammar.faults import ALIKE
from facetlog.grammar.fixing.fix import Edit, Fix
from facetlog.grammar.source import Span

__all__ = ["Named", "alike", "is_slip", "respelling", "respelt"]

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
    """difflib's ratio of two words: 1 if they are the same."""
    return SequenceMatcher(None, one, other).ratio()


def is_slip(word: str, meant: str) -> bool:
    """Whether a word is another one with a slip of the pen, and not a name of its own.

    Names that differ in a figure, a word of theirs or their last letter are different on purpose;
    two letters that changed places are a slip however short the word.

    >>> is_slip("upwrad", "upward"), is_slip("corner_b", "corner_a"), is_slip("leg2", "leg")
    (True, False, False)
    >>> is_slip("titl", "tilt"), is_slip("angel", "angle")
    (True, True)
    """
    if any(word == _swapped(meant, at) for at in range(len(meant) - 1)):
        return not any(map(str.isdigit, word))
    if [c for c in word if c.isdigit()] != [c for c in meant if c.isdigit()]:
        return False
    if word.count("_") != meant.count("_"):
        return False
    if len(word) == len(meant) and word[:-1] == meant[:-1]:
        return False
    return alike(word, meant) >= SURELY_ALIKE


def _swapped(word: str, at: int) -> str:
    return f"{word[:at]}{word[at + 1]}{word[at]}{word[at + 2 :]}"


def respelling(name: Named, known: Iterable[str]) -> tuple[Fix, ...]:
    """The fix that writes the nearest known word; none if no word is like it."""
    found = get_close_matches(name.text, sorted(set(known)), n=2, cutoff=ALIKE)
    if not found:
        return ()
    best, *others = found
    clear = all(alike(name.text, best) >= alike(name.text, x) + LEAD for x in others)
    return (respelt(name.span, best, sure=clear and is_slip(name.text, best)),)


def respelt(span: Span, word: str, *, sure: bool) -> Fix:
    """The fix that writes a word in the place of another."""
    return Fix(f"write `{word}`", (Edit(span, word),), sure)
