"""Why, why not, and where from: the same for the shell's commands and the command line's."""

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from facetlog.errors import InputError
from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.verdict import Verdict
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.perception.facts.fact_schema import ArgumentKind
from facetlog.query_shell.scene_names import kind_of
from facetlog.query_shell.session import Session
from facetlog.query_shell.words import nearest
from facetlog.terminal import printable

WHY, WHY_NOT, ORIGIN = "facetlog-why/2", "facetlog-why-not/2", "facetlog-origin/1"

_PART = re.compile(r"([^=()\s]+)=([^=()\s]+)")


@dataclass(frozen=True, slots=True)
class About:
    """Subject of a question: a model, perhaps one thing only, and the parts that are given."""

    model: str
    thing: str | None = None
    parts: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Explanation:
    """An answer as text and as the same data; `yes` if it holds, or if there is something to say.

    `hint` is what a reader may do next, to follow the name of the command why_not. `cut` says that
    the lines leave something out which they have in full. `verdicts` are those that it is about.
    """

    yes: bool
    lines: tuple[str, ...]
    data: Mapping[str, Any]
    hint: str = ""
    cut: bool = False
    verdicts: tuple[Verdict, ...] = ()

    def __post_init__(self) -> None:
        # Names of pictures are whatever a file says.
        object.__setattr__(self, "lines", tuple(map(printable, self.lines)))

    @property
    def json(self) -> str:
        """The data on one line."""
        return json.dumps(self.data)


def parse_parts(words: Sequence[str]) -> dict[str, str]:
    """Parse parts like `top=f1`. Raise InputError for any other word and for one given twice.

    >>> parse_parts(["top=f1", "leg=f4"])
    {'top': 'f1', 'leg': 'f4'}
    """
    found: dict[str, str] = {}
    for word in words:
        match = _PART.fullmatch(word)
        if match is None:
            raise InputError(f"{word!r} is no part: write PART=FACE, as in top=f1")
        role, face = match.groups()
        if role in found:
            raise InputError(f"the part {role} is given twice")
        found[role] = face
    return found


def is_origin(names: Mapping[ArgumentKind, Sequence[str]], text: str) -> bool:
    """Return whether a text that is no model is a fact, or something among these names."""
    return "(" in text or kind_of(names, text) is not None


def make_unknown_subject_error(
    models: Iterable[str], names: Mapping[ArgumentKind, Sequence[str]], text: str
) -> InputError:
    """Return the error about a word that is neither a model nor, if any could be meant, one of the
    names.

    >>> str(make_unknown_subject_error(["box"], {ArgumentKind.FACE: ["f1"]}, "bx"))
    "there is neither a model nor a thing of the scene called 'bx'; did you mean box?"
    >>> str(make_unknown_subject_error(["box"], {ArgumentKind.FACE: ["f1"]}, ""))
    "there is neither a model nor a thing of the scene called ''; models are box"
    >>> str(make_unknown_subject_error(["box"], {ArgumentKind.FACE: ["f1"]}, "my.model"))
    "'my.model' is a file of models: load it (--models FILE, :load FILE) and name a model"
    """
    if text.endswith(".model"):
        return InputError(
            f"{text!r} is a file of models: load it (--models FILE, :load FILE) and name a model"
        )
    known = tuple(models)
    meant = nearest(text, (*known, *(name for those in names.values() for name in those)))
    alike = next((those for those in names.values() if those and those[0][0] == text[:1]), ())
    if meant:
        guess = f"did you mean {meant}?"
    elif alike:
        guess = f"there are {alike[0]} to {alike[-1]}"
    else:
        guess = f"models are {', '.join(known)}"
    neither = "neither a model nor a thing of the scene called" if names else "no model"
    return InputError(f"there is {neither} {text!r}; {guess}")


def why(session: Session, scene: str, about: About, *, full: bool = False) -> Explanation:
    """Explain why the model holds for what fits it best; if it does not, what is missing.

    Of parts that are given for sets, whether they belong to them. With `full` by its whole proof,
    and where each face comes from, down to pixels. Raises QueryError for a model, a thing, a part
    or a face that there is not.
    """
    verdict = session.base.why(scene, about.model, thing=about.thing, parts=about.parts)
    states = [member.state for member in verdict.asked] or [verdict.state]
    holds = all(state is State.HOLDS for state in states)
    faces = tuple(dict.fromkeys(f for part in verdict.parts for f in part.faces)) if full else ()
    origins = {face: session.base.origin(scene, face) for face in faces}
    unit = session.base.scenes[scene].length_unit
    lines = [*verdict.lines(full=full)]
    for found in origins.values():
        lines.extend(found.lines(full=True, length_unit=unit))
    data = {
        "schema": WHY,
        "scene": scene,
        "verdict": verdict.to_json(full=full),
        **({"origins": {f: o.to_json() for f, o in origins.items()}} if full else {}),
    }
    hint = "" if holds else f"{about.model} shows what else comes near"
    return Explanation(holds, tuple(lines), data, hint, cut=not full, verdicts=(verdict,))


def why_not(
    session: Session, scene: str, about: About, *, count: int, full: bool = False
) -> Explanation:
    """Find what comes nearest to the model and does not hold, at most `count` of them; errors as
    `why`.

    With `full` each with its whole proof, not only with what fails.
    """
    misses = session.base.why_not(
        scene, about.model, thing=about.thing, parts=about.parts, count=count
    )
    lines = tuple(line for miss in misses for line in _format_miss(miss, full=full))
    data = {
        "schema": WHY_NOT,
        "scene": scene,
        "model": about.model,
        "near_misses": [miss.to_json(full=full) for miss in misses],
    }
    if not misses:
        lines = explain_nothing_near(session.base, scene, about.model)
    cut = bool(misses) and not full
    return Explanation(bool(misses), lines, data, cut=cut, verdicts=tuple(misses))


def explain_nothing_near(base: KnowledgeBase, scene: str, model: str) -> tuple[str, ...]:
    """Explain that nothing comes near, or why there is nothing at all."""
    found = base.why(scene, model)
    if not found.thing:
        return tuple(found.lines())
    return (f"nothing in {scene} comes near {model} without being one",)


def _format_miss(verdict: Verdict, *, full: bool) -> Iterator[str]:
    return verdict.lines(full=True) if full else verdict.iter_miss_lines()


def origin(session: Session, scene: str, name: str, *, full: bool = False) -> Explanation:
    """Trace where something of a scene or a fact comes from; QueryError for another name."""
    found = session.base.origin(scene, name)
    unit = session.base.scenes[scene].length_unit
    whole = tuple(found.lines(full=True, length_unit=unit))
    lines = whole if full else tuple(found.lines(length_unit=unit))
    data = {"schema": ORIGIN, "scene": scene, "origin": found.to_json()}
    return Explanation(True, lines, data, cut=lines != whole)
