"""Lint: what never holds, contradicts, is said twice or is never used in models without errors."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

from facetlog.grammar import syntax as s
from facetlog.grammar.claim_reader import read_claims
from facetlog.grammar.claims import Bound, Claims, Linear, Place, Region, shorten
from facetlog.grammar.fading import FADING
from facetlog.grammar.faults import MOST_FAULTS, Edit, Fault, Fix, Severity, make_removal, swap
from facetlog.grammar.lint.conflicts import find_contradictions, find_repeats
from facetlog.grammar.resolve import FlatModel
from facetlog.grammar.scope import Scope
from facetlog.grammar.source import Source, Span
from facetlog.grammar.traversal import walk
from facetlog.grammar.vocabulary import Gives


def find_impossible(claims: Claims, reported: set[Place]) -> Iterator[Fault]:
    """Find comparisons of the model itself that never hold, each reported once.

    `reported` gets the places of those that have a fault.
    """
    seen: dict[int, bool] = {}
    for region in claims.regions:
        if region.own and id(region.node) not in seen:
            # Definitions are used more than once.
            fault = _find_bad_width(claims, region) or _find_never(claims, region)
            seen[id(region.node)] = fault is not None
            if fault is not None:
                yield fault
        if seen.get(id(region.node)):
            reported.add(region.place)


def _find_bad_width(claims: Claims, region: Region) -> Fault | None:
    node, source = region.node, region.source
    widths = (("tolerance", region.tolerance, node.second), ("fading", region.fading, node.fading))
    for what, width, shown in widths:
        if width is None or shown is None or not width.is_constant:
            continue
        if width.constant < 0:
            message, hint = f"a {what} cannot be negative", "write it without the sign"
            fixes = _drop_sign(source.text, shown)
            return Fault("negative-width", message, source, shown.span, hint, fixes=fixes)
        if what == "tolerance" and width.constant == 0 and not _is_count(claims, region.measure):
            message = "with a tolerance of 0 only an exact value will do"
            hint = "no measure is exact: give it some room"
            return Fault("zero-tolerance", message, source, shown.span, hint, Severity.WARNING)
    return None


def _drop_sign(text: str, node: s.Expression) -> tuple[Fix, ...]:
    if not isinstance(node, s.Negative) or not isinstance(node.operand, s.Quantity):
        return ()
    number = node.operand.span.start
    before = text[:number].rstrip()
    if not before.endswith("-"):
        return ()  # brackets stand there
    return (Fix("leave the sign out", (Edit(Span(len(before) - 1, number), ""),), True),)


def _is_count(claims: Claims, measure: Linear) -> bool:
    words = claims.scope.words
    names = [str(atom[0]) for atom in measure.terms]
    return all(n == "count" or (n in words and words[n].gives is Gives.COUNT) for n in names)


def _find_never(claims: Claims, region: Region) -> Fault | None:
    node, source = region.node, region.source
    low, high = region.low_bound, region.high_bound
    if low and high and _is_impossible(claims, low.half.plus(high.half)):
        first, second = shorten(source, node.limit), shorten(source, node.second or node.limit)
        message = f"this never holds: `{first}` is more than `{second}`"
        fixes: tuple[Fix, ...] = ()
        if node.comparator is s.Comparator.BETWEEN and node.second is not None:
            ends = (region.low, region.high)
            sure = all(end is not None and end.is_constant for end in ends)
            fixes = (swap(source.text, node.limit.span, node.second.span, sure=sure),)
        return Fault("never-holds", message, source, node.span, "change them round", fixes=fixes)
    for bound in region.bounds:
        if _is_impossible(claims, bound.half):
            why = _describe_range(claims, region, bound)
            message = f"this never holds{why and ': ' + why}"
            return Fault("never-holds", message, source, node.span)
    return None


def _is_impossible(claims: Claims, rest: Linear) -> bool:
    """Return whether what should not be negative is."""
    high = rest.interval(claims.ranges)[1]
    # Else nothing but measures that are never zero, taken off.
    return high < 0 or (
        high == 0
        and rest.constant == 0
        and any(c < 0 and a in claims.positive for a, c in rest.terms.items())
    )


def _describe_range(claims: Claims, region: Region, bound: Bound) -> str:
    """Return the range of what is measured, if that is the reason."""
    if len(bound.full.terms) != 1 or bound.half.interval(claims.ranges)[1] >= 0:
        return ""
    ((atom, factor),) = bound.full.terms.items()
    if region.measure.terms.get(atom) != abs(factor):
        return ""
    name = f"`{shorten(region.source, region.node.measure)}`"
    if atom[0] == "count":
        name = f"the number of `{str(atom[1])[1:]}`"
    low, high = claims.ranges[atom]
    end, side = (high, "most") if bound is region.low_bound else (low, "least")
    word = claims.scope.words.get(str(atom[0]))
    shown = f"{end:g}"
    if word is not None and word.gives is Gives.ANGLE:
        shown = f"{end:g} deg"
    elif word is not None and word.gives is Gives.RATIO:
        shown = f"{100 * end:g} %"
    return f"{name} is at {side} {shown}" if math.isfinite(end) else ""


def find_unused_names(claims: Claims, main: s.File) -> Iterator[Fault]:
    """Find singular parts and sets of the model itself, and local names, that nothing mentions.

    The number of a set's members is a condition by itself, unless any number will do. An object is
    required by its kind.
    """
    scope = claims.scope
    for owned in scope.model.parts:
        part = owned.node
        if owned.file is not main or owned.model != scope.model.name:
            continue
        if part.count is not None and part.count.kind is not s.CountKind.ANY and not part.optional:
            continue
        if part.count is None and part.where is not None:
            continue
        for name in part.names:
            symbol = scope.symbols.get(name.text)
            if name.text in claims.used or symbol is None or (symbol.model and part.count is None):
                continue
            what = "set" if part.count is not None else "part"
            message = f"nothing is said of the {what} `{name}`"
            yield _warn("unused-part", message, owned.source, name, "add a line about it")
    for name, source in claims.in_vain:
        message = f"what must be so does not depend on `{name}`"
        yield _warn("in-vain", message, source, name, f"say it of `{name}`")


def find_unused_statements(models: Iterable[Claims], main: s.File) -> Iterator[Fault]:
    """Find constants, definitions and parameters of a file that no model uses, heirs included."""
    used: set[int] = set()
    for claims in models:
        _mark_used(claims.used, claims.scope.model, used)
    for statement in [*main.statements, *(x for model in main.models for x in model.statements)]:
        if not isinstance(statement, s.Let | s.Define):
            continue
        if id(statement) not in used and statement.name.text != FADING:
            what = "constant" if isinstance(statement, s.Let) else "definition"
            title = f"leave out the {what} `{statement.name}`"
            fixes = make_removal(title, main.source.text, statement.span, sure=False)
            message = f"the {what} `{statement.name}` is never used"
            code = f"unused-{what}"
            yield _warn(code, message, main.source, statement.name, "leave it out", fixes)
        if isinstance(statement, s.Define):
            inside = set(_iter_references(statement.body))
            for parameter in statement.parameters:
                if parameter.text not in inside:
                    message = f"`{statement.name}` does not use its `{parameter}`"
                    hint = "leave it out"
                    yield _warn("unused-parameter", message, main.source, parameter, hint)


def _mark_used(names: frozenset[str], model: FlatModel, used: set[int]) -> None:
    """Note the constants and definitions that a model needs, and what its constants need."""
    waiting, seen = list(names), set[str]()
    while waiting:
        name = waiting.pop()
        if name in seen:
            continue
        seen.add(name)
        define, let = model.defines.get(name), model.lets.get(name)
        if define is not None:
            used.add(id(define.node))
        if let is not None:
            used.add(id(let.node))
            waiting.extend(_iter_references(let.node.value))


def _iter_references(node: s.Expression) -> Iterator[str]:
    for inner in walk(node):
        match inner:
            case s.Reference(name):
                yield name.text
            case s.Member(owner):
                yield owner.text
            case s.EachOf(_, of) | s.There(of=of):
                yield from (n.text for n in of)


def _warn(
    code: str, message: str, source: Source, node: s.Name, hint: str, fixes: tuple[Fix, ...] = ()
) -> Fault:
    return Fault(code, message, source, node.span, hint, Severity.WARNING, fixes)


def lint(scopes: Mapping[str, Scope], main: s.File, faults: Iterable[Fault]) -> tuple[Fault, ...]:
    """Return the lint faults of a file; at most MOST_FAULTS, errors first.

    `scopes` are those of all models in reach, `faults` those found before: a model that has an
    error is left out, and what it might use is not said to be unused. Never raises, and is bounded
    in time whatever the models say.
    """
    every = list(_iter_faults(scopes, main, _Errors(faults, scopes)))
    # What stands in a definition is met in each model that uses it.
    found = list({(f.code, f.source, f.span): f for f in reversed(every)}.values())[::-1]
    found.sort(key=lambda f: (f.severity is not Severity.ERROR, f.span.start, f.span.end))
    return tuple(found[:MOST_FAULTS])


def _iter_faults(scopes: Mapping[str, Scope], main: s.File, errors: "_Errors") -> Iterator[Fault]:
    checked: list[Claims] = []
    for scope in scopes.values():
        is_own = scope.model.file is main
        sound = not errors.touch(scope)
        rest = scope if sound else errors.drop_faulty_lines(scope) if is_own else None
        claims = read_claims(rest, main) if rest is not None else None
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

    def __init__(self, faults: Iterable[Fault], scopes: Mapping[str, Scope]) -> None:
        self._places = [(f.source, f.span.start) for f in faults if f.severity is Severity.ERROR]
        self._faulty = {name for name, scope in scopes.items() if self._touch_text(scope.model)}
        parents = {name: scope.model.written.parent for name, scope in scopes.items()}
        heirs = self._faulty
        while heirs:
            heirs = {
                name
                for name, parent in parents.items()
                if parent is not None
                and (parent.text in self._faulty or parent.text not in scopes)
                and name not in self._faulty
            }
            self._faulty |= heirs

    def touch(self, scope: Scope) -> bool:
        """Return whether a model, or one that it inherits from, has an error."""
        return scope.model.name in self._faulty

    def touch_head(self, file: s.File) -> bool:
        """Return whether what stands before the first model of a file has an error."""
        first = file.models[0].span.start if file.models else len(file.source.text)
        return any(source is file.source and at < first for source, at in self._places)

    def _touch_text(self, model: FlatModel) -> bool:
        start = model.written.span.start
        following = (m.span.start for m in model.file.models if m.span.start > start)
        end = min(following, default=len(model.source.text) + 1)
        return self.touch_head(model.file) or any(
            source is model.source and start <= at < end for source, at in self._places
        )

    def drop_faulty_lines(self, scope: Scope) -> Scope | None:
        """Return a model without its lines that have an error; None if it has other errors."""
        model = scope.model
        starts = [at for source, at in self._places if source is model.source]
        statements = (model.written, *model.written.statements)
        bad = [x for x in statements if any(start in x.span for start in starts)]
        if not bad or model.written.parent or any(not isinstance(x, s.Line) for x in bad):
            return None
        lines = tuple((label, x) for label, x in model.lines if x.node not in bad)
        return replace(scope, model=replace(model, lines=lines))
