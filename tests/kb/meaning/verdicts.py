"""Which faces a model chooses for its parts, and what it says then: all choices are tried."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from typing import NamedTuple

from tests.kb.meaning.cases import Case
from tests.kb.meaning.models import Line, Members, Model
from tests.kb.meaning.quantities import quantity
from tests.kb.meaning.reference import join_goals, said
from tests.kb.meaning.scene import FAILS, HOLDS, STATES, UNKNOWN, Outline, Scene
from tests.kb.meaning.terms import Term

__all__ = ["Verdict", "rank", "scene_of", "verdict", "verdict_on"]

MOST_CHOICES = 60  # that are proposed as far as a thing was seen
RESOLUTION = 1e-9

Parts = tuple[str, ...]


class Verdict(NamedTuple):
    """A model's on t1: state, bounds of the probability, what plays the parts and groups, sizes as
    (name, value, standard deviation)."""

    state: str
    low: float
    high: float
    roles: Mapping[str, object]
    sizes: Sequence[tuple[str, float, float]]


def scene_of(case: Case) -> Scene:
    """Return the scene of a case, in which no model is being judged."""
    known: dict[tuple[str, tuple[str, ...]], Outline] = {}

    def outcome(scene: Scene, name: str) -> Outline:
        key = (name, scene.judged)
        if key not in known:
            model = next(model for model in case.models if model.name == name)
            judged = _judging(scene, model)
            best = _best(judged, model)
            known[key] = (UNKNOWN, 0, 1, 0) if best is None else _together(judged, model, best)
        return known[key]

    return Scene(case, outcome)


def verdict(scene: Scene, model: Model) -> Verdict:
    """Return the model's verdict on the best choice of faces."""
    best = _best(_judging(scene, model), model)
    return Verdict("unknown", 0, 1, {}, ()) if best is None else verdict_on(scene, model, best)


def verdict_on(scene: Scene, model: Model, parts: Parts) -> Verdict:
    """Return the model's verdict on these faces for its parts."""
    judged = _judging(scene, model)
    state, low, high, _ = _together(judged, model, parts)
    chosen = judged.with_names(dict(zip(model.parts, parts, strict=True)))
    roles: dict[str, object] = {
        part.lower(): face for part, face in zip(model.parts, parts, strict=True)
    }
    if model.group:
        roles["others"] = _members(chosen, model, model.group)
    return Verdict(STATES[state], low, high, roles, _sizes(chosen, model))


def rank(scene: Scene, model: Model, parts: Parts) -> tuple[float, ...]:
    """Return a rank, better if less: states, then how many conditions hold and fail, then misses,
    then probabilities."""
    found = _outlines(_judging(scene, model), model, parts)
    holding, failing = (sum(one[0] == state for one in found) for state in (HOLDS, FAILS))
    misses = sum(sorted(one[3] for one in found if one[0] == FAILS))
    state, low, high, _ = join_goals(found)
    probable = (0, 0) if failing else (_improbability(low), _improbability(high))
    return (1 - state, -holding, failing, round(misses / RESOLUTION), *probable)


def _improbability(probability: float) -> float:
    return round(-math.log(probability) / RESOLUTION) if probability > 0 else math.inf


def _judging(scene: Scene, model: Model) -> Scene:
    return Scene(scene.case, scene.verdict, model.module, {"T": "t1"}, (*scene.judged, model.name))


def _together(judged: Scene, model: Model, parts: Parts) -> Outline:
    return join_goals(_outlines(judged, model, parts))


# ----------------------------------------------------------------------------------------- the best


def _best(judged: Scene, model: Model) -> Parts | None:
    """Return the best of all choices."""
    outer = Scene(judged.case, judged.verdict, judged=judged.judged[:-1])
    choices = set(_candidates(judged, model))
    return min(choices, key=lambda parts: (rank(outer, model, parts), parts), default=None)


def _names(term: Term, name: str) -> bool:
    if isinstance(term, (tuple, list)):
        return any(_names(part, name) for part in term)
    return term == name


# ------------------------------------------------------------------------------------------ choices


def _with(judged: Scene, model: Model, parts: Parts) -> Scene:
    return judged.with_names(dict(zip(model.parts, parts, strict=True)))


def _faces(scene: Scene) -> list[str]:
    """Return the measured faces of the thing."""
    return sorted(
        str(key[1])
        for key in scene.case.facts
        if key[0] == "part_of" and scene.fact("evidence", key[1], "measured") is not None
    )


def _possible(scene: Scene, test: Term) -> bool:
    return said(scene, test)[0] != FAILS


def _candidates(judged: Scene, model: Model) -> Iterator[Parts]:
    found = list(_joined(judged, model, ()))
    if found or not model.seen:
        yield from found
    else:
        yield from islice(_seen(judged, model, ()), MOST_CHOICES)


def _joined(judged: Scene, model: Model, before: Parts) -> Iterator[Parts]:
    if len(before) == len(model.join):
        if before:
            yield before
        return
    step = model.join[len(before)]
    for face in _proposed(judged, step.way, before):
        scene = judged.with_names(dict(zip(model.parts, (*before, face), strict=False)))
        if step.test is None or _possible(scene, step.test):
            yield from _joined(judged, model, (*before, face))


def _proposed(judged: Scene, way: str, before: Parts) -> list[str]:
    faces = _faces(judged)
    if way == "shared":
        # Faces of the scene, whatever they are part of.
        measured = [str(k[1]) for k in judged.case.facts if k[0] == "evidence"]
        if before[-1] not in measured:
            return []
        return [f for f in measured if judged.fact("adjoins", before[-1], f) is not None]
    if way == "later":
        return [face for face in faces if face > before[-1]]
    return [face for face in faces if way == "face" or face != before[-1]]


def _seen(judged: Scene, model: Model, before: Parts) -> Iterator[Parts]:
    if len(before) == len(model.seen):
        yield before
        return
    _, count, test = model.seen[len(before)]
    areas = ((face, judged.fact("area", face)) for face in _faces(judged))
    largest = sorted(((area[0], face) for face, area in areas if area is not None), reverse=True)

    def fits(face: str) -> bool:
        scene = judged.with_names(dict(zip(model.parts, (*before, face), strict=False)))
        return face not in before and _possible(scene, test)

    fitting = list(islice((face for _, face in largest if fits(face)), count))
    for face in fitting or ["unseen"]:
        yield from _seen(judged, model, (*before, face))


# --------------------------------------------------------------------------------------- conditions


def _outlines(judged: Scene, model: Model, parts: Parts) -> list[Outline]:
    chosen = _with(judged, model, parts)
    return [one for line in model.lines for one in _line(chosen, model, line)]


def _line(chosen: Scene, model: Model, line: Line) -> Iterator[Outline]:
    if line.members:
        faces = _members(chosen, model, line.members)
        names = {"Fs": faces, "Gs": _separate(chosen, faces)}
        yield said(chosen.with_names(names), line.test)
    elif line.each:
        for face in _faces(chosen):
            yield said(chosen.with_names({"F": face}), line.test)
    elif line.where is None or said(chosen, line.where)[0] == HOLDS:
        yield said(chosen, line.test)


def _members(chosen: Scene, model: Model, members: Members) -> list[Term]:
    parts = {chosen.name(part) for part in model.parts}
    return [
        face
        for face in _faces(chosen)
        if face not in parts and _possible(chosen.with_names({"F": face}), members.test)
    ]


def _separate(scene: Scene, faces: Sequence[Term]) -> list[Term]:
    """Return groups of faces that adjoin, one by one."""
    groups: list[list[Term]] = []
    for face in faces:
        near = [g for g in groups if any(scene.fact("adjoins", face, one) is not None for one in g)]
        joined = sorted([face, *(one for group in near for one in group)], key=str)
        groups = [group for group in groups if group not in near] + [joined]
    return [*sorted(groups, key=lambda group: list(map(str, group)))]


def _sizes(chosen: Scene, model: Model) -> list[tuple[str, float, float]]:
    if not model.size:
        return []
    one, two = model.size
    sizes = []
    measures = [quantity(chosen, ("length", one)), quantity(chosen, ("width", two))]
    known = [measure for measure in measures if measure is not None]
    if len(known) == len(measures):
        longest = sorted(known, key=lambda measure: -measure.value)
        sizes = [
            (name, measure.value, math.sqrt(measure.variance))
            for name, measure in zip(("long", "short"), longest, strict=True)
        ]
    wide = quantity(chosen, ("width", one))
    if wide is not None:
        sizes.append(("wide", wide.value, math.sqrt(wide.variance)))
    return sizes
