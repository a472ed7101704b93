"""Facts about the pieces of things and their openings: what they are like, and how they meet."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from facetlog.perception.facts.filled_space import FilledSpace
from facetlog.perception.facts.levels import level_at
from facetlog.perception.facts.named_rows import BlockFacts
from facetlog.perception.facts.opening_facts import framing, hanging, opening_rows, openings_of
from facetlog.perception.facts.piece_kinds import OPENING_KINDS, PIECE_KINDS
from facetlog.perception.facts.scene_memo import Names, SceneMemo
from facetlog.perception.pieces.pieces import Kind, Piece, Pieces, find_pieces
from facetlog.perception.pieces.shown_pieces import ShownPiece, ShownPieces
from facetlog.perception.scene import Evidence, Scene
from facetlog.perception.space.grid import ROUNDING
from facetlog.perception.space.openings import Opening
from facetlog.perception.surfaces.floors import LEVEL_ENOUGH
from facetlog.perception.types import FloatArray

__all__ = ["piece_facts", "shown_pieces"]


def piece_facts(s: SceneMemo, rows: BlockFacts) -> None:
    """All facts about pieces."""
    if not any(rows.wants(kind.functor) for kind in PIECE_KINDS):
        return
    with_openings = any(rows.wants(kind.functor) for kind in OPENING_KINDS)
    holes = [0] * len(s.scenes)
    for scene, found in _all_found(s):
        for functor, each in found.facts(s.face_names):
            rows.add_rows(functor, scene, [each])
        if not with_openings:
            continue
        openings = openings_of(found.filled, found.up)
        named = [(f"o{holes[scene] + i}", each) for i, each in enumerate(openings, start=1)]
        holes[scene] += len(named)
        for functor, each in found.openings(named, s.face_names):
            rows.add_rows(functor, scene, [each])


def shown_pieces(scene: Scene) -> ShownPieces:
    """The pieces of a scene by the names that facts have, to be drawn."""
    memo = SceneMemo.of(scene)
    measured = [face.evidence is Evidence.MEASURED for face in scene.faces]
    found = [each for _, each in _all_found(memo)]
    return ShownPieces(
        tuple(
            ShownPiece(name, piece, bool(piece.faces) and not any(measured[i] for i in piece.faces))
            for each in found
            for name, piece in zip(each.names, each.pieces.pieces, strict=True)
        ),
        tuple(each.filled.space for each in found),
    )


@dataclass(frozen=True, eq=False, slots=True)
class _Found:
    # The pieces of one thing, and what they are called.
    filled: FilledSpace
    up: FloatArray | None
    thing: str
    names: tuple[str, ...]
    pieces: Pieces

    def facts(self, face_names: Names) -> Iterator[tuple[str, tuple[str | float, ...]]]:
        """Functors and arguments; `face_names` (f,) are those of all faces."""
        lattice = self.filled.space.lattice
        ground = float(lattice.corner[2])
        for name, piece in zip(self.names, self.pieces.pieces, strict=True):
            yield "piece", (name,)
            yield "piece_of", (name, self.thing)
            sizes = (piece.length.value, piece.width.value, piece.thickness.value)
            yield "piece_size", (name, *sizes, piece.length.sd)
            yield "piece_round", (name, piece.round)
            for face in piece.faces:
                yield "piece_face", (name, face_names[face])
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

    def openings(
        self, named: Sequence[tuple[str, Opening]], face_names: Names
    ) -> Iterator[tuple[str, tuple[str | float, ...]]]:
        """Functors and arguments of the facts about the thing's openings, each with its name."""
        pieces = list(zip(self.names, self.pieces.pieces, strict=True))
        for name, opening in named:
            yield "opening_of", (name, self.thing)
            yield from opening_rows(name, opening, self.filled, self.up, face_names)
            for piece in framing(opening, pieces):
                yield "frames", (piece, name)

    def _level(
        self, name: str, piece: Piece, up: FloatArray
    ) -> Iterator[tuple[str, tuple[str | float, ...]]]:
        if piece.kind is Kind.BAR:
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


def _all_found(s: SceneMemo) -> Iterator[tuple[int, _Found]]:
    """The scene and the pieces of each thing; of a scene they are numbered through."""
    counts = [0] * len(s.scenes)
    for index, filled in s.filled.items():
        scene = s.things[index].scene
        surface = filled.surface
        pieces = find_pieces(filled.space.least(), surface.faces, surface.curved, surface.lines)
        first, last = counts[scene] + 1, counts[scene] + len(pieces.pieces)
        names = tuple(f"p{i}" for i in range(first, last + 1))
        counts[scene] = last
        yield scene, _Found(filled, s.scenes[scene].up, s.thing_names[index], names, pieces)


def _lying(piece: Piece, up: FloatArray) -> int:
    """The axis that is square to its broad side: of those along which it is as thin within a cell,
    as all are of a cube, the most upright one."""
    cell = piece.thickness.sd / ROUNDING
    extents = (piece.length.value, piece.width.value, piece.thickness.value)
    thin = [i for i, extent in enumerate(extents) if extent <= piece.thickness.value + cell]
    return max(thin, key=lambda i: abs(float(piece.axes[i] @ up)))


def _tilt(piece: Piece, up: FloatArray) -> tuple[float, float]:
    """Degrees, and the sd: ends across it that are each known to a cell."""
    if piece.kind is Kind.BAR:  # of another the broad side tilts
        rise = min(1.0, abs(float(piece.axes[0] @ up)))
        across, angle = piece.length, np.arcsin(rise)
    else:
        rise = min(1.0, abs(float(piece.axes[_lying(piece, up)] @ up)))
        across, angle = piece.width, np.arccos(rise)
    sd = np.arctan2(np.sqrt(2.0) * across.sd, across.value) if across.value > 0 else np.pi / 2
    return float(np.rad2deg(angle)), float(np.rad2deg(sd))
