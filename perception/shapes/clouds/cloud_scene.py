"""A point cloud as a scene: strays → planes → outlines → up → objects → outer sides → scene."""

from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import KDTree

from facetlog.perception.ragged import find_distinct, iter_groups, number_rows, unique_rows
from facetlog.perception.reading.shape_files.clouds.point_cloud import LEAST_POINTS, Cloud
from facetlog.perception.scene import Plane, Scene, SightLines
from facetlog.perception.shapes.clouds.cloud_outlines import Outline, cloud_outlines
from facetlog.perception.shapes.clouds.cloud_planes import (
    CloudPlane,
    CloudPlanes,
    cloud_planes,
    fit_least_squares_plane,
)
from facetlog.perception.shapes.clouds.cloud_sides import (
    Surroundings,
    find_levels_by_height,
    find_outer_sides,
)
from facetlog.perception.shapes.clouds.lines_of_sight import (
    SightTest,
    View,
    covers_all_sides,
    find_sheets,
    find_things_round_sensor,
    find_view,
)
from facetlog.perception.shapes.clouds.neighbourhoods import find_k_nearest
from facetlog.perception.shapes.regions.flat_region import FlatRegion, Rest
from facetlog.perception.shapes.regions.floor_and_walls import (
    HELD_OTHERWISE,
    FacedSurface,
    Up,
    find_up,
    find_up_from_cameras,
)
from facetlog.perception.shapes.regions.point_bodies import (
    cluster_bodies,
    group_sizes,
    is_scatter,
    majority,
)
from facetlog.perception.shapes.regions.scene_from_regions import assemble_scene, make_unit_vector
from facetlog.perception.types import FloatArray

# A face's own points are within so many sd of its plane: none of a million is further.
NOISE_SDS = 5.0
# Its outline runs amid the noise of its rim: points beyond are within so many sd of it, and one
# spacing, since an outline is that jagged.
RIM_SDS = 4.0


def find_points_off_faces(
    points: FloatArray,
    bodies: NDArray[np.intp],
    regions: Iterable[FlatRegion],
    *,
    noise: float,
    spacing: float,
) -> NDArray[np.bool_]:
    """Return whether each of points (n, 3) is off its object's faces by more than noise makes it,
    (n,).

    `bodies` (n,) numbers the object of each point, as regions do; `noise` is the sd of a point off
    its surface, where a region's own is not more, `spacing` the typical distance between points. A
    thing's extent is that of its faces, not of their outliers.
    """
    off = np.ones(len(points), dtype=bool)
    for region in regions:
        sd = max(noise, region.noise)
        gaps = np.abs(region.plane.distance(points))
        near = np.flatnonzero(off & (bodies == region.body) & (gaps <= NOISE_SDS * sd))
        frame = region.frame
        polygon = frame.polygon(region.outline, region.holes)
        wide = polygon.buffer(RIM_SDS * sd + spacing)
        shapely.prepare(wide)
        x, y = frame.flatten(points[near]).T
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
class _Work:
    """A cloud of n points with its faces: `owner` (n,) numbers the outline of each point, -1: none.

    `planes` are those of the outlines. The rows `looked` (k,) of the points are looked at, which
    lie `stretch` times as far apart as all, `spacing`.
    """

    cloud: Cloud
    found: CloudPlanes
    outlines: tuple[Outline, ...]
    planes: list[Plane]
    owner: NDArray[np.intp]
    looked: NDArray[np.intp]
    stretch: float

    @classmethod
    def of(cls, cloud: Cloud) -> "_Work":
        """Find the faces of a cloud."""
        found = cloud_planes(cloud.points)
        outlines = cloud_outlines(cloud.points, found)
        owner = np.full(len(cloud.points), -1)
        for number, outline in enumerate(outlines):
            owner[outline.members] = number
        planes = [found.planes[outline.region].plane for outline in outlines]
        looked, stretch = _choose_rows(np.arange(len(cloud.points)))
        return cls(cloud, found, outlines, planes, owner, looked, stretch)

    def look_off(self, around: Collection[int]) -> tuple["_Work", float]:
        """Return the work with rows that are mostly off the faces `around` things, and their
        spacing: a large floor leaves few points of the things.
        """
        on_things = ~np.isin(self.owner, list(around))
        if not around or not on_things.any():
            return self, float(np.median(self.found.spacing)) * self.stretch
        things, stretch = _choose_rows(np.flatnonzero(on_things))
        looked = np.sort(np.concatenate([things, self.looked[~on_things[self.looked]]]))
        spacing = float(np.median(self.found.spacing[things])) * stretch
        return replace(self, looked=looked, stretch=stretch), spacing

    def find_up(self, up: FloatArray | None, *, metric: bool) -> Up | None:
        """Return up as given, by the floor, or by the cameras; with the floor's number if there is
        one.

        A floor that is level by the cameras is preferred to others, which may be walls; but cameras
        that look straight down are held with their up along the floor, so any floor is preferred to
        cameras.
        """
        cloud = self.cloud
        held = None if cloud.camera_ups is None else find_up_from_cameras(cloud.camera_ups)
        rough = up if up is not None else None if held is None else held.direction
        # where lines of sight say which side of a wall is seen, a room's corner is one
        metric = metric and cloud.seen_from is None and cloud.sensor_places is None
        surface = FacedSurface.of(
            cloud.points[self.looked],
            self.owner[self.looked],
            self.planes,
            noise=self.found.noise,
            spacing=float(np.median(self.found.spacing)) * self.stretch,
        )
        level = find_up(surface, rough, metric=metric)
        if level is None and up is not None:
            return Up(up, None, "up was given")
        if level is None and held is not None:
            level = find_up(surface)
            if level is not None:
                level = replace(level, how=HELD_OTHERWISE)
        if level is None:
            return held
        if up is None and level.floor is not None:
            # the floor is a better level than the cameras are
            plane = self.planes[level.floor]
            sign = 1.0 if float(plane.normal @ level.direction) > 0.0 else -1.0
            return replace(level, direction=sign * plane.normal)
        return level

    def turn_up(self, up: FloatArray) -> FloatArray:
        """Return the up that was given in the frame of the points, of a file with a sensor's pose.

        It is meant in the world's frame and the points are in the sensor's if more of the surface
        is level then, and below the sensor.
        """
        cloud = self.cloud
        if cloud.world_axes is None:
            return up
        places = np.zeros((1, 3)) if cloud.sensor_places is None else cloud.sensor_places
        turned = up @ cloud.world_axes

        def count_level(way: FloatArray) -> int:
            level = 0
            for outline, plane in zip(self.outlines, self.planes, strict=True):
                rise = float(plane.normal @ way)
                seen = (np.sign(rise) * plane.distance(places) > 0.0).any()
                if abs(rise) >= LEVEL_ENOUGH and seen:
                    level += len(outline.members)
            return level

        return turned if count_level(turned) > count_level(up) else up

    def find_view(self, level: Up | None, bodies: NDArray[np.intp]) -> View:
        """Return from where the cloud was seen, as its faces allow."""
        if self.cloud.seen_from is None and self.cloud.sensor_places is None:
            return View(None)
        noise, spacing = self.found.noise, self.found.spacing
        sheets = find_sheets(self.outlines, self.planes, noise=noise, spacing=spacing)
        test = SightTest(sheets, noise, float(np.median(spacing)), level)
        return find_view(self.cloud, self.looked, bodies, test)

    def find_levels(
        self, about: Surroundings, regions: tuple[FlatRegion, ...], up: FloatArray
    ) -> tuple[tuple[FlatRegion, ...], NDArray[np.intp]]:
        """Return level regions that look up and are not among `regions` yet, and the rows of their
        points.
        """
        points, found = self.cloud.points, self.found
        rises = np.array([region.plane.normal @ up for region in regions] + [0.0])
        known = rises[about.owner] >= LEVEL_ENOUGH
        sheets, body_of = [], []
        for body in range(int(about.bodies.max(initial=-1)) + 1):
            own = np.flatnonzero(about.bodies == body)
            for members in find_levels_by_height(
                about.points[own], up, known[own], noise=found.noise, spacing=about.spacing
            ):
                rows = self.looked[own[members]]
                plane, rms = fit_least_squares_plane(points[rows])
                upwards = float(plane.normal @ up) > 0.0
                sheets.append(CloudPlane(plane if upwards else plane.flipped(), rows, rms))
                body_of.append(body)
        # these points alone are as far apart as those that were looked at
        count = len(found.planes)
        spacing = np.asarray(found.spacing * self.stretch)
        both = replace(found, planes=(*found.planes, *sheets), spacing=spacing)
        outlines = cloud_outlines(points, both, first=count) if sheets else ()
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

    def rest(
        self,
        regions: tuple[FlatRegion, ...],
        bodies: NDArray[np.intp],
        normals: FloatArray | None,
    ) -> Rest:
        """Return points of no region that are of an object's surface, with the area of each.

        Those that a face's noise explains may still close a gap between faces, but stand for no
        area. `bodies` (k,) are of the rows that are looked at, `normals` (n, 3) of all points.
        """
        points, looked = self.cloud.points, self.looked
        unowned = (self.owner[looked] < 0) & (bodies >= 0)
        spacing = float(np.median(self.found.spacing))
        scatter = is_scatter(points[looked], bodies, unowned, spacing * self.stretch)
        kept = np.flatnonzero(unowned & ~scatter)
        areas = (self.found.spacing[looked[kept]] * self.stretch) ** 2
        if len(kept) > MOST_REST:
            some = np.sort(np.random.default_rng(0).permutation(len(kept))[:MOST_REST])
            areas = areas[some] * (len(kept) / MOST_REST)
            kept = kept[some]
        free, own = looked[kept], bodies[kept]
        off = find_points_off_faces(
            points[free], own, regions, noise=self.found.noise, spacing=spacing
        )
        areas[~off] = 0.0  # noise of faces, whose area counts already
        outwards = np.zeros((len(free), 3)) if normals is None else normals[free]
        return Rest(points[free], outwards, areas, own.astype(np.float64))


def _refusals(view: View) -> tuple[str, ...]:
    """Return a warning of places that were given and are not believed."""
    if not view.refused:
        return ()
    places = " or ".join("({:g}, {:g}, {:g})".format(*place) for place in view.refused[:3])
    return (
        f"points were not seen from {places}: lines of sight from there go through faces, or begin "
        "in or below one; from where is unknown: give --sensor X,Y,Z if you know it",
    )


def _forget_inner_sensor(about: Surroundings, up: FloatArray | None) -> tuple[Surroundings, bool]:
    """Forget from where things that go round a sensor were seen; return whether there
    is one.
    """
    found = find_things_round_sensor(about.points, about.bodies, about.seen_from, up)
    if about.seen_from is None or not found:
        return about, False
    seen_from = np.where(np.isin(about.bodies, found)[:, None], np.nan, about.seen_from)
    return replace(about, seen_from=seen_from), True


def _covered(points: FloatArray, bodies: NDArray[np.intp], noise: float, spacing: float) -> bool:
    """Return whether points go round each object: of two seen from one side, one may hide the
    other.
    """
    numbers = np.unique(bodies[bodies >= 0])
    return len(numbers) > 0 and all(
        covers_all_sides(points[bodies == body], noise=noise, spacing=spacing) for body in numbers
    )


def _choose_rows(rows: NDArray[np.intp]) -> tuple[NDArray[np.intp], float]:
    """Return the rows, or 20,000 of them at random, and how much further apart these are."""
    if len(rows) <= MOST_LOOKED_AT:
        return rows, 1.0
    some = np.random.default_rng(0).permutation(len(rows))[:MOST_LOOKED_AT]
    return rows[np.sort(some)], float(np.sqrt(len(rows) / MOST_LOOKED_AT))


# Lines of sight to a radian at least, as many as a picture has (surfaces/seeing/seen_faces.py).
PER_RADIAN = 40.0
# Across what was seen from a place there are so many where points are dense: three for each cell of
# the space of a thing that fills it. A direction has so many points then, or more.
ACROSS = 128
POINTS_OF_LINE = 4


def make_scan_sights(cloud: Cloud) -> tuple[SightLines, ...]:
    """Return the lines of sight from each place that the cloud's points were seen from.

    Of all points in about one direction the nearest is kept: the space in front of it is free.
    """
    if cloud.seen_from is None:
        return ()
    known = np.isfinite(cloud.seen_from).all(axis=1)
    if not known.any():
        return ()
    points = cloud.points[known]
    seen_from = cloud.seen_from[known]
    found = []
    for rows in iter_groups(number_rows(seen_from)):
        place = seen_from[rows[0]]
        seen = points[rows]
        rays = seen - place
        away = np.linalg.norm(rays, axis=1)
        ahead = away > 0
        seen, rays, away = seen[ahead], rays[ahead], away[ahead]
        nearest_first = np.argsort(away, kind="stable")
        ways = rays / away[:, None]
        direction = np.rint(_count_per_radian(ways) * ways).astype(np.int64)[nearest_first]
        first = find_distinct(number_rows(direction))[0]
        if len(first):
            found.append(SightLines(place, seen[nearest_first[np.sort(first)]]))
    return tuple(found)


def _count_per_radian(ways: FloatArray) -> float:
    """Return how many lines of sight to a radian there are among the directions (n, 3) of
    points.
    """
    if not len(ways):
        return PER_RADIAN
    extent = float(np.ptp(ways, axis=0).max())
    across = min(ACROSS, float(np.sqrt(len(ways) / POINTS_OF_LINE)))
    return max(PER_RADIAN, across / max(extent, 1.0 / PER_RADIAN))


# One such point among thousands widens what is measured by a hull or by the farthest point, and
# its line of sight ends in the air. Radius outlier removal: R. B. Rusu, "Semantic 3D Object Maps",
# 2009.

# Fewer points than this together are no surface; a point's density is that of so many neighbours.
GROUP = 8
# Points on one surface are within so many spacings of the next, even where the surface is seen at a
# glance, or four times as far away as most.
REACH_SPACINGS = 12.0
# Points from which the spacing is judged: the median of so many is good to 3 %.
SAMPLE = 500


def drop_strays(cloud: Cloud) -> Cloud:
    """Return the cloud without the points that lie alone, and with a warning that counts them."""
    stray = find_strays(cloud.points)
    count = int(stray.sum())
    if not count or len(stray) - count < LEAST_POINTS:
        return cloud
    rows = np.flatnonzero(~stray)
    normals, seen_from, errors = (
        None if values is None else values[rows]
        for values in (cloud.normals, cloud.seen_from, cloud.errors)
    )
    said = f"{count} of {len(stray)} points left out: they lie alone, far from any surface"
    return replace(
        cloud,
        points=cloud.points[rows],
        normals=normals,
        seen_from=seen_from,
        errors=errors,
        warnings=(*cloud.warnings, said),
    )


def find_strays(points: FloatArray) -> NDArray[np.bool_]:
    """Return which of points (n, 3) are in groups of fewer than 8, far from all others, (n,)."""
    if len(points) <= GROUP:
        return np.zeros(len(points), dtype=bool)
    sample = np.random.default_rng(0).permutation(len(points))[:SAMPLE]
    far = find_k_nearest(KDTree(points), points[sample], GROUP + 1)[0][:, -1]
    spacing = float(np.median(far)) * np.sqrt(np.pi / GROUP)
    if not spacing > 0.0:
        return np.zeros(len(points), dtype=bool)
    alone: NDArray[np.bool_] = group_sizes(points, REACH_SPACINGS * spacing) < GROUP
    return alone


def make_cloud_scene(cloud: Cloud, *, up: ArrayLike | None = None, metric: bool = False) -> Scene:
    """Return the scene of a cloud, in its frame and unit of length; `metric` says that this is the
    metre.

    `up` is any vector upwards; without one it is found from a floor or from cameras, and the
    scene's warnings say so, or it is unknown. Whether the surface is known from all sides is judged
    from the cloud: wherever one looks from, some of it must be hidden behind other surface, as of
    points all over a solid, but not of a view from one side. Where it is known from where points
    were seen, the scene has lines of sight. Points that lie alone are left out, and counted in a
    warning.
    """
    cloud = drop_strays(cloud)
    work = _Work.of(cloud)
    outlines, planes = work.outlines, work.planes
    noise = np.array([max(work.found.noise, work.found.planes[o.region].rms) for o in outlines])
    given = None if up is None else work.turn_up(make_unit_vector(up))
    level = work.find_up(given, metric=metric)
    around = () if level is None or level.floor is None else (level.floor, *level.around)
    work, spacing = work.look_off(around)
    points, owner = cloud.points[work.looked], work.owner[work.looked]
    bodies = cluster_bodies(points, owner, spacing, support=around)
    body_of = [-1 if n in around else majority(bodies[owner == n]) for n in range(len(outlines))]
    normals = None if cloud.normals is None else cloud.normals[work.looked]
    about = Surroundings(points, owner, bodies, noise, spacing, normals)
    direction = None if level is None else level.direction
    view = work.find_view(level, bodies)
    if view.seen_from is not None:
        about = replace(about, seen_from=view.seen_from[work.looked], partly=view.partly)
    about, round_sensor = _forget_inner_sensor(about, direction)
    sides = find_outer_sides(planes, body_of, about, around=around, up=direction)
    if sides.is_place_wrong and view.seen_from is not None:
        known = np.isfinite(view.seen_from).all(axis=1)
        view = View(None, refused=tuple(unique_rows(view.seen_from[known])))
    unsigned = (
        FlatRegion(plane, outline.outline, outline.holes, outline.corner_sd, body, sd)
        for outline, plane, body, sd in zip(outlines, planes, body_of, noise.tolist(), strict=True)
    )
    regions = tuple(
        region if sign > 0 else region.flipped()
        for region, sign in zip(unsigned, sides.signs.tolist(), strict=True)
    )
    whole = not round_sensor and _covered(points, bodies, work.found.noise, spacing)
    if whole and direction is not None:
        levels, on_levels = work.find_levels(about, regions, direction)
        regions = (*regions, *levels)
        work.owner[on_levels] = len(regions)  # they are not of the rest
    normals = cloud.normals
    if sides.wrong_normals and normals is not None:
        believed = np.ones(len(cloud.points), dtype=bool)
        believed[work.looked] = ~np.isin(bodies, sides.wrong_normals)
        normals = normals * believed[:, None]
    rest = work.rest(regions, bodies, normals)
    how = () if level is None or up is not None else (level.how,)
    said = (*how, *((SENSOR_WITHIN,) if round_sensor else _refusals(view)))
    scene = assemble_scene(
        cloud.name,
        regions,
        rest,
        up=direction,
        metric=metric,
        whole=whole,
        warnings=(*cloud.warnings, *said),
    )
    return replace(scene, sights=make_scan_sights(replace(cloud, seen_from=view.seen_from)))
