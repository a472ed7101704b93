"""Conditions of a model that cannot be met together, as far as solids were tried."""

from collections.abc import Collection, Iterable
from itertools import combinations

from facetlog.prototype.fit import slopes, stepped
from facetlog.prototype.search import Search
from facetlog.prototype.workbench import Candidate

# Sets of more conditions are explained by no one.
MOST_TOGETHER = 3
# How often a set is tried to be met by itself, by how many forms, in how many steps.
ROUNDS, FORMS, STEPS = 6, 3, 4
REACH = 0.7


def find_never_together(missed: Iterable[Collection[str]]) -> tuple[str, ...]:
    """Return the fewest labels of which each of the sets has one: what no solid met all of.

    >>> find_never_together([{"wide", "high"}, {"narrow"}, {"wide"}])
    ('narrow', 'wide')
    >>> find_never_together([{"wide"}, set()])
    ()
    """
    sets = [frozenset(each) for each in missed]
    if not all(sets):
        return ()
    labels = sorted(frozenset().union(*sets))
    for count in range(1, MOST_TOGETHER + 1):
        for some in combinations(labels, count):
            if all(each.intersection(some) for each in sets):
                return some
    return tuple(labels)


def conflict(search: Search) -> tuple[str, ...]:
    """Return labels of what no solid met together, after sizes were fitted to meet them and nothing
    else.

    Of a search in which nothing holds.
    """
    found = find_never_together(search.bench.missed)
    for _ in range(ROUNDS):
        nearest = sorted(
            search.ranked(), key=lambda candidate: len({*candidate.judged.missed} & {*found})
        )
        for candidate in nearest[:FORMS]:
            _towards(search, candidate, found)
        now = find_never_together(search.bench.missed)
        if now == found:
            break
        found = now
    return found


def _towards(search: Search, candidate: Candidate, labels: Collection[str]) -> None:
    """Judge sizes that are to meet some conditions, whatever becomes of the others."""
    judge, at, reach = search.bench.trying(candidate.form), candidate.judged, REACH
    for _ in range(STEPS):
        wanted = {key: margin for key, margin in at.margins.items() if key[0] in labels}
        if not wanted:
            return
        found = judge(stepped(at, wanted, slopes(at, judge), reach))
        if found is None:
            reach /= 2.0
            continue
        at = found
        if not {*at.missed} & {*labels}:
            return
