"""What can be folded: models, statements of several lines, and comments one below another."""

from collections.abc import Iterable, Iterator

from lsprotocol import types as lsp

from facetlog.grammar.reading.layout import laid_out, pieces
from facetlog.grammar.source import Source, Span

__all__ = ["folds"]


def folds(source: Source) -> list[lsp.FoldingRange]:
    """The pieces of a text that can be folded, in the order of their first lines.

    Statements that cannot be read are among them: a model does not unfold while one is written.
    """
    layout = laid_out(source)
    spans = [statement.span for statement in layout.statements]
    found = list(_several_lines(spans, source, None))
    text = source.text
    for piece in pieces(text):
        inside = text[piece.start : piece.end]
        if inside.lstrip().startswith("model"):
            held = [span for span in spans if piece.start <= span.start < piece.end]
            whole = [Span(held[0].start, held[-1].end)] if held else []
            found += _several_lines(whole, source, None)
    alone = (comment.span for comment in layout.comments if comment.alone)
    blocks = _blocks(alone, source)
    found += _several_lines(blocks, source, lsp.FoldingRangeKind.Comment)
    return sorted(found, key=lambda fold: (fold.start_line, -fold.end_line))


def _several_lines(
    spans: Iterable[Span], source: Source, kind: lsp.FoldingRangeKind | None
) -> Iterator[lsp.FoldingRange]:
    for span in spans:
        first, last = (source.line_and_column(at)[0] - 1 for at in span)
        if last > first:
            yield lsp.FoldingRange(first, last, kind=kind)


def _blocks(comments: Iterable[Span], source: Source) -> Iterator[Span]:
    """Comments that stand on lines one below another, as one."""
    block: Span | None = None
    for span in comments:
        below = block is not None and (
            source.line_and_column(block.end)[0] + 1 == source.line_and_column(span.start)[0]
        )
        if block is not None and below:
            block = block.to(span)
            continue
        if block is not None:
            yield block
        block = span
    if block is not None:
        yield block
