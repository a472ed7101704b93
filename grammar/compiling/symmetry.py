"""Parts that may be swapped without changing what a model says.

Two parts are interchangeable if swapping their names maps the model's lines onto themselves, as a
set: then only one order of what plays them needs to be tried.
"""

from collections.abc import Mapping

from facetlog.grammar import syntax as s
from facetlog.grammar.scope import PartSymbol, Scope, SetSymbol
from facetlog.grammar.traversal import Node, children

PAIR = 2


def interchangeable(scope: Scope) -> tuple[tuple[str, ...], ...]:
    """Return the groups of singular parts that are interchangeable, two or more in each."""
    names = [p.name for p in scope.singular if not p.owned.node.optional]
    if len(names) < 2 or scope.of_things:
        return ()
    symmetric = _find_symmetric(scope)
    before = _collect_lines(scope, symmetric, {})
    groups: list[list[str]] = []
    for name in names:
        for group in groups:
            if _collect_lines(scope, symmetric, {group[0]: name, name: group[0]}) == before:
                group.append(name)
                break
        else:
            groups.append([name])
    return tuple(tuple(group) for group in groups if len(group) > 1)


def _find_symmetric(scope: Scope) -> Mapping[str, bool]:
    """Return the symmetric form of a test, and whether a number follows its arguments.

    Words of the vocabulary, and definitions of two parameters with such a body.
    """
    found = {
        name: word.number_last is not None for name, word in scope.words.items() if word.symmetric
    }
    defines = {
        name: owned.node
        for name, owned in scope.defines.items()
        if len(owned.node.parameters) == PAIR
    }
    while True:
        more = {
            name
            for name, define in defines.items()
            if name not in found and _is_symmetric(define.parameters, define.body, found)
        }
        if not more:
            return found
        found |= dict.fromkeys(more, False)


def _is_symmetric(
    names: tuple[s.Name, ...], body: s.Expression, symmetric: Mapping[str, bool]
) -> bool:
    plain, turned = _get_bodies(names, body, symmetric, {})
    return plain == turned


def _collect_lines(
    scope: Scope, symmetric: Mapping[str, bool], swap: Mapping[str, str]
) -> frozenset[object]:
    """Return all that is said of the parts, in a form that does not depend on order."""
    said: list[object] = []
    every: tuple[PartSymbol | SetSymbol, ...] = (*scope.singular, *scope.sets)
    for part in every:
        node = part.owned.node
        name = swap.get(part.name, part.name)
        demanded = scope.where(part)
        where = _get_form(demanded, symmetric, swap) if demanded is not None else None
        count = (node.count.kind, str(node.count.low), str(node.count.high)) if node.count else None
        said.append((name, part.kinds, part.model, node.optional, node.separate, count, where))
    for _, owned in scope.model.lines:
        line = owned.node
        said.append((line.expect, line.if_known, _get_form(line.condition, symmetric, swap)))
    said += [
        (define.node.name.text, _get_form(define.node.body, symmetric, swap))
        for define in scope.defines.values()
    ]
    for size in scope.model.sizes:
        forms = [_get_form(m, symmetric, swap) for m in size.node.measures]
        names = tuple(n.text for n in size.node.names)
        said.append((names, _sort_forms(forms) if size.node.longest_first else tuple(forms)))
    return frozenset(said)


def _sort_forms(forms: list[object]) -> tuple[object, ...]:
    return tuple(sorted(forms, key=repr))


def _get_form(node: Node, symmetric: Mapping[str, bool], swap: Mapping[str, str]) -> object:
    """Return a node without places; arguments of what is symmetric in one order."""

    def inner(one: Node) -> object:
        return _get_form(one, symmetric, swap)

    match node:
        case s.Name(text):
            return swap.get(text, text)
        case s.Reference(name):
            return inner(name)
        case s.Member(owner, part):
            return "member", inner(owner), part.text
        case s.Quantity(number, unit):
            return number.text, unit.text if unit else ""
        case s.Call(name, arguments):
            forms = [inner(a) for a in arguments]
            if name.text in symmetric:
                last = forms[-1:] if symmetric[name.text] else []
                first = forms[:-1] if symmetric[name.text] else forms
                return name.text, _sort_forms(first), tuple(last)
            return name.text, tuple(forms), ()
        case s.Relation(left, name, right):
            forms = [inner(left), inner(right)]
            ordered = _sort_forms(forms) if name.text in symmetric else tuple(forms)
            return name.text, ordered, ()
        case s.Property(subject, name, negated):
            return "is", inner(subject), name.text, negated
        case s.And(conditions) | s.Or(conditions):
            return type(node).__name__, _sort_forms([inner(c) for c in conditions])
        case s.EachOf(names, of, body):
            plain, turned = _get_bodies(names, body, symmetric, swap)
            among = [inner(n) for n in of]
            # Of two that are not alike in it, which comes first says which is which.
            alike = len(names) == 1 or plain == turned
            return "each of", len(names), _sort_forms(among) if alike else tuple(among), plain
        case s.There():
            where = inner(node.where) if node.where is not None else None
            range_ = _sort_forms([inner(n) for n in node.of])
            count = (
                (node.count.kind, str(node.count.low), str(node.count.high)) if node.count else None
            )
            return "there", node.some, count, node.kind.text, node.name.text, range_, where
        case s.Each():
            where = inner(node.where) if node.where is not None else None
            return "each", str(node.kind), inner(node.name), where, inner(node.body)
        case s.Comparison():
            second = inner(node.second) if node.second is not None else None
            fading = inner(node.fading) if node.fading is not None else None
            sides = inner(node.measure), inner(node.limit)
            return (node.comparator, *sides, second, fading, node.sharp)
        case s.Arithmetic(sign, left, right):
            return sign, inner(left), inner(right)
        case _:
            return (
                type(node).__name__,
                getattr(node, "how", ""),
                tuple(map(inner, children(node))),
            )


def _get_bodies(
    names: tuple[s.Name, ...],
    body: s.Expression,
    symmetric: Mapping[str, bool],
    swap: Mapping[str, str],
) -> tuple[object, object]:
    """Return the body of `each pair x, y`, and the same with x and y changed about."""
    plain = {name.text: f"#{number}" for number, name in enumerate(names)}
    turned = {name.text: f"#{len(names) - 1 - number}" for number, name in enumerate(names)}
    return (
        _get_form(body, symmetric, {**swap, **plain}),
        _get_form(body, symmetric, {**swap, **turned}),
    )
