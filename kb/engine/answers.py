"""Answers to a question, streamed in chunks: as tuples of terms, or straight into numpy arrays."""

from collections.abc import Callable, Iterator

from facetlog.kb.engine.closing import Closing
from facetlog.kb.engine.columns import Array, Chunk, Column, build_column_array
from facetlog.kb.engine.terms import Term

__all__ = ["Answers"]


class Answers(Closing):
    """The answers to a question: an iterator of tuples, one value for each of `names`.

    Prolog works out a chunk when it is needed. Reading may stop at any time, and several answers
    may be read by turns; a context manager, or `close`, ends the question at once, and so does
    dropping the object. The methods read on where the last one stopped.
    """

    def __init__(
        self, names: tuple[str, ...], chunks: Iterator[Chunk], close: Callable[[], None]
    ) -> None:
        self.names = names
        """The variables in the order of appearance; `Scene` first if several scenes are asked."""
        self._chunks, self._close = chunks, close
        # The first chunk is read at once: an error is one where the question is asked.
        self._first = next(chunks, None)
        self._rows: Iterator[tuple[Term, ...]] = iter(())

    def chunks(self) -> Iterator[Chunk]:
        """Return the unread answers chunk by chunk, each a column of values for each name."""
        rest = tuple(self._rows)
        if rest:
            yield Chunk.of_rows(rest, len(self.names))
        if self._first is not None:
            first, self._first = self._first, None
            yield first
        yield from self._chunks

    def __iter__(self) -> Iterator[tuple[Term, ...]]:
        yield from self._rows
        for chunk in self.chunks():
            self._rows = iter(chunk.rows())
            yield from self._rows

    def __next__(self) -> tuple[Term, ...]:
        while True:
            row = next(self._rows, None)
            if row is not None:
                return row
            chunk = next(self.chunks(), None)
            if chunk is None:
                raise StopIteration
            self._rows = iter(chunk.rows())

    def arrays(self) -> dict[str, Array]:
        """Return all that is still unread, one array for each name: float64, int64, or object."""
        parts: list[list[Column]] = [[] for _ in self.names]
        for chunk in self.chunks():
            for column, part in zip(chunk.columns, parts, strict=True):
                part.append(column)
        return {
            name: build_column_array(part) for name, part in zip(self.names, parts, strict=True)
        }

    def close(self) -> None:
        """End the question; what was not read is lost."""
        self._close()
        self._first, self._rows, self._chunks = None, iter(()), iter(())
