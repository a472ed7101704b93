"""Chunks of answers, as columns.pl writes them: rows of exact terms, or numpy arrays."""

import json
import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import chain
from typing import TYPE_CHECKING, TypeAlias

from facetlog.errors import EngineError
from facetlog.kb.engine.terms import Atom, Term, decode_terms

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ["Array", "Chunk", "Column", "build_column_array", "decode_chunk"]

Array: TypeAlias = "NDArray[np.float64] | NDArray[np.int64] | NDArray[np.object_]"
"""Array of floats, of integers, or of terms."""

SEPARATOR = "\x1f"  # separator/1 of columns.pl

FLOAT_BYTES = 9  # a byte that says float, and the float

EXACT = 1 << 53
"""Integers up to this are floats as well, IEEE 754's double having 53 bits."""


class _Layout(StrEnum):
    """How columns.pl wrote a column."""

    FLOATS = "f"
    NUMBERS = "n"
    ATOMS = "a"
    STRINGS = "s"
    TERMS = "j"


class _Atoms(dict[str, Atom]):
    """The atom of each name, made when it is first asked for."""

    def __missing__(self, name: str) -> Atom:
        atom = self[name] = Atom(name)
        return atom


@dataclass(frozen=True, slots=True)
class Column:
    """The values of one variable in a chunk, decoded when they are asked for."""

    layout: _Layout
    length: int
    data: bytes | str | tuple[Term, ...]

    @classmethod
    def of_terms(cls, terms: Iterable[Term]) -> "Column":
        """Return a column of terms that are decoded already."""
        values = tuple(terms)
        return cls(_Layout.TERMS, len(values), values)

    def terms(self) -> Sequence[Term]:
        """Return the values, exact: `Atom`, `str`, `int`, `float`, `Fraction`, `Struct`, `Var`,
        tuple."""
        if isinstance(self.data, tuple):
            return self.data
        if not self.length:
            return ()
        match self.layout:
            case _Layout.FLOATS:
                return [x for (x,) in struct.iter_unpack("<xd", self._get_float_bytes())]
            case _Layout.NUMBERS:
                numbers: list[int | float] = json.loads(f"[{self._text()}]")
                return numbers
            case _Layout.ATOMS:
                return list(map(_Atoms().__getitem__, self._text().split(SEPARATOR)))
            case _Layout.STRINGS:
                return self._text().split(SEPARATOR)
            case _:
                return decode_terms(self._text())

    def _get_float_bytes(self) -> bytes:
        if not isinstance(self.data, bytes):
            raise EngineError("Prolog's answer cannot be read")
        return self.data[len(self.data) - FLOAT_BYTES * self.length :]

    def _text(self) -> str:
        if isinstance(self.data, bytes):
            return self.data.decode("latin-1")
        if isinstance(self.data, str):
            return self.data
        raise EngineError("Prolog's answer cannot be read")


@dataclass(frozen=True, slots=True)
class Chunk:
    """Some answers: a column for each variable, all of the same length."""

    columns: tuple[Column, ...]
    length: int

    @classmethod
    def of_rows(cls, rows: Sequence[tuple[Term, ...]], width: int) -> "Chunk":
        """Return a chunk of rows that are decoded already."""
        values = zip(*rows, strict=True) if rows else ((),) * width
        return cls(tuple(map(Column.of_terms, values)), len(rows))

    def rows(self) -> Iterable[tuple[Term, ...]]:
        """Return the answers, one tuple each."""
        if not self.columns:
            return ((),) * self.length
        return zip(*(column.terms() for column in self.columns), strict=True)


def decode_chunk(pieces: Sequence[bytes | str]) -> Chunk:
    """Return the chunk of which columns.pl wrote the pieces."""
    header, *data = pieces
    text = header.decode("ascii") if isinstance(header, bytes) else header
    count, _, letters = text.partition(" ")
    length = int(count)
    if len(letters) != len(data):
        raise EngineError("Prolog's answer cannot be read")
    columns = tuple(
        Column(_Layout(letter), length, piece) for letter, piece in zip(letters, data, strict=True)
    )
    return Chunk(columns, length)


def build_column_array(parts: Sequence[Column]) -> Array:
    """Return one array of the columns that follow each other.

    float64 if all values are floats, or integers that a float holds exactly; int64 if all are
    integers of 64 bits; else objects, the terms. Of no values it is an empty array of float64.
    """
    import numpy as np

    parts = [part for part in parts if part.length]
    if all(part.layout is _Layout.FLOATS for part in parts):
        return np.concatenate([np.empty(0), *(_read_float_column(part) for part in parts)])
    values = list(chain.from_iterable(part.terms() for part in parts))
    if all(part.layout in (_Layout.FLOATS, _Layout.NUMBERS) for part in parts):
        numbers = [x for x in values if isinstance(x, int | float)]
        kinds = set(map(type, numbers))
        if kinds == {int}:
            return np.array(numbers, dtype=np.int64)
        if kinds == {float} or all(type(x) is float or abs(x) <= EXACT for x in numbers):
            return np.array(numbers, dtype=np.float64)
    objects = np.empty(len(values), dtype=np.object_)
    objects[:] = values
    return objects


def _read_float_column(column: Column) -> "NDArray[np.float64]":
    import numpy as np

    pairs = np.frombuffer(column._get_float_bytes(), dtype=[("byte", "u1"), ("value", "<f8")])
    return np.array(pairs["value"])
