"""Random scenes with rules of their own, and tests and models to be judged.

A test is a term as a nested tuple (functor, arguments...). Names are strings: faces, and variables,
which begin with a capital letter; lists are lists. Nothing here knows what a test means.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from random import Random

from tests.kb.meaning.models import Model, random_models
from tests.kb.meaning.random_tests import (
    FACES,
    FAULTY_MEASURES,
    OF_FACE,
    OPEN,
    OWN_MEASURES,
    VALUES,
    Drawing,
)
from tests.kb.meaning.terms import Term, prolog

__all__ = ["MODULES", "Case", "Facts", "random_case"]

MODULES = ("rules", "asking")  # models of the second ask for those of both
SDS = (0, 0, 0.01, 0.1, 5)

Facts = Mapping[tuple[object, ...], tuple[float, ...]]


@dataclass(frozen=True)
class Case:
    """A scene's facts (names, then numbers), rules, whether values are exact, and what is to be
    judged: tests, tests of each two faces X and Y, and models.

    `words` are short words with their meaning of X, `measures` the file's own.
    """

    facts: Facts
    words: Mapping[str, Term]
    measures: Mapping[str, tuple[str, float]]
    crisp: bool
    tests: Sequence[Term]
    pairs: Sequence[Term]
    models: Sequence[Model]

    def rules(self) -> tuple[list[str], list[str]]:
        """Return the texts of the clauses of the two files."""
        clauses = ["tolerance(own, 12)"]
        clauses += [f"means('{word}'(X), {prolog(test)})" for word, test in self.words.items()]
        for own, (measure, times) in self.measures.items():
            kind = next(kind for kind, names in OF_FACE.items() if measure in names)
            clauses.append(
                f"measured({own}(X), V, Sd, {kind}) :- measure({measure}(X), V0, Sd0, _), "
                f"V is {times}*V0, Sd is {times}*Sd0"
            )
        for own, (value, sd, kind, _) in FAULTY_MEASURES.items() if self.measures else ():
            answer = f"member([V, Sd, Kind], [[{value}, {sd}, {kind}]])"
            clauses.append(f"measured({own}(_), V, Sd, Kind) :- {answer}")
        texts = [clauses, ["tolerance(own, 7)"]]
        for model in self.models:
            texts[MODULES.index(model.module)] += model.clauses()
        return texts[0], texts[1]


def random_case(seed: int, tests: int, models: int = 2) -> Case:
    """Return a scene with so many tests and at most so many models, the same for the same seed."""
    draw = Random(seed)
    measures = {own: OWN_MEASURES[own] for own in OWN_MEASURES if draw.random() < 0.15}
    short = Drawing(draw, ("X",))
    words = {"own.one": short.test(2), "own.two": short.test(1)}
    crowded = draw.random() < 0.1
    chosen = random_models(draw, words, models, crowded=crowded)
    others = tuple(model.name for model in chosen)
    drawing = Drawing(draw, FACES, words=words, measures=tuple(measures), models=others)
    two_faces = Drawing(draw, ("X", "Y"), words=words)
    return Case(
        _facts(draw, (*FACES, "f5") if crowded else FACES),
        words,
        measures,
        draw.random() < 0.2,
        [drawing.test(draw.randint(1, 4)) for _ in range(tests - 1)] + [drawing.faulty()],
        [two_faces.test(draw.randint(0, 1)) for _ in range(2)],
        chosen,
    )


def _facts(draw: Random, faces: Sequence[str]) -> Facts:
    facts: dict[tuple[object, ...], tuple[float, ...]] = {("thing", "t1"): ()}
    for face in faces:
        facts["face", face] = ()
        if draw.random() < 0.95:
            facts["part_of", face, "t1"] = ()
        if draw.random() < 0.85:
            facts["evidence", face, "measured"] = ()
        for kind, names in OF_FACE.items():
            for name in names:
                if draw.random() < 0.75:
                    value = draw.choice(VALUES[kind]) + draw.choice((0, 0, 0.01, -0.1))
                    facts[name, face] = (float(value), float(draw.choice(SDS)))
                    if name in OPEN and draw.random() < 0.5:
                        ends = (float(draw.choice(VALUES[kind])) for _ in range(2))
                        facts["unseen_bounds", name, face] = tuple(ends)
        if draw.random() < 0.5:
            facts["upward", face] = ()
    for a, b in combinations(faces, 2):
        if draw.random() < 0.7:
            value = draw.choice(VALUES["deg"]) + draw.choice((0, 4))
            facts["angle", a, b] = facts["angle", b, a] = (float(value), float(draw.choice(SDS)))
        for name in ("adjoins", draw.choice(("convex", "concave")), "opposite"):
            if draw.random() < 0.4:
                facts[name, a, b] = facts[name, b, a] = ()
    if draw.random() < 0.5:
        facts["whole", "t1"] = ()
    if draw.random() < 0.7:
        facts[("up",)] = (0.0, 0.0, 1.0)
    if draw.random() < 0.7:
        facts["scale", "metric"] = ()
    return facts
