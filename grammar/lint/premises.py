"""What may be taken for granted where a model holds."""

from collections.abc import Iterator

from facetlog.grammar.lint.claims import Claim, Claims
from facetlog.grammar.scope import PartSymbol, SetSymbol

__all__ = ["premises"]


def premises(claims: Claims) -> Iterator[tuple[Claim, bool]]:
    """The claims that hold where the model does, and whether that is sure.

    Lines that name an optional part do not apply where it is absent. Of a set's members something
    follows only if there must be one, and then not surely: a member counts from a degree of 1/2, at
    which nothing need be so of it.
    """
    symbols = claims.scope.symbols
    optional = {
        name
        for name, x in symbols.items()
        if isinstance(x, PartSymbol | SetSymbol) and x.owned.node.optional
    }
    counts = {n: x.owned.node.count for n, x in symbols.items() if isinstance(x, SetSymbol)}
    some = {name for name, count in counts.items() if count is not None and count.least > 0}
    for claim in claims.claims:
        if not claim.origin.required or claim.parts & optional:
            continue
        if not claim.of_set:
            yield claim, True
        elif claim.of_set in some:
            yield claim, False
