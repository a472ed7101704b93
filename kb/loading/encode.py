"""Facts to Prolog text."""

import math
from collections.abc import Iterable, Iterator
from functools import lru_cache
from typing import TypeAlias

from facetlog.grammar.vocabulary import VOCABULARY
from facetlog.kb.engine.terms import Atom, Struct, format_prolog_term
from facetlog.perception.facts.fact_schema import FACT_SCHEMA

__all__ = ["Fact", "declarations", "format_argument", "format_fact_clause", "iter_program_lines"]

Fact: TypeAlias = tuple[str | int | float, ...]
"""A functor's name and its arguments: strings are atoms."""


def format_fact_clause(fact: Fact) -> str:
    """Return the fact as one clause, with its full stop.

    Raise TypeError for what is no fact, and ValueError for a number that is not finite.

    >>> format_fact_clause(("angle", "f1", "f2", 90.25, 1e-05))
    "'angle'('f1','f2',90.25,1.0e-05)."
    """
    functor, *args = fact
    if not isinstance(functor, str):
        raise TypeError(f"a fact begins with the name of its functor, not {functor!r}")
    texts = [format_argument(argument, fact) for argument in args]
    return f"{_name(functor)}({','.join(texts)})."


def format_argument(argument: object, fact: Fact) -> str:
    """Return one argument of the fact in Prolog syntax; errors as in `format_fact_clause`."""
    if isinstance(argument, str):
        return _name(argument)
    if not isinstance(argument, int | float):
        raise TypeError(f"{argument!r} in {fact} is neither a text nor a number")
    if isinstance(argument, float) and not math.isfinite(argument):
        raise ValueError(f"facts have no {argument}: {fact}")
    return format_prolog_term(argument)


@lru_cache(maxsize=10_000)
def _name(text: str) -> str:
    # The same few thousand names come again and again.
    return format_prolog_term(Atom(text))


def iter_program_lines(facts: Iterable[Fact]) -> Iterator[str]:
    """Return lines of a file that `swipl` loads by itself, for `facts.pl`."""
    yield "% Facts of one scene; `facetlog model words facts` explains them."
    yield ":- style_check(-discontiguous)."
    yield from map(format_fact_clause, facts)


def declarations() -> str:
    """Return the facts and the words of models, for declare_facts/1 of schema.pl."""
    facts = (
        Struct(
            "declared",
            (
                Atom(kind.functor),
                tuple(Struct("-", (Atom(a.name), Atom(a.kind.value))) for a in kind.arguments),
                kind.meaning,
            ),
        )
        for kind in FACT_SCHEMA
    )
    words = (Struct("means", (Atom(word.name), word.meaning)) for word in VOCABULARY.values())
    return format_prolog_term((*facts, *words))
