"""What holds of every solid: inequalities between measures, and conditions that exclude each other.

Only what docs/facts.md says of the facts: bounds that these give are sure, but where it is said
otherwise. A face may stand askew in its thing, so that it is longer than the thing's least box: no
more than its diagonal is certain.
"""

import math
from collections.abc import Hashable, Iterable, Iterator, Mapping

from facetlog.grammar.lint.linear import Atom
from facetlog.grammar.scope import THIS

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
_REACHES = ("length", "width", "height", "edge_length", "protrusion", "reach_behind")

THIN, SLENDER = 0.35, 0.35
"""The thickness of a board is at most this share of its width, the width of a bar at most this of
its length (rules/vocabulary.pl)."""

AT_MOST: Mapping[str, tuple[str, float]] = {"level": ("tilt", 10.0), "convex": ("dihedral", 180.0)}
AT_LEAST: Mapping[str, tuple[str, float]] = {
    "upright": ("tilt", 80.0),
    "concave": ("dihedral", 180.0),
}
"""Conditions as bounds of an angle in degrees (rules/vocabulary.pl, docs/facts.md)."""

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


def iter_solid_bounds(atoms: Iterable[Atom], this_holds_all: bool) -> Iterator[SolidBound]:
    """Iterate over what holds between measured values, whatever solid they are of.

    `this_holds_all`: every element that is named belongs to the thing that is judged.
    """
    of_one: dict[Hashable, dict[str, Atom]] = {}
    for atom in atoms:
        if len(atom) == 2 and isinstance(atom[0], str) and isinstance(atom[1], str):
            of_one.setdefault(atom[1], {})[atom[0]] = atom
        elif this_holds_all and atom[0] == "shared_length":
            yield ("length", f"${THIS}"), atom, _DIAGONAL, True
    for words in of_one.values():
        for greater, lesser, sure in _OF_ONE:
            if greater in words and lesser in words:
                yield words[greater], words[lesser], 1.0, sure
    this = of_one.pop(f"${THIS}", {})
    if "top_of" in this and "height" in this:
        yield this["height"], this["top_of"], 1.0, True
    for name, words in of_one.items():
        if not this_holds_all or "." in str(name):
            continue
        for greater in _HIGHEST:
            if greater in this:
                yield from ((this[greater], words[x], 1.0, True) for x in _HEIGHTS if x in words)
        if "length" in this:
            yield from ((this["length"], words[x], _DIAGONAL, True) for x in _REACHES if x in words)


def iter_piece_bounds(word: str, of: str) -> Iterator[SolidBound]:
    """Iterate over the bounds of a piece that is a board, a bar or a block; else over nothing."""
    long, wide, thick = (("length", of), ("width", of), ("thickness", of))
    if word == "board":
        yield wide, thick, 1.0 / THIN, True
    elif word in {"bar", "block"}:
        yield thick, wide, THIN, True
    if word == "bar":
        yield long, wide, 1.0 / SLENDER, True
    elif word == "block":
        yield wide, long, SLENDER, True


def iter_excluded(key: Hashable) -> Iterator[Hashable]:
    """Iterate over the conditions that cannot hold where this one does."""
    match key:
        case ("every", of_set, inner):
            for other in iter_excluded(inner):
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
