"""What is odd about models without faults: the door to all lint warnings."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TypeAlias

from facetlog.grammar import syntax as s
from facetlog.grammar.faults import MOST_FAULTS, Fault, Severity
from facetlog.grammar.lint.angles import Effort, angle_faults
from facetlog.grammar.lint.bounds import bound_faults
from facetlog.grammar.lint.claims import Claims, Place
from facetlog.grammar.lint.habits import absolute_sizes, habits, in_vain
from facetlog.grammar.lint.implied import implied_models
from facetlog.grammar.lint.knowledge import Knowledge, knowledge_of
from facetlog.grammar.lint.normal import claims_of
from facetlog.grammar.lint.parts import part_faults
from facetlog.grammar.lint.ranges import region_faults
from facetlog.grammar.lint.unused import unused_parts, unused_statements
from facetlog.grammar.passes.memo import Fingerprints, Memo
from facetlog.grammar.resolve import FlatModel
from facetlog.grammar.scope import Scope

__all__ = ["RULES", "KnowledgeMemo", "lint"]

MOST_STEPS = 20_000
"""Expressions of one model, its definitions opened. A large model has some hundreds."""

STEPS_IN_ALL = 1_500_000
"""The same of all models that are looked at: five thousand large ones."""

SEARCH_STEPS = 150_000
"""Steps of all searches for directions: about half a second."""


@dataclass(frozen=True, slots=True)
class Look:
    """One model as its rules see it.

    `reported` are the places of claims that have a warning already, `seen` the comparisons that
    were looked at, `effort` what searches may still cost: they grow from rule to rule.
    """

    claims: Claims
    known: Knowledge
    main: s.File
    effort: Effort
    reported: set[Place] = field(default_factory=set)
    seen: dict[int, bool] = field(default_factory=dict)


Rule = Callable[[Look], Iterator[Fault]]

_HOLDING: tuple[Rule, ...] = (
    lambda x: region_faults(x.claims, x.seen, x.reported),
    lambda x: bound_faults(x.claims, x.known, x.reported),
    lambda x: angle_faults(x.claims, x.reported, x.effort),
)
"""Whether lines can hold, and whether they say anything."""

_SAYING: tuple[Rule, ...] = (
    lambda x: _parts(x.claims, x.main),
    lambda x: in_vain(x.claims),
    lambda x: absolute_sizes(x.claims, x.reported),
)
"""Whether something is said of what is named, and so that it can be judged."""

RULES = (*_HOLDING, *_SAYING)
"""What each model is looked at for, in this order; habits come first, models side by side last."""

KnowledgeMemo: TypeAlias = Memo[Knowledge | None]
"""What follows from models, kept from one text to the next; None of a model that is too large."""


def lint(
    scopes: Mapping[str, Scope],
    main: s.File,
    faults: Iterable[Fault],
    prints: Fingerprints | None = None,
    memo: KnowledgeMemo | None = None,
) -> tuple[Fault, ...]:
    """What is odd about the models of a file, and about what stands before them.

    `scopes` are those of all models in reach, `faults` those found before: a model that has an
    error is left out, and what it might use is not said to be unused. At most MOST_FAULTS are
    given, errors first. Never raises, and is bounded in time whatever the models say. With a
    `memo`, only models that are not in it are looked at.
    """
    errors = _Errors(faults)
    sound = {name: x for name, x in scopes.items() if not errors.touch(x, scopes)}
    complete = len(sound) == len(scopes) and not errors.before_models(main)
    every = [
        *_faults(sound, main, complete, prints, memo or Memo()),
        *_of_other_lines(scopes, main, errors),
    ]
    # What stands in a definition is met in each model that uses it.
    found = list({(f.code, f.source, f.span): f for f in reversed(every)}.values())[::-1]
    found.sort(key=lambda f: (f.severity is not Severity.ERROR, f.span.start, f.span.end))
    return tuple(found[:MOST_FAULTS])


def _faults(
    sound: Mapping[str, Scope],
    main: s.File,
    complete: bool,
    prints: Fingerprints | None,
    memo: KnowledgeMemo,
) -> Iterator[Fault]:
    """`complete`: all models are looked at, so that what none of them uses is not used."""
    effort = Effort(SEARCH_STEPS)
    left = STEPS_IN_ALL
    looked: dict[str, Knowledge] = {}
    for name, scope in sound.items():
        kept = memo.take(scope.model, prints) if prints is not None else None
        if kept is None:
            known, faults = _looked_at(scope, main, min(MOST_STEPS, left), effort)
            if prints is not None:
                memo.keep(scope.model, prints, known, faults)
        else:
            known, faults = kept
        yield from faults
        if known is None:
            complete = False
            continue
        left -= known.claims.steps
        known.graph.visits = 0
        looked[name] = known
    models = {name: scope.model for name, scope in sound.items()}
    if complete:
        used = ((known.claims.used, models[name]) for name, known in looked.items())
        yield from unused_statements(used, main)
    yield from implied_models(looked, models, main)


def _looked_at(
    scope: Scope, main: s.File, most: int, effort: Effort
) -> tuple[Knowledge | None, tuple[Fault, ...]]:
    """What follows from a model, and what is odd about it if it is of the file itself."""
    is_own = scope.model.file is main
    found = list(habits(scope)) if is_own else []
    claims = claims_of(scope, main, most)
    if claims is None:
        return None, tuple(found)
    known = knowledge_of(claims)
    if is_own:
        look = Look(claims, known, main, effort)
        for rule in RULES:
            found.extend(rule(look))
    return known, tuple(found)


def _parts(claims: Claims, main: s.File) -> Iterator[Fault]:
    parts = tuple(unused_parts(claims, main))
    yield from parts
    yield from part_faults(claims, main, frozenset(_text(f) for f in parts))


def _of_other_lines(
    scopes: Mapping[str, Scope], main: s.File, errors: "_Errors"
) -> Iterator[Fault]:
    """What is wrong with the sound lines of models of which other lines have errors."""
    for scope in scopes.values():
        model = scope.model
        if model.file is not main or model.written.parent is not None:
            continue
        bad = errors.statements(model)
        if not bad or any(not isinstance(statement, s.Line) for statement in bad):
            continue
        lines = tuple((label, x) for label, x in model.lines if x.node not in bad)
        mended = replace(scope, model=replace(model, lines=lines))
        claims = claims_of(mended, main, MOST_STEPS)
        if claims is not None:
            look = Look(claims, knowledge_of(claims), main, Effort(SEARCH_STEPS // 10))
            for rule in _HOLDING:
                yield from rule(look)


def _text(fault: Fault) -> str:
    return fault.source.text[fault.span.start : fault.span.end]


class _Errors:
    """Where errors are, to know which models have one."""

    def __init__(self, faults: Iterable[Fault]) -> None:
        self._places: dict[int, list[int]] = {}
        for fault in faults:
            if fault.severity is Severity.ERROR:
                self._places.setdefault(id(fault.source), []).append(fault.span.start)
        self._faulty: dict[int, frozenset[int]] = {}

    def touch(self, scope: Scope, scopes: Mapping[str, Scope]) -> bool:
        """Whether a model, or one that it inherits from, has an error."""
        model: FlatModel | None = scope.model
        seen: set[str] = set()
        while model is not None and model.name not in seen:
            seen.add(model.name)
            if id(model.written) in self._of(model.file) or self.before_models(model.file):
                return True
            parent = model.written.parent
            if parent is None:
                return False
            above = scopes.get(parent.text)
            if above is None:
                return True
            model = above.model
        return False

    def statements(self, model: FlatModel) -> tuple[s.Statement | s.Model, ...]:
        """The statements of a model that errors stand in; the model itself for its first line."""
        starts = self._places.get(id(model.source), ())
        return tuple(
            statement
            for statement in (model.written, *model.written.statements)
            if any(start in statement.span for start in starts)
        )

    def before_models(self, file: s.File) -> bool:
        """Whether what stands before the first model of a file has an error."""
        return id(file) in self._of(file)

    def _of(self, file: s.File) -> frozenset[int]:
        """The models of a file (ids) that have an error; the file's own id for what is before."""
        found = self._faulty.get(id(file))
        if found is None:
            starts = sorted(self._places.get(id(file.source), ()))
            hit: set[int] = set()
            at: object = file
            models = iter(file.models)
            following = next(models, None)
            for start in starts:
                while following is not None and following.span.start <= start:
                    at, following = following, next(models, None)
                hit.add(id(at))
            found = self._faulty[id(file)] = frozenset(hit)
        return found
