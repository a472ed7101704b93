"""Facts about the pieces of things and their openings: what they are like, and how they meet."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.facts.levels.filled_space import FilledSpace
from facetlog.perception.facts.levels.levels import level_at, shelves_below
from facetlog.perception.facts.named_rows import CollectedFacts, Names
from facetlog.perception.facts.pieces.kinds import OPENING_KINDS, PIECE_KINDS
from facetlog.perception.facts.pieces.opening_facts import (
    find_openings_of,
    iter_extents,
    iter_hollow_facts,
    iter_opening_facts,
    iter_rim_facts,
    openings_known,
)
from facetlog.perception.facts.pieces.piece_directions import (
    find_broad_axis,
    iter_angles,
    measure_side_tilt,
    measure_tilt,
)
from facetlog.perception.facts.pieces.solid_boxes import (
    SolidBox,
    heights,
    iter_known_distances,
    iter_known_insets,
    iter_known_overlaps,
    iter_known_relations,
    iter_missed_beside_shares,
)
from facetlog.perception.facts.scene_memo import SceneMemo
from facetlog.perception.pieces.measure_solids import measure_solids
from facetlog.perception.pieces.pieces import find_pieces
from facetlog.perception.pieces.shown_pieces import (
    Kind,
    Piece,
    Pieces,
    ShownPiece,
    ShownPieces,
    compute_box_corners,
)
from facetlog.perception.scene import Evidence, Scene
from facetlog.perception.space.hollows import Hollow, find_hollows
from facetlog.perception.space.openings import Opening
from facetlog.perception.surfaces.floors import LEVEL_ENOUGH
from facetlog.perception.surfaces.things import Thing
from facetlog.perception.types import FloatArray

# Facts that only models ask for which name a hollow.
HOLLOW_FACTS = ("hollow_of", "hollow_mouth", "hollows_known")
# The foot of a leg is lower than this share of what stands on it.
FOOT = 0.1


def find_grounded(pieces: Pieces, up: FloatArray, cell: float) -> NDArray[np.bool_]:
    """Return which pieces (p,) stand on the ground: they reach as low as any within a cell, or
    stand on a board that lies there, or on a foot.
    """
    low, high = np.array([(piece.low, piece.high) for piece in pieces.pieces]).reshape(-1, 2).T
    lowest = low < low.min(initial=np.inf) + cell
    lies = np.array(
        [
            piece.kind is Kind.BOARD and abs(float(piece.axes[2] @ up)) > LEVEL_ENOUGH
            for piece in pieces.pieces
        ],
        dtype=np.bool_,
    )
    stands_on = pieces.joins & (low[:, None] >= high[None] - cell / 2.0)
    foot = (high - low)[None] < FOOT * (high - low)[:, None]
    grounded: NDArray[np.bool_] = lowest | (stands_on & lowest & (lies | foot)).any(axis=1)
    return grounded


def hanging(pieces: Pieces, cell: float) -> NDArray[np.bool_]:
    """Return which piece hangs from which (p, p): they touch, the second's middle is higher, and
    without the second nothing joins the first to the ground.
    """
    count = len(pieces.pieces)
    found = np.zeros((count, count), dtype=np.bool_)
    if not count:
        return found
    low = np.array([piece.low for piece in pieces.pieces])
    middle = np.array([piece.low + piece.high for piece in pieces.pieces]) / 2.0
    ground = low < low.min() + cell
    for holder in range(count):
        hung = ~_joined(pieces.joins, ground & (np.arange(count) != holder), holder)
        found[:, holder] = hung & pieces.joins[:, holder] & (middle < middle[holder]) & ~ground
    return found


def _joined(joins: NDArray[np.bool_], first: NDArray[np.bool_], without: int) -> NDArray[np.bool_]:
    """Return the pieces (p,) that touch the first ones, or others that do, none of them
    `without`.
    """
    reached, more = first, True
    while more:
        wider = reached | joins[:, reached].any(axis=1)
        wider[without] = False
        reached, more = wider, bool((wider != reached).any())
    return reached


def piece_facts(s: SceneMemo, rows: CollectedFacts) -> None:
    """Add all facts about pieces."""
    if not any(rows.wants(kind.functor) for kind in PIECE_KINDS):
        return
    with_openings = any(rows.wants(kind.functor) for kind in OPENING_KINDS)
    with_hollows = any(rows.wants(functor) for functor in HOLLOW_FACTS)
    holes = hollow_count = 0
    for found in _iter_found_pieces(s):
        for functor, each in found.facts(s.face_names):
            rows.add_rows(functor, [each])
        if found.filled.known:
            rows.add_rows("explained", [(found.thing, found.pieces.explained)])
            rows.add_rows("unexplained", [(found.thing, *gap) for gap in found.pieces.gaps])
        if rows.wants("piece_angle"):
            rows.add_rows("piece_angle", found.angles())
        if rows.wants("piece_overlap"):
            rows.add_rows("piece_overlap", found.overlaps())
        if rows.wants("piece_distance"):
            rows.add_rows("piece_distance", found.distances())
        if rows.wants("piece_inset"):
            rows.add_rows("piece_inset", found.insets())
        if not with_openings:
            continue
        openings = find_openings_of(found.filled, found.up)
        named: list[tuple[str, Opening]] = [
            (f"o{holes + i}", each) for i, each in enumerate(openings, start=1)
        ]
        holes += len(named)
        for functor, each in found.openings(named, s.face_names):
            rows.add_rows(functor, [each])
        hollows = (
            ()
            if found.up is None or not with_hollows
            else find_hollows(found.filled.space, on_ground=True)
        )
        named_hollows = [(f"h{hollow_count + i}", each) for i, each in enumerate(hollows, start=1)]
        hollow_count += len(hollows)
        for functor, each in found.hollows(named_hollows):
            rows.add_rows(functor, [each])
        named += named_hollows
        if rows.wants("inside") or rows.wants("beside") or rows.wants("beside_shares"):
            for functor, all_ in found.relate_solids(named).items():
                rows.add_rows(functor, all_)


def shown_pieces(scene: Scene) -> ShownPieces:
    """Return the pieces of a scene by the names that facts have, to be drawn."""
    memo = SceneMemo.of(scene)
    found = list(_iter_found_pieces(memo))
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
        """Yield functors and arguments; `face_names` (f,) are those of all faces."""
        cell = self.filled.space.cell
        grounded = (
            np.zeros(len(self.names), dtype=np.bool_)
            if self.up is None
            else find_grounded(self.pieces, self.up, cell)
        )
        for name, piece, box, on_ground in zip(
            self.names, self.pieces.pieces, self._boxes, grounded.tolist(), strict=True
        ):
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
                yield "piece_tilt", (name, *measure_tilt(piece, self.up))
                yield "piece_side_tilt", (name, *measure_side_tilt(piece, self.up))
                if on_ground:
                    yield "piece_on_ground", (name,)
                yield from self._level(name, piece, self.up)
            for measure, if_free, if_full in self._iter_hidden_extents(piece, box):
                yield "piece_unseen", (name, measure, if_free, if_full)
        pairs = [("joins", self.pieces.joins), ("may_join", self._share_gaps(cell))]
        if self.up is not None:
            pairs.append(("carries", self.pieces.carries))
            pairs.append(("hangs_from", hanging(self.pieces, cell)))
        for functor, related in pairs:
            for i, j in np.argwhere(related).tolist():
                yield functor, (self.names[i], self.names[j])

    def _share_gaps(self, cell: float) -> NDArray[np.bool_]:
        """Return which pieces (p, p) do not touch, while one gap of the volume lies within a cell
        of the boxes round both.
        """
        corners = [compute_box_corners(piece) for piece in self.pieces.pieces]
        found = np.zeros_like(self.pieces.joins)
        for gap in np.array(self.pieces.gaps).reshape(-1, 2, 3):
            near = np.array(
                [
                    bool(
                        (each.min(axis=0) <= gap[1] + cell).all()
                        and (each.max(axis=0) >= gap[0] - cell).all()
                    )
                    for each in corners
                ]
            )
            found |= near[:, None] & near
        np.fill_diagonal(found, val=False)
        return found & ~self.pieces.joins

    def angles(self) -> Iterator[tuple[str, str, float, float]]:
        """Yield the arguments of the facts about how each two pieces are turned to one another."""
        for one, other, angle in iter_angles(self.pieces.pieces, self.up):
            yield self.names[one], self.names[other], *angle

    def overlaps(self) -> Iterator[tuple[str, str, float, float]]:
        """Yield the arguments of the facts about which share of each two pieces' plans is the
        other's.
        """
        for one, other, share, sd in iter_known_overlaps(self._boxes, self.up):
            yield self.names[one], self.names[other], share, sd

    def distances(self) -> Iterator[tuple[str, str, float, float]]:
        """Yield the arguments of the facts about how far apart each two pieces' plans are."""
        for one, other, apart, sd in iter_known_distances(self._boxes, self.up):
            yield self.names[one], self.names[other], apart, sd

    def insets(self) -> Iterator[tuple[str, str, float, float, float]]:
        """Yield the arguments of the facts about how far each piece's plan is within another's."""
        for one, other, inset, corner, sd in iter_known_insets(self._boxes, self.up):
            yield self.names[one], self.names[other], inset, corner, sd

    @cached_property
    def _boxes(self) -> list[SolidBox]:
        return [SolidBox.of_piece(piece, self.filled.space) for piece in self.pieces.pieces]

    def openings(
        self, named: Sequence[tuple[str, Opening]], face_names: Names
    ) -> Iterator[tuple[str, tuple[str | float, ...]]]:
        """Yield functors and arguments of the facts about the thing's openings, each with
        its name.
        """
        pieces = list(zip(self.names, self.pieces.pieces, strict=True))
        for name, opening in named:
            yield "opening_of", (name, self.thing)
            yield from iter_opening_facts(name, opening, self.filled, self.up, face_names)
            yield from iter_rim_facts(name, opening, pieces)
        if openings_known(self.filled, self.up, [opening for _, opening in named]):
            yield "openings_known", (self.thing,)

    def hollows(
        self, named: Sequence[tuple[str, Hollow]]
    ) -> Iterator[tuple[str, tuple[str | float, ...]]]:
        """Yield functors and arguments of the facts about the thing's hollows, each with its
        name.
        """
        for name, hollow in named:
            yield from iter_extents(name, hollow, self.filled, self.up)
            yield from iter_hollow_facts(name, hollow, self.thing)
        if self.filled.known and self.up is not None:
            yield "hollows_known", (self.thing,)

    def relate_solids(
        self, named: Sequence[tuple[str, Opening]]
    ) -> dict[str, list[tuple[str | float, ...]]]:
        """Return the arguments of the facts `inside`, `beside` and `beside_shares`, by functor."""
        boxes = [*self._boxes, *(SolidBox.of_opening(opening) for _, opening in named)]
        every = [*self.names, *(name for name, _ in named)]
        found: dict[str, list[tuple[str | float, ...]]] = {}
        for relation, one, other, so in iter_known_relations(boxes, self.up):
            known = "yes" if so else "no"
            found.setdefault(relation, []).append((every[one], every[other], known))
        found["beside_shares"] = [
            (every[one], every[other], *shares)
            for one, other, *shares in iter_missed_beside_shares(boxes, self.up)
        ]
        return found

    def _heights(self, piece: Piece) -> tuple[float, float]:
        """Return heights of a piece's lowest and highest point above the lowest one of its
        thing.
        """
        ground = float(self.filled.space.corner[2])
        return max(0.0, piece.low - ground), piece.high - ground

    def _iter_hidden_extents(
        self, piece: Piece, box: SolidBox
    ) -> Iterator[tuple[str, float, float]]:
        """Yield the extents that unseen space may change, as they were seen and if all of it is
        full.

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
        side = find_broad_axis(piece, up)
        if abs(float(piece.axes[side] @ up)) < LEVEL_ENOUGH:
            return
        height = self._find_upper_side(piece, up, side)
        level = level_at(self.filled.space, height)
        if level is not None:
            for measure, each in level.measures.items():
                yield "piece_level", (name, measure, each.value, each.sd)
                if each.open:
                    yield "piece_unseen", (name, measure, each.if_free, each.if_full)
        shelves = shelves_below(self.filled.space, height)
        if shelves is not None:
            fewest, most = map(float, shelves)
            yield "piece_level", (name, "shelves_below", fewest, 0.0)
            if fewest < most:
                yield "piece_unseen", (name, "shelves_below", fewest, most)

    def _find_upper_side(self, piece: Piece, up: FloatArray, side: int) -> float:
        """Return how high the side is that it turns upwards: its largest face there, or what is
        curved halfway between its middle and its highest point, for a hollow seat is below its rim.
        """
        faces = (face for face in self.filled.surface.faces if face.index in piece.faces)
        level = [face for face in faces if float(face.normal @ up) >= LEVEL_ENOUGH]
        if level:
            return float(max(level, key=lambda face: face.area).middle @ up)
        half = (piece.length, piece.width, piece.thickness)[side].value / 2.0
        rise = abs(float(piece.axes[side] @ up))
        return float(piece.middle @ up) + half * rise / 2.0


def _iter_found_pieces(s: SceneMemo) -> Iterator[_Found]:
    """Yield the pieces of each thing; they are numbered through."""
    measured = frozenset(
        i for i, face in enumerate(s.scene.faces) if face.evidence is Evidence.MEASURED
    )
    count = 0
    for index, filled in s.filled.items():
        pieces = _find_pieces(s.things[index], filled, s.table.points)
        names = tuple(f"p{count + i}" for i in range(1, len(pieces.pieces) + 1))
        count += len(names)
        yield _Found(filled, s.scene.up, s.thing_names[index], names, pieces, measured)


def _find_pieces(thing: Thing, filled: FilledSpace, points: FloatArray) -> Pieces:
    """Return the pieces of a thing: the solids of its closed surface, else what its cells show."""
    space, surface, solids = filled.space, filled.surface, thing.solids
    if solids is None and filled.known and not thing.patches:
        from facetlog.perception.pieces.body_solids import cut_faces  # scipy: few ask for pieces

        solids = cut_faces(surface.faces, points)
    if solids is not None and solids.pieces:
        return measure_solids(solids, space.axes[2], surface.corner_sd, space.cell)
    found = find_pieces(space.least(), surface.faces, surface.curved, surface.lines)
    if solids is None:
        return found
    return replace(found, explained=min(found.explained, solids.explained), gaps=solids.gaps)


def _is_measured(piece: Piece, measured: frozenset[int]) -> bool:
    """Return whether it is more than faces that were completed; what is curved was measured."""
    return not piece.faces or not measured.isdisjoint(piece.faces)
