"""Reference semantics of tests, from the paper and docs/model-reference.md.

It shares no code with the program.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import combinations

from tests.kb.meaning.quantities import FORMS, SLOPES, compared, open_measures
from tests.kb.meaning.scene import FAILS, HOLDS, UNKNOWN, Outline, Scene
from tests.kb.meaning.terms import Term

__all__ = ["any_of", "instances", "join_goals", "left_open", "said"]


def said(scene: Scene, test: Term) -> Outline:
    """Return (state, least and greatest probability, by how much it fails) of the test.

    Raises FaultyTestError for one without meaning.
    """
    assert isinstance(test, tuple)
    if left_open(scene, test):
        return (UNKNOWN, 0, 1, 0)
    match test:
        case ("all", list(tests)):
            return join_goals([said(scene, one) for one in tests])
        case ("any", list(tests)):
            return any_of([said(scene, one) for one in tests])
        case ("not", one):
            return _not(said(scene, one))
        case ("if_known", one):
            found = said(scene, one)
            return (HOLDS, 1, 1, 0) if found[0] == UNKNOWN else found
        case ("implies", where, one):
            return any_of([_not(said(scene, where)), said(scene, one)])
        case ("expect", float() | int() as weight, one):
            _, low, high, _ = said(scene, one)
            if scene.case.crisp:
                return (HOLDS, 1, 1, 0)
            return (HOLDS, 1 - weight * (1 - low), 1 - weight * (1 - high), 0)
        case ("each" | "each_pair", *_, one):
            return join_goals([said(inner, one) for inner in instances(scene, test)])
        case ("some", *_, one):
            return any_of([said(inner, one) for inner in instances(scene, test)])
        case ("at_least_of" | "at_most_of" as bound, int(count), variable, groups, one):
            every = _of_groups(scene, str(variable), groups, one)
            return _at_least(count, every) if bound == "at_least_of" else _at_most(count, every)
        case ("at_least_in", int(count), closed, variable, groups, one):
            every = _of_groups(scene, str(variable), groups, one)
            if said(scene, closed)[0] == HOLDS:
                return _at_least_of_all(count, every)
            return _at_least(count, every)
        case ("is_a", thing, str(model)):
            return _model(scene, scene.name(thing), model)
        case (str(form), *_) if form in (*FORMS, *SLOPES):
            if open_measures(scene, test):
                return either(*(_compared(scene.read_as(way), test) for way in (0, 1)))
            return _compared(scene, test)
        case (str(name), one) if name in scene.case.words:
            return said(word_scene(scene, one), scene.case.words[name])
    return _related(scene, str(test[0]), [scene.name(arg) for arg in test[1:]])


def _compared(scene: Scene, test: Term) -> Outline:
    found = compared(scene, test)
    return (UNKNOWN, 0, 1, 0) if found is None else found.said


def either(one: Outline, two: Outline) -> Outline:
    """Return the outline where nobody knows which of two is so."""
    state = one[0] if one[0] == two[0] else UNKNOWN
    return state, min(one[1], two[1]), max(one[2], two[2]), min(one[3], two[3])


def word_scene(scene: Scene, argument: Term) -> Scene:
    """Where the meaning of a short word is asked for its argument."""
    return Scene(scene.case, scene.verdict, names={"X": scene.name(argument)}, judged=scene.judged)


def instances(scene: Scene, test: Term) -> Iterator[Scene]:
    """Yield the scenes in which a quantifier asks its test, one for each element or two
    elements."""
    match test:
        case ("each" | "some", variable, values, _):
            for value in scene.list(values):
                yield scene.with_names({str(variable): value})
        case ("each_pair", a, b, values, _):
            for x, y in combinations(scene.list(values), 2):
                yield scene.with_names({str(a): x, str(b): y})


def left_open(scene: Scene, test: Term) -> bool:
    """There is nothing to choose from, for a part that was not seen: nobody knows."""
    match test:
        case ("each" | "some", variable, values, one):
            variables = {variable}
        case ("each_pair", a, b, values, one):
            variables = {a, b}
        case ("at_least_of" | "at_most_of", _, variable, values, one):
            variables = {variable}
        case ("at_least_in", _, _, variable, values, one):
            variables = {variable}
        case _:
            return False
    return not scene.list(values) and _unseen(scene, one, frozenset(map(str, variables)))


def _unseen(scene: Scene, term: Term, variables: frozenset[str]) -> bool:
    """Return whether the test names a part that was not seen."""
    if isinstance(term, (tuple, list)):
        return any(_unseen(scene, part, variables) for part in term)
    return term not in variables and scene.name(term) == "unseen"


def join_goals(every: Sequence[Outline]) -> Outline:
    """Return the outline of conditions that are all needed."""
    return (
        min((state for state, _, _, _ in every), default=HOLDS),
        math.prod(low for _, low, _, _ in every),
        math.prod(high for _, _, high, _ in every),
        1 - math.prod(1 - miss for _, _, _, miss in every),
    )


def any_of(every: Sequence[Outline]) -> Outline:
    """Return the outline of alternatives."""
    columns = zip(*every, strict=True) if every else ((), (), (), ())
    state, low, high, _ = (max(column, default=0) for column in columns)
    misses = (miss for _, _, _, miss in every)
    return state, low, high, min(misses, default=1) if state == FAILS else 0


def _not(one: Outline) -> Outline:
    return 1 - one[0], 1 - one[2], 1 - one[1], float(one[0] == HOLDS)


def _ranked(every: Sequence[Outline], place: int, part: int) -> float:
    """Return the place-th best, from 1."""
    if place == 0:
        return 1
    values = sorted((one[part] for one in every), reverse=True)
    return values[place - 1] if place <= len(values) else 0


def _of_groups(scene: Scene, variable: str, groups: Term, one: Term) -> list[Outline]:
    return [
        any_of([said(scene.with_names({variable: name}), one) for name in group])
        for group in map(scene.list, scene.list(groups))
    ]


def _at_least_of_all(count: int, every: Sequence[Outline]) -> Outline:
    holding = sum(one[0] == HOLDS for one in every)
    possible = sum(one[0] != FAILS for one in every)
    state = HOLDS if holding >= count else UNKNOWN if possible >= count else FAILS
    miss = (count - holding) / count if state == FAILS else 0
    return state, _ranked(every, count, 1), _ranked(every, count, 2), miss


def _at_least(count: int, every: Sequence[Outline]) -> Outline:
    enough = sum(one[0] == HOLDS for one in every) >= count
    low, high = _ranked(every, count, 1), _ranked(every, count, 2)
    return (HOLDS, low, high, 0) if enough else (UNKNOWN, low, 1, 0)


def _at_most(count: int, every: Sequence[Outline]) -> Outline:
    holding = sum(one[0] == HOLDS for one in every)
    possible = sum(one[0] != FAILS for one in every)
    state = FAILS if holding > count else UNKNOWN if possible > count else HOLDS
    miss = (holding - count) / holding if state == FAILS else 0
    return state, 1 - _ranked(every, count + 1, 2), 1 - _ranked(every, count + 1, 1), miss


def _model(scene: Scene, thing: Term, model: str) -> Outline:
    # Of a part that was not seen, a thing that there is not, or what is being judged: nothing yet.
    if thing != "t1" or model in scene.judged:
        return (UNKNOWN, 0, 1, 0)
    state, low, high, _ = scene.verdict(scene, model)
    return state, low, high, float(state == FAILS)


def _related(scene: Scene, name: str, parts: Sequence[Term]) -> Outline:
    if name == "measured":
        found = scene.fact("evidence", *parts, "measured")
    else:
        found = scene.fact(name, *parts)
    against = {"convex": "concave", "upward": "tilt"}.get(name)
    if found is not None:
        return (HOLDS, 1, 1, 0)
    if (scene.fact(against, *parts) is not None) if against else "unseen" not in parts:
        return (FAILS, 0, 0, 1)
    return (UNKNOWN, 0, 1, 0)
