"""What holds of every solid: inequalities between measures, and conditions that exclude each other.

Only what the schema of facts says: bounds that these give are sure, but where it is said
otherwise. A face may stand askew in its thing, so that it is longer than the thing's least box: no
more than its diagonal is certain.
"""

import math
from collections.abc import Hashable, Iterable, Iterator, Mapping

from facetlog.grammar.lint.linear import Atom
from facetlog.grammar.scope import THIS

__all__ = [
    "HIGHER",
    "IMPLIES",
    "SLENDER",
    "THIN",
    "THROUGH_AT_LEAST",
    "THROUGH_AT_MOST",
    "TILT_AT_LEAST",
    "TILT_AT_MOST",
    "SolidBound",
    "excluded",
    "piece_bounds",
    "solid_bounds",
]

SolidBound = tuple[Atom, Atom, float, bool]
"""The first is at least so many times the second; whether that is sure."""

# Of one face, edge or thing: the first word's measure is at least the second's. The middle of a
# face is as high as most of it in all but ragged shapes: not certain.
_OF_ONE = (
    ("top_of", "elevation", True),
    ("elevation", "bottom_of", True),
    ("top_of", "bottom_of", True),
    ("top_of", "height", True),
    ("top_of", "clear_below", True),
    ("elevation", "clear_below", False),
    ("length", "width", True),
    ("width", "thickness", True),
)

# Of a thing (its highest point) and what belongs to it.
_HIGHEST = ("top_of", "height")
_HEIGHTS = ("top_of", "elevation", "bottom_of", "height", "clear_below")

# No two points of a thing are further apart than the corners of its box, whose longest side is its
# length.
_DIAGONAL = 1 / math.sqrt(3)
_REACHES = (
    "length",
    "width",
    "height",
    "edge_length",
    "protrusion",
    "reach_behind",
    "shared_length",
)

_THIS = f"${THIS}"


def solid_bounds(atoms: Iterable[Atom], this_holds_all: bool) -> Iterator[SolidBound]:
    """What holds between measured values, whatever solid they are of.

    `this_holds_all`: every element that is named belongs to the thing that is judged.
    """
    of_one: dict[Hashable, dict[str, Atom]] = {}
    shared: list[Atom] = []
    for atom in atoms:
        word = atom[0]
        if len(atom) == 2 and isinstance(word, str):
            if word == "shared_length":
                shared.append(atom)
            elif isinstance(atom[1], str):
                of_one.setdefault(atom[1], {})[word] = atom
    yield from _rectangles(atoms)
    for words in of_one.values():
        for greater, lesser, sure in _OF_ONE:
            if greater in words and lesser in words:
                yield words[greater], words[lesser], 1.0, sure
    this = of_one.pop(_THIS, {})
    if "top_of" in this and "height" in this:
        yield this["height"], this["top_of"], 1.0, True
    if not this_holds_all:
        return
    for name, words in of_one.items():
        if "." not in str(name):
            yield from _within(this, words)
    for atom in shared:
        if "length" in this:
            yield this["length"], atom, _DIAGONAL, True


def piece_bounds(word: str, of: str) -> Iterator[SolidBound]:
    """What a piece's measures are if it is a board, a bar or a block; nothing for other words."""
    long, wide, thick = (("length", of), ("width", of), ("thickness", of))
    if word == "board":
        yield wide, thick, 1.0 / THIN, True
    elif word in {"bar", "block"}:
        yield thick, wide, THIN, True
    if word == "bar":
        yield long, wide, 1.0 / SLENDER, True
    elif word == "block":
        yield wide, long, SLENDER, True


def _rectangles(atoms: Iterable[Atom]) -> Iterator[SolidBound]:
    """No face has a larger area than the least rectangle round it."""
    there = set(atoms)
    for atom in there:
        match atom:
            case ("*", frozenset() as sides):
                found = [_one_measure(side) for side in sides] * (3 - len(sides))
                if any(side is None for side in found):
                    continue
                (first, a), (second, b) = found  # type: ignore[misc]
                words = {first[0], second[0]}
                area: Atom = ("area", *first[1:])
                if first[1:] == second[1:] and area in there and words in _SIDES and a * b > 0:
                    yield atom, area, a * b, True


_SIDES = ({"length", "width"}, {"length"})


def _one_measure(key: Hashable) -> tuple[Atom, float] | None:
    """The measure and its factor, of a sum that is so many times one measure."""
    match key:
        case (0.0, frozenset() as terms) if len(terms) == 1:
            return next(iter(terms))  # type: ignore[no-any-return]
    return None


def _within(this: Mapping[str, Atom], words: Mapping[str, Atom]) -> Iterator[SolidBound]:
    for greater in _HIGHEST:
        if greater in this:
            for lesser in _HEIGHTS:
                if lesser in words:
                    yield this[greater], words[lesser], 1.0, True
    if "length" in this:
        for lesser in _REACHES:
            if lesser in words:
                yield this["length"], words[lesser], _DIAGONAL, True


# Conditions of the same elements that cannot both hold, and of two in the other order.
_EXCLUDES = {
    "convex": ("concave",),
    "concave": ("convex",),
    "upward": ("downward",),
    "downward": ("upward",),
    "level": ("upright",),
    "upright": ("level",),
    "above": ("below",),
    "below": ("above",),
    "board": ("bar", "block"),
    "bar": ("board", "block"),
    "block": ("board", "bar"),
}
_ONE_WAY = frozenset({"above", "below", "underside_of", "closes", "supports"})

TILT_AT_MOST: Mapping[str, float] = {"level": 10.0}
TILT_AT_LEAST: Mapping[str, float] = {"upright": 80.0}
"""`level` and `upright` as bounds of the tilt in degrees (rules/vocabulary.pl)."""

THIN, SLENDER = 0.35, 0.35
"""The thickness of a board is at most this share of its width, the width of a bar at most this of
its length (rules/vocabulary.pl)."""

THROUGH_AT_MOST: Mapping[str, float] = {"convex": 180.0}
THROUGH_AT_LEAST: Mapping[str, float] = {"concave": 180.0}
"""`convex` and `concave` as bounds of the dihedral in degrees (fact_schema.py)."""

HIGHER: Mapping[str, tuple[int, int]] = {"above": (0, 1), "below": (1, 0)}
"""Which of the two is the higher, and which the lower, of conditions that compare heights."""

IMPLIES: Mapping[str, tuple[str, ...]] = {
    "convex": ("adjoins",),
    "concave": ("adjoins",),
}
"""Conditions that say another of the same elements too: a solid bends at an edge of both."""


def excluded(key: Hashable) -> Iterator[Hashable]:
    """The conditions that cannot hold where this one does."""
    match key:
        case ("every", of_set, inner):
            for other in excluded(inner):
                yield "every", of_set, other
        case ("not", inner):
            yield inner
        case (str() as word, tuple() | frozenset() as of):
            yield "not", key
            for other in _EXCLUDES.get(word, ()):
                yield other, of
            if word in _ONE_WAY and isinstance(of, tuple) and len(of) == 2:
                yield word, (of[1], of[0])
        case _:
            yield "not", key
