"""Facts about the pieces of things and their openings: what they are like, and how they meet."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from facetlog.perception.facts.levels.filled_space import FilledSpace
from facetlog.perception.facts.levels.levels import level_at
from facetlog.perception.facts.levels.shelves import shelves_below
from facetlog.perception.facts.named_rows import BlockFacts
from facetlog.perception.facts.pieces.directions import angles_between, lying, tilt
from facetlog.perception.facts.pieces.kinds import OPENING_KINDS, PIECE_KINDS
from facetlog.perception.facts.pieces.opening_facts import (
    hanging,
    opening_rows,
    openings_known,
    openings_of,
    rim_rows,
)
from facetlog.perception.facts.pieces.solid_boxes import (
    SolidBox,
    heights,
    known_of_two,
    known_overlaps,
)
from facetlog.perception.facts.scene_memo import Names, SceneMemo
from facetlog.perception.pieces.pieces import Kind, Piece, Pieces, find_pieces
from facetlog.perception.pieces.shown_pieces import ShownPiece, ShownPieces
from facetlog.perception.scene import Evidence, Scene
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
        if rows.wants("piece_angle"):
            rows.add_rows("piece_angle", scene, found.angles())
        if rows.wants("piece_overlap"):
            rows.add_rows("piece_overlap", scene, found.overlaps())
        if not with_openings:
            continue
        openings = openings_of(found.filled, found.up)
        named = [(f"o{holes[scene] + i}", each) for i, each in enumerate(openings, start=1)]
        holes[scene] += len(named)
        for functor, each in found.openings(named, s.face_names):
            rows.add_rows(functor, scene, [each])
        if rows.wants("inside") or rows.wants("beside"):
            for functor, all_ in found.of_two(named).items():
                rows.add_rows(functor, scene, all_)


def shown_pieces(scene: Scene) -> ShownPieces:
    """The pieces of a scene by the names that facts have, to be drawn."""
    memo = SceneMemo.of(scene)
    found = [each for _, each in _all_found(memo)]
    return ShownPieces(
        tuple(
            ShownPiece(name, piece, not _is_measured(piece, each.measured))
            for each in found
            for name, piece in zip(each.names, each.pieces.pieces, strict=True)
        ),
        tuple(each.filled.space for each in found),
        tuple(each.thing for each in found),
    )


@dataclass(frozen=True, eq=False, slots=False)
class _Found:
    # The pieces of one thing, and what they are called.
    filled: FilledSpace
    up: FloatArray | None
    thing: str
    names: tuple[str, ...]
    pieces: Pieces
    measured: frozenset[int]  # of all faces those that were

    def facts(self, face_names: Names) -> Iterator[tuple[str, tuple[str | float, ...]]]:
        """Functors and arguments; `face_names` (f,) are those of all faces."""
        lattice = self.filled.space.lattice
        for name, piece, box in zip(self.names, self.pieces.pieces, self._boxes, strict=True):
            yield "piece", (name,)
            yield "piece_of", (name, self.thing)
            sizes = (piece.length.value, piece.width.value, piece.thickness.value)
            yield "piece_size", (name, *sizes, piece.length.sd)
            yield "piece_round", (name, piece.round)
            if _is_measured(piece, self.measured):
                yield "piece_measured", (name,)
            for face in piece.faces:
                yield "piece_face", (name, face_names[face])
            if self.up is not None:
                low, high = self._heights(piece)
                yield "piece_heights", (name, low, high, piece.length.sd)
                yield "piece_tilt", (name, *tilt(piece, self.up))
                if low < lattice.cell:
                    yield "piece_on_ground", (name,)
                yield from self._level(name, piece, self.up)
            for measure, if_free, if_full in self._hidden_extents(piece, box):
                yield "piece_unseen", (name, measure, if_free, if_full)
        pairs = [("joins", self.pieces.joins)]
        if self.up is not None:
            pairs.append(("carries", self.pieces.carries))
            pairs.append(("hangs_from", hanging(self.pieces, lattice.cell)))
        for functor, related in pairs:
            for i, j in np.argwhere(related).tolist():
                yield functor, (self.names[i], self.names[j])

    def angles(self) -> Iterator[tuple[str, str, float, float]]:
        """The arguments of the facts about how each two pieces are turned to one another."""
        for one, other, angle in angles_between(self.pieces.pieces, self.up):
            yield self.names[one], self.names[other], *angle

    def overlaps(self) -> Iterator[tuple[str, str, float, float]]:
        """The arguments of the facts about which share of each two pieces' plans is the other's."""
        for one, other, share, sd in known_overlaps(self._boxes, self.up):
            yield self.names[one], self.names[other], share, sd

    @cached_property
    def _boxes(self) -> list[SolidBox]:
        return [SolidBox.of_piece(piece, self.filled.space) for piece in self.pieces.pieces]

    def openings(
        self, named: Sequence[tuple[str, Opening]], face_names: Names
    ) -> Iterator[tuple[str, tuple[str | float, ...]]]:
        """Functors and arguments of the facts about the thing's openings, each with its name."""
        pieces = list(zip(self.names, self.pieces.pieces, strict=True))
        for name, opening in named:
            yield "opening_of", (name, self.thing)
            yield from opening_rows(name, opening, self.filled, self.up, face_names)
            yield from rim_rows(name, opening, pieces)
        if openings_known(self.filled, self.up, [opening for _, opening in named]):
            yield "openings_known", (self.thing,)

    def of_two(self, named: Sequence[tuple[str, Opening]]) -> dict[str, list[tuple[str, str, str]]]:
        """By functor the arguments of the facts about what lies inside, or beside, what."""
        boxes = [*self._boxes, *(SolidBox.of_opening(opening) for _, opening in named)]
        every = [*self.names, *(name for name, _ in named)]
        found: dict[str, list[tuple[str, str, str]]] = {}
        for relation, one, other, so in known_of_two(boxes, self.up):
            known = "yes" if so else "no"
            found.setdefault(relation, []).append((every[one], every[other], known))
        return found

    def _heights(self, piece: Piece) -> tuple[float, float]:
        """Its lowest and its highest point above the lowest one of its thing."""
        ground = float(self.filled.space.corner[2])
        return max(0.0, piece.low - ground), piece.high - ground

    def _hidden_extents(self, piece: Piece, box: SolidBox) -> Iterator[tuple[str, float, float]]:
        """The extents that unseen space may change, as they were seen and if all of it is full.

        How deep a piece goes behind a face that it shows is taken as what was seen of it: only its
        length may go on there.
        """
        faces = (face for face in self.filled.surface.faces if face.index in piece.faces)
        across = np.array([face.normal for face in faces]).reshape(-1, 3) @ box.axes.T
        reaches = box.reaches.copy()
        reaches[[axis for axis in np.abs(across).argmax(axis=1).tolist() if axis]] = 0.0
        if not reaches.any():
            return
        most = replace(box, reaches=reaches).widest
        length, width, _ = sorted(2.0 * most.half, reverse=True)
        changes = [("length", piece.length.value, length), ("width", piece.width.value, width)]
        if self.up is not None:
            bottom, top = self._heights(piece)
            seen, all_ = heights(box, self.up), heights(most, self.up)
            lowest, highest = max(0.0, bottom + all_[0] - seen[0]), top + all_[1] - seen[1]
            changes += [
                ("bottom_of", bottom, lowest),
                ("top_of", top, highest),
                ("height", top - bottom, highest - lowest),
                ("elevation", (bottom + top) / 2.0, (lowest + highest) / 2.0),
            ]
        for measure, if_free, if_full in changes:
            if abs(if_full - if_free) > piece.length.sd:
                yield measure, if_free, float(if_full)

    def _level(
        self, name: str, piece: Piece, up: FloatArray
    ) -> Iterator[tuple[str, tuple[str | float, ...]]]:
        if piece.kind is Kind.BAR:
            return
        side = lying(piece, up)
        if abs(float(piece.axes[side] @ up)) < LEVEL_ENOUGH:
            return
        height = self._upper_side(piece, up, side)
        level = level_at(self.filled.space, height)
        if level is not None:
            for measure, each in level.measures():
                yield "piece_level", (name, measure, each.value, each.sd)
                if each.open:
                    yield "piece_unseen", (name, measure, each.if_free, each.if_full)
        shelves = shelves_below(self.filled.space, height)
        if shelves is not None:
            fewest, most = map(float, shelves)
            yield "piece_level", (name, "shelves_below", fewest, 0.0)
            if fewest < most:
                yield "piece_unseen", (name, "shelves_below", fewest, most)

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
    faces = (face for scene in s.scenes for face in scene.faces)
    measured = frozenset(i for i, f in enumerate(faces) if f.evidence is Evidence.MEASURED)
    for index, filled in s.filled.items():
        scene = s.things[index].scene
        surface = filled.surface
        pieces = find_pieces(filled.space.least(), surface.faces, surface.curved, surface.lines)
        first, last = counts[scene] + 1, counts[scene] + len(pieces.pieces)
        names = tuple(f"p{i}" for i in range(first, last + 1))
        counts[scene] = last
        up, thing = s.scenes[scene].up, s.thing_names[index]
        yield scene, _Found(filled, up, thing, names, pieces, measured)


def _is_measured(piece: Piece, measured: frozenset[int]) -> bool:
    """Whether it is more than faces that were completed; what is curved was measured."""
    return not piece.faces or not measured.isdisjoint(piece.faces)
