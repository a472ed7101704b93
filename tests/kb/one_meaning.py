"""Random tests of random scenes, and what they mean by the reference: one definition, from the
paper and docs/models.md, that shares nothing with the program's.

A test is a term as a nested tuple (functor, arguments...); faces are names, lists are lists. The
reference says (state, low, high, miss) of it, states as numbers: 0 fails, ½ unknown, 1 holds, which
makes Kleene's connectives a minimum, a maximum and a difference.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from random import Random

__all__ = ["STATES", "Case", "Outline", "prolog", "random_case", "reference"]

FACES = ("f1", "f2", "f3", "f4")
STATES = {0.0: "fails", 0.5: "unknown", 1.0: "holds"}
HOLDS, UNKNOWN, FAILS = 1.0, 0.5, 0.0

Term = object
Outline = tuple[float, float, float, float]

# Measures of one face by their kind, with values that limits are drawn from.
OF_FACE = {
    "deg": ("tilt",),
    "ratio": ("fill", "share"),
    "length": ("width", "protrusion"),
    "area": ("area",),
}
VALUES = {
    "deg": (0, 10, 80, 90, 100),
    "ratio": (0, 0.5, 0.8, 1),
    "length": (0, 0.2, 1),
    "area": (0, 0.5, 2),
}
SDS = (0, 0, 0.01, 0.1, 5)
RELATIONS = ("measured", "upward", "adjoins", "convex", "opposite")


@dataclass(frozen=True)
class Case:
    """A scene's facts, the words of its rules, whether values are exact, and the tests."""

    facts: Mapping[tuple[object, ...], tuple[float, ...]]
    words: Mapping[str, Term]
    crisp: bool
    tests: Sequence[Term]


def prolog(term: Term) -> str:
    """The text of a term."""
    if isinstance(term, tuple):
        return f"'{term[0]}'({','.join(map(prolog, term[1:]))})"
    if isinstance(term, list):
        return f"[{','.join(map(prolog, term))}]"
    if isinstance(term, float) and math.isinf(term):
        return "1.0Inf" if term > 0 else "-1.0Inf"
    return repr(term) if isinstance(term, float) else str(term)


# ------------------------------------------------------------------------------------------ drawing


def random_case(seed: int, tests: int) -> Case:
    """A scene and so many tests of it, the same for the same seed."""
    draw = Random(seed)
    facts: dict[tuple[object, ...], tuple[float, ...]] = {}
    for face in FACES:
        facts["face", face] = ()
        if draw.random() < 0.8:
            facts["evidence", face, "measured"] = ()
        for kind, names in OF_FACE.items():
            for name in names:
                if draw.random() < 0.75:
                    value = draw.choice(VALUES[kind]) + draw.choice((0, 0, 0.01, -0.1))
                    facts[name, face] = (float(value), float(draw.choice(SDS)))
        if draw.random() < 0.5:
            facts["upward", face] = ()
    for a, b in combinations(FACES, 2):
        if draw.random() < 0.7:
            angle = (
                float(draw.choice(VALUES["deg"]) + draw.choice((0, 4))),
                float(draw.choice(SDS)),
            )
            facts["angle", a, b] = facts["angle", b, a] = angle
        for name in ("adjoins", draw.choice(("convex", "concave")), "opposite"):
            if draw.random() < 0.4:
                facts[name, a, b] = facts[name, b, a] = ()
    if draw.random() < 0.5:
        facts["whole", "t1"] = ()
    words = {"own.one": _test(draw, 2, ("X",)), "own.two": _test(draw, 1, ("X",))}
    return Case(
        facts,
        words,
        draw.random() < 0.2,
        [_test(draw, draw.randint(1, 4), FACES, words) for _ in range(tests)],
    )


def _test(draw: Random, depth: int, names: Sequence[str], words: Mapping[str, Term] = {}) -> Term:
    def inner() -> Term:
        return _test(draw, depth - 1, names, words)

    def quantified(*variables: str) -> Term:
        return _test(draw, depth - 1, (*names, *variables * 2), words)

    def some_faces() -> list[str]:
        faces = draw.sample(FACES, draw.randint(0, 3))
        return [*faces, "unseen"] if draw.random() < 0.1 else faces

    variable = f"V{depth}"
    forms: dict[str, Callable[[], Term]] = {
        "all": lambda: ("all", [inner() for _ in range(draw.randint(0, 3))]),
        "any": lambda: ("any", [inner() for _ in range(draw.randint(0, 3))]),
        "not": lambda: ("not", inner()),
        "if_known": lambda: ("if_known", inner()),
        "implies": lambda: ("implies", inner(), inner()),
        "expect": lambda: ("expect", draw.choice((0, 0.25, 1)), inner()),
        "each": lambda: ("each", variable, some_faces(), quantified(variable)),
        "some": lambda: ("some", variable, some_faces(), quantified(variable)),
        "each_pair": lambda: (
            "each_pair", variable, f"{variable}b", some_faces(),
            quantified(variable, f"{variable}b"),
        ),
        "at_least_of": lambda: (
            "at_least_of", draw.randint(0, 3), variable,
            [some_faces() for _ in range(draw.randint(0, 3))], quantified(variable),
        ),
        "at_most_of": lambda: (
            "at_most_of", draw.randint(0, 2), variable,
            [some_faces() for _ in range(draw.randint(0, 3))], quantified(variable),
        ),
    }  # fmt: skip
    leaf = depth == 0 or draw.random() < 0.25
    if not leaf:
        return forms[draw.choice(list(forms))]()
    if words and draw.random() < 0.2:
        return (draw.choice(list(words)), draw.choice(names))
    if draw.random() < 0.3:
        name = draw.choice((*RELATIONS, "whole"))
        if name == "whole":
            return (name, "t1")
        return (
            name,
            *(draw.choice(names) for _ in range(1 if name in ("measured", "upward") else 2)),
        )
    return _comparison(draw, names)


def _comparison(draw: Random, names: Sequence[str]) -> Term:
    if draw.random() < 0.1:
        counted = ("count", [draw.choice(names) for _ in range(draw.randint(0, 3))])
        bound = draw.choice(("at_least", "at_most", "near"))
        return (bound, counted, draw.randint(0, 3), *((1,) if bound == "near" else ()))
    kind = draw.choice(list(OF_FACE))
    measure = _expression(draw, kind, names, 1)

    def limit() -> Term:
        # Of a bare number only angles and ratios know the unit.
        if kind in ("deg", "ratio") and draw.random() < 0.8:
            return draw.choice((*VALUES[kind], math.inf, -math.inf))
        return _expression(draw, kind, names, 0)

    def finite() -> Term:
        found = limit()
        return 1 if isinstance(found, float) and math.isinf(found) else found

    test: Term = {
        "near": lambda: ("near", measure, finite(), finite()),
        "between": lambda: ("between", measure, limit(), limit()),
        "at_least": lambda: ("at_least", measure, limit()),
        "at_most": lambda: ("at_most", measure, limit()),
    }[draw.choice(("near", "between", "at_least", "at_most"))]()
    if draw.random() < 0.2:
        return ("soft", test, draw.choice((0, 0.1, 0.5)))
    return ("fading", test, finite()) if draw.random() < 0.2 else test


def _expression(draw: Random, kind: str, names: Sequence[str], depth: int) -> Term:
    way = draw.random()
    if depth and way < 0.3:
        return (draw.choice("+-"), *(_expression(draw, kind, names, depth - 1) for _ in "ab"))
    if depth and way < 0.4:
        return ("*", draw.choice((0.5, 2)), _expression(draw, kind, names, depth - 1))
    if depth and way < 0.5:
        some = [_expression(draw, kind, names, 0) for _ in range(draw.randint(1, 3))]
        return (draw.choice(("lowest", "highest", "sum", "mean")), some)
    if kind == "ratio" and way < 0.6:
        other = draw.choice(("length", "area"))
        return ("/", *(_expression(draw, other, names, 0) for _ in "ab"))
    if kind == "deg" and way < 0.75:
        return ("angle", draw.choice(names), draw.choice(names))
    return (draw.choice(OF_FACE[kind]), draw.choice(names))


# ---------------------------------------------------------------------------------------- reference


@dataclass
class _Scene:
    case: Case
    names: dict[str, str] = field(default_factory=dict)

    def name(self, name: Term) -> str:
        return self.names.get(str(name), str(name))

    def with_names(self, **names: str) -> _Scene:
        return _Scene(self.case, {**self.names, **names})


def reference(case: Case, test: Term) -> Outline:
    """(state, least and greatest probability, by how much it fails) of the test."""
    return _said(_Scene(case), test)


def _said(scene: _Scene, test: Term) -> Outline:
    assert isinstance(test, tuple)
    match test:
        # Nothing to choose from, for a part that was not seen: nobody knows.
        case ("each" | "some", variable, [], one) if _unseen(scene, one, variable):
            return (UNKNOWN, 0, 1, 0)
        case ("each_pair", a, b, [], one) if _unseen(scene, one, a, b):
            return (UNKNOWN, 0, 1, 0)
        case ("at_least_of" | "at_most_of", _, variable, [], one) if _unseen(scene, one, variable):
            return (UNKNOWN, 0, 1, 0)
        case ("all", list(tests)):
            return _all([_said(scene, one) for one in tests])
        case ("any", list(tests)):
            return _any([_said(scene, one) for one in tests])
        case ("not", one):
            return _not(_said(scene, one))
        case ("if_known", one):
            said = _said(scene, one)
            return (HOLDS, 1, 1, 0) if said[0] == UNKNOWN else said
        case ("implies", where, one):
            return _any([_not(_said(scene, where)), _said(scene, one)])
        case ("expect", weight, one):
            _, low, high, _ = _said(scene, one)
            if scene.case.crisp:
                return (HOLDS, 1, 1, 0)
            return (HOLDS, 1 - weight * (1 - low), 1 - weight * (1 - high), 0)
        case ("each", variable, list(values), one):
            return _all([_said(scene.with_names(**{variable: value}), one) for value in values])
        case ("some", variable, list(values), one):
            return _any([_said(scene.with_names(**{variable: value}), one) for value in values])
        case ("each_pair", a, b, list(values), one):
            pairs = combinations(values, 2)
            return _all([_said(scene.with_names(**{a: x, b: y}), one) for x, y in pairs])
        case ("at_least_of" | "at_most_of" as bound, count, variable, groups, one):
            said = [
                _any([_said(scene.with_names(**{variable: value}), one) for value in group])
                for group in groups
            ]
            return _at_least(count, said) if bound == "at_least_of" else _at_most(count, said)
        case ("fading", (form, measure, *limits), width):
            return _compared(scene, form, measure, limits, width)
        case ("soft", (form, measure, *limits), share):
            return _compared(scene, form, measure, limits, None, share)
        case ("near" | "between" | "at_least" | "at_most" as form, measure, *limits):
            return _compared(scene, form, measure, limits, None)
        case (str(name), *args) if name in scene.case.words:
            return _said(_Scene(scene.case, {"X": scene.name(args[0])}), scene.case.words[name])
    return _related(scene, str(test[0]), [scene.name(arg) for arg in test[1:]])


def _unseen(scene: _Scene, test: Term, *variables: str) -> bool:
    """Whether the test names a part that was not seen."""
    if isinstance(test, (tuple, list)):
        return any(_unseen(scene, part, *variables) for part in test)
    return test not in variables and scene.name(test) == "unseen"


def _all(said: Sequence[Outline]) -> Outline:
    return (
        min((state for state, _, _, _ in said), default=HOLDS),
        math.prod(low for _, low, _, _ in said),
        math.prod(high for _, _, high, _ in said),
        1 - math.prod(1 - miss for _, _, _, miss in said),
    )


def _any(said: Sequence[Outline]) -> Outline:
    columns = zip(*said, strict=True) if said else ((), (), (), ())
    state, low, high, _ = (max(column, default=0) for column in columns)
    misses = (miss for _, _, _, miss in said)
    return state, low, high, min(misses, default=1) if state == FAILS else 0


def _not(said: Outline) -> Outline:
    return 1 - said[0], 1 - said[2], 1 - said[1], float(said[0] == HOLDS)


def _ranked(said: Sequence[Outline], place: int, part: int) -> float:
    """The place-th best, from 1."""
    if place == 0:
        return 1
    values = sorted((one[part] for one in said), reverse=True)
    return values[place - 1] if place <= len(values) else 0


def _at_least(count: int, said: Sequence[Outline]) -> Outline:
    enough = sum(one[0] == HOLDS for one in said) >= count
    low, high = _ranked(said, count, 1), _ranked(said, count, 2)
    return (HOLDS, low, high, 0) if enough else (UNKNOWN, low, 1, 0)


def _at_most(count: int, said: Sequence[Outline]) -> Outline:
    holding = sum(one[0] == HOLDS for one in said)
    possible = sum(one[0] != FAILS for one in said)
    state = FAILS if holding > count else UNKNOWN if possible > count else HOLDS
    miss = (holding - count) / holding if state == FAILS else 0
    return state, 1 - _ranked(said, count + 1, 2), 1 - _ranked(said, count + 1, 1), miss


def _related(scene: _Scene, name: str, parts: Sequence[str]) -> Outline:
    facts = scene.case.facts
    if name == "measured":
        found = ("evidence", *parts, "measured") in facts
    else:
        found = (name, *parts) in facts
    against = {"convex": "concave", "upward": "tilt"}.get(name)
    if found:
        return (HOLDS, 1, 1, 0)
    if (against, *parts) in facts if against else "unseen" not in parts:
        return (FAILS, 0, 0, 1)
    return (UNKNOWN, 0, 1, 0)


def _compared(
    scene: _Scene,
    form: str,
    measure: Term,
    limits: Sequence[Term],
    width: Term | None,
    share: float = 0,
) -> Outline:
    values = [_value(scene, expression) for expression in (measure, *limits)]
    slope = (0.0, 0.0) if width is None else _value(scene, width)
    known = [value for value in values if value is not None]
    if slope is None or len(known) < len(values):
        return (UNKNOWN, 0, 1, 0)
    (v, var), *bounds = known
    fade, fade_var = max(0, slope[0]), slope[1]
    if form == "near":
        (t, t_var), (w, w_var) = bounds
        edges = [(v - t + w, var + t_var + w_var), (t + w - v, var + t_var + w_var)]
        scale = abs(w)
    elif form == "between":
        scale = abs(bounds[1][0] - bounds[0][0]) / 2
        edges = [(v - bounds[0][0], var + bounds[0][1]), (bounds[1][0] - v, var + bounds[1][1])]
    else:
        scale = abs(bounds[0][0])
        distance = v - bounds[0][0] if form == "at_least" else bounds[0][0] - v
        edges = [(distance, var + bounds[0][1])]
    edges = [(d + fade / 2, var + fade_var / 4) for d, var in edges]
    sharp = width is None or scene.case.crisp
    inside = [_mass(*edge) if sharp else _faded(*edge, fade) for edge in edges]
    degree = chance = min(1, max(0, sum(inside) - len(inside) + 1))
    if share and not scene.case.crisp:  # of the degree alone: not of what holds
        inside = [_faded(*edge, 2 * share * scale) for edge in edges]
        degree = min(1, max(0, sum(inside) - len(inside) + 1))
    distance, edge_var = min(edges, key=lambda edge: edge[0])
    if distance < 0:
        # More of what is counted may be there than was seen.
        counted = isinstance(measure, tuple) and measure[0] == "count"
        if counted and form != "at_most" and edges[0][0] < 0:
            return (UNKNOWN, 0, 1, 0)
        # A miss by a tolerance is a half; what is not measured more exactly has its deviation.
        tolerance = max(scale + (fade / 2 if width is not None else 0), math.sqrt(edge_var))
        return (FAILS, degree, degree, distance / (distance - tolerance))
    return (UNKNOWN if chance < 0.5 - 1e-9 else HOLDS, degree, degree, 0)


def _mass(distance: float, var: float) -> float:
    if var == 0:
        return float(distance >= 0)
    return 0.5 * math.erfc(-distance / math.sqrt(2 * var))


def _faded(distance: float, var: float, width: float) -> float:
    """The mean of a slope's membership over the normal distribution."""
    sd = math.sqrt(var)
    if abs(distance) > width + 40 * sd:  # beyond the slope: the difference below would cancel
        return float(distance > 0)
    if width <= 1e-4 * sd or (width == 0 and sd == 0):
        return _mass(distance, var)
    if sd == 0:
        return min(1, max(0, 0.5 + distance / width))

    def above(edge: float) -> float:
        z = (distance - edge) / sd
        density = math.exp(-z * z / 2) / math.sqrt(2 * math.pi)
        return sd * (density + z * 0.5 * math.erfc(-z / math.sqrt(2)))

    return (above(-width / 2) - above(width / 2)) / width


def _value(scene: _Scene, expression: Term) -> tuple[float, float] | None:
    """A value and its variance; None where the scene does not know."""
    if not isinstance(expression, tuple):
        # No measured value comes near an infinite limit: one far away is the same.
        return min(1e100, max(-1e100, float(expression))), 0.0  # type: ignore[arg-type]
    name, *args = expression
    if name in ("lowest", "highest", "sum", "mean"):
        some = [_value(scene, one) for one in args[0]]
        if None in some:
            return None
        known = [one for one in some if one is not None]
        if name in ("lowest", "highest"):
            return (min if name == "lowest" else max)(known)
        divisor = len(known) if name == "mean" else 1
        return sum(v for v, _ in known) / divisor, sum(s for _, s in known) / divisor**2
    if name == "count":
        return float(len(args[0])), 0.0
    if name in ("+", "-", "*", "/"):
        a, b = (_value(scene, arg) for arg in args)
        if a is None or b is None or (name == "/" and b[0] == 0):
            return None
        (x, sx), (y, sy) = a, b
        match name:
            case "+":
                return x + y, sx + sy
            case "-":
                return x - y, sx + sy
            case "*":
                return x * y, y * y * sx + x * x * sy
        return x / y, (sx + (x / y) ** 2 * sy) / (y * y)
    found = scene.case.facts.get((name, *map(scene.name, args)))
    if found is None:
        return None
    return found[0], 0.0 if scene.case.crisp else found[1] ** 2
