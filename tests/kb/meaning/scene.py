"""Scene of the reference: the facts of a case and what names stand for at the moment."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

from tests.kb.meaning.cases import Case
from tests.kb.meaning.terms import Term

__all__ = ["FAILS", "HOLDS", "STATES", "UNKNOWN", "FaultyTestError", "Outline", "Scene"]

# States as numbers, which makes Kleene's connectives a minimum, a maximum and a difference.
STATES = {0.0: "fails", 0.5: "unknown", 1.0: "holds"}
HOLDS, UNKNOWN, FAILS = 1.0, 0.5, 0.0

# State, least and greatest probability, by how much it fails.
Outline = tuple[float, float, float, float]


class FaultyTestError(Exception):
    """A test has no meaning: the kind of Prolog's error, what was expected, the culprit."""

    def __init__(self, kind: str, expected: str, culprit: Term) -> None:
        super().__init__(kind, expected, culprit)
        self.kind, self.expected, self.culprit = kind, expected, culprit


@dataclass(frozen=True)
class Scene:
    """Facts, with what variables stand for: a face, or a list of faces or of groups.

    `module` has the words and tolerances of tests; `judged` are the models (of the thing t1) that
    are being judged, and `verdict` gives what a model comes to in a scene, with why not if nothing
    is known. `reading` is what space that was not seen is taken for, if that is asked: 0 for free,
    1 for full.
    """

    case: Case
    verdict: Callable[[Scene, str], Outline]
    module: str = "rules"
    names: Mapping[str, Term] = field(default_factory=dict)
    judged: tuple[str, ...] = ()
    reading: int | None = None

    def name(self, name: Term) -> Term:
        """Return the value of the name."""
        return self.names.get(name, name) if isinstance(name, str) else name

    def list(self, values: Term) -> list[Term]:
        """Return the elements of a list or of what a variable stands for."""
        found = self.name(values)
        assert isinstance(found, list)
        return [self.name(value) for value in found]

    def with_names(self, names: Mapping[str, Term]) -> Scene:
        """Return a scene where variables stand for these, too."""
        return replace(self, names={**self.names, **names})

    def read_as(self, reading: int) -> Scene:
        """Return a scene where space that was not seen is free (0), or full (1)."""
        return replace(self, reading=reading)

    def fact(self, *key: object) -> tuple[float, ...] | None:
        """Return the numbers of a fact, None if it is not stated."""
        return self.case.facts.get(key)

    def written(self, term: Term) -> Term:
        """Return the term with what its variables stand for."""
        if isinstance(term, tuple):
            return (term[0], *(self.written(part) for part in term[1:]))
        if isinstance(term, list):
            return [self.written(part) for part in term]
        return self.name(term)
