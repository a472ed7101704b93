"""What a model should have or avoid."""

from collections.abc import Iterator

from facetlog.grammar import syntax as s
from facetlog.grammar.faults import Fault, Severity
from facetlog.grammar.lint.claims import Claims, Place, in_short
from facetlog.grammar.scope import Scope
from facetlog.grammar.source import Source

__all__ = ["absolute_sizes", "habits", "in_vain"]


def habits(scope: Scope) -> Iterator[Fault]:
    """A model without text or examples, and labels that are called as parts are."""
    model = scope.model
    name, source = model.written.name, model.source
    if model.written.doc is None:
        message = f"`{name}` does not say what it is"
        yield _warning("no-doc", message, source, name, "write a text after the line with `model`")
    if not model.written.examples:
        message = f"`{name}` has no example"
        yield _warning("no-example", message, source, name, "add one that holds and one that fails")
    for statement in model.written.statements:
        match statement:
            case s.Line(label) if label is not None and label.text in scope.symbols:
                message = f"the line `{label}` is called as a part is"
                hint = "`because` could mean either: choose another label"
                yield _warning("label-is-part", message, source, label, hint)


def in_vain(claims: Claims) -> Iterator[Fault]:
    """Names that `each` and `there` bring and that nothing is said of."""
    for name, source in claims.in_vain:
        message = f"what must be so does not depend on `{name}`"
        yield _warning("in-vain", message, source, name, f"say it of `{name}`")


def absolute_sizes(claims: Claims, reported: set[Place]) -> Iterator[Fault]:
    """Comparisons with metres that leave scenes without scale undecided, one a statement.

    `reported` are the places that have a warning already.
    """
    seen: set[int] = set()
    for region in claims.regions:
        origin = region.origin
        statement = origin.statement.node
        if not origin.own or not region.absolute or id(statement) in seen:
            continue
        if origin.if_known or not origin.required or region.place in reported:
            continue
        seen.add(id(statement))
        shown = in_short(origin.source, region.shown)
        message = f"where the scale is not known, `{shown}` leaves the model undecided"
        hint = "write `if known:` before the line, or compare with another measure"
        if origin.symbol:
            hint = "compare with another measure, or say it in a line with `if known:`"
        yield _warning("absolute-size", message, origin.source, region.shown, hint)


def _warning(code: str, message: str, source: Source, node: s.Node, hint: str) -> Fault:
    return Fault(code, message, source, node.span, hint, Severity.WARNING)
