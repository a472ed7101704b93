"""The parts of things: faces and loose edges by the vertices that they have, and their cores.

Faces that meet in a convex or flat edge are of one core, as are loose edges that share an end.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from facetlog.perception.batch_linalg import dots
from facetlog.perception.ragged import Bools, Indices, pairs_in_rows, row_starts
from facetlog.perception.surfaces.components import components
from facetlog.perception.surfaces.contacts import SideContacts
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.types import FloatArray

__all__ = ["Cores", "Parts"]

NONE = np.zeros(0, dtype=np.intp)


@dataclass(frozen=True, eq=False)
class Parts:
    """All faces and then all loose edges, numbered as parts; who holds which vertex.

    Part `part` (h,) has the vertex `vertex` (h,); those of a part stand together, `counts` (p,) of
    them. `loose` (l, 2) are the loose edges' ends. `rise` (f,) is how far the faces' normals point
    up, 0 where up is not known.
    """

    table: FaceTable
    rise: FloatArray
    loose: Indices
    part: Indices
    vertex: Indices
    counts: Indices

    @classmethod
    def of(cls, table: FaceTable, rise: FloatArray, loose: Indices) -> "Parts":
        counts = np.concatenate((table.members.counts, np.full(len(loose), 2)))
        vertex = np.concatenate((table.members.vertex, loose.ravel()))
        return cls(table, rise, loose, np.repeat(np.arange(len(counts)), counts), vertex, counts)

    @cached_property
    def used(self) -> Indices:
        """All vertices that some part has, ascending."""
        return np.unique(self.vertex)

    @cached_property
    def _ordered(self) -> tuple[Indices, Indices]:
        order = np.argsort(self.vertex, kind="stable")
        return order, self.vertex[order]

    def holders(self, vertices: Indices) -> tuple[Indices, Indices]:
        """(place among `vertices`, part) (m,) each, for all parts that have one of these (v,)."""
        order, ordered = self._ordered
        first = np.searchsorted(ordered, vertices, "left")
        counts = np.searchsorted(ordered, vertices, "right") - first
        steps = np.arange(int(counts.sum())) - np.repeat(row_starts(counts), counts)
        return np.repeat(np.arange(len(vertices)), counts), self.part[
            order[np.repeat(first, counts) + steps]
        ]

    def on_loose_edges(self) -> tuple[Indices, Indices]:
        """(vertex, part) (m,) each, wherever a vertex lies on a loose edge that ends elsewhere."""
        points, tolerance = self.table.points, self.table.tolerance
        if not len(self.loose):
            return NONE, NONE
        scenes = len(self.table.face_counts)
        loose_scene = tolerance.scene[self.loose[:, 0]]
        row, edge = pairs_in_rows(
            np.bincount(tolerance.scene[self.used], minlength=scenes),
            np.bincount(loose_scene, minlength=scenes),
        )
        vertex, both = self.used[row], self.loose[edge]
        start = points[both[:, 0]]
        span, beside = points[both[:, 1]] - start, points[vertex] - start
        square = np.maximum(dots(span, span), 1e-300)
        t = np.clip(dots(beside, span) / square, 0.0, 1.0)
        away = beside - t[:, None] * span
        sds = tolerance.vertex_sds
        slack = np.hypot(sds[vertex], sds[both].max(axis=1))
        limit = tolerance.within(slack, loose_scene[edge])
        on = (np.sqrt(dots(away, away)) <= limit) & (vertex[:, None] != both).all(axis=1)
        return vertex[on], len(self.table) + edge[on]


def _loose_pairs(parts: Parts) -> Iterator[tuple[int, int]]:
    """Pairs of loose edges that share an end, or of which one ends on the other."""
    count = len(parts.table)
    if not len(parts.loose):
        return
    row, part = parts.holders(parts.used)
    for held in np.split(part, np.cumsum(np.bincount(row))[:-1]):
        yield from pairwise(held[held >= count].tolist())
    vertex, edge = parts.on_loose_edges()
    row, part = parts.holders(vertex)
    keep = part >= count
    yield from zip(edge[row[keep]].tolist(), part[keep].tolist(), strict=True)


@dataclass(frozen=True, eq=False, slots=True)
class Cores:
    """The core (p,) of every part, and whether each core (c,) is a body (has a convex edge)."""

    of: Indices
    bodies: Bools

    @classmethod
    def among(cls, parts: Parts, contacts: SideContacts) -> "Cores":
        bent = contacts.take(contacts.against)
        flush = bent.faces[~bent.concave & ~bent.back_to_back].tolist()
        groups = np.array(
            components(len(parts.counts), [*_loose_pairs(parts), *flush]), dtype=np.intp
        )
        bodies = np.zeros(int(groups.max()) + 1, dtype=np.bool_)
        bodies[groups[bent.faces[bent.convex, 0]]] = True
        return cls(groups, bodies)
