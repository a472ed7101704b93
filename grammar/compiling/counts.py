"""How many there must be: counts into tests, and when too few, or none, are known to be all."""

import math
from collections.abc import Mapping

from facetlog.grammar import syntax as s
from facetlog.grammar.compiling.writer import NOTHING, all_of
from facetlog.grammar.terms import Struct, Term, Var
from facetlog.grammar.vocabulary import OPENING, PIECE, Kinds

__all__ = ["amount_test", "count_numbers", "some_test"]

_NO_MORE: Mapping[Kinds, Struct] = {
    PIECE: Struct("whole", (Var("Thing"),)),
    OPENING: Struct("openings_known", (Var("Thing"),)),
}
"""Of what all that a thing has may be known, and the test that it is: a round leg has no face, but
is a piece."""


def count_numbers(count: s.Count) -> tuple[float, float]:
    """The least and the greatest number that a count allows."""
    low = float(count.low.text) if count.low else 0.0
    high = float(count.high.text) if count.high else math.inf
    match count.kind:
        case s.CountKind.AT_LEAST:
            return low, math.inf
        case s.CountKind.AT_MOST:
            return -math.inf, high
        case s.CountKind.ANY:
            return -math.inf, math.inf
        case _:
            return low, high


def some_test(found: Struct, among: Kinds, *, some: bool) -> Term:
    """The test that one was found `among` all of such kinds that a thing has, or that none was.

    As long as a thing may have more openings than were seen nobody knows that there is none; what
    there is besides of other kinds is not asked.
    """
    if among != OPENING:
        return found if some else Struct("not", (found,))
    known = _NO_MORE[OPENING]
    if some:
        return Struct("any", ((found, Struct("not", (known,))),))
    return all_of([Struct("not", (found,)), known])


def amount_test(
    pattern: Term, groups: Term, test: Term, low: float, high: float, among: Kinds
) -> Term:
    """The test of so many groups, `among` all of such kinds that a thing has."""
    tests: list[Term] = []
    known = _NO_MORE.get(among)
    if low > 0 and math.isfinite(low):
        least = math.ceil(low)
        if known is not None:
            counted = Struct("at_least_in", (least, known, pattern, groups, test))
        else:
            counted = Struct("at_least_of", (least, pattern, groups, test))
        tests.append(counted)
    if math.isfinite(high):
        tests.append(Struct("at_most_of", (math.floor(high), pattern, groups, test)))
        if among == OPENING:
            tests.append(_NO_MORE[OPENING])
    return all_of(tests) if tests else NOTHING
