"""A cloud as flat regions and the rest: planes, outlines, objects, floor and outer sides."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.flat_faces import plane_axes
from facetlog.perception.polygons import make_polygon
from facetlog.perception.reading.shape_files.clouds.point_cloud import Cloud
from facetlog.perception.scene import Plane
from facetlog.perception.shapes.clouds.all_sides import covers_all_sides, things_round_a_sensor
from facetlog.perception.shapes.clouds.cloud_levels import levels_by_height
from facetlog.perception.shapes.clouds.cloud_outlines import Outline, cloud_outlines
from facetlog.perception.shapes.clouds.cloud_planes import (
    CloudPlane,
    CloudPlanes,
    cloud_planes,
    least_squares_plane,
)
from facetlog.perception.shapes.clouds.cloud_sides import Surroundings, outer_sides
from facetlog.perception.shapes.clouds.lines_of_sight import (
    SightTest,
    View,
    find_sheets,
    find_view,
)
from facetlog.perception.shapes.regions.flat_region import FlatRegion, Rest
from facetlog.perception.shapes.regions.point_bodies import cluster_bodies, is_scatter, majority
from facetlog.perception.shapes.regions.up_direction import (
    HELD_OTHERWISE,
    Up,
    find_up,
    up_from_cameras,
)
from facetlog.perception.types import FloatArray

# A face's own points are within so many sd of its plane: none of a million is further.
NOISE_SDS = 5.0
# Its outline runs amid the noise of its rim: points beyond are within so many sd of it, and one
# spacing, since an outline is that jagged.
RIM_SDS = 4.0


def off_faces(
    points: FloatArray,
    bodies: NDArray[np.intp],
    regions: Iterable[FlatRegion],
    *,
    noise: float,
    spacing: float,
) -> NDArray[np.bool_]:
    """Whether each of points (n, 3) is off its object's faces by more than noise makes it, (n,).

    `bodies` (n,) numbers the object of each point, as regions do; `noise` is the sd of a point off
    its surface, where a region's own is not more, `spacing` the typical distance between points. A
    thing's extent is that of its faces, not of their outliers.
    """
    off = np.ones(len(points), dtype=bool)
    for region in regions:
        sd = max(noise, region.noise)
        gaps = np.abs(region.plane.distance(points))
        near = np.flatnonzero(off & (bodies == region.body) & (gaps <= NOISE_SDS * sd))
        start = region.outline[0]
        axes = plane_axes(region.plane.normal, region.outline[1] - start)
        loops = [(loop - start) @ axes.T for loop in (region.outline, *region.holes)]
        polygon = make_polygon(loops[0], loops[1:])
        wide = polygon.buffer(RIM_SDS * sd + spacing)
        shapely.prepare(wide)
        x, y = ((points[near] - start) @ axes.T).T
        off[near[shapely.contains_xy(wide, x, y)]] = False
    return off


# So many points are enough to separate floor, objects and sides; more only take longer.
MOST_LOOKED_AT = 20_000
# The rest of the surface is thinned to so many points, each with more area.
MOST_REST = 5_000
# A face within 20 degrees of level is one for what stands on it (cosine).
LEVEL_ENOUGH = float(np.cos(np.deg2rad(20.0)))

SENSOR_WITHIN = (
    "the place that the points were seen from is inside a thing, whose outside cannot be seen from "
    "there: give --sensor X,Y,Z where the scanner stood, or scan it from outside; or it is a room "
    "with next to nothing in it, and all is well"
)


@dataclass(frozen=True, eq=False, slots=True)
class CloudRegions:
    """Flat regions and the rest of a cloud; up (3,) if it is known; whether it goes all round.

    `seen_from` (n, 3) as of the cloud, as far as its lines of sight agree with it.
    """

    regions: tuple[FlatRegion, ...]
    rest: Rest
    up: FloatArray | None
    whole: bool
    warnings: tuple[str, ...]
    seen_from: FloatArray | None


def cloud_regions(
    cloud: Cloud, *, up: FloatArray | None = None, metric: bool = False
) -> CloudRegions:
    """Return the flat regions and the rest of a cloud; `up` is a unit vector where it is known, and
    `metric` says that lengths are metres.
    """
    found = cloud_planes(cloud.points)
    outlines = cloud_outlines(cloud.points, found)
    owner = np.full(len(cloud.points), -1)
    for number, outline in enumerate(outlines):
        owner[outline.members] = number
    looked, stretch = _some_rows(np.arange(len(cloud.points)))
    spacing = float(np.median(found.spacing)) * stretch
    planes = [found.planes[outline.region].plane for outline in outlines]
    noise = np.array([max(found.noise, found.planes[o.region].rms) for o in outlines])
    if up is not None and cloud.world_axes is not None:
        up = _up_of_points(up, cloud, outlines, planes)
    level = _up(cloud, found, outlines, owner, looked, spacing, up, metric)
    around = () if level is None or level.floor is None else (level.floor, *level.around)
    on_things = ~np.isin(owner, around)
    if around and on_things.any():
        # a large floor leaves few points of the things
        things, stretch = _some_rows(np.flatnonzero(on_things))
        looked = np.sort(np.concatenate([things, looked[~on_things[looked]]]))
        spacing = float(np.median(found.spacing[things])) * stretch
    bodies = np.full(len(cloud.points), -1)
    bodies[looked] = cluster_bodies(cloud.points[looked], owner[looked], spacing, support=around)
    body_of = [
        -1 if n in around else majority(bodies[looked][owner[looked] == n])
        for n in range(len(outlines))
    ]
    about = Surroundings(
        cloud.points[looked],
        owner[looked],
        bodies[looked],
        noise,
        spacing,
        None if cloud.normals is None else cloud.normals[looked],
    )
    direction = None if level is None else level.direction
    view = _view(cloud, found, outlines, planes, level, looked, bodies)
    if view.seen_from is not None:
        about = replace(about, seen_from=view.seen_from[looked], partly=view.partly)
    about, round_sensor = _seen_from_outside(about, direction)
    sides = outer_sides(planes, body_of, about, around=around, up=direction)
    if sides.is_place_wrong and view.seen_from is not None:
        known = np.isfinite(view.seen_from).all(axis=1)
        view = View(None, refused=tuple(np.unique(view.seen_from[known], axis=0)))
    regions = _regions(outlines, planes, sides.signs.tolist(), body_of, noise)
    whole = not round_sensor
    whole = whole and _covered(cloud.points[looked], bodies[looked], found.noise, spacing)
    if whole and direction is not None:
        levels, on_levels = _levels(cloud, found, about, looked, stretch, regions, direction)
        regions = (*regions, *levels)
        owner[on_levels] = len(regions)  # they are not of the rest
    said = () if level is None or up is not None else (level.how,)
    if sides.wrong_normals and cloud.normals is not None:
        believed = ~np.isin(bodies, sides.wrong_normals)
        cloud = replace(cloud, normals=cloud.normals * believed[:, None])
    rest = _rest(cloud, found, regions, owner, looked, bodies, stretch)
    said = (*said, *((SENSOR_WITHIN,) if round_sensor else _refusals(view)))
    return CloudRegions(regions, rest, direction, whole, (*cloud.warnings, *said), view.seen_from)


def _view(
    cloud: Cloud,
    found: CloudPlanes,
    outlines: tuple[Outline, ...],
    planes: list[Plane],
    level: Up | None,
    looked: NDArray[np.intp],
    bodies: NDArray[np.intp],
) -> View:
    """Return from where the cloud was seen, as its faces allow."""
    if cloud.seen_from is None and cloud.sensor_places is None:
        return View(None)
    sheets = find_sheets(outlines, planes, noise=found.noise, spacing=found.spacing)
    test = SightTest(sheets, found.noise, float(np.median(found.spacing)), level)
    return find_view(cloud, looked, bodies[looked], test)


def _refusals(view: View) -> tuple[str, ...]:
    """Return a warning of places that were given and are not believed."""
    if not view.refused:
        return ()
    places = " or ".join("({:g}, {:g}, {:g})".format(*place) for place in view.refused[:3])
    return (
        f"points were not seen from {places}: lines of sight from there go through faces, or begin "
        "in or below one; from where is unknown: give --sensor X,Y,Z if you know it",
    )


def _up_of_points(
    up: FloatArray, cloud: Cloud, outlines: tuple[Outline, ...], planes: list[Plane]
) -> FloatArray:
    """Return the up that was given in the frame of the points, of a file with a sensor's pose.

    It is meant in the world's frame and the points are in the sensor's if more of the surface is
    level then, and below the sensor.
    """
    places = np.zeros((1, 3)) if cloud.sensor_places is None else cloud.sensor_places
    turned = up if cloud.world_axes is None else up @ cloud.world_axes

    def count_level(way: FloatArray) -> int:
        level = 0
        for outline, plane in zip(outlines, planes, strict=True):
            rise = float(plane.normal @ way)
            if abs(rise) >= LEVEL_ENOUGH and (np.sign(rise) * plane.distance(places) > 0.0).any():
                level += len(outline.members)
        return level

    return turned if count_level(turned) > count_level(up) else up


def _seen_from_outside(about: Surroundings, up: FloatArray | None) -> tuple[Surroundings, bool]:
    """Of things that go round a sensor it is not known from where they were seen; whether there
    is one.
    """
    found = things_round_a_sensor(about.points, about.bodies, about.seen_from, up)
    if about.seen_from is None or not found:
        return about, False
    seen_from = np.where(np.isin(about.bodies, found)[:, None], np.nan, about.seen_from)
    return replace(about, seen_from=seen_from), True


def _covered(points: FloatArray, bodies: NDArray[np.intp], noise: float, spacing: float) -> bool:
    """Whether points go round each object: of two seen from one side, one may hide the other."""
    numbers = np.unique(bodies[bodies >= 0])
    return len(numbers) > 0 and all(
        covers_all_sides(points[bodies == body], noise=noise, spacing=spacing) for body in numbers
    )


def _some_rows(rows: NDArray[np.intp]) -> tuple[NDArray[np.intp], float]:
    """Return the rows, or 20,000 of them at random, and how much further apart these are."""
    if len(rows) <= MOST_LOOKED_AT:
        return rows, 1.0
    some = np.random.default_rng(0).permutation(len(rows))[:MOST_LOOKED_AT]
    return rows[np.sort(some)], float(np.sqrt(len(rows) / MOST_LOOKED_AT))


def _up(
    cloud: Cloud,
    found: CloudPlanes,
    outlines: tuple[Outline, ...],
    owner: NDArray[np.intp],
    looked: NDArray[np.intp],
    spacing: float,
    up: FloatArray | None,
    metric: bool,
) -> Up | None:
    """Up as given, by the floor, or by the cameras; with the floor's number if there is one.

    A floor that is level by the cameras is preferred to others, which may be walls; but cameras
    that look straight down are held with their up along the floor, so any floor is preferred to
    cameras.
    """
    held = None if cloud.camera_ups is None else up_from_cameras(cloud.camera_ups)
    rough = up if up is not None else None if held is None else held.direction
    planes = [found.planes[outline.region].plane for outline in outlines]
    points, owners = cloud.points[looked], owner[looked]
    # where lines of sight say which side of a wall is seen, a room's corner is one
    metric = metric and cloud.seen_from is None and cloud.sensor_places is None
    level = find_up(
        points, owners, planes, noise=found.noise, spacing=spacing, up=rough, metric=metric
    )
    if level is None and up is not None:
        return Up(up, None, "up was given")
    if level is None and held is not None:
        level = find_up(points, owners, planes, noise=found.noise, spacing=spacing)
        if level is not None:
            level = replace(level, how=HELD_OTHERWISE)
    if level is None:
        return held
    if up is None and level.floor is not None:
        # the floor is a better level than the cameras are
        plane = planes[level.floor]
        sign = 1.0 if float(plane.normal @ level.direction) > 0.0 else -1.0
        return replace(level, direction=sign * plane.normal)
    return level


def _regions(
    outlines: tuple[Outline, ...],
    planes: list[Plane],
    signs: list[int],
    body_of: list[int],
    noise: FloatArray,
) -> tuple[FlatRegion, ...]:
    """Return the outlines as regions that look outwards, by the sign of each."""
    regions = []
    rows = zip(outlines, planes, signs, body_of, noise.tolist(), strict=True)
    for outline, plane, sign, body, sd in rows:
        loops = (outline.outline, *outline.holes)
        if sign < 0:
            plane, loops = plane.flipped(), tuple(loop[::-1] for loop in loops)
        regions.append(FlatRegion(plane, loops[0], loops[1:], outline.corner_sd, body, sd))
    return tuple(regions)


def _levels(
    cloud: Cloud,
    found: CloudPlanes,
    about: Surroundings,
    looked: NDArray[np.intp],
    stretch: float,
    regions: tuple[FlatRegion, ...],
    up: FloatArray,
) -> tuple[tuple[FlatRegion, ...], NDArray[np.intp]]:
    """Level regions that look up and are not among `regions` yet, and their points' rows."""
    rises = np.array([region.plane.normal @ up for region in regions] + [0.0])
    known = rises[about.owner] >= LEVEL_ENOUGH
    sheets, body_of = [], []
    for body in range(int(about.bodies.max(initial=-1)) + 1):
        own = np.flatnonzero(about.bodies == body)
        for members in levels_by_height(
            about.points[own], up, known[own], noise=found.noise, spacing=about.spacing
        ):
            rows = looked[own[members]]
            plane, rms = least_squares_plane(cloud.points[rows])
            sign = 1.0 if float(plane.normal @ up) > 0.0 else -1.0
            sheets.append(CloudPlane(plane if sign > 0.0 else plane.flipped(), rows, rms))
            body_of.append(body)
    # these points alone are as far apart as those that were looked at
    count = len(found.planes)
    both = replace(
        found, planes=(*found.planes, *sheets), spacing=np.asarray(found.spacing * stretch)
    )
    outlines = cloud_outlines(cloud.points, both, first=count) if sheets else ()
    levels = tuple(
        FlatRegion(
            sheets[outline.region - count].plane,
            outline.outline,
            outline.holes,
            outline.corner_sd,
            body_of[outline.region - count],
            sheets[outline.region - count].rms,
        )
        for outline in outlines
    )
    none = np.zeros(0, dtype=np.intp)
    return levels, np.concatenate([none, *(outline.members for outline in outlines)])


def _rest(
    cloud: Cloud,
    found: CloudPlanes,
    regions: tuple[FlatRegion, ...],
    owner: NDArray[np.intp],
    looked: NDArray[np.intp],
    bodies: NDArray[np.intp],
    stretch: float,
) -> Rest:
    """Points of no region that are of an object's surface, with the area that each stands for.

    Those that a face's noise explains may still close a gap between faces, but stand for no area.
    """
    unowned = (owner[looked] < 0) & (bodies[looked] >= 0)
    spacing = float(np.median(found.spacing))
    scatter = is_scatter(cloud.points[looked], bodies[looked], unowned, spacing * stretch)
    free = looked[unowned & ~scatter]
    areas = (found.spacing[free] * stretch) ** 2
    if len(free) > MOST_REST:
        kept = np.sort(np.random.default_rng(0).permutation(len(free))[:MOST_REST])
        free, areas = free[kept], areas[kept] * (len(free) / MOST_REST)
    off = off_faces(cloud.points[free], bodies[free], regions, noise=found.noise, spacing=spacing)
    areas[~off] = 0.0  # noise of faces, whose area counts already
    normals = np.zeros((len(free), 3)) if cloud.normals is None else cloud.normals[free]
    return Rest(cloud.points[free], normals, areas, bodies[free].astype(np.float64))
