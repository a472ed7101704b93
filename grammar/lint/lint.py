"""Lint: what never holds, contradicts, is said twice or is never used in models without errors."""

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

from facetlog.grammar import syntax as s
from facetlog.grammar.faults import MOST_FAULTS, Fault, Severity
from facetlog.grammar.lint.claims import Claims, Place
from facetlog.grammar.lint.conflicts import find_contradictions, find_repeats
from facetlog.grammar.lint.impossible import find_impossible
from facetlog.grammar.lint.reader import read_claims
from facetlog.grammar.lint.unused import find_unused_names, find_unused_statements
from facetlog.grammar.scope import Scope

MOST_STEPS = 20_000
"""Expressions of one model, its definitions opened. A large model has some hundreds."""


def lint(scopes: Mapping[str, Scope], main: s.File, faults: Iterable[Fault]) -> tuple[Fault, ...]:
    """Return the lint faults of a file; at most MOST_FAULTS, errors first.

    `scopes` are those of all models in reach, `faults` those found before: a model that has an
    error is left out, and what it might use is not said to be unused. Never raises, and is bounded
    in time whatever the models say.
    """
    every = list(_iter_faults(scopes, main, _Errors(faults)))
    # What stands in a definition is met in each model that uses it.
    found = list({(f.code, f.source, f.span): f for f in reversed(every)}.values())[::-1]
    found.sort(key=lambda f: (f.severity is not Severity.ERROR, f.span.start, f.span.end))
    return tuple(found[:MOST_FAULTS])


def _iter_faults(scopes: Mapping[str, Scope], main: s.File, errors: "_Errors") -> Iterator[Fault]:
    checked: list[Claims] = []
    for scope in scopes.values():
        is_own = scope.model.file is main
        sound = not errors.touch(scope, scopes)
        rest = scope if sound else errors.drop_faulty_lines(scope) if is_own else None
        claims = read_claims(rest, main, MOST_STEPS) if rest is not None else None
        if claims is None:
            continue
        if is_own:
            reported: set[Place] = set()
            yield from find_impossible(claims, reported)
            yield from find_contradictions(claims, reported)
            yield from find_repeats(claims, reported)
        if sound:
            checked.append(claims)
            yield from find_unused_names(claims, main) if is_own else ()
    if len(checked) == len(scopes) and not errors.touch_head(main):
        yield from find_unused_statements(checked, main)


class _Errors:
    """Where errors are, to know which models have one."""

    def __init__(self, faults: Iterable[Fault]) -> None:
        # A file's source and the place of the model in it; -1 for what stands before the first.
        self._touched: set[tuple[int, int]] = set()
        self._faults = [f for f in faults if f.severity is Severity.ERROR]
        self._read: set[int] = set()

    def _has(self, file: s.File, number: int) -> bool:
        if id(file) not in self._read:
            self._read.add(id(file))
            starts = [model.span.start for model in file.models]
            for fault in self._faults:
                if fault.source is file.source:
                    at = bisect_right(starts, fault.span.start) - 1
                    self._touched.add((id(file), at))
        return (id(file), number) in self._touched

    def touch_head(self, file: s.File) -> bool:
        """Whether what stands before the first model of a file has an error."""
        return self._has(file, -1)

    def drop_faulty_lines(self, scope: Scope) -> Scope | None:
        """Return a model without its lines that have an error; None if it has other errors."""
        model = scope.model
        starts = [f.span.start for f in self._faults if f.source is model.source]
        statements = (model.written, *model.written.statements)
        bad = [x for x in statements if any(start in x.span for start in starts)]
        if not bad or model.written.parent or any(not isinstance(x, s.Line) for x in bad):
            return None
        lines = tuple((label, x) for label, x in model.lines if x.node not in bad)
        return replace(scope, model=replace(model, lines=lines))

    def touch(self, scope: Scope, scopes: Mapping[str, Scope]) -> bool:
        """Whether a model, or one that it inherits from, has an error."""
        seen: set[str] = set()
        at: Scope | None = scope
        while at is not None and at.model.name not in seen:
            model = at.model
            seen.add(model.name)
            if self.touch_head(model.file) or self._has(
                model.file, model.file.models.index(model.written)
            ):
                return True
            parent = model.written.parent
            if parent is None:
                return False
            at = scopes.get(parent.text)
        return at is None
