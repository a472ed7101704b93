"""Values of one variable, or of one argument of a fact, in an array: names, floats or integers."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import chain
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from facetlog.kb.engine.columns import EXACT, Column, column_array, object_array
from facetlog.kb.engine.terms import Atom, Term

__all__ = ["Index", "Kind", "Mask", "Names", "NotOnArraysError", "Values"]

Mask: TypeAlias = NDArray[np.bool_]
Index: TypeAlias = "NDArray[np.intp] | slice"


class NotOnArraysError(Exception):
    """What only Prolog can answer: other kinds of values, or arithmetic that it refuses."""


class Kind(Enum):
    """What the values are: an array has one kind of them."""

    NAME = "places in the scene's names"
    FLOAT = "finite floats"
    INTEGER = "integers of 64 bits"
    TERM = "anything"


class _Places(dict[str, int]):
    """The place of each name, given when it is first asked for."""

    def __init__(self, atoms: list[Atom]) -> None:
        self._atoms = atoms

    def __missing__(self, name: str) -> int:
        place = self[name] = len(self._atoms)
        self._atoms.append(Atom(name))
        return place


class Names:
    """The names that occur in a scene, each with its place; names are only ever added."""

    def __init__(self) -> None:
        self.atoms: list[Atom] = []
        self._places = _Places(self.atoms)
        self._ranks: NDArray[np.int32] = np.empty(0, np.int32)

    def place(self, name: str) -> int:
        """The place of a name, which has one from now on."""
        return self._places[name]

    def places(self, names: Sequence[str]) -> NDArray[np.int32]:
        """The place of each."""
        return np.fromiter(map(self._places.__getitem__, names), np.int32, len(names))

    @property
    def ranks(self) -> NDArray[np.int32]:
        """Where each place stands in Prolog's standard order, that of the characters' codes."""
        if len(self._ranks) != len(self.atoms):
            order = sorted(range(len(self.atoms)), key=lambda place: self.atoms[place].name)
            ranks = np.empty(len(order), np.int32)
            ranks[order] = np.arange(len(order), dtype=np.int32)
            self._ranks = ranks
        return self._ranks


@dataclass(frozen=True, slots=True)
class Values:
    """Values of one kind; places are those of `names`."""

    kind: Kind
    data: NDArray[Any]
    names: Names

    @classmethod
    def of_columns(cls, parts: Sequence[Column], names: Names) -> "Values":
        """The values of columns that follow each other."""
        if all(part.is_floats for part in parts):
            return cls(Kind.FLOAT, column_array(parts), names)
        texts = [part.atom_names() for part in parts]
        if all(text is not None for text in texts):
            return cls.of_names(list(chain(*filter(None, texts))), names)
        return cls.of_terms(list(chain.from_iterable(part.terms() for part in parts)), names)

    @classmethod
    def of_names(cls, texts: Sequence[str], names: Names) -> "Values":
        """The values of atoms by their names."""
        return cls(Kind.NAME, names.places(texts), names)

    @classmethod
    def of_parts(cls, parts: "Sequence[Values]", names: Names) -> "Values":
        """Values that follow each other."""
        kinds = {part.kind for part in parts}
        if len(kinds) == 1:
            return cls(kinds.pop(), np.concatenate([part.data for part in parts]), names)
        return cls.of_terms([term for part in parts for term in part.column().terms()], names)

    @classmethod
    def of_terms(cls, terms: Sequence[Term], names: Names) -> "Values":
        """The same of terms; no terms are no floats."""
        kinds = set(map(type, terms))
        if kinds == {Atom}:
            return cls(Kind.NAME, names.places([str(term) for term in terms]), names)
        if kinds <= {float} and all(map(np.isfinite, terms)):  # type: ignore[arg-type]
            return cls(Kind.FLOAT, np.array(terms, np.float64), names)
        if kinds == {int} and all(-(1 << 63) <= term < 1 << 63 for term in terms):  # type: ignore[operator]
            return cls(Kind.INTEGER, np.array(terms, np.int64), names)
        return cls(Kind.TERM, object_array(terms), names)

    @classmethod
    def of_rows(cls, count: int, names: Names) -> "Values":
        """The numbers of so many rows."""
        return cls(Kind.INTEGER, np.arange(count), names)

    def __len__(self) -> int:
        return len(self.data)

    def take(self, rows: Index) -> "Values":
        """Those of the rows."""
        return Values(self.kind, self.data[rows], self.names)

    def column(self) -> Column:
        """As a column of answers."""
        match self.kind:
            case Kind.NAME:
                return Column.of_names(self.data, self.names.atoms)
            case Kind.TERM:
                return Column.of_terms(self.data.tolist())
            case _:
                return Column.of_numbers(self.data)

    @property
    def keys(self) -> NDArray[Any]:
        """Integers that are equal where terms are: 0.0 is not -0.0."""
        match self.kind:
            case Kind.TERM:
                raise NotOnArraysError
            case Kind.FLOAT:
                return self.data.view(np.int64)
            case _:
                return self.data

    def equal(self, value: Term) -> Mask:
        """Where the value is this one."""
        other = Values.of_terms((value,), self.names)
        if other.kind is not self.kind and self.kind is not Kind.TERM:
            return np.zeros(len(self), np.bool_)
        return np.asarray(self.keys == other.keys[0])

    def same(self, other: "Values") -> Mask:
        """Where both have the same value."""
        ours, theirs = self.keys, other.keys
        if self.kind is not other.kind:
            return np.zeros(len(self), np.bool_)
        return np.asarray(ours == theirs)

    def exact_floats(self) -> NDArray[np.float64]:
        """The numbers as floats, which are no other numbers than these."""
        if self.kind is Kind.FLOAT:
            return self.data
        if self.kind is Kind.INTEGER and not (np.abs(self.data) > EXACT).any():
            return self.data.astype(np.float64)
        raise NotOnArraysError
