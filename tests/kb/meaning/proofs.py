"""Contents of proofs: state and bounds of every step, and what it compared, missed or counted."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from tests.kb.meaning.quantities import FORMS, SLOPES, compared, open_measures, quantity
from tests.kb.meaning.random_tests import OPEN
from tests.kb.meaning.reference import instances, said, word_scene
from tests.kb.meaning.scene import FAILS, HOLDS, STATES, UNKNOWN, Outline, Scene
from tests.kb.meaning.terms import Term, prolog

__all__ = ["Proof", "proof_of"]

CLOSE = 1e-9


@dataclass(frozen=True)
class Proof:
    """A step. `details` are what it may say of itself: one, or some where values are as good as
    equal. Steps of a count are in the order of what they say, `ordered` if no two are alike."""

    state: str
    low: float
    high: float
    details: Sequence[Sequence[object]]
    steps: Sequence[Proof] = ()
    ordered: bool = field(default=True)


def proof_of(scene: Scene, test: Term) -> Proof:
    """Return the proof of a test that has a meaning."""
    state, low, high, _ = said(scene, test)
    details, steps, ordered = _inside(scene, test)
    return Proof(STATES[state], low, high, details, steps, ordered)


Inside = tuple[Sequence[Sequence[object]], Sequence[Proof], bool]


def _inside(scene: Scene, test: Term) -> Inside:
    match test:
        case ("all" | "any" as join, list(tests)):
            return [[join]], [proof_of(scene, one) for one in tests], True
        case ("not", one):
            return [["not"]], [proof_of(scene, one)], True
        case ("if_known", one):
            step = proof_of(scene, one)
            name = "not_applied" if step.state == "unknown" else "if_known"
            return [[name]], [step], True
        case ("implies", where, one):
            return [["implies"]], [proof_of(scene, where), proof_of(scene, one)], True
        case ("expect", weight, one):
            return [["expect", weight]], [proof_of(scene, one)], True
        case ("each" | "each_pair" | "some" as form, *_, one):
            join = "any" if form == "some" else "all"
            return [[join]], [proof_of(inner, one) for inner in instances(scene, test)], True
        case ("at_least_of" | "at_least_in" | "at_most_of", *_):
            return _counted(scene, test)
        case ("is_a", thing, model):
            return [["judged", _why_not_judged(scene, scene.name(thing), str(model))]], [], True
        case (str(form), *_) if form in (*FORMS, *SLOPES):
            return _compared(scene, test), [], True
        case (str(name), one) if name in scene.case.words:
            return [["short"]], [proof_of(word_scene(scene, one), scene.case.words[name])], True
    truth = {HOLDS: True, UNKNOWN: "unknown", FAILS: False}[said(scene, test)[0]]
    cause = _why_missing(scene, scene.written(test)) if truth == "unknown" else "none"
    return [["fact", truth, cause]], [], True


def _why_not_judged(scene: Scene, thing: Term, model: str) -> str:
    if thing == "t1":
        return "cycle" if model in scene.judged else "none"
    return "unseen" if thing == "unseen" else "unstated"


# -------------------------------------------------------------------------------------- comparisons


def _compared(scene: Scene, test: Term) -> Sequence[Sequence[object]]:
    if not open_measures(scene, test):
        return _compared_as_read(scene, test)
    # That case is shown which is nearer to failing; either of two that are as near.
    free, full = (_compared_as_read(scene.read_as(way), test) for way in (0, 1))
    for case in (free, full):
        if case[0][0] == "missing":
            return case
    return [
        ["unseen", free[0][1], full[0][1], list(shown)]
        for case, other in ((free, full), (full, free))
        for shown in case
        if _distance(shown) <= _distance(other[0]) + CLOSE
    ]


def _distance(detail: Sequence[object]) -> float:
    distance = detail[-2]
    assert isinstance(distance, (int, float))
    return distance


def _compared_as_read(scene: Scene, test: Term) -> Sequence[Sequence[object]]:
    found = compared(scene, test)
    if found is None:
        missing = _missing(scene, _expressions(test))
        written = scene.written(missing)
        return [["missing", prolog(written).replace("'", ""), _why_missing(scene, written)]]
    state = found.said[0]
    kind = "uncertain" if state == UNKNOWN else "compared"
    fades = [] if found.fades is None else [found.fades]
    least = min(distance for _, distance, _ in found.edges)
    value = [found.quantity.value, math.sqrt(found.quantity.variance)]
    return [
        [kind, *value, *found.within, *fades, side, distance, math.sqrt(var)]
        for side, distance, var in found.edges
        if distance <= least + CLOSE
    ]


def _expressions(test: Term) -> list[Term]:
    """In the order in which they are looked for: the measure, what fades, the limits."""
    assert isinstance(test, tuple)
    if test[0] == "soft":
        return _expressions(test[1])
    if test[0] == "fading":
        measure, *limits = _expressions(test[1])
        return [measure, test[2], *limits]
    return list(test[1:])


def _missing(scene: Scene, expressions: Sequence[Term]) -> Term:
    """Return the first measure that is not known, or an expression whose terms are known."""
    for expression in expressions:
        if quantity(scene, expression) is None:
            assert isinstance(expression, tuple)
            name, *operands = expression
            if name in ("lowest", "highest", "sum", "mean", "smallest_step", "largest_step"):
                operands = operands[0]
            elif name not in ("+", "-", "*", "/"):
                operands = []
            inner = _missing(scene, operands)
            return expression if inner is None else inner
    return None


def _why_missing(scene: Scene, word: Term) -> str:
    assert isinstance(word, tuple)
    if any(part == "unseen" or (isinstance(part, list) and "unseen" in part) for part in word[1:]):
        return "unseen"
    if word[0] in ("tilt", "upward", *OPEN) and scene.fact("up") is None:
        return "up"
    if word[0] == "metres" and scene.fact("scale", "metric") is None:
        return "scale"
    return "unstated"


# ------------------------------------------------------------------------------------------- counts


def _counted(scene: Scene, test: Term) -> Inside:
    assert isinstance(test, tuple)
    bound, count, *_, variable, groups, one = test
    place = count + 1 if bound == "at_most_of" else count
    best: list[list[tuple[tuple[float, ...], str, Proof]]] = []
    outlines: list[Outline] = []
    for group in map(scene.list, scene.list(groups)):
        members = []
        for name in group:
            inner = scene.with_names({variable: name})
            members.append((_rank(said(inner, one)), str(name), proof_of(inner, one)))
        every = [said(scene.with_names({variable: name}), one) for name in group]
        states = [state for state, *_ in every]
        outlines.append((max(states, default=FAILS), 0, 0, 0))
        if members:
            least = min(member[0] for member in members)
            best.append([member for member in members if _alike(member[0], least)])
    best.sort(key=lambda members: members[0][0])
    ranks = [members[0][0] for members in best]
    holding = sum(state == HOLDS for state, *_ in outlines)
    open_ones = sum(state == UNKNOWN for state, *_ in outlines)
    deciding = {"none"}
    if 0 < place <= len(best):
        deciding = {
            name for members in best for rank, name, _ in members if _alike(rank, ranks[place - 1])
        }
    clear = all(len(members) == 1 for members in best) and not any(
        _alike(a, b) for a, b in pairwise(ranks)
    )
    details = [["counted", holding, open_ones, name] for name in sorted(deciding)]
    return details, [members[0][2] for members in best], clear


def _rank(outline: Outline) -> tuple[float, ...]:
    return (-outline[0], -outline[1], -outline[2])


def _alike(one: Sequence[float], two: Sequence[float]) -> bool:
    return all(abs(a - b) <= CLOSE for a, b in zip(one, two, strict=True))
