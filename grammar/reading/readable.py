"""Which statements of a text could be read."""

from bisect import bisect_left

from facetlog.grammar import syntax as s
from facetlog.grammar.source import Span

__all__ = ["Readable"]


class Readable:
    """The places where the statements stand that became syntax."""

    def __init__(self, file: s.File) -> None:
        nodes: list[s.Node] = [*file.statements]
        for model in file.models:
            nodes += [model, *([] if model.doc is None else [model.doc]), *model.statements]
        # A model's own place begins behind its first word.
        self._starts = sorted(node.span.start for node in nodes)

    def has(self, span: Span) -> bool:
        """Whether the statement at a place could be read."""
        at = bisect_left(self._starts, span.start)
        return at < len(self._starts) and self._starts[at] < span.end
