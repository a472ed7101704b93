"""Assemble the pieces that were found of a mesh: each once, in order, and which of them touch."""

from dataclasses import dataclass, field

import numpy as np

from facetlog.perception.pieces.exact.convex_parts import CONVEX, Hull
from facetlog.perception.pieces.exact.cut_pieces import CutPiece, CutPieces
from facetlog.perception.pieces.exact.regions import PLANE_SLACK
from facetlog.perception.pieces.exact.sheets import Sheets
from facetlog.perception.pieces.exact.wind_bodies import is_inside
from facetlog.perception.types import FloatArray

# A gap of this share of the thinner piece's thickness is none: legs are drawn a little short.
TOUCH = 0.05


@dataclass(slots=True)
class FoundPieces:
    """Pieces and volumes found of the bodies so far."""

    pieces: list[CutPiece] = field(default_factory=list)
    hulls: list[Hull] = field(default_factory=list)
    body: list[int] = field(default_factory=list)
    explained: float = 0.0
    left: list[FloatArray] = field(default_factory=list)
    left_volumes: list[float] = field(default_factory=list)
    open_area: float = 0.0


def assemble_pieces(sheets: Sheets, given: Sheets, found: FoundPieces) -> CutPieces:
    """Return the pieces, the largest first, without those that lie inside others; `given` are the
    sheets before their holes were filled.
    """
    kept = _drop_inner(sheets, given, found)
    order = sorted(kept, key=lambda i: _rank(found.pieces[i], sheets.size))
    pieces = tuple(found.pieces[i] for i in order)
    left = np.array(found.left).reshape(-1, 2, 3)
    total = float(sheets.volumes.sum())
    # what is open encloses nothing: it counts by its share of the surface
    closed = 1.0 - found.open_area / sheets.surface
    explained = closed * (min(1.0, found.explained / total) if total > 0.0 else 1.0)
    contacts = _find_contacts(sheets, given, found, order)
    reason = ""
    if not pieces:
        reason = "the solid is neither convex nor made of flat or round parts"
        if closed < 1.0:
            reason = f"{1.0 - closed:.0%} of the surface is open: it bounds no solid"
    volumes = np.array(found.left_volumes)
    return CutPieces(pieces, contacts, explained if pieces else 0.0, left, volumes, reason)


def _rank(piece: CutPiece, size: float) -> tuple[float, ...]:
    volume = -round(float(np.log(max(piece.volume, 1e-300))), 6)
    return (volume, *np.round(piece.middle / size, 6).tolist())


def _drop_inner(sheets: Sheets, given: Sheets, found: FoundPieces) -> list[int]:
    """Return the pieces that do not lie inside one of another body: those are drawn twice. What is
    in the hole of a pipe is not inside it.
    """
    volumes = np.array([piece.volume for piece in found.pieces])
    slack = 2.0 * PLANE_SLACK * sheets.slack  # as much as layers are thick
    low = np.array([hull.points.min(axis=0) for hull in found.hulls]).reshape(-1, 3)
    high = np.array([hull.points.max(axis=0) for hull in found.hulls]).reshape(-1, 3)
    body = np.array(found.body)
    kept = np.zeros(len(volumes), dtype=np.bool_)
    order = np.argsort(-volumes, kind="stable").tolist()
    for number in order:
        points = found.hulls[number].points
        outer = kept & (body != body[number])
        outer &= (low <= low[number] + slack).all(axis=1)
        outer &= (high >= high[number] - slack).all(axis=1)
        kept[number] = not any(
            found.hulls[other].coarsen().contains(points, slack).all()
            # a layer on the surface of a piece is part of it
            and (
                body[number] < 0
                or is_inside(points.mean(axis=0), given.corners(given.body == body[other]))
            )
            for other in np.flatnonzero(outer).tolist()
        )
    return [number for number in order if kept[number]]


def _find_contacts(
    sheets: Sheets, given: Sheets, found: FoundPieces, order: list[int]
) -> tuple[tuple[int, int], ...]:
    """Return the pairs of pieces, in this order, between which no plane of either leaves a gap; of
    what has holes, none of its triangles in the `given` sheets.
    """
    joins = []
    hulls = [found.hulls[i].coarsen() for i in order]
    # what a coarse hull leaves out of its piece is no gap
    lost = np.array(
        [
            coarse.measure_beyond(found.hulls[i].points)
            for coarse, i in zip(hulls, order, strict=True)
        ]
    )
    low = np.array([hull.points.min(axis=0) for hull in hulls]).reshape(-1, 3)
    high = np.array([hull.points.max(axis=0) for hull in hulls]).reshape(-1, 3)
    near = TOUCH * np.array([float(found.pieces[i].extents.min()) for i in order])
    near = np.minimum(near[:, None], near) + lost[:, None] + lost + PLANE_SLACK * sheets.slack
    close = (low[:, None] <= high + near[..., None]) & (low <= high[:, None] + near[..., None])
    bored = set(np.flatnonzero(given.volumes < (1.0 - 1e-9) * sheets.volumes).tolist())
    hollow = [
        found.body[i] in bored or found.pieces[i].volume < CONVEX * found.hulls[i].volume
        for i in order
    ]
    for one, two in np.argwhere(np.triu(close.all(axis=2), 1)).tolist():
        gaps = []
        for a, b in ((one, two), (two, one)):
            corners = hulls[b].points[None]
            if hollow[b] and found.body[order[a]] != found.body[order[b]]:
                corners = given.corners(given.body == found.body[order[b]])
            away = corners @ hulls[a].planes[:, :3].T + hulls[a].planes[:, 3]
            gaps.append(away.min(axis=1).max(axis=1).min())
        if max(gaps) <= near[one, two]:
            joins.append((one, two))
    return tuple(joins)
