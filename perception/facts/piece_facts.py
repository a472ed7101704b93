"""Facts about the pieces of things: what they are like, how they meet, what is at their levels."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from facetlog.perception.facts.filled_space import LEVEL_ENOUGH, FilledSpace
from facetlog.perception.facts.levels import level_at
from facetlog.perception.facts.named_rows import BlockFacts
from facetlog.perception.facts.piece_kinds import PIECE_KINDS
from facetlog.perception.facts.scene_memo import SceneMemo
from facetlog.perception.pieces.pieces import ROUNDING, Piece, Pieces, find_pieces
from facetlog.perception.types import FloatArray

__all__ = ["piece_facts"]

# What is thinner than this share of its width is a board; what else is narrower than this share of
# its length a bar, of which the tilt is that of its length, and of others that of their broad side.
THIN = 0.35
SLENDER = 0.35


def piece_facts(s: SceneMemo, rows: BlockFacts) -> None:
    """All facts about pieces."""
    if not any(rows.wants(kind.functor) for kind in PIECE_KINDS):
        return
    for nth, own in s.alone(np.ones(len(s.scenes), dtype=np.bool_)):
        up = own.scenes[0].up
        count = 0
        for index, filled in own.filled.items():
            found = _Found.of(filled, up, f"t{index + 1}", count)
            count += len(found.names)
            for functor, each in found.facts():
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
        for functor, related in pairs:
            for i, j in np.argwhere(related).tolist():
                yield functor, (self.names[i], self.names[j])

    def _level(
        self, name: str, piece: Piece, up: FloatArray
    ) -> Iterator[tuple[str, tuple[str | float, ...]]]:
        if _is_slender(piece):
            return
        side = _lying(piece, up)
        if abs(float(piece.axes[side] @ up)) < LEVEL_ENOUGH:
            return
        level = level_at(self.filled.space, self._upper_side(piece, up, side))
        if level is not None:
            for measure, each in level.measures():
                yield "piece_level", (name, measure, each.value, each.sd)
                if each.open:
                    yield "piece_unseen", (name, measure, each.if_free, each.if_full)

    def _upper_side(self, piece: Piece, up: FloatArray, side: int) -> float:
        """How high the side is that it turns upwards: its largest face there, or what is curved
        halfway between its middle and its highest point, for a hollow seat is below its rim."""
        faces = (face for face in self.filled.surface.faces if face.index in piece.faces)
        level = [face for face in faces if float(face.normal @ up) >= LEVEL_ENOUGH]
        if level:
            return float(max(level, key=lambda face: face.area).middle @ up)
        half = (piece.length, piece.width, piece.thickness)[side].value / 2.0
        rise = abs(float(piece.axes[side] @ up))
        return float(piece.middle @ up) + half * rise / 2.0


def _is_thin(piece: Piece) -> bool:
    return piece.thickness.value <= THIN * piece.width.value


def _is_slender(piece: Piece) -> bool:
    return not _is_thin(piece) and piece.width.value <= SLENDER * piece.length.value


def _lying(piece: Piece, up: FloatArray) -> int:
    """The axis that is square to its broad side: of those along which it is as thin within a cell,
    as all are of a cube, the most upright one."""
    cell = piece.thickness.sd / ROUNDING
    extents = (piece.length.value, piece.width.value, piece.thickness.value)
    thin = [i for i, extent in enumerate(extents) if extent <= piece.thickness.value + cell]
    return max(thin, key=lambda i: abs(float(piece.axes[i] @ up)))


def _tilt(piece: Piece, up: FloatArray) -> tuple[float, float]:
    """Degrees, and the sd: ends across it that are each known to a cell."""
    if _is_slender(piece):
        rise = min(1.0, abs(float(piece.axes[0] @ up)))
        across, angle = piece.length, np.arcsin(rise)
    else:
        rise = min(1.0, abs(float(piece.axes[_lying(piece, up)] @ up)))
        across, angle = piece.width, np.arccos(rise)
    sd = np.arctan2(np.sqrt(2.0) * across.sd, across.value) if across.value > 0 else np.pi / 2
    return float(np.rad2deg(angle)), float(np.rad2deg(sd))
