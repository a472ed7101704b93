"""What is named and never used: constants, definitions, parameters, parts, sets, local names."""

from collections.abc import Iterable, Iterator

from facetlog.grammar import syntax as s
from facetlog.grammar.fading import FADING
from facetlog.grammar.faults import Fault, Severity
from facetlog.grammar.fixing.fix import Fix, removal
from facetlog.grammar.lint.claims import Claims
from facetlog.grammar.resolve import FlatModel
from facetlog.grammar.source import Source


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
            fixes = removal(title, main.source.text, statement.span, sure=False)
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
    for inner in s.walk(node):
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
