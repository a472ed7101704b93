"""A form and its sizes that a model describes: forms judged, the best fitted, and grown further."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from facetlog.prototype.assembly import Form
from facetlog.prototype.fit import fitted
from facetlog.prototype.forms import grown_from, starting_forms, surfaces
from facetlog.prototype.workbench import Candidate, Workbench

__all__ = ["Search", "searched"]

# How many of a generation are fitted, and how many grow further.
FITTED, GROWING = 4, 3
GENERATIONS = 3


@dataclass(slots=True)
class Search:
    """Forms that were judged on a workbench, each once; fewer than `most` solids are judged."""

    bench: Workbench
    most: int
    tried: dict[str, Candidate] = field(default_factory=dict)

    @property
    def is_spent(self) -> bool:
        """Whether no more may be judged."""
        return self.bench.judged >= self.most

    @property
    def best(self) -> Candidate:
        """The best of all: the prototype, if it holds."""
        return self.ranked()[0]

    @property
    def holding(self) -> list[Candidate]:
        """The forms that hold, the best first."""
        return [candidate for candidate in self.ranked() if candidate.judged.holds]

    def ranked(self, among: Iterable[Candidate] | None = None) -> list[Candidate]:
        """Candidates, the best first; of equals those with fewer sizes."""
        some = self.tried.values() if among is None else among
        return sorted(
            some, key=lambda c: (*(-x for x in c.judged.rank), len(c.judged.sizes), c.form.name)
        )

    def look(self, forms: Iterable[Form]) -> list[Candidate]:
        """Judges forms as they begin, those that were not before."""
        found = []
        for form in forms:
            if self.is_spent:
                break
            if _key(form) in self.tried:
                continue
            judged = self.bench.trying(form)(form.sizes)
            if judged is not None:
                found.append(Candidate(form, judged))
                self.tried[_key(form)] = found[-1]
        return found

    def fit(self, candidate: Candidate) -> Candidate:
        """The candidate with its sizes fitted."""
        judge = self.bench.trying(candidate.form)
        judged = fitted(candidate.judged, judge, enough=lambda: self.is_spent)
        better = Candidate(candidate.form, judged)
        self.tried[_key(candidate.form)] = better
        return better

    def grown(self, most: int = GROWING) -> Iterator[Form]:
        """What one more group of parts makes of each of the best, of so many."""
        growing = [one for one in self.ranked() if one.form.grows][:most]
        for one in growing:
            yield from grown_from(one.form, one.judged.sizes)

    def finds(self, forms: Iterable[Form]) -> bool:
        """Whether one of some forms, or of the best of them once fitted, holds, or all is spent."""
        for candidate in self.ranked(self.look(forms))[:FITTED]:
            if self.fit(candidate).judged.holds:
                return True
        return self.is_spent


def _key(form: Form) -> str:
    return f"{form.name}: {', '.join(form.sizes)}"


def searched(bench: Workbench, most: int) -> Search:
    """A search that ends with the first form that holds once it is fitted, or after `most` solids.

    Raises ValueError if no form could be judged.
    """
    search = Search(bench, most)
    if search.finds(starting_forms()):
        return search
    # What is no solid counts if it holds, and as no evidence of what solids miss.
    seen = Search(bench, most)
    if seen.finds(surfaces()) and seen.holding:
        return seen
    for _ in range(GENERATIONS):
        if search.finds(search.grown()):
            break
    return search
