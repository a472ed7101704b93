"""A form and its sizes that a model describes: forms judged, the best fitted, and grown further."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import islice, zip_longest

from facetlog.prototype.assembly import Form
from facetlog.prototype.fit import fitted
from facetlog.prototype.forms import (
    COUNTS,
    MOST_PARTS,
    iter_grown_forms,
    iter_starting_forms,
    surfaces,
)
from facetlog.prototype.objective import iter_counts
from facetlog.prototype.workbench import Candidate, Workbench

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
    def counts(self) -> list[int]:
        """Numbers of repeated parts to try: few, and those that the model names."""
        proofs = (c.proof for one in self.tried.values() for c in one.judged.verdict.conditions)
        named = {count for proof in proofs for count in iter_counts(proof)}
        return sorted({*COUNTS, *(count for count in named if 2 <= count <= MOST_PARTS - 2)})

    @property
    def best(self) -> Candidate:
        """The best of all: the prototype, if it holds."""
        return self.ranked()[0]

    @property
    def holding(self) -> list[Candidate]:
        """The forms that hold, the best first."""
        return [candidate for candidate in self.ranked() if candidate.judged.holds]

    def ranked(self, among: Iterable[Candidate] | None = None) -> list[Candidate]:
        """Return candidates, the best first; of equals those with fewer sizes."""
        some = self.tried.values() if among is None else among
        return sorted(
            some, key=lambda c: (*(-x for x in c.judged.rank), len(c.judged.sizes), c.form.name)
        )

    def look(self, forms: Iterable[Form]) -> list[Candidate]:
        """Judge forms as they begin, those that were not before."""
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
        """Return the candidate with its sizes fitted."""
        judge = self.bench.trying(candidate.form)
        judged = fitted(candidate.judged, judge, enough=lambda: self.is_spent)
        better = Candidate(candidate.form, judged)
        self.tried[_key(candidate.form)] = better
        return better

    def grown(self, most: int = GROWING) -> Iterator[Form]:
        """Yield what one more group of parts makes of each of the best, of so many, in turn."""
        growing = [one for one in self.ranked() if one.form.grows][:most]
        counts = self.counts
        forms = [iter_grown_forms(one.form, one.judged.sizes, counts) for one in growing]
        for some in zip_longest(*forms):
            yield from (form for form in some if form is not None)

    def finds(self, forms: Iterable[Form]) -> bool:
        """Return whether one of some forms, or of the best of them once fitted, holds, or all is
        spent.
        """
        for candidate in islice(_unlike(self.ranked(self.look(forms))), FITTED):
            if self.fit(candidate).judged.holds:
                return True
        return self.is_spent


def _unlike(candidates: Iterable[Candidate]) -> Iterator[Candidate]:
    """Yield candidates that miss other conditions, or by other margins, than those before."""
    seen = set()
    for one in candidates:
        missed = {key: round(m, 2) for key, m in one.judged.margins.items() if m <= 0.0}
        if (how := frozenset(missed.items())) not in seen or one.judged.holds:
            seen.add(how)
            yield one


def _key(form: Form) -> str:
    return f"{form.name}: {', '.join(form.sizes)}"


def searched(bench: Workbench, most: int) -> Search:
    """Return a search that ends with the first form that holds once it is fitted, or after `most`
    solids.

    Raise ValueError if no form could be judged.
    """
    search = Search(bench, most)
    search.look(islice(iter_starting_forms(), 1))
    if search.finds(iter_starting_forms(search.counts)):
        return search
    # What is no solid counts if it holds, and as no evidence of what solids miss.
    seen = Search(bench, most)
    if seen.finds(surfaces()) and seen.holding:
        return seen
    for _ in range(GENERATIONS):
        # The other half is for fitting, and for what grows out of these.
        if search.finds(islice(search.grown(), (most - bench.judged) // 2)):
            break
    return search
