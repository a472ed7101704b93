"""Parts that may be swapped without changing what a model says.

Two parts are interchangeable if swapping their names maps the model's claims onto themselves: then
only one order of what plays them needs to be tried.
"""

from collections import Counter
from collections.abc import Hashable, Mapping

from facetlog.grammar.claim_reader import read_claims
from facetlog.grammar.claims import Claims, Origin
from facetlog.grammar.scope import PartSymbol, Scope, SetSymbol


def interchangeable(scope: Scope) -> tuple[tuple[str, ...], ...]:
    """Return the groups of singular parts that are interchangeable, two or more in each."""
    names = [p.name for p in scope.singular if not p.owned.node.optional]
    if len(names) < 2 or scope.of_things:
        return ()
    claims = read_claims(scope, scope.model.file, degrees=True)
    if claims is None:
        return ()
    forms = _collect_forms(claims)
    groups: list[list[str]] = []
    for name in names:
        for group in groups:
            if _swap(forms, {group[0]: name, name: group[0]}) == forms:
                group.append(name)
                break
        else:
            groups.append([name])
    return tuple(tuple(group) for group in groups if len(group) > 1)


def _collect_forms(claims: Claims) -> Hashable:
    """Return all that a model says of its parts, in a form that does not depend on order."""
    scope = claims.scope
    said: dict[Origin, Counter[Hashable]] = {}
    for claim in claims.claims:
        said.setdefault(claim.origin, Counter())[claim.key] += 1
    forms: list[Hashable] = []
    parts: tuple[PartSymbol | SetSymbol, ...] = (*scope.singular, *scope.sets)
    for part in parts:
        node = part.owned.node
        count = (node.count.kind, str(node.count.low), str(node.count.high)) if node.count else None
        forms.append((f"${part.name}", part.kinds, part.model, node.optional, node.separate, count))
    for origin, keys in said.items():
        line = origin.statement.node
        expect = getattr(line, "expect", None)
        symbol = f"${origin.symbol}" if origin.symbol else ""
        forms.append((symbol, expect, origin.if_known, frozenset(keys.items())))
    for size, measures in zip(scope.model.sizes, claims.sizes, strict=True):
        sums = [measure.key for measure in measures]
        names = tuple(n.text for n in size.node.names)
        alike = frozenset(Counter(sums).items()) if size.node.longest_first else tuple(sums)
        forms.append((names, alike))
    return frozenset(forms)


def _swap(form: Hashable, names: Mapping[str, str]) -> Hashable:
    """Return a form with other names of parts, which are written `$top` or `$top.part`."""
    match form:
        case str() if form[:1] == "$":
            name, dot, rest = form[1:].partition(".")
            return f"${names.get(name, name)}{dot}{rest}"
        case tuple():
            return tuple([_swap(one, names) for one in form])
        case frozenset():
            return frozenset([_swap(one, names) for one in form])
        case _:
            return form
