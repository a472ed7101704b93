"""Values of measures and expressions, and by how much they are within limits: the reference, from
the paper and docs/model-reference.md."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from tests.kb.meaning.random_tests import FAULTY_MEASURES, OF_FACE, OPEN, OWN_MEASURES
from tests.kb.meaning.scene import FAILS, HOLDS, UNKNOWN, FaultyTestError, Outline, Scene
from tests.kb.meaning.terms import Term

__all__ = ["Compared", "Quantity", "compared", "open_measures", "quantity"]

FORMS = ("near", "between", "at_least", "at_most")
SLOPES = ("fading", "soft")
TOLERANCES = {"level": 10}
OWN_TOLERANCES = {"rules": 12, "asking": 7}
DIMENSIONS = {"deg": 0, "ratio": 0, "length": 1, "area": 2}


class Quantity(NamedTuple):
    """A value, its variance, and which power of a length it is."""

    value: float
    variance: float
    dimension: int


def open_measures(scene: Scene, test: Term) -> bool:
    """Return whether the test asks for a measure that space changes which was not seen."""
    if isinstance(test, tuple) and test[0] in OPEN:
        return scene.fact("unseen_bounds", *map(scene.name, test)) is not None
    return isinstance(test, (tuple, list)) and any(open_measures(scene, part) for part in test)


class Compared(NamedTuple):
    """A quantity against its limits: what is said of it, the limits in numbers, how wide they fade
    (None if they do not), whose slopes are about the limits or beyond them, and for each edge its
    side, distance and variance, the lower first."""

    said: Outline
    quantity: Quantity
    within: tuple[object, ...]
    fades: float | None
    edges: Sequence[tuple[str, float, float]]


def compared(scene: Scene, test: Term) -> Compared | None:
    """Return the test of a measure against its limits; None where the scene does not know one of
    them."""
    assert isinstance(test, tuple)
    bounds, slopes = (test[1], test[2]) if test[0] in SLOPES else (test, None)
    width = slopes if test[0] == "fading" else None
    assert isinstance(bounds, tuple)
    form, measure, *limits = bounds
    found = quantity(scene, measure)
    if found is None:
        return None

    def limit(expression: Term) -> Quantity | None:
        value = quantity(scene, expression)
        if value is not None:
            _comparable(scene, test, found, value)
        return value

    known: list[Quantity] = []
    for expression in limits:
        value = limit(expression)
        if value is None:
            return None
        known.append(value)
    slope = None if width is None else limit(width)
    if width is not None and slope is None:
        return None
    fades = None if slope is None else max(0.0, slope.value)
    edges = _edges(form, found, known)
    if slope is not None and fades is not None:
        # Distances are those from the middle of a slope.
        edges = [(side, d + fades / 2, var + slope.variance / 4) for side, d, var in edges]
    within = (form, *(one.value for one in known))
    counted = isinstance(measure, tuple) and measure[0] == "count"
    said = _said(edges, within, fades, crisp=scene.case.crisp, counted=counted)
    if test[0] == "soft":
        fades = 2 * float(str(slopes)) * _scale(within)
        state, _, _, miss = said
        if said[1:3] != (0, 1) and not scene.case.crisp:  # of the degree alone
            degree = _inside([_faded(d, var, fades) for _, d, var in edges])
            said = (state, degree, degree, miss)
    return Compared(said, found, within, fades, edges)


def _edges(
    form: str, found: Quantity, limits: Sequence[Quantity]
) -> list[tuple[str, float, float]]:
    value, variance, _ = found
    if form == "near":
        target, tolerance = limits
        var = variance + target.variance + tolerance.variance
        # Summed as compare.pl does: a value in the limit itself is not to fail by rounding.
        below = value - target.value + tolerance.value
        return [("below", below, var), ("above", target.value + tolerance.value - value, var)]
    edges = []
    if form in ("between", "at_least"):
        edges.append(("below", value - limits[0].value, variance + limits[0].variance))
    if form in ("between", "at_most"):
        edges.append(("above", limits[-1].value - value, variance + limits[-1].variance))
    return edges


def _said(
    edges: Sequence[tuple[str, float, float]],
    within: tuple[object, ...],
    fades: float | None,
    *,
    crisp: bool,
    counted: bool,
) -> Outline:
    sharp = fades is None or crisp
    inside = [_mass(d, var) if sharp else _faded(d, var, fades or 0) for _, d, var in edges]
    degree = _inside(inside)
    side, distance, var = min(edges, key=lambda edge: edge[1])
    if distance >= 0:
        return (UNKNOWN if degree < 0.5 - 1e-9 else HOLDS, degree, degree, 0)
    # More of what is counted may be there than was seen.
    if counted and side == "below":
        return (UNKNOWN, 0, 1, 0)
    # A miss by a tolerance is a half; what is not measured more exactly has its deviation.
    tolerance = max(_scale(within) + (fades or 0) / 2, math.sqrt(var))
    return (FAILS, degree, degree, distance / (distance - tolerance))


def _inside(masses: Sequence[float]) -> float:
    """Return the mass between the edges, from that on the inner side of each."""
    return min(1, max(0, sum(masses) - len(masses) + 1))


def _scale(within: Sequence[object]) -> float:
    """Return half the width of a region, its tolerance, or its limit."""
    form, *limits = within
    low, high = (float(str(one)) for one in (limits[0], limits[-1]))
    return abs(high - low) / 2 if form == "between" else abs(high)


def _mass(distance: float, var: float) -> float:
    if var == 0:
        return float(distance >= 0)
    return 0.5 * math.erfc(-distance / math.sqrt(2 * var))


def _faded(distance: float, var: float, width: float) -> float:
    """Return the mean of a slope's membership over the normal distribution."""
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


def _comparable(scene: Scene, test: Term, one: Quantity, two: Quantity) -> None:
    if one.dimension != two.dimension and two.value != 0:
        raise FaultyTestError("type_error", "comparable", scene.written(test))


def quantity(scene: Scene, expression: Term) -> Quantity | None:
    """Return the value of an expression; None where the scene does not know.

    Raises FaultyTestError for what has no meaning.
    """
    if not isinstance(expression, tuple):
        # No measured value comes near an infinite limit: one far away is the same.
        return Quantity(min(1e100, max(-1e100, float(str(expression)))), 0.0, 0)
    name, *args = expression
    if name == "tolerance":
        named = {**TOLERANCES, "own": OWN_TOLERANCES[scene.module]}
        if args[0] not in named:
            raise FaultyTestError("existence_error", "tolerance", args[0])
        return Quantity(named[args[0]], 0.0, 0)
    if name in ("lowest", "highest", "sum", "mean", "smallest_step", "largest_step"):
        return _summary(scene, expression, args[0])
    if name == "count":
        return Quantity(float(len(args[0])), 0.0, 0)
    if name in ("+", "-", "*", "/"):
        return _arithmetic(scene, expression)
    return _measure(scene, name, args)


def _summary(scene: Scene, expression: tuple[Term, ...], some: Sequence[Term]) -> Quantity | None:
    known: list[Quantity] = []
    for one in some:
        value = quantity(scene, one)
        if value is None:
            return None
        if known:
            _comparable(scene, expression, known[0], value)
        known.append(value)
    if not known:
        return None
    if expression[0] in ("lowest", "highest"):
        best = (min if expression[0] == "lowest" else max)(known, key=lambda one: one[:2])
        return best._replace(dimension=known[0].dimension)
    if expression[0] in ("smallest_step", "largest_step"):
        ordered = sorted(known, key=lambda one: one[:2])
        steps = [
            Quantity(b.value - a.value, a.variance + b.variance, known[0].dimension)
            for a, b in pairwise(ordered)
        ]
        choose = min if expression[0] == "smallest_step" else max
        return choose(steps, key=lambda one: one[:2]) if steps else None
    divisor = len(known) if expression[0] == "mean" else 1
    value = sum(one.value for one in known) / divisor
    return Quantity(value, sum(one.variance for one in known) / divisor**2, known[0].dimension)


def _arithmetic(scene: Scene, expression: tuple[Term, ...]) -> Quantity | None:
    operator, *operands = expression
    a = quantity(scene, operands[0])
    if a is None:
        return None
    if len(operands) == 1:
        return a._replace(value=-a.value)
    b = quantity(scene, operands[1])
    if b is None or (operator == "/" and b.value == 0):
        return None
    (x, sx, dx), (y, sy, dy) = a, b
    if operator in ("+", "-"):
        _comparable(scene, expression, a, b)
        return Quantity(x + y if operator == "+" else x - y, sx + sy, dx)
    if operator == "*":
        return Quantity(x * y, y * y * sx + x * x * sy, dx + dy)
    return Quantity(x / y, (sx + (x / y) ** 2 * sy) / (y * y), dx - dy)


def _measure(scene: Scene, name: Term, args: Sequence[Term]) -> Quantity | None:
    if name in FAULTY_MEASURES and scene.case.measures:
        kind, expected, culprit = FAULTY_MEASURES[str(name)][3]
        raise FaultyTestError(kind, expected, culprit)
    if name == "metres":
        metric = scene.fact("scale", "metric") is not None
        return Quantity(float(str(args[0])), 0.0, 1) if metric else None
    times = 1.0
    if name in scene.case.measures and scene.module == "rules":
        name, times = OWN_MEASURES[str(name)]
    found = scene.fact(name, *map(scene.name, args))
    if found is None:
        return None
    kinds = {one: kind for kind, names in OF_FACE.items() for one in names}
    dimension = DIMENSIONS[kinds.get(str(name), "deg")]
    variance = 0.0 if scene.case.crisp else (times * found[1]) ** 2
    ends = scene.fact("unseen_bounds", name, *map(scene.name, args))
    value = found[0] if ends is None or scene.reading is None else ends[scene.reading]
    return Quantity(times * value, variance, dimension)
