"""What must be so of the singular parts alone: the conditions that can choose them."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

from facetlog.grammar import syntax as s
from facetlog.grammar.scope import THIS, PartSymbol, Scope
from facetlog.grammar.vocabulary import Gives

__all__ = ["Requirement", "requirements"]


@dataclass(frozen=True, slots=True)
class Requirement:
    """One condition on singular parts; `substitutes` says what its names stand for.

    `identifies`: it says how a part lies (level, at right angles to another), or the author
    chose it by `where`, so that what does not satisfy it is not the part, rather than a bad one.
    """

    condition: s.Expression
    substitutes: tuple[tuple[str, str], ...]
    parts: frozenset[str]
    if_known: bool
    identifies: bool
    adjoins: tuple[str, str] | None = None


def requirements(scope: Scope) -> tuple[Requirement, ...]:
    """The requirements of a model on its singular parts, in the order of the file."""
    singular = {p.name: p for p in scope.singular if not p.owned.node.optional}
    found: list[Requirement] = []
    for part in singular.values():
        where = scope.where(part)
        if where is not None:
            found += _from(where, scope, singular, {}, False, True)
    for _, owned in scope.model.lines:
        if owned.node.expect is None:
            found += _from(owned.node.condition, scope, singular, {}, owned.node.if_known, False)
    return tuple(found)


def _from(
    node: s.Expression,
    scope: Scope,
    singular: dict[str, PartSymbol],
    given: dict[str, str],
    if_known: bool,
    chosen: bool,
) -> Iterator[Requirement]:
    """The single requirements that a condition is made of."""
    match node:
        case s.And(conditions):
            for condition in conditions:
                yield from _from(condition, scope, singular, given, if_known, chosen)
            return
        case s.EachOf(names, of, body) if all(n.text in singular for n in of):
            for some in combinations([n.text for n in of], len(names)):
                inner = {**given, **dict(zip((n.text for n in names), some, strict=True))}
                yield from _from(body, scope, singular, inner, if_known, chosen)
            return
    parts = _parts(node, scope, singular, given)
    if parts is None or not parts:
        return
    adjoins = _adjoining(node, given)
    identifies = chosen or _is_orientation(node, scope)
    yield Requirement(node, tuple(given.items()), parts, if_known, identifies, adjoins)


def _parts(
    node: s.Expression, scope: Scope, singular: dict[str, PartSymbol], given: dict[str, str]
) -> frozenset[str] | None:
    """The singular parts that a condition is about; None if it is about more than these."""
    found: set[str] = set()
    waiting: list[tuple[s.Node, frozenset[str]]] = [(node, frozenset())]
    seen: set[str] = set()
    while waiting:
        one, parameters = waiting.pop()
        for inner in s.walk(one):
            match inner:
                case s.There() | s.Each() | s.EachOf() | s.Aggregate() | s.Member():
                    return None
                case s.Reference(name):
                    text = given.get(name.text, name.text)
                    if text in singular:
                        found.add(text)
                    elif text in parameters or text == THIS or text in scope.lets:
                        continue
                    else:
                        return None
                case s.Call(name) | s.Property(_, name) | s.Relation(_, name):
                    if name.text == "count":
                        return None
                    if name.text in scope.defines and name.text not in seen:
                        seen.add(name.text)
                        define = scope.defines[name.text].node
                        waiting.append((define.body, frozenset(p.text for p in define.parameters)))
    return frozenset(found)


def _adjoining(node: s.Expression, given: dict[str, str]) -> tuple[str, str] | None:
    match node:
        case s.Relation(s.Reference(left), s.Name("adjoins"), s.Reference(right)):
            pass
        case s.Call(s.Name("adjoins"), (s.Reference(left), s.Reference(right))):
            pass
        case _:
            return None
    return given.get(left.text, left.text), given.get(right.text, right.text)


def _is_orientation(node: s.Expression, scope: Scope) -> bool:
    """Whether it says how faces lie: a property of one, or an angle."""
    match node:
        case s.Property(_, name, False):
            word = scope.words.get(name.text)
            return word is not None and word.is_condition and len(word.arguments) == 1
        case s.Comparison(_, s.Call(name)):
            word = scope.words.get(name.text)
            return word is not None and word.gives is Gives.ANGLE
    return False
