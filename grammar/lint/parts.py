"""Parts that could be anything: bound by their kind alone, or by nothing that others are."""

from collections.abc import Iterator

from facetlog.grammar import syntax as s
from facetlog.grammar.faults import Fault, Severity
from facetlog.grammar.lint.claims import Claims
from facetlog.grammar.scope import PartSymbol
from facetlog.grammar.vocabulary import THING

__all__ = ["part_faults"]


def part_faults(claims: Claims, main: s.File, reported: frozenset[str]) -> Iterator[Fault]:
    """Parts of the model itself that no required line binds, or that no line joins to the others.

    `reported` are parts that have a warning already.
    """
    scope = claims.scope
    bound = {name for c in claims.claims if c.origin.required for name in c.parts}
    bound |= {c.origin.symbol for c in claims.claims if c.origin.symbol}
    free = set(reported)
    for part in scope.singular:
        if part.name in bound or part.name in reported or part.kinds == THING:
            continue
        free.add(part.name)
        if _is_own(part, main, scope.model.name):
            message = f"no line that must hold is about `{part.name}`: any {_kind(part)} will do"
            hint = "say what it must be like"
            yield _warning("unconstrained", message, part, hint)
    yield from _unconnected(claims, main, free)


def _unconnected(claims: Claims, main: s.File, free: set[str]) -> Iterator[Fault]:
    scope = claims.scope
    parts = [p for p in scope.singular if p.name not in free]
    if len(parts) < 2:
        return
    groups = {name: name for name in scope.symbols}

    def root(name: str) -> str:
        while groups[name] != name:
            groups[name] = groups[groups[name]]
            name = groups[name]
        return name

    for claim in claims.claims:
        names = [n for n in claim.parts if n in groups]
        for name in names[1:]:
            groups[root(name)] = root(names[0])
    first = parts[0]
    seen = {root(first.name)}
    for part in parts[1:]:
        group = root(part.name)
        if group in seen:
            continue
        seen.add(group)
        if _is_own(part, main, scope.model.name):
            message = f"no line joins `{part.name}` to `{first.name}`"
            hint = "say how they lie to one another: `x adjoins y`, or compare their measures"
            yield _warning("unconnected", message, part, hint)


def _is_own(part: PartSymbol, main: s.File, model: str) -> bool:
    return part.owned.file is main and part.owned.model == model


def _kind(part: PartSymbol) -> str:
    return part.owned.node.kind.text


def _warning(code: str, message: str, part: PartSymbol, hint: str) -> Fault:
    name = next(n for n in part.owned.node.names if n.text == part.name)
    return Fault(code, message, part.owned.source, name.span, hint, Severity.WARNING)
