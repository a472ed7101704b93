"""Facts about the pieces of things and their openings: what they are like, and how they meet."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from facetlog.perception.facts.filled_space import LEVEL_ENOUGH, FilledSpace
from facetlog.perception.facts.levels import level_at
from facetlog.perception.facts.named_rows import BlockFacts
from facetlog.perception.facts.opening_facts import hanging, opening_rows, openings_of
from facetlog.perception.facts.piece_kinds import PIECE_KINDS
from facetlog.perception.facts.scene_memo import SceneMemo
from facetlog.perception.pieces.pieces import Piece, Pieces, find_pieces
from facetlog.perception.types import FloatArray

__all__ = ["piece_facts"]

# What is thinner than this share of its width has a broad side, of which its tilt is.
THIN = 0.35


def piece_facts(s: SceneMemo, rows: BlockFacts) -> None:
    """All facts about pieces."""
    if not any(rows.wants(kind.functor) for kind in PIECE_KINDS):
        return
    for nth, own in s.alone(np.ones(len(s.scenes), dtype=np.bool_)):
        up = own.scenes[0].up
        count = holes = 0
        for index, filled in own.filled.items():
            found = _Found.of(filled, up, f"t{index + 1}", count)
            count += len(found.names)
            for functor, each in found.facts():
                rows.add_rows(functor, nth, [each])
            openings = openings_of(filled, up)
            named = [(f"o{holes + i}", each) for i, each in enumerate(openings, start=1)]
            holes += len(named)
            pieces = list(zip(found.names, found.pieces.pieces, strict=True))
            for functor, each in opening_rows(named, found.thing, filled, up, pieces):
                rows.add_rows(functor, nth, [each])


@dataclass(frozen=True, eq=False, slots=True)
class _Found:
    # The pieces of one thing, and what they are called.
    filled: FilledSpace
    up: FloatArray | None
    thing: str
    names: tuple[str, ...]
    pieces: Pieces

    @classmethod
    def of(cls, filled: FilledSpace, up: FloatArray | None, thing: str, before: int) -> "_Found":
        surface = filled.surface
        pieces = find_pieces(filled.space.least(), surface.faces, surface.curved)
        names = tuple(f"p{before + i}" for i in range(1, len(pieces.pieces) + 1))
        return cls(filled, up, thing, names, pieces)

    def facts(self) -> Iterator[tuple[str, tuple[str | float, ...]]]:
        """Functors and arguments."""
        lattice = self.filled.space.lattice
        ground = float(lattice.corner[2])
        for name, piece in zip(self.names, self.pieces.pieces, strict=True):
            yield "piece", (name,)
            yield "piece_of", (name, self.thing)
            sizes = (piece.length.value, piece.width.value, piece.thickness.value)
            yield "piece_size", (name, *sizes, piece.length.sd)
            yield "piece_round", (name, piece.round)
            for face in piece.faces:
                yield "piece_face", (name, f"f{face + 1}")
            if self.up is not None:
                low, high = max(0.0, piece.low - ground), piece.high - ground
                yield "piece_heights", (name, low, high, piece.length.sd)
                yield "piece_tilt", (name, *_tilt(piece, self.up))
                if low < lattice.cell:
                    yield "piece_on_ground", (name,)
                yield from self._level(name, piece, self.up)
        pairs = [("joins", self.pieces.joins)]
        if self.up is not None:
            pairs.append(("carries", self.pieces.carries))
            pairs.append(("hangs_from", hanging(self.pieces, lattice.cell)))
        for functor, related in pairs:
            for i, j in np.argwhere(related).tolist():
                yield functor, (self.names[i], self.names[j])

    def _level(
        self, name: str, piece: Piece, up: FloatArray
    ) -> Iterator[tuple[str, tuple[str | float, ...]]]:
        if not _is_thin(piece) or abs(float(piece.axes[2] @ up)) < LEVEL_ENOUGH:
            return
        # of a board that leans the middle of its upper side
        level = level_at(self.filled.space, (piece.high + float(piece.middle @ up)) / 2.0)
        if level is not None:
            for measure, each in level.measures():
                yield "piece_level", (name, measure, each.value, each.sd)
                if each.open:
                    yield "piece_unseen", (name, measure, each.if_free, each.if_full)


def _is_thin(piece: Piece) -> bool:
    return piece.thickness.value <= THIN * piece.width.value


def _tilt(piece: Piece, up: FloatArray) -> tuple[float, float]:
    """Degrees, and the sd: ends across it that are each known to a cell."""
    if _is_thin(piece):
        rise = min(1.0, abs(float(piece.axes[2] @ up)))
        across, angle = piece.width, np.arccos(rise)
    else:
        rise = min(1.0, abs(float(piece.axes[0] @ up)))
        across, angle = piece.length, np.arcsin(rise)
    sd = np.arctan2(np.sqrt(2.0) * across.sd, across.value) if across.value > 0 else np.pi / 2
    return float(np.rad2deg(angle)), float(np.rad2deg(sd))
