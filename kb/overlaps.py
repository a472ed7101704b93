"""Users' models that do not go without a built-in one, in the scenes at hand."""

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

from facetlog.kb.explaining.wording import add_article, listed
from facetlog.plurals import many

if TYPE_CHECKING:
    from facetlog.grammar.analysis import Analysis

__all__ = ["Overlaps", "list_stated_orders"]

SAME_DEGREE = 0.005
"""Degrees that differ by less are written as the same per cent."""

FEWEST = 2
"""Things of which "all" may be said."""


def list_stated_orders(analyses: "Iterable[Analysis]") -> dict[str, frozenset[str]]:
    """Return by model of these files the others that it names as what it is or comes before."""
    return {
        name: frozenset((*model.ancestors, *(other.text for other in model.written.rather_than)))
        for analysis in analyses
        for name, model in analysis.models.items()
    }


class Overlaps:
    """For each of a user's models the built-in ones that held of all things that it held of, to the
    same degree or a higher one, so that names are told apart by their order alone.

    `stated` has by model the others that it already names: those it is a special case of, and those
    it is to come before.
    """

    def __init__(self, stated: Mapping[str, Iterable[str]]) -> None:
        self._stated = {model: frozenset(others) for model, others in stated.items()}
        self._counts = dict.fromkeys(self._stated, 0)
        self._shared: dict[str, frozenset[str]] = {}

    def add(self, holding: Iterable[tuple[str, str, float]]) -> None:
        """Count what holds in one scene: thing, model and degree of each verdict."""
        found = tuple(holding)
        for thing, model, degree in found:
            if model not in self._stated:
                continue
            self._counts[model] += 1
            others = frozenset(
                other
                for its_thing, other, its_degree in found
                if its_thing == thing
                and its_degree > degree - SAME_DEGREE
                and other not in self._stated
            )
            self._shared[model] = self._shared.get(model, others) & others - self._stated[model]

    def iter_lines(self) -> Iterator[str]:
        """Yield a line for each model of a user that never held without a built-in one.

        >>> overlaps = Overlaps({"cart": ()})
        >>> for _ in range(4):
        ...     overlaps.add([("t1", "cart", 0.9), ("t1", "table", 1.0)])
        >>> list(overlaps.iter_lines())
        ['all 4 things that are a cart are a table, too: write `model cart rather than table`']
        """
        for model, others in sorted(self._shared.items()):
            count = self._counts[model]
            if count >= FEWEST and others:
                named = ", ".join(sorted(others))
                kinds = listed([add_article(other) for other in sorted(others)])
                yield (
                    f"all {many(count, 'thing')} that are {add_article(model)} are {kinds}, too: "
                    f"write `model {model} rather than {named}`"
                )
