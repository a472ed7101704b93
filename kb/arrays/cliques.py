"""Faces of which each two pass a test: a graph as bitsets, and all its cliques of a given size."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facetlog.kb.arrays.pace import Pace
from facetlog.kb.arrays.values import Kind, Mask, Names, Values

__all__ = ["PairGraph", "clique_count", "cliques"]

MOST_BITS = 1 << 22  # looked at in one go


@dataclass(frozen=True, slots=True)
class PairGraph:
    """Measured faces in the standard order, and for each the later ones that pass with it.

    `faces` (n,) are places of names; `later` (n, ⌈n/8⌉) are bytes of bits, the lowest first.
    """

    faces: NDArray[np.int32]
    later: NDArray[np.uint8]

    @classmethod
    def of_matrix(cls, faces: NDArray[np.int32], passing: Mask) -> "PairGraph":
        """The graph of pairs that pass, (n, n)."""
        return cls(faces, np.packbits(passing, axis=1, bitorder="little"))

    def values(self, numbers: NDArray[np.intp], names: Names) -> Values:
        """The names of the faces with these numbers."""
        return Values(Kind.NAME, self.faces[numbers], names)

    def number(self, name: str, names: Names) -> int | None:
        """The number of the face of that name, if there is one."""
        found = np.flatnonzero(self.faces == names.place(name))
        return int(found[0]) if len(found) else None


def cliques(
    graph: PairGraph, given: Sequence[int | None], pace: Pace
) -> Iterator[list[NDArray[np.intp]]]:
    """All lists of faces of which each two pass, in order; `given` has the number of some.

    Each part is one array of faces' numbers for each place in the list.
    """
    count = len(graph.faces)
    every = np.packbits(np.ones((1, count), np.bool_), axis=1, bitorder="little")
    yield from _chosen(graph, given, [], every, pace)


def clique_count(graph: PairGraph, size: int, pace: Pace) -> Iterator[int]:
    """How many lists of so many faces there are, part by part: the last faces are only counted."""
    if size == 1:
        yield len(graph.faces)
        return
    for chosen in cliques(graph, [None] * (size - 1), pace):
        rest = graph.later[chosen[0]]
        for others in chosen[1:]:
            rest = rest & graph.later[others]
        yield int(np.bitwise_count(rest).sum())


def _chosen(
    graph: PairGraph,
    given: Sequence[int | None],
    before: list[NDArray[np.intp]],
    candidates: NDArray[np.uint8],
    pace: Pace,
) -> Iterator[list[NDArray[np.intp]]]:
    count = len(graph.faces)
    low = 0
    while count and low < len(candidates):
        high = low + max(1, min(pace.step(), MOST_BITS // count))
        part = candidates[low:high]
        bits = np.unpackbits(part, axis=1, count=count, bitorder="little").ravel()
        rows, faces = np.divmod(np.flatnonzero(bits.view(np.bool_)), count)  # twice as fast so
        if given[0] is not None:
            wanted = faces == given[0]
            rows, faces = rows[wanted], faces[wanted]
        chosen = [*(numbers[low:high][rows] for numbers in before), faces]
        if len(given) == 1:
            yield chosen
        elif len(faces):
            yield from _chosen(graph, given[1:], chosen, part[rows] & graph.later[faces], pace)
        low = high
