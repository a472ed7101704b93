"""Outer surfaces of a cloud: which side of a face is outside, and level ones that face up.

In a cloud of all sides level surfaces that face up are found as peaks of the heights' histogram.
With up known such a surface has one unknown left, its height, which all of its points determine
together. That still works where neighbourhoods are wider than a board is thick, or where a cushion
is bent: there planes are not found, or a board's two sides are one plane, which may face down.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.signal import find_peaks
from scipy.spatial import ConvexHull, QhullError

from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.ragged import unique_rows
from facetlog.perception.scene import Plane
from facetlog.perception.shapes.clouds.lines_of_sight import CELL_SPACINGS, OFF_PLANE_SDS
from facetlog.perception.shapes.regions.visibility_grid import CUBES, FreeWays
from facetlog.perception.space.flooding import is_empty_shell
from facetlog.perception.types import FloatArray

# One way is free if it is this much longer than the other, on the mean over the face.
CLEARLY_FREE = 1.5
# Given normals, or the places a face was seen from, decide where they agree by so much (-1 … 1).
AGREEMENT = 0.3
# A face was seen from a place if this share of its points was, and is not hidden from there.
SEEN_SHARE = 0.9
# Seen from its edge, to within so many spacings and the noise, either side may have been seen.
EDGE_ON_SPACINGS = 3.0
# Of the thing's other points this share is behind a face at least; otherwise both sides are alike.
BEHIND_SHARE = 0.6


# Normals, or places that not all of a thing was seen from, decide for a thing if they agree with
# free space on this share of its faces, and of the points on these. Normals of furniture sampled
# all over agree on .9 or more; those that all look up, or to a sensor, on half.
BELIEVED_SHARE = 0.75
# Heights are counted in bins of this share of the noise, and the counts smoothed by the noise.
BIN_SHARE = 0.5
# A level's points are within so many sd of its height, ...
SLAB_SDS = 2.0
# ... and where it faces up there are next to none so many sd further up: a wall has as many there,
# a second layer at least a third.
CLEAR_SDS = 4.0
CLEAR_RATIO = 3.0
# Columns are so many spacings wide: nine points of a level surface fall into each on average, and
# one column in 160 has fewer than three.
COLUMN_SPACINGS = 3.0
LEAST_HELD = 3
# A level takes this share of the plan at least, as in levels.py: the rest is rims and leg ends.
LEAST_SHARE = 0.1
# No more than every second column of a level is filled, not held.
FILLED = 2.0
# Columns that are missing by chance are filled, one wide; strips less than two wide are the tops of
# walls, and are taken away.
CROSS = ndimage.generate_binary_structure(2, 1)
BLOCK = np.ones((2, 2), dtype=bool)
# Cubes of the grid that is looked out through, in spacings: where a surface's points fall half into
# one cube and half into the next, either is empty by chance once in e^6, 400.
CUBE_SPACINGS = 3.5
# A level is not an inner side of a closed box if this share of all directions is free above it, on
# the mean over its columns: half-way up to what is above it, or all if nothing is.
LEAST_SIGHT = 0.03
# Columns at the rim, so many wide, have no say: a cube there reaches past the rim.
RIM = 2
# Half of what faces up at a height is known already: it needs no second face.
KNOWN_SHARE = 0.5


def find_levels_by_height(
    points: FloatArray, up: FloatArray, known: NDArray[np.bool_], *, noise: float, spacing: float
) -> Iterator[NDArray[np.intp]]:
    """Yield rows of points (n, 3) on each level that faces up, those of most points first.

    `known` (n,) are points of faces that look up: what is mostly of these is left out. `up` is a
    unit vector, `noise` the sd of a point off its surface, `spacing` the typical distance between
    points on it. A level is connected, and no point is in two.
    """
    if not (noise > 0.0 and spacing > 0.0 and np.ptp(points @ up) > SLAB_SDS * noise):
        return
    columns = _Columns.of(points, up, COLUMN_SPACINGS * spacing)
    extent = float(np.linalg.norm(np.ptp(points, axis=0)))
    ways = FreeWays.of(points, max(CUBE_SPACINGS * spacing, extent / CUBES))
    free = np.ones(len(points), dtype=bool)
    for middle in _heights(columns.height, BIN_SHARE * noise):
        top = middle + SLAB_SDS * noise
        clear = top + CLEAR_SDS * noise
        rows = columns.between(middle - SLAB_SDS * noise, top)
        rows = rows[free[rows]]
        if len(rows) < LEAST_HELD * LEAST_SHARE * columns.taken / FILLED:
            continue  # where noise is little, a wall has as many heights as points
        held, over = columns.counts(rows), columns.counts(columns.between(top, clear))
        level = (held >= LEAST_HELD) & (held >= CLEAR_RATIO * over)
        roof = columns.find_lowest_from(clear)
        for part in _parts(level.reshape(columns.shape), LEAST_SHARE * columns.taken):
            members = rows[part.ravel()[columns.column[rows]]]
            free[members] = False
            if known[members].mean() >= KNOWN_SHARE:
                continue
            inner = members[_inner(part).ravel()[columns.column[members]]]
            gaps = roof[columns.column[inner]] - middle
            if _sight(points[inner], up, gaps, ways) >= LEAST_SIGHT:
                yield np.sort(members)


def _inner(part: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return columns of a part away from its rim, over which one sees past it; all if no other is
    left.
    """
    inner = ndimage.binary_erosion(part, iterations=RIM)
    return inner if inner.any() else part


def _sight(points: FloatArray, up: FloatArray, gaps: FloatArray, ways: FreeWays) -> float:
    """Return share of directions that are free half-way up from points (n, 3), all where gaps are
    inf.

    Into a gap narrower than two cubes the grid does not see.
    """
    sights = np.where(np.isinf(gaps), 1.0, 0.0)
    covered = np.flatnonzero(np.isfinite(gaps) & (gaps >= 2.0 * ways.cube))
    halves = gaps[covered, None] / 2.0
    sights[covered] = ways.open_share(points[covered] + halves * up)
    return float(sights.mean())


@dataclass(frozen=True, eq=False, slots=True)
class _Columns:
    """Points (n,) by height and by `column`, the number of a square of a plan of this `shape`.

    `order` are the rows by height, `taken` says how many columns hold a point.
    """

    height: FloatArray
    column: NDArray[np.intp]
    shape: tuple[int, int]
    order: NDArray[np.intp]
    taken: int

    @classmethod
    def of(cls, points: FloatArray, up: FloatArray, width: float) -> "_Columns":
        """Return columns so wide through points (n, 3)."""
        height = points @ up
        plan = points @ make_plane_axes(up, np.roll(up, 1)).T
        places = np.floor((plan - plan.min(axis=0)) / width).astype(np.intp)
        shape = (int(places[:, 0].max()) + 1, int(places[:, 1].max()) + 1)
        column = places @ np.array([shape[1], 1])
        taken = int(np.count_nonzero(np.bincount(column)))
        return cls(height, column, shape, np.argsort(height, kind="stable"), taken)

    def between(self, low: float, high: float) -> NDArray[np.intp]:
        """Return rows, ascending by height, of the points from `low` up to below `high`."""
        first, last = np.searchsorted(self.height, [low, high], sorter=self.order)
        rows: NDArray[np.intp] = self.order[first:last]
        return rows

    def counts(self, rows: NDArray[np.intp]) -> NDArray[np.intp]:
        """Return how many of some points are in each column."""
        return np.bincount(self.column[rows], minlength=self.shape[0] * self.shape[1])

    def find_lowest_from(self, low: float) -> FloatArray:
        """Return the height at which there is surface from `low` on, in a column or one next to it.

        It is inf where there is none: in one column alone points may be missing by chance.
        """
        rows = self.between(low, np.inf)
        counts = self.counts(rows)
        by_column = rows[np.argsort(self.column[rows], kind="stable")]
        held = counts >= LEAST_HELD
        found = np.full(len(counts), np.inf)
        starts = np.cumsum(counts) - counts
        found[held] = self.height[by_column[starts[held] + LEAST_HELD - 1]]
        return np.asarray(ndimage.minimum_filter(found.reshape(self.shape), 3)).ravel()


def _heights(height: FloatArray, step: float) -> list[float]:
    """Return heights at which more points are than right above and below, those of most points
    first.
    """
    low = float(height.min())
    bins = np.floor((height - low) / step).astype(np.intp)
    # empty bins at both ends, so that the highest and the lowest can be peaks
    counts = np.pad(np.bincount(bins).astype(np.float64), 3)
    smooth = ndimage.gaussian_filter1d(counts, 1.0 / BIN_SHARE, mode="constant")
    peaks = find_peaks(smooth)[0]
    return [low + (p - 2.5) * step for p in peaks[np.argsort(-smooth[peaks], kind="stable")]]


def _parts(level: NDArray[np.bool_], least: float) -> Iterator[NDArray[np.bool_]]:
    """Yield the connected parts of a plan with so many columns at least."""
    filled = ndimage.binary_closing(np.pad(level, 1), CROSS)[1:-1, 1:-1] | level
    broad = ndimage.binary_opening(filled, BLOCK)
    labels, count = ndimage.label(broad, np.ones((3, 3)))
    sizes = np.bincount(labels.ravel(), minlength=count + 1)
    for nth in np.argsort(-sizes[1:], kind="stable") + 1:
        if sizes[nth] >= max(least, 1.0):
            yield labels == nth


@dataclass(frozen=True, eq=False, slots=True)
class Surroundings:
    """A cloud's points (n, 3), the region and object of each, and their spacing.

    `noise` (m,) is the sd of a region's points off it.
    `normals` (n, 3) as the file gives them and `seen_from` (n, 3), a place from which each point
    was seen; None where the file does not have them. Of the objects `partly` other places saw
    some.
    """

    points: FloatArray
    owner: NDArray[np.intp]
    bodies: NDArray[np.intp]
    noise: FloatArray
    spacing: float
    normals: FloatArray | None = None
    seen_from: FloatArray | None = None
    partly: tuple[int, ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class OuterSides:
    """Signs (m,) of planes, 1 if they look outwards and -1 if inwards.

    `is_place_wrong` says that the places it was seen from contradict free space, and were ignored;
    `wrong_normals` are the objects of which the file's normals do.
    """

    signs: NDArray[np.intp]
    is_place_wrong: bool
    wrong_normals: tuple[int, ...]


def find_outer_sides(
    planes: Sequence[Plane],
    body_of: Sequence[int],
    about: Surroundings,
    *,
    around: Collection[int] = (),
    up: FloatArray | None = None,
) -> OuterSides:
    """Return which planes look outwards.

    `planes` are those of the regions that `about.owner` numbers, `body_of` their objects. By the
    first criterion that decides: where it was seen from; the normals of the file; the side from
    which rays go further before they meet other surface; the side with less of the same object;
    up; away from the middle. Regions `around` all things, as a floor, look towards them.
    """
    faces = [
        _Face(number, np.flatnonzero(about.owner == number), plane, about)
        for number, plane in enumerate(planes)
    ]
    free = np.zeros(len(planes), dtype=np.intp)
    seen, by_normals = free.copy(), free.copy()
    inwards = free.copy()
    for number, face in enumerate(faces):
        if number in around:
            inwards[number] = 1 if float(face.plane.distance(about.points).mean()) > 0.0 else -1
        elif len(face.rows):
            free[number] = face.find_freer_side()
        if len(face.rows):
            seen[number] = face.find_seen_side()
            by_normals[number] = face.find_side_of_normals()
    weights = np.array([len(face.rows) for face in faces])
    is_place_wrong = False
    # where the normals of a floor look down, the others may, too
    wrong = set(body_of) if (inwards * by_normals < 0).any() else set[int]()
    for body in set(body_of):
        own = np.array(body_of) == body
        if body >= 0 and body in about.partly:
            agreed = _agreement(seen[own], free[own], weights[own])
            is_place_wrong |= seen[own].any() and not agreed and not _is_room(body, about)
        agreed = _agreement(by_normals[own], free[own], weights[own])
        if agreed is False and not (body >= 0 and _is_room(body, about)):
            wrong.add(body)
    by_normals[np.isin(body_of, list(wrong))] = 0
    if is_place_wrong:
        seen[:] = 0
    signs = np.where(seen != 0, seen, np.where(by_normals != 0, by_normals, free))
    signs = np.where(inwards != 0, inwards, signs)
    for number in np.flatnonzero(signs == 0).tolist():
        signs[number] = faces[number].find_likelier_side(up)
    return OuterSides(signs, bool(is_place_wrong), tuple(wrong))


def _agreement(
    stated: NDArray[np.intp], free: NDArray[np.intp], weights: NDArray[np.intp]
) -> bool | None:
    """Return whether the sides stated of an object's `own` regions agree with free space; None:
    unknown.

    Walls of a room are seen from inside, although there is more free space behind them.
    """
    both = (stated != 0) & (free != 0)
    if not both.any():
        return None
    agree = (stated == free)[both]
    shares = float(agree.mean()), float(np.average(agree, weights=weights[both]))
    return min(shares) >= BELIEVED_SHARE


def _is_room(body: int, about: Surroundings) -> bool:
    """Return whether an object is the walls round another, or round a sensor that something stands
    near.

    Only what lies within its convex hull tells walls from the outside of a thing.
    """
    own = about.points[about.bodies == body]
    try:
        sides = ConvexHull(own).equations
    except (QhullError, ValueError):  # flat, or too few points
        return False

    def find_within(places: FloatArray) -> FloatArray:
        within: FloatArray = places[(places @ sides[:, :3].T + sides[:, 3] < 0.0).all(axis=1)]
        return within

    numbers = np.unique(about.bodies[(about.bodies >= 0) & (about.bodies != body)])
    middles = [about.points[about.bodies == number].mean(axis=0) for number in numbers]
    if len(find_within(np.array(middles).reshape(-1, 3))):
        return True
    if about.seen_from is None:
        return False
    known = about.seen_from[np.isfinite(about.seen_from).all(axis=1)]
    within = find_within(unique_rows(known))
    return any(not is_empty_shell(own, about.points, place) for place in within)


def _get_clear_sign(mean: float) -> int:
    return 0 if abs(mean) < AGREEMENT else 1 if mean > 0.0 else -1


@dataclass(frozen=True, eq=False, slots=True)
class _Face:
    """A region of a cloud, the `rows` of its points, and its plane."""

    region: int
    rows: NDArray[np.intp]
    plane: Plane
    about: Surroundings

    @property
    def off(self) -> float:
        """Points farther than this from the plane are not on it."""
        return OFF_PLANE_SDS * float(self.about.noise[self.region])

    def find_seen_side(self) -> int:
        """Return the side that most points were seen from; 0 where that is not known."""
        seen_from = self.about.seen_from
        if seen_from is None:
            return 0
        rows = self.rows[np.isfinite(seen_from[self.rows]).all(axis=1)]
        if len(rows) < SEEN_SHARE * len(self.rows):
            return 0
        places, points = seen_from[rows], self.about.points[rows]
        height, away = self.plane.distance(places), np.linalg.norm(places - points, axis=1)
        # how far off the plane lines of sight pass from end to end of the face
        turn = np.abs(height) / np.maximum(away, 1e-300)
        extent = float(np.linalg.norm(np.ptp(points, axis=0)))
        clear = turn * extent > EDGE_ON_SPACINGS * self.about.spacing + self.off
        return _get_clear_sign(float((np.sign(height) * clear).mean()))

    def find_side_of_normals(self) -> int:
        """Return the side that the file's normals look to; 0 where they do not agree."""
        if self.about.normals is None:
            return 0
        own = self.about.normals[self.rows]
        known = (own @ self.plane.normal)[own.any(axis=1)]
        return _get_clear_sign(float(known.mean())) if len(known) else 0

    def find_freer_side(self) -> int:
        """Return the side from which rays go clearly further before they meet other surface; 0 if
        none.
        """
        paths = self._measure_free_paths()
        # a ray that meets nothing is as long as the whole cloud
        longest = float(np.linalg.norm(np.ptp(self.about.points, axis=0)))
        ahead, back = (np.minimum(path, longest).mean() for path in paths)
        if ahead > CLEARLY_FREE * back:
            return 1
        return -1 if back > CLEARLY_FREE * ahead else 0

    def find_likelier_side(self, up: FloatArray | None) -> int:
        """Return the side with less of the same object, else the upper one, else away from the
        middle.
        """
        sign = self._find_emptier_side() if len(self.rows) else 1
        if not sign and up is not None:
            sign = int(np.sign(np.round(float(self.plane.normal @ up), 1)))
        if not sign:
            middle = self.about.points.mean(axis=0)
            sign = 1 if float(self.plane.distance(middle)) <= 0.0 else -1
        return sign

    def _measure_free_paths(self) -> tuple[FloatArray, FloatArray]:
        """Return lengths of rays from cells of the face to other surface, before and behind it;
        inf: none.
        """
        points = self.about.points
        axes = make_plane_axes(self.plane.normal, np.roll(self.plane.normal, 1))
        width = max(CELL_SPACINGS * self.about.spacing, 1e-300)
        own = points[self.rows] @ axes.T
        low, high = own.min(axis=0), own.max(axis=0)
        shape = np.floor((high - low) / width).astype(np.intp) + 1
        height = self.plane.distance(points)
        rest = (self.about.owner != self.region) & (np.abs(height) > self.off)
        flat = points[rest] @ axes.T
        over = ((flat >= low) & (flat <= high)).all(axis=1)
        cells = np.floor((flat[over] - low) / width).astype(np.intp) @ [shape[1], 1]
        above = height[rest][over]
        used = np.unique(np.floor((own - low) / width).astype(np.intp) @ [shape[1], 1])
        paths = []
        for sign in (1.0, -1.0):
            nearest = np.full(int(shape.prod()), np.inf)
            way = sign * above > 0.0
            np.minimum.at(nearest, cells[way], np.abs(above[way]))
            paths.append(nearest[used])
        return paths[0], paths[1]

    def _find_emptier_side(self) -> int:
        """Return the side with less of the face's own object; 0 where both have about as much."""
        about = self.about
        body = np.bincount(about.bodies[self.rows] + 1).argmax() - 1
        rest = (about.bodies == body) & (about.owner != self.region) & (body >= 0)
        height = self.plane.distance(about.points[rest])
        height = height[np.abs(height) > self.off]
        if not len(height):
            return 0
        behind = float((height < 0.0).mean())
        if behind >= BEHIND_SHARE:
            return 1
        return -1 if behind <= 1.0 - BEHIND_SHARE else 0
