"""The limits of a model file, and over which width each fades, for their author to look at."""

from collections.abc import Iterator
from dataclasses import dataclass

from facetlog.grammar import syntax as s
from facetlog.grammar.analysis import Analysis
from facetlog.grammar.claims import shorten
from facetlog.grammar.fading import describe_fading
from facetlog.grammar.scope import Scope, build_file_scope
from facetlog.grammar.traversal import walk


@dataclass(frozen=True, slots=True)
class Limit:
    """A comparison of the file, and from where to where it fades."""

    node: s.Comparison
    place: str
    text: str
    fades: str

    def __str__(self) -> str:
        return f"{self.place}: {self.text}: {self.fades}"


def limits(analysis: Analysis) -> Iterator[Limit]:
    """Iterate over the comparisons of the file that was analysed, in the order of its text."""
    source = analysis.file.source
    for scope, statement in _iter_statements(analysis):
        for node in walk(statement):
            if isinstance(node, s.Comparison):
                line, column = source.get_line_and_column(node.span.start)
                place = f"{source.name}:{line}:{column}"
                yield Limit(node, place, shorten(source, node), describe_fading(node, scope))


def limit_at(analysis: Analysis, offset: int) -> Limit | None:
    """Return the innermost comparison at a place of the file; None where there is none."""
    found = [one for one in limits(analysis) if offset in one.node.span]
    return min(found, key=lambda one: one.node.span.end - one.node.span.start, default=None)


def _iter_statements(analysis: Analysis) -> Iterator[tuple[Scope, s.Statement]]:
    before = build_file_scope(analysis.file, analysis.words, {})
    for statement in analysis.file.statements:
        yield before, statement
    for model in analysis.file.models:
        scope = analysis.scopes.get(model.name.text)
        if scope is not None and scope.model.written is model:
            for statement in model.statements:
                yield scope, statement
