"""Measures into terms: constants folded, lengths in metres, angles in degrees."""

from dataclasses import dataclass

from facetlog.grammar.constants import Constant
from facetlog.grammar.terms import Struct, Term
from facetlog.grammar.units import Dimension
from facetlog.grammar.vocabulary import IN_SPACE, OPENING, PIECE, THING, VOCABULARY, Kinds

__all__ = ["Bound", "aggregate_functor", "amount", "is_number", "scaled", "word_term"]

# What the vocabulary calls the measures of a thing that share their names with those of faces.
_OF_THINGS = {"length": "thing_length", "width": "thing_width", "height": "thing_height"}
# The words that are said of pieces and of others: of pieces by a name of their own, so that whoever
# asks of faces alone need not know the pieces.
_OF_PIECES_TOO = frozenset(word.name for word in VOCABULARY.values() if word.arguments[0] > PIECE)
# The words that are said of pieces and openings alike have one such name for both.
_IN_SPACE = frozenset(word.name for word in VOCABULARY.values() if word.arguments[0] == IN_SPACE)
# How the middle of one thing is compared with that of another whose words have other names.
_BY_ELEVATION = {"above": "at_least", "below": "at_most"}
_AGGREGATES = {"smallest gap": "smallest_gap", "largest gap": "largest_gap"}


@dataclass(frozen=True, slots=True)
class Bound:
    """What a name stands for in a clause: its term, kinds, and the model of an object."""

    term: Term
    kinds: Kinds
    model: str = ""


def amount(value: Constant) -> Term:
    """A constant as a test writes it."""
    if value.value == 0:
        return 0
    match value.dimension:
        case Dimension.LENGTH:
            return Struct("metres", (value.value,))
        case Dimension.AREA:
            return Struct("*", (Struct("metres", (value.value,)), Struct("metres", (1,))))
        case _:
            return value.value


def scaled(factor: float, term: Term) -> Term:
    """So many times a measure."""
    factor = float(f"{factor:.15g}")
    if factor == 1:
        return term
    if isinstance(term, int | float):
        return float(f"{factor * term:.15g}")
    if isinstance(term, Struct) and term.functor == "metres":
        (value,) = term.args
        if isinstance(value, int | float):
            return Struct("metres", (float(f"{factor * value:.15g}"),))
    return Struct("*", (factor, term))


def word_term(name: str, arguments: tuple[Bound, ...]) -> Struct:
    """A measure or relation of the vocabulary with its arguments."""
    if name in _BY_ELEVATION and arguments[0].kinds != arguments[1].kinds:
        middles = tuple(word_term("elevation", (argument,)) for argument in arguments)
        return Struct(_BY_ELEVATION[name], middles)
    kinds = arguments[0].kinds
    if name in _OF_THINGS and kinds == THING:
        name = _OF_THINGS[name]
    elif (name in _OF_PIECES_TOO and kinds == PIECE) or (name in _IN_SPACE and kinds <= IN_SPACE):
        name = f"piece_{name}"
    elif kinds == OPENING:
        name = f"opening_{name}"
    return Struct(name, tuple(argument.term for argument in arguments))


def aggregate_functor(how: str) -> str:
    """What the vocabulary calls an aggregate."""
    return _AGGREGATES.get(how, how)


def is_number(term: Term) -> bool:
    """Whether a term is a number, or a length in metres."""
    return isinstance(term, int | float) or (isinstance(term, Struct) and term.functor == "metres")
