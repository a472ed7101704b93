"""Random tests: every form within each other, of relations, comparisons, words, other models."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from random import Random

from tests.kb.meaning.terms import Term

__all__ = ["FACES", "FAULTY_MEASURES", "OF_FACE", "OPEN", "OWN_MEASURES", "VALUES", "Drawing"]

FACES = ("f1", "f2", "f3", "f4")
RELATIONS = ("measured", "upward", "adjoins", "convex", "opposite")
OF_ONE = ("measured", "upward")

# Measures of one face by their kind, with values that limits are drawn from.
OF_FACE = {
    "deg": ("tilt",),
    "ratio": ("fill", "share", "free_below"),
    "length": ("width", "length", "protrusion", "room_below"),
    "area": ("area",),
}
VALUES = {
    "deg": (0, 10, 80, 90, 100),
    "ratio": (0, 0.5, 0.8, 1),
    "length": (0, 0.2, 1),
    "area": (0, 0.5, 2),
}
# Those that space which was not seen may change.
OPEN = ("free_below", "room_below")
# Measures that a file of rules defines, as so many times one of the vocabulary, and such as none
# may: value, deviation and kind, and what is wrong with them.
OWN_MEASURES = {"own_fill": ("fill", 2.0), "own_width": ("width", 0.5)}
KINDS = "oneof([deg,ratio,count,length,area])"
FAULTY_MEASURES = {
    "no_number": ("many", "0.1", "deg", ("type_error", "number", "many")),
    "no_finite": ("1.0Inf", "0.1", "deg", ("domain_error", "finite_number", "1.0Inf")),
    "no_sd": ("2", "-1", "deg", ("domain_error", "standard_deviation", "-1")),
    "no_kind": ("2", "0.1", "weight", ("type_error", KINDS, "weight")),
}


@dataclass(frozen=True)
class Drawing:
    """Names that a test may use: faces or variables for them, a thing, lists of faces and of groups
    of them, words and measures of the rules, other models."""

    draw: Random
    names: Sequence[str]
    thing: str = "t1"
    faces: Sequence[str] = ()
    groups: Sequence[str] = ()
    words: Mapping[str, Term] = field(default_factory=dict)
    measures: Sequence[str] = ()
    models: Sequence[str] = ()

    def test(self, depth: int) -> Term:
        """Return a test within which so many others stand."""
        if depth == 0 or self.draw.random() < 0.25:
            return self._leaf()
        forms = self._forms(depth)
        return forms[self.draw.choice(list(forms))]()

    def _forms(self, depth: int) -> dict[str, Callable[[], Term]]:
        draw, variable = self.draw, f"V{depth}"

        def inner() -> Term:
            return self.test(depth - 1)

        def quantified(*variables: str) -> Term:
            return replace(self, names=(*self.names, *variables * 2)).test(depth - 1)

        def list_of_faces() -> Term:
            if self.faces and draw.random() < 0.8:
                return draw.choice(self.faces)
            faces = draw.sample(self.names, draw.randint(0, min(3, len(self.names))))
            return [*faces, "unseen"] if draw.random() < 0.1 else faces

        def groups() -> Term:
            if self.groups and draw.random() < 0.8:
                return draw.choice(self.groups)
            return [list_of_faces() for _ in range(draw.randint(0, 3))]

        return {
            "all": lambda: ("all", [inner() for _ in range(draw.randint(0, 3))]),
            "any": lambda: ("any", [inner() for _ in range(draw.randint(0, 3))]),
            "not": lambda: ("not", inner()),
            "if_known": lambda: ("if_known", inner()),
            "implies": lambda: ("implies", inner(), inner()),
            "expect": lambda: ("expect", draw.choice((0, 0.25, 1)), inner()),
            "each": lambda: ("each", variable, list_of_faces(), quantified(variable)),
            "some": lambda: ("some", variable, list_of_faces(), quantified(variable)),
            "each_pair": lambda: (
                "each_pair", variable, f"{variable}b", list_of_faces(),
                quantified(variable, f"{variable}b"),
            ),
            "at_least_of": lambda: (
                "at_least_of", draw.randint(0, 3), variable, groups(), quantified(variable),
            ),
            "at_least_in": lambda: (
                "at_least_in", draw.randint(0, 3),
                ("whole", self.thing) if draw.random() < 0.7 else inner(),
                variable, groups(), quantified(variable),
            ),
            "at_most_of": lambda: (
                "at_most_of", draw.randint(0, 2), variable, groups(), quantified(variable),
            ),
        }  # fmt: skip

    def _leaf(self) -> Term:
        draw = self.draw
        if self.models and draw.random() < 0.1:
            thing = draw.choice((self.thing,) * 4 + ("unseen", "t9"))
            return ("is_a", thing, draw.choice(self.models))
        if self.words and draw.random() < 0.2:
            return (draw.choice(list(self.words)), draw.choice(self.names))
        if draw.random() < 0.3:
            name = draw.choice((*RELATIONS, "whole"))
            if name == "whole":
                return (name, self.thing)
            return (name, *(draw.choice(self.names) for _ in range(1 if name in OF_ONE else 2)))
        if draw.random() < 0.1:
            counted = ("count", [draw.choice(self.names) for _ in range(draw.randint(0, 3))])
            return self._compared(counted, lambda: draw.randint(0, 3))
        kind = draw.choice(list(OF_FACE))
        return self._compared(self._expression(kind, 1), lambda: self._limit(kind))

    def faulty(self) -> Term:
        """Return a comparison of what may not be compared, of a measure whose clause gives
        nonsense, or of a tolerance that nobody named; or else one that is in order."""
        draw = self.draw
        kinds = draw.choice((("length", "deg"), ("area", "length"), ("ratio", "area")))
        one, two = (self._expression(kind, 0) for kind in kinds)
        three = self._expression(kinds[0], 0)
        faulty: Term = (draw.choice(list(FAULTY_MEASURES)), draw.choice(self.names))
        return draw.choice(
            (
                self._compared(one, lambda: draw.choice((0, 3, two))),
                ("at_least", (draw.choice("+-"), one, two), draw.choice((0, three))),
                ("at_most", (draw.choice(("lowest", "mean", "sum")), [three, one, two]), three),
                ("at_most", faulty, 3),
                ("at_least", ("-", faulty), ("*", 2, faulty)),
                ("between", one, three, ("tolerance", "unnamed")),
            )
        )

    def _compared(self, measure: Term, limit: Callable[[], Term]) -> Term:
        def finite() -> Term:
            found = limit()
            return 1 if isinstance(found, float) and math.isinf(found) else found

        form = self.draw.choice(("near", "between", "at_least", "at_most"))
        limits = {"near": (finite, finite), "between": (limit, limit)}.get(form, (limit,))
        test: Term = (form, measure, *(one() for one in limits))
        if self.draw.random() < 0.2:
            return ("soft", test, self.draw.choice((0, 0.1, 0.5)))
        return ("fading", test, finite()) if self.draw.random() < 0.2 else test

    def _limit(self, kind: str) -> Term:
        draw = self.draw
        # Of a bare number only angles and ratios know the unit.
        if kind in ("deg", "ratio") and draw.random() < 0.8:
            named = ("tolerance", draw.choice(("level", "own")))
            return draw.choice((*VALUES[kind], math.inf, -math.inf, named))
        if kind == "length" and draw.random() < 0.3:
            return ("metres", draw.choice(VALUES[kind]))
        return self._expression(kind, 0)

    def _expression(self, kind: str, depth: int) -> Term:
        draw = self.draw
        way = draw.random()
        if depth and way < 0.3:
            return (draw.choice("+-"), *(self._expression(kind, depth - 1) for _ in "ab"))
        if depth and way < 0.4:
            return ("*", draw.choice((0.5, 2, 1, 0)), self._expression(kind, depth - 1))
        if depth and way < 0.5:
            some = [self._expression(kind, 0) for _ in range(draw.randint(0, 3))]
            how = ("lowest", "highest", "sum", "mean", "smallest_step", "largest_step")
            return (draw.choice(how), some)
        if depth and way < 0.55:
            return ("-", self._expression(kind, depth - 1))
        if kind == "ratio" and way < 0.65:
            other = draw.choice(("length", "area"))
            return ("/", *(self._expression(other, 0) for _ in "ab"))
        if kind == "deg" and way < 0.8:
            return ("angle", draw.choice(self.names), draw.choice(self.names))
        if kind == "area" and depth and way < 0.7:
            return ("*", self._expression("length", 0), self._expression("length", 0))
        own = [name for name in self.measures if OWN_MEASURES[name][0] in OF_FACE[kind]]
        return (draw.choice((*OF_FACE[kind], *own * 3)), draw.choice(self.names))
