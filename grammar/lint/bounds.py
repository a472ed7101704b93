"""Lines that contradict one another, are said twice, or follow from one another."""

from collections.abc import Hashable, Iterable, Iterator

from facetlog.grammar import syntax as s
from facetlog.grammar.faults import Fault, Severity
from facetlog.grammar.lint.bound_graph import Edge
from facetlog.grammar.lint.claims import Claim, Claims, Place, in_short, where_it_stands
from facetlog.grammar.lint.given_words import kind_meant, of_every_solid
from facetlog.grammar.lint.knowledge import Contradiction, Knowledge, claims_on, given_on

__all__ = ["bound_faults", "quoted"]

MOST_NAMED = 3
"""Other lines that a message names."""


def bound_faults(claims: Claims, known: Knowledge, reported: set[Place]) -> Iterator[Fault]:
    """Contradictions, then what is said twice, then what follows from other lines.

    `reported` are the places of claims that have a warning already, and grows.
    """
    for one in known.contradictions:
        yield from _contradiction(one, reported)
    groups = _groups(claims)
    yield from _twice(groups, reported)
    yield from _implied(groups, known, reported)


def quoted(claims: Iterable[Claim], at: Claim) -> str:
    """Other conditions, as a message names them that stands at a claim."""
    source = at.origin.source
    said = (
        f"`{in_short(c.origin.source, c.node)}` ({where_it_stands(c.origin, source)})"
        for c in {c.place: c for c in claims}.values()
    )
    return " and ".join(list(said)[:MOST_NAMED])


def _contradiction(found: Contradiction, reported: set[Place]) -> Iterator[Fault]:
    own = [c for c in found.claims if c.origin.own]
    if not own or any(c.place in reported for c in found.claims):
        return
    reported.update(c.place for c in found.claims)
    at = max(own, key=lambda c: c.node.span.start)
    others = [c for c in found.claims if c.place != at.place]
    sure = found.sure and not any(c.origin.if_known for c in found.claims)
    message = f"this contradicts {quoted(others, at) or of_every_solid(found.given)}"
    hint = "both hold only of what is 0" if found.only_zero else kind_meant(found.claims)
    severity = Severity.ERROR if sure else Severity.WARNING
    yield Fault("contradiction", message, at.origin.source, at.node.span, hint, severity)


def _groups(claims: Claims) -> list[list[Claim]]:
    """The claims that one condition of the text makes; lines that must hold first."""
    groups: dict[Place, list[Claim]] = {}
    for claim in claims.claims:
        groups.setdefault(claim.place, []).append(claim)
    return sorted(groups.values(), key=lambda g: not g[0].origin.required)


def _twice(groups: list[list[Claim]], reported: set[Place]) -> Iterator[Fault]:
    before: dict[Hashable, Claim] = {}
    for group in groups:
        first = group[0]
        # A line that does not always apply does not make another one superfluous.
        known = [before.get(c.key) for c in group]
        same = [
            k for k in known
            if k is not None and (first.origin.if_known or not k.origin.if_known)
        ]  # fmt: skip
        if len(same) < len(group) or _says_who(first):
            for claim in group:
                if claim.origin.required:
                    before.setdefault(claim.key, claim)
        elif first.origin.own and first.place not in reported:
            reported.add(first.place)
            message = f"this is said already: {quoted(same, first)}"
            yield _warning("said-twice", message, first, "leave one of them out")


def _says_who(claim: Claim) -> bool:
    """Whether it says who belongs to a set: that is not superfluous because all members do it."""
    return bool(claim.origin.symbol and claim.of_set)


def _implied(groups: list[list[Claim]], known: Knowledge, reported: set[Place]) -> Iterator[Fault]:
    # What is said twice does not follow from itself.
    removed: list[object] = [c for g in groups if g[0].place in reported for c in g]
    for group in reversed(groups):
        first = group[0]
        if first.place in reported or not first.origin.own or first.origin.symbol:
            continue
        if not all(c.bounds for c in group):
            continue
        reasons: list[Edge] = []
        for claim in group:
            found = known.follows(claim, [*group, *removed], if_known=first.origin.if_known)
            if found is None:
                break
            reasons += found
        else:
            reported.add(first.place)
            removed += group
            said = quoted(claims_on(reasons), first) or of_every_solid(given_on(reasons))
            message = f"this follows from {said}"
            yield _warning("implied-line", message, first, "leave it out, or ask for more")


def _warning(code: str, message: str, claim: Claim, hint: str) -> Fault:
    node: s.Node = claim.node
    return Fault(code, message, claim.origin.source, node.span, hint, Severity.WARNING)
