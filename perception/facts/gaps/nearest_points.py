"""Where two things may be nearest: pairs of points on their vertices, sides and faces.

The least distance of two sets of flat polygons and segments is 0 where a side goes through a face;
otherwise it is found between a vertex and a vertex, side or face, or between two sides that pass
each other. Each of these is a *witness*: a point of one thing and a point of the other, weighted
means of vertices whose weights sum to 1 and to -1.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.facts.relations import VAGUE
from facetlog.perception.flat_faces import cross
from facetlog.perception.ragged import Indices
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.surfaces.things import Thing
from facetlog.perception.surfaces.tolerance import ANGLE_RESOLUTION, SDS
from facetlog.perception.types import FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class Sheets:
    """Faces that have an area (f,), with outlines of k vertices at most; all in the scene's unit.

    The plane's height at x, in the plane's axes from `centres` on, is the mean of its vertices'
    heights, weighted by `shares` + x · `levers`: the least-squares plane has the weights
    1 / k + (x - m)ᵀ S⁻¹ (xi - m), with S = Σ (xi - m)(xi - m)ᵀ. Shorter outlines end in weights 0.
    """

    normals: FloatArray
    middles: FloatArray
    axes: FloatArray
    polygons: NDArray[np.object_]
    low: FloatArray
    high: FloatArray
    outlines: Indices
    centres: FloatArray
    shares: FloatArray
    levers: FloatArray

    @classmethod
    def of(cls, table: FaceTable, faces: Indices) -> "Sheets":
        """Return some faces (f,) of a scene, in this order."""
        outlines, there, flat = table.outlines[faces], table.there[faces], table.flat[faces]
        loops = table.points[outlines]
        shares = there / there.sum(axis=1)[:, None]
        centres = (shares[:, None] @ flat)[:, 0]
        spokes = np.where(there[..., None], flat - centres[:, None], 0.0)
        across = spokes.transpose(0, 2, 1)
        return cls(
            table.planes.normals[faces],
            table.middles[faces],
            table.axes[faces],
            table.polygons[faces],
            loops.min(axis=1),
            loops.max(axis=1),
            np.where(there, outlines, 0),
            centres,
            shares,
            np.linalg.pinv(across @ spokes, hermitian=True) @ across,
        )

    def part(self, rows: slice) -> "Sheets":
        """Return some of the faces."""
        return Sheets(*(getattr(self, field.name)[rows] for field in fields(self)))

    def heights(self, rows: Indices, where: FloatArray) -> FloatArray:
        """Return heights (c,) of points (c, 3) above the planes of these faces (c,)."""
        lift: FloatArray = ((where - self.middles[rows]) * self.normals[rows]).sum(axis=1)
        return lift

    def flat(self, rows: Indices, where: FloatArray) -> FloatArray:
        """Return coordinates (c, 2) of points (c, 3) in the planes of these faces (c,)."""
        spokes = (where - self.middles[rows])[:, :, None]
        coordinates: FloatArray = (self.axes[rows] @ spokes)[:, :, 0]
        return coordinates

    def inside(self, rows: Indices, where: FloatArray, slack: float) -> NDArray[np.bool_]:
        """Return whether points (c, 3) are within the outlines of these faces, outside
        their holes.
        """
        dots = shapely.points(self.flat(rows, where))
        return np.asarray(shapely.distance(dots, self.polygons[rows]) <= slack, dtype=np.bool_)

    def weights(self, rows: Indices, where: FloatArray) -> FloatArray:
        """Return weights (c, k) of the outlines' vertices in the planes' heights at points
        (c, 3).
        """
        x = (self.flat(rows, where) - self.centres[rows])[:, None]
        found: FloatArray = self.shares[rows] + (x @ self.levers[rows])[:, 0]
        return found


Boxes = tuple[FloatArray, FloatArray]

PAIRS_AT_ONCE = 1_000_000
"""Pairs of boxes compared in one go: some 50 MB."""

_VERTEX_END, _VERTEX_SIDE, _SIDE_SIDE, _VERTEX_FACE, _SIDE_FACE = range(5)

NONE = np.zeros(0, dtype=np.intp)


@dataclass(frozen=True, eq=False, slots=True)
class Parts:
    """Vertices (n,), sides and loose edges (m, 2), and faces of some things, thing by thing.

    `vertex_of`, `side_of` and `sheet_of` are the things' numbers; `points` and `vertex_sds` (worst
    1σ) are those of the whole scene.
    """

    points: FloatArray
    vertex_sds: FloatArray
    vertices: Indices
    sides: Indices
    sheets: Sheets
    vertex_of: Indices
    side_of: Indices
    sheet_of: Indices

    @classmethod
    def of(cls, table: FaceTable, edges: Indices, things: Sequence[Thing]) -> "Parts":
        """Return the parts of one thing at least; `edges` (e, 2) are the scene's."""
        count, most = len(things), max(len(table.points), 1)
        owner = np.full(len(table), count)
        for nth, thing in enumerate(things):
            owner[list(thing.faces)] = nth
        loose = [edge for thing in things for edge in thing.edges]
        of = np.repeat(np.arange(count), [len(thing.edges) for thing in things])
        of = np.concatenate((owner[table.sides.face], of))
        ends = np.sort(np.concatenate((table.sides.ends, edges[loose])), axis=1)
        keys = np.unique((of * most + ends[:, 0]) * most + ends[:, 1])
        keys, last = np.divmod(keys[keys < count * most * most], most)
        side_of, first = np.divmod(keys, most)
        pairs = np.column_stack([first, last])
        vertex_of, vertices = np.divmod(np.unique(side_of[:, None] * most + pairs), most)
        faces = np.flatnonzero(~shapely.is_empty(table.polygons) & (owner < count))
        faces = faces[np.argsort(owner[faces], kind="stable")]
        return cls(
            table.points,
            table.tolerance.vertex_sds,
            vertices,
            pairs,
            Sheets.of(table, faces),
            vertex_of,
            side_of,
            owner[faces],
        )

    def between(self, low: int, high: int) -> "Parts":
        """Return the parts of the things from number `low` up to, but without, `high`."""
        v, s, f = (
            slice(*np.searchsorted(of, (low, high)).tolist())
            for of in (self.vertex_of, self.side_of, self.sheet_of)
        )
        return Parts(
            self.points,
            self.vertex_sds,
            self.vertices[v],
            self.sides[s],
            self.sheets.part(f),
            self.vertex_of[v],
            self.side_of[s],
            self.sheet_of[f],
        )

    @property
    def at(self) -> FloatArray:
        """Places (n, 3) of the vertices."""
        return np.asarray(self.points[self.vertices], dtype=np.float64)

    @property
    def side_boxes(self) -> Boxes:
        """Low and high corners (m, 3) of the sides' boxes."""
        ends = self.points[self.sides]
        return ends.min(axis=1), ends.max(axis=1)

    @property
    def sheet_boxes(self) -> Boxes:
        """Low and high corners (f, 3) of the faces' boxes."""
        return self.sheets.low, self.sheets.high


@dataclass(frozen=True, eq=False, slots=True)
class Witnesses:
    """Pairs of points (c, 3) of two things, whose numbers are `one` and `two` (c,).

    They are made from vertices (c, k) with weights (c, k). `across` is the direction in which the
    things lie apart where the points coincide, NaN if there is none. `rank` is what meets: a vertex
    and the end of a side, a vertex and a side, two sides, a vertex and a face, a side and a face.
    """

    one: Indices
    two: Indices
    first: FloatArray
    second: FloatArray
    across: FloatArray
    vertices: Indices
    weights: FloatArray
    rank: Indices

    @property
    def far(self) -> FloatArray:
        """Distances (c,) between the points."""
        return np.asarray(np.linalg.norm(self.first - self.second, axis=1), dtype=np.float64)

    def take(self, rows: NDArray[np.intp] | NDArray[np.bool_]) -> "Witnesses":
        """Return some of them."""
        return Witnesses(*(getattr(self, field.name)[rows] for field in fields(self)))


def joined(batches: Sequence[Witnesses]) -> Witnesses:
    """Return all witnesses of the batches; those of few vertices get weights 0."""
    widest = max(batch.weights.shape[1] for batch in batches)

    def column(name: str) -> NDArray[np.generic]:
        parts = [getattr(batch, name) for batch in batches]
        if name in ("vertices", "weights"):
            parts = [np.pad(part, ((0, 0), (0, widest - part.shape[1]))) for part in parts]
        return np.concatenate(parts)

    return Witnesses(*(column(field.name) for field in fields(Witnesses)))  # type: ignore[arg-type]


def _near(first: Boxes, second: Boxes, reach: FloatArray) -> tuple[Indices, Indices]:
    """Return pairs of boxes (n, 3), (m, 3) no further apart than `reach`, which broadcasts to (n,
    m).
    """
    reach = np.broadcast_to(reach, (len(first[0]), len(second[0])))
    rows = max(1, PAIRS_AT_ONCE // max(len(second[0]), 1))
    one, two = [], []
    for start in range(0, len(reach), rows):
        part = slice(start, start + rows)
        apart = np.maximum(second[0] - first[1][part, None], first[0][part, None] - second[1])
        np.maximum(apart, 0.0, out=apart)
        i, j = np.nonzero((apart * apart).sum(axis=2) <= reach[part] ** 2)
        one.append(i + start)
        two.append(j)
    return np.concatenate(one or [NONE]), np.concatenate(two or [NONE])


def _reach(reach: FloatArray, one: Indices, two: Indices) -> FloatArray:
    """Return the reach (n, m) of parts of the things `one` (n,) and `two` (m,)."""
    return np.asarray(reach[one[:, None], two], dtype=np.float64)


def find_nearest_on_sides(one: Parts, two: Parts, reach: FloatArray, slack: float) -> Witnesses:
    """Return vertices with the nearest points of sides of other things."""
    at = one.at
    i, j = _near((at, at), two.side_boxes, _reach(reach, one.vertex_of, two.side_of))
    p, ends = at[i], two.points[two.sides[j]]
    span = ends[:, 1] - ends[:, 0]
    size = np.maximum((span * span).sum(axis=1), 1e-300)
    foot = ((p - ends[:, 0]) * span).sum(axis=1) / size
    t = np.clip(foot, 0.0, 1.0)
    beside = np.abs(foot - t) * np.sqrt(size) <= slack
    return Witnesses(
        one.vertex_of[i],
        two.side_of[j],
        p,
        ends[:, 0] + t[:, None] * span,
        np.full_like(p, np.nan),
        np.column_stack([one.vertices[i], two.sides[j]]),
        np.column_stack([np.ones(len(t)), t - 1.0, -t]),
        np.where(beside, _VERTEX_SIDE, _VERTEX_END),
    )


def passing(one: Parts, two: Parts, reach: FloatArray, slack: float) -> Witnesses:
    """Return sides that pass each other, each nearest to the other within its length.

    Of sides that are parallel within 3 sd none is nearest at one place; their ends stand for them.
    """
    i, j = _near(one.side_boxes, two.side_boxes, _reach(reach, one.side_of, two.side_of))
    ends = np.hstack([one.sides[i], two.sides[j]])
    a, b = one.points[ends[:, :2]], one.points[ends[:, 2:]]
    u, v, r = a[:, 1] - a[:, 0], b[:, 1] - b[:, 0], a[:, 0] - b[:, 0]
    uu, uv, vv = (u * u).sum(axis=1), (u * v).sum(axis=1), (v * v).sum(axis=1)
    ur, vr = (u * r).sum(axis=1), (v * r).sum(axis=1)
    # The direction of p - q has variance (σp² + σq²) / |p - q|² at most, in radians².
    squares = one.vertex_sds[ends] ** 2
    tiny = 1e-300
    variance = squares[:, :2].sum(axis=1) / np.maximum(uu, tiny)
    variance += squares[:, 2:].sum(axis=1) / np.maximum(vv, tiny)
    parallel = np.minimum(SDS * np.sqrt(variance), VAGUE) + ANGLE_RESOLUTION
    area = uu * vv - uv * uv  # |u × v|²
    skew = area > np.sin(parallel) ** 2 * uu * vv
    area = np.where(skew, area, 1.0)
    s, t = (uv * vr - vv * ur) / area, (uu * vr - uv * ur) / area
    beyond = np.hypot(
        (s - np.clip(s, 0.0, 1.0)) * np.sqrt(uu), (t - np.clip(t, 0.0, 1.0)) * np.sqrt(vv)
    )
    keep = skew & (beyond <= slack)
    i, j, s, t = i[keep], j[keep], np.clip(s[keep], 0.0, 1.0), np.clip(t[keep], 0.0, 1.0)
    a, b, u, v = a[keep], b[keep], u[keep], v[keep]
    across = cross(u, v)
    return Witnesses(
        one.side_of[i],
        two.side_of[j],
        a[:, 0] + s[:, None] * u,
        b[:, 0] + t[:, None] * v,
        across / np.linalg.norm(across, axis=1)[:, None],
        ends[keep],
        np.column_stack([1.0 - s, s, t - 1.0, -t]),
        np.full(len(s), _SIDE_SIDE),
    )


def find_feet_on_faces(one: Parts, two: Parts, reach: FloatArray, slack: float) -> Witnesses:
    """Return vertices with their feet on faces of other things."""
    at, sheets = one.at, two.sheets
    i, j = _near((at, at), two.sheet_boxes, _reach(reach, one.vertex_of, two.sheet_of))
    heights = sheets.heights(j, at[i])
    keep = np.abs(heights) <= reach[one.vertex_of[i], two.sheet_of[j]]
    i, j, heights = i[keep], j[keep], heights[keep]
    feet = at[i] - heights[:, None] * sheets.normals[j]
    keep = sheets.inside(j, feet, slack)
    i, j, feet = i[keep], j[keep], feet[keep]
    return Witnesses(
        one.vertex_of[i],
        two.sheet_of[j],
        at[i],
        feet,
        sheets.normals[j],
        np.column_stack([one.vertices[i], sheets.outlines[j]]),
        np.column_stack([np.ones(len(i)), -sheets.weights(j, feet)]),
        np.full(len(i), _VERTEX_FACE),
    )


def find_crossed_faces(one: Parts, two: Parts, reach: FloatArray, slack: float) -> Witnesses:
    """Return where sides go through faces of other things, for pairs that have a reach."""
    sheets = two.sheets
    touching = np.where(np.isnan(reach), np.nan, slack)
    i, j = _near(one.side_boxes, two.sheet_boxes, _reach(touching, one.side_of, two.sheet_of))
    ends = one.points[one.sides[i]]
    start, end = sheets.heights(j, ends[:, 0]), sheets.heights(j, ends[:, 1])
    # An end that lies on the face is a vertex over it.
    keep = (start * end < 0.0) & (np.minimum(np.abs(start), np.abs(end)) > slack)
    i, j, ends = i[keep], j[keep], ends[keep]
    t = start[keep] / (start - end)[keep]
    where = ends[:, 0] + t[:, None] * (ends[:, 1] - ends[:, 0])
    keep = sheets.inside(j, where, slack)
    i, j, where, t = i[keep], j[keep], where[keep], t[keep]
    return Witnesses(
        one.side_of[i],
        two.sheet_of[j],
        where,
        where,
        sheets.normals[j],
        np.hstack([one.sides[i], sheets.outlines[j]]),
        np.column_stack([1.0 - t, t, -sheets.weights(j, where)]),
        np.full(len(i), _SIDE_FACE),
    )
