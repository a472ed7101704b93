"""How large and how deep a condition is when each definition stands where it is named.

Whatever walks a condition goes as deep as it is, and a compiled model is as large: both are bounded
before anything else is looked at.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from facetlog.grammar import syntax as s
from facetlog.grammar.resolve import Owned
from facetlog.grammar.source import Span

__all__ = ["DEEPEST", "LARGEST", "Extents"]

LARGEST = 3000
"""Words of one condition, with those of the definitions that it names."""

WRITTEN = 60
"""Expressions within expressions of one statement as it is written (`parse.DEEPEST`)."""

DEEPEST = 80
"""Expressions within expressions, those of definitions counted where they are named."""

MOST_NESTED = 30
"""Definitions within definitions."""


@dataclass(slots=True)
class Extents:
    """Sizes and depths by a model's definitions."""

    defines: Mapping[str, Owned[s.Define]]
    known: dict[str, tuple[int, int]] = field(default_factory=dict)

    def too_much(self, node: s.Expression, statement: Span) -> str:
        """What is too much about an expression, or nothing; `statement` is that it stands in."""
        if self._surely_little(statement.end - statement.start):
            return ""
        size, depth = self.of(node, ())
        if size > LARGEST:
            return f"it comes to more than {LARGEST} words, those of its definitions included"
        if depth > DEEPEST:
            return f"it is more than {DEEPEST} expressions deep, those of its definitions included"
        return ""

    def _surely_little(self, letters: int) -> bool:
        """Whether a statement of so many letters cannot be too much, whatever it names.

        A letter is three nodes at most (a part alone is a name, a reference and a property's
        subject), a call takes three letters, and no statement is deeper than it may be written.
        """
        for name in self.defines:
            self._of_definition(name, ())
        size = max((size for size, _ in self.known.values()), default=0)
        depth = max((depth for _, depth in self.known.values()), default=0)
        return 3 * letters + letters // 3 * size <= LARGEST and WRITTEN + depth <= DEEPEST

    def of(self, node: s.Expression, within: tuple[str, ...]) -> tuple[int, int]:
        """Size and depth of an expression."""
        size, deepest = 0, 0
        waiting: list[tuple[s.Node, int]] = [(node, 1)]
        while waiting:
            one, depth = waiting.pop()
            size += 1
            if isinstance(one, s.Call | s.Property | s.Relation):
                more, deeper = self._of_definition(one.name.text, within)
                size += more
                deepest = max(deepest, depth + deeper)
            deepest = max(deepest, depth)
            waiting.extend((child, depth + 1) for child in s.children(one))
        return size, deepest

    def _of_definition(self, name: str, within: tuple[str, ...]) -> tuple[int, int]:
        if name not in self.defines or name in within:
            return 0, 0
        if name not in self.known:
            if len(within) >= MOST_NESTED:
                return 0, DEEPEST + 1
            size, depth = self.of(self.defines[name].node.body, (*within, name))
            self.known[name] = min(size, LARGEST + 1), min(depth, DEEPEST + 1)
        return self.known[name]
