"""From where a cloud was seen: from a place, as lines of sight agree with it, or from all sides.

Nothing is seen through a surface: a point behind a face was not seen from there, and a sensor is
neither in a surface that it sees nor below the floor. Files say wrong places: an organised cloud
that was moved into the world keeps the sensor's origin, and a VIEWPOINT may be meant for points in
the sensor's frame or in the world's.

Points sampled all over a surface cover all sides of an object. A scan from one side has no occluded
points: there is a direction from which all of it is visible. A cloud of all sides has hidden
surface from every direction, for solids about half of it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.ragged import find_distinct, iter_groups, number_rows, unique_rows
from facetlog.perception.reading.shape_files.clouds.point_cloud import Cloud
from facetlog.perception.scene import Plane
from facetlog.perception.shapes.clouds.cloud_outlines import Outline
from facetlog.perception.shapes.regions.flat_region import PlaneFrame
from facetlog.perception.shapes.regions.floor_and_walls import Up
from facetlog.perception.space.flooding import OPEN_SHARE, is_empty_shell
from facetlog.perception.types import FloatArray

# A scan has a few places; a cloud from photographs has one for each point, about the middle of
# those it was seen from, which is no end of a line of sight.
MOST_PLACES = 16

# Points within so many sd of a plane, and one spacing, are on it.
OFF_PLANE_SDS = 4.0
# An outline is jagged to within a spacing; a line of sight that close to the rim passes it.
RIM_SPACINGS = 1.0
# More of a thing's points are behind faces only if it was not seen from there alone: flying points
# and noise at rims are 1.1 % of a room's scan, and less of others; of a box that was sampled all
# over, a place outside of it has 40 % hidden. So few points are chance.
HIDDEN_SHARE = 0.02
HIDDEN_POINTS = 5
# A face with this share of the points is one that a sensor in its plane cannot have seen.
LEAST_SHARE = 0.1
# A room, too, goes all round the sensor. It is told from a thing by what stands in it. Of a shell
# in which nothing stands nothing tells which it is: an empty room and a carton differ in size
# alone. It counts as a thing.

# Directions that are looked along, 20 degrees apart: a thing is closed in those in which it has
# points.
WAYS_ROUND = 96


def find_things_round_sensor(
    points: FloatArray,
    bodies: NDArray[np.intp],
    seen_from: FloatArray | None,
    up: FloatArray | None,
) -> tuple[int, ...]:
    """Return the numbers of the things that go round a place from which points (n, 3) were seen.

    `bodies` (n,) is the object of each, -1 for none; `seen_from` (n, 3) as of a Cloud. The ground
    closes a thing below where `up` (3,) is known.
    """
    if seen_from is None:
        return ()
    known = np.isfinite(seen_from).all(axis=1)
    places = unique_rows(seen_from[known])
    if len(places) > MOST_PLACES:
        return ()
    found = []
    for body in range(int(bodies.max(initial=-1)) + 1):
        own = points[bodies == body]
        low, high = own.min(axis=0), own.max(axis=0)
        within = places[((places > low) & (places < high)).all(axis=1)]
        if any(_is_round(own, points, place, up) for place in within):
            found.append(body)
    return tuple(found)


def _is_round(
    own: FloatArray, points: FloatArray, place: FloatArray, up: FloatArray | None
) -> bool:
    """Return whether a thing, of its `own` points (k, 3) of all, and no room, goes round a
    place.
    """
    rays = own - place
    ways = rays / np.maximum(np.linalg.norm(rays, axis=1), 1e-300)[:, None]
    directions = make_even_directions(WAYS_ROUND)
    asked = np.ones(len(directions), dtype=bool) if up is None else directions @ up > 0.0
    closed = np.zeros(len(directions), dtype=bool)
    closed[cKDTree(directions).query(ways)[1]] = True
    if not asked.any() or float((~closed[asked]).mean()) > OPEN_SHARE:
        return False
    return is_empty_shell(own, points, place)


# Directions to look along, each from both ends: none is further than 15 degrees from one of them.
DIRECTIONS = 48
GOLDEN_TURN = float(np.pi * (3.0 - np.sqrt(5.0)))
# Rays run through cells so many spacings wide: of points at random one cell in 500 is empty.
CELL_SPACINGS = 2.5
# A gap of so many sd and so many cells in depth separates two layers; less is noise, or the slope
# of one surface.
GAP_SDS = 4.0
GAP_CELLS = 1.0
# In a view from one side less than this is hidden: flying points, and points seen past an edge from
# beside the nearest tested direction. Of 62 views of boxes none hides more than 0.5 %; of
# noisy samples all over furniture the least, tables of one thin sheet on four legs, hide 1.3 %.
HIDDEN_ALL_ROUND = 0.01


def covers_all_sides(points: FloatArray, *, noise: float, spacing: float) -> bool:
    """Return whether more of points (n, 3) is hidden from every direction than in a view from one
    side.
    """
    return compute_least_hidden(points, noise=noise, spacing=spacing) > HIDDEN_ALL_ROUND


def compute_least_hidden(points: FloatArray, *, noise: float, spacing: float) -> float:
    """Return the share of points (n, 3) hidden behind others, from the direction where it is
    smallest.

    `noise` is the sd of a point off its surface, `spacing` the typical distance between points.
    """
    width = max(CELL_SPACINGS * spacing, 1e-300)
    gap = max(GAP_SDS * noise, GAP_CELLS * width)
    shares = [
        share
        for way in make_even_directions(DIRECTIONS, lowest=0.0)
        for share in _hidden(points, way, width, gap)
    ]
    return min(shares)


def make_even_directions(count: int, lowest: float = -1.0) -> FloatArray:
    """Return `count` unit vectors (count, 3) evenly over the sphere above a height, along a
    spiral.
    """
    nth = np.arange(count)
    height = lowest + (1.0 - lowest) * (nth + 0.5) / count
    radius = np.sqrt(1.0 - height**2)
    turn = GOLDEN_TURN * nth
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height])


def _hidden(points: FloatArray, way: FloatArray, width: float, gap: float) -> tuple[float, float]:
    """Return shares of points hidden when seen along the direction `way`, and against it."""
    flat = points @ make_plane_axes(way, np.roll(way, 1)).T
    cells = np.floor((flat - flat.min(axis=0)) / width).astype(np.int64)
    cell = cells[:, 0] * (int(cells[:, 1].max()) + 1) + cells[:, 1]
    depth = points @ way
    order = np.lexsort((depth, cell))
    cell, depth = cell[order], depth[order]
    first = np.append(True, cell[1:] != cell[:-1])
    # the runs of points without a gap in depth: the first and the last of a cell lie open
    breaks = first | np.append(True, np.diff(depth) > gap)
    run = np.cumsum(breaks) - 1
    sizes = np.bincount(run)
    front: NDArray[np.bool_] = first[breaks]
    back = np.append(front[1:], True)
    return float(sizes[~front].sum()) / len(points), float(sizes[~back].sum()) / len(points)


@dataclass(frozen=True, eq=False, slots=True)
class Sheet:
    """A face that lines of sight end at: its plane, and what it surely covers, in the plane."""

    plane: Plane
    axes: FloatArray
    covered: shapely.Geometry
    share: float


def find_sheets(
    outlines: Sequence[Outline],
    planes: Sequence[Plane],
    *,
    noise: float,
    spacing: FloatArray,
) -> tuple[Sheet, ...]:
    """Return the faces of a cloud, less their rims; `planes` of each outline, `spacing` (n,) of
    each point.
    """
    sheets = []
    for outline, plane in zip(outlines, planes, strict=True):
        axes = make_plane_axes(plane.normal, np.roll(plane.normal, 1))
        polygon = PlaneFrame(np.zeros(3), axes).polygon(outline.outline, outline.holes)
        apart = float(np.median(spacing[outline.members]))
        covered = polygon.buffer(-(RIM_SPACINGS * apart + OFF_PLANE_SDS * noise))
        shapely.prepare(covered)
        sheets.append(Sheet(plane, axes, covered, len(outline.members) / len(spacing)))
    return tuple(sheets)


@dataclass(frozen=True, eq=False, slots=True)
class SightTest:
    """The sheets of a cloud; noise and spacing; the floor's level if known."""

    sheets: tuple[Sheet, ...]
    noise: float
    spacing: float
    level: Up | None

    @property
    def _margin(self) -> float:
        return OFF_PLANE_SDS * self.noise + self.spacing

    def is_possible(self, place: FloatArray) -> bool:
        """Return whether a sensor could be at a place (3,): in none of the large faces, above the
        floor.

        A sensor that was moved to a place in a face's plane would see the face from its edge.
        """
        for sheet in self.sheets:
            if sheet.share < LEAST_SHARE:
                continue
            if abs(float(sheet.plane.distance(place))) <= self._margin:
                return False
        if self.level is None or self.level.floor is None:
            return True
        floor = self.sheets[self.level.floor].plane
        sign = 1.0 if float(floor.normal @ self.level.direction) > 0.0 else -1.0
        return sign * float(floor.distance(place)) > 0.0

    def find_hidden(self, points: FloatArray, place: FloatArray) -> NDArray[np.bool_]:
        """Return whether each of points (n, 3) is behind a face as seen from a place (3,)."""
        hidden = np.zeros(len(points), dtype=bool)
        for sheet in self.sheets:
            ahead = float(sheet.plane.distance(place))
            if sheet.covered.is_empty or not ahead:
                continue
            behind = np.copysign(1.0, ahead) * sheet.plane.distance(points)
            met = np.flatnonzero((behind < -self._margin) & ~hidden)
            share = abs(ahead) / (abs(ahead) - behind[met])
            # where the line of sight crosses the plane, axis by axis
            spots = [
                start + share * ((points @ axis)[met] - start)
                for axis, start in zip(sheet.axes, sheet.axes @ place, strict=True)
            ]
            inside = np.ones(len(met), dtype=bool)
            bounds = np.reshape(sheet.covered.bounds, (2, 2))
            for spot, low, high in zip(spots, *bounds, strict=True):
                inside &= (spot >= low) & (spot <= high)
            x, y = (spot[inside] for spot in spots)
            hidden[met[inside][shapely.contains_xy(sheet.covered, x, y)]] = True
        return hidden


@dataclass(frozen=True, eq=False, slots=True)
class View:
    """From where a cloud was seen, as far as its lines of sight agree with it.

    `seen_from` (n, 3) as of a Cloud; `partly` are the objects of which more is hidden from there
    than in a scan from one place, as of several scans that were merged; `refused` are places
    (k, 3) that the file or user gave and that none of the points was seen from.
    """

    seen_from: FloatArray | None
    partly: tuple[int, ...] = ()
    refused: tuple[FloatArray, ...] = ()


def find_view(
    cloud: Cloud, looked: NDArray[np.intp], bodies: NDArray[np.intp], test: SightTest
) -> View:
    """Return from where the points of a cloud were seen.

    It is tested on the rows `looked` (k,), of the objects `bodies` (k,). Of a file's candidates it
    is the first with which all lines of sight agree. Of places that the user states, points that
    are hidden from there were seen from elsewhere.
    """
    if cloud.seen_from is not None:
        # rows and columns of an organised cloud determine the place: where it may be is no question
        is_sure = cloud.sensor_places is not None
        return _check_stated(cloud.points, cloud.seen_from, looked, bodies, test, is_sure=is_sure)
    if cloud.sensor_places is None:
        return View(None)
    points = cloud.points[looked]
    for place in cloud.sensor_places:
        if test.is_possible(place) and not _find_partly_seen(
            test.find_hidden(points, place), bodies
        ):
            return View(np.broadcast_to(place, cloud.points.shape))
    return View(None, refused=tuple(cloud.sensor_places))


def _check_stated(
    points: FloatArray,
    seen_from: FloatArray,
    looked: NDArray[np.intp],
    bodies: NDArray[np.intp],
    test: SightTest,
    *,
    is_sure: bool,
) -> View:
    known = np.isfinite(seen_from).all(axis=1)
    first, of_place = find_distinct(number_rows(seen_from[known]))
    places = seen_from[known][first]
    if not 0 < len(places) <= MOST_PLACES:
        return View(seen_from)
    refused = [not (is_sure or test.is_possible(place)) for place in places]
    kept = seen_from.copy()
    kept[np.flatnonzero(known)[np.isin(of_place, np.flatnonzero(refused))]] = np.nan
    partly = _find_partly_seen(_find_all_hidden(test, points[looked], kept[looked]), bodies)
    if partly:
        kept[_find_all_hidden(test, points, kept)] = np.nan
    return View(kept, () if is_sure else partly, tuple(places[refused]))


def _find_all_hidden(
    test: SightTest, points: FloatArray, seen_from: FloatArray
) -> NDArray[np.bool_]:
    """Return whether each of points (n, 3) is behind a face as seen from its place (n, 3)."""
    hidden = np.zeros(len(points), dtype=bool)
    known = np.flatnonzero(np.isfinite(seen_from).all(axis=1))
    for rows in iter_groups(number_rows(seen_from[known])):
        own = known[rows]
        hidden[own] = test.find_hidden(points[own], seen_from[own[0]])
    return hidden


def _find_partly_seen(hidden: NDArray[np.bool_], bodies: NDArray[np.intp]) -> tuple[int, ...]:
    """Return the objects, -1 for the ground, of which more points are hidden than noise can
    hide.
    """
    counts, behind = np.bincount(bodies + 1), np.bincount(bodies[hidden] + 1)
    most = np.maximum(HIDDEN_POINTS, HIDDEN_SHARE * counts[: len(behind)])
    return tuple((np.flatnonzero(behind > most) - 1).tolist())
