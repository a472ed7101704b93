"""Models of which every one is another too, though nobody says so.

A model is implied by another if all that it asks for follows from what the other asks for, its
parts being some of the other's. Sound, not complete; bounded by a number of steps.
"""

from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass

from facetlog.grammar import syntax as s
from facetlog.grammar.faults import MOST_FAULTS, Fault, Severity
from facetlog.grammar.lint.bound_graph import EQUAL
from facetlog.grammar.lint.briefs import Given, Needed, Required, brief_of
from facetlog.grammar.lint.claims import Claim, Claims
from facetlog.grammar.lint.knowledge import Knowledge, claims_on
from facetlog.grammar.lint.solids import IMPLIES
from facetlog.grammar.resolve import FlatModel
from facetlog.grammar.scope import PartSymbol, SetSymbol

__all__ = ["implied_models"]

MOST_MAPPINGS = 720
"""Ways to lay the parts of one model onto those of another that are tried: all of six parts."""

MOST_TRIED = 2_000
"""Parts laid onto others in all comparisons of a file: about a third of a second."""

MOST_LOOKED_AT = 40
"""Models of the same shape that one is held against."""

MOST_CANDIDATES = 6
"""Of these, so many are compared part by part."""

Names = Mapping[str, str]


@dataclass(slots=True)
class _Tried:
    """How much may still be tried."""

    left: int


def implied_models(
    known: Mapping[str, Knowledge], models: Mapping[str, FlatModel], main: s.File
) -> Iterator[Fault]:
    """Models that others imply without being one of them, each once.

    `models` are those models as they stand in the text. A fault stands at the implied model's name,
    or, if that is in another file, at the other's.
    """
    briefs = {name: brief_of(k) for name, k in known.items()}
    required = {name: wanted for name, (wanted, _) in briefs.items() if wanted is not None}
    given = {name: has for name, (_, has) in briefs.items()}
    holders: dict[Hashable, list[str]] = {}
    for name, one in given.items():
        for shape in one.shapes:
            holders.setdefault(shape, []).append(name)
    order = {name: place for place, name in enumerate(known)}
    tried = _Tried(MOST_TRIED)
    left = MOST_FAULTS
    for name, wanted in required.items():
        for other in _candidates(wanted, known, given, holders):
            if not _implied(wanted, known[other], tried):
                if tried.left <= 0:
                    return
                continue
            back = other in required and given[name].may_imply(required[other])
            mutual = back and _implied(required[other], known[name], tried)
            if mutual and order[other] > order[name]:
                # They are the same: the fault stands at the later one.
                continue
            fault = _fault(models[name], models[other], main, mutual)
            if fault is not None:
                yield fault
                left -= 1
                break
        if left <= 0:
            return


def _fault(implied: FlatModel, by: FlatModel, main: s.File, mutual: bool) -> Fault | None:
    at = implied if implied.file is main else by
    if at.file is not main:
        return None
    if mutual:
        message = f"`{implied.name}` asks for no more and no less than `{by.name}`"
        hint = "leave one of them out, or add what distinguishes them"
    else:
        message = f"every `{by.name}` is a `{implied.name}`: all that this asks for follows"
        if at is by:
            message = f"every `{by.name}` is a `{implied.name}`"
        hint = f"write `model {by.name} is {implied.name}`"
    return Fault("implied-model", message, at.source, at.written.name.span, hint, Severity.WARNING)


def _candidates(
    wanted: Required,
    known: Mapping[str, Knowledge],
    given: Mapping[str, Given],
    holders: Mapping[Hashable, list[str]],
) -> list[str]:
    """The models that may imply a model, and are not known to be it."""
    if not wanted.shapes:
        return []
    fewest = min((holders.get(shape, []) for shape in wanted.shapes), key=len)
    found = [
        name
        for name in fewest[:MOST_LOOKED_AT]
        if name != wanted.name
        and wanted.name not in known[name].claims.scope.model.ancestors
        and given[name].may_imply(wanted)
    ]
    return found[:MOST_CANDIDATES]


# ------------------------------------------------------------------ mappings


def _implied(one: Required, other: Knowledge, tried: _Tried) -> bool:
    """Whether all that one model asks for follows from another, under some mapping of the parts."""
    scope, theirs = one.known.claims.scope, other.claims.scope
    if scope.of_things != theirs.of_things:
        return False
    there = [p for p in theirs.singular if not p.owned.node.optional]
    if len(one.parts) > len(there) or (one.whole and len(one.parts) != len(theirs.singular)):
        return False
    return _placed(one, other, there, {}, tried, [0])


def _placed(
    one: Required,
    other: Knowledge,
    there: list[PartSymbol],
    names: dict[str, str],
    tried: _Tried,
    whole: list[int],
) -> bool:
    """Lays the next part onto each that is left; what is decided by then must follow."""
    if len(names) == len(one.parts):
        whole[0] += 1
        return _sets_placed(one, other, names)
    part = one.parts[len(names)]
    for target in there:
        if target.name in names.values() or target.model != part.model:
            continue
        if not target.kinds <= part.kinds or tried.left <= 0 or whole[0] >= MOST_MAPPINGS:
            continue
        tried.left -= 1
        inner = {**names, part.name: target.name}
        ready = [
            n
            for n in one.needed
            if part.name in n.claim.parts and n.claim.parts <= inner.keys() and not n.claim.of_set
        ]
        decided = all(_follows(n, other, inner) for n in ready)
        if decided and _placed(one, other, there, inner, tried, whole):
            return True
    return False


def _sets_placed(one: Required, other: Knowledge, names: dict[str, str]) -> bool:
    """Whether every set of the one is a set of the other, and what is said of all follows."""
    inner = dict(names)
    for symbol in one.sets:
        found = next(
            (x for x in other.claims.scope.sets if _same_set(symbol, x, one, other, inner)), None
        )
        if found is None:
            return False
        inner[symbol.name] = found.name
    return all(
        _follows(n, other, inner)
        for n in one.needed
        if n.claim.of_set or not n.claim.parts or not n.claim.parts <= names.keys()
    )


def _same_set(
    symbol: SetSymbol, other: SetSymbol, one: Required, known: Knowledge, names: dict[str, str]
) -> bool:
    ours, theirs = symbol.owned.node, other.owned.node
    if (symbol.kinds, symbol.model, ours.separate) != (other.kinds, other.model, theirs.separate):
        return False
    if theirs.optional or not _at_least_as_narrow(ours.count, theirs.count):
        return False
    inner = {**names, symbol.name: other.name}
    said = {_renamed(c.key, inner) for c in _who(one.known.claims, symbol.name)}
    return said == {c.key for c in _who(known.claims, other.name)}


def _who(claims: Claims, name: str) -> list[Claim]:
    """The claims that say who belongs to a set."""
    return [c for c in claims.claims if c.origin.symbol == name and c.of_set == name]


def _at_least_as_narrow(wanted: s.Count | None, given: s.Count | None) -> bool:
    """Whether a number that is allowed by the second is always allowed by the first."""
    if wanted is None or wanted.kind is s.CountKind.ANY:
        return True
    if given is None or given.kind is s.CountKind.ANY:
        return False
    (low, high), (least, most) = _numbers(wanted), _numbers(given)
    return low <= least and most <= high


def _numbers(count: s.Count) -> tuple[float, float]:
    low = float(count.low.text) if count.low else 0.0
    high = float(count.high.text) if count.high else float("inf")
    if count.kind is s.CountKind.AT_LEAST:
        high = float("inf")
    elif count.kind is s.CountKind.AT_MOST:
        low = 0.0
    return low, high


def _follows(needed: Needed, other: Knowledge, names: Names) -> bool:
    """Whether a claim follows from another model, its parts called as there."""
    claim = needed.claim
    if needed.edges is not None:
        # Quicker than their forms, and equal bounds follow too, unless they fade.
        if _bounded(needed, other, names):
            return True
        if all(bound.full is bound.half for bound in claim.bounds):
            return False
    key = _renamed(claim.key, names)
    found = other.conditions.get(key)
    if found is not None and not (found[0].origin.if_known and not claim.origin.if_known):
        return True
    match key:
        case (str() as word, of):
            stronger = (w for w, weaker in IMPLIES.items() if word in weaker)
            return any((w, of) in other.conditions for w in stronger)
    return False


def _bounded(needed: Needed, other: Knowledge, names: Names) -> bool:
    """Whether the bounds of a claim follow from those of another model."""
    for edge in needed.edges or ():
        greater, lesser = _renamed(edge.greater, names), _renamed(edge.lesser, names)
        factor, path = other.graph.best(greater, lesser)
        if factor < edge.factor * (1 - EQUAL):
            return False
        if not needed.claim.origin.if_known and any(c.origin.if_known for c in claims_on(path)):
            return False
    return True


def _renamed_tuple(atom: tuple[Hashable, ...], names: Names) -> tuple[Hashable, ...]:
    return tuple(_renamed(x, names) for x in atom)


def _renamed(key: Hashable, names: Names) -> Hashable:
    """A form with the parts called as in another model."""
    if isinstance(key, str):
        if key[:1] != "$":
            return key
        name, dot, part = key[1:].partition(".")
        return f"${names.get(name, name)}{dot}{part}"
    if isinstance(key, tuple):
        if len(key) == 3 and key[0] == "every" and isinstance(key[1], str):
            return "every", names.get(key[1], key[1]), _renamed(key[2], names)
        return _renamed_tuple(key, names)
    if isinstance(key, frozenset):
        return frozenset(_renamed(x, names) for x in key)
    return key
