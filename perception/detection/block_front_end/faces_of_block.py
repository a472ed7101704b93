"""The paper's own front end as a whole: posed pictures of one block to tracks and outlines.

Algorithm of section 5.2, steps 2 to 6, with what section 5.3 says of each. Step 6 makes outlines of
faces as loops of tracks, over all pictures: "If more than one vertex is available in each segmented
region then consider them belonging to the same plane." One picture's regions may be wrong (two
faces of one grey, a face parted by a highlight), so the regions of all pictures vote, and a face's
points must lie in one plane.
"""

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from facetlog.perception.detection.block_front_end.correspondence import (
    fit_point,
    track_vertices,
    triangulate_pairs,
)
from facetlog.perception.detection.block_front_end.edge_lines import EdgeLine
from facetlog.perception.detection.block_front_end.image_vertices import (
    ImageVertex,
    find_edge_lines,
    find_vertices,
)
from facetlog.perception.detection.block_front_end.localise import (
    PAPER_THRESHOLD,
    Localisation,
    find_otsu_threshold,
    find_valley_threshold,
    grow_region,
    localise,
    threshold_picture,
)
from facetlog.perception.detection.block_front_end.plane_regions import PlaneRegions, plane_regions
from facetlog.perception.detection.block_front_end.position_labels import (
    LabelledVertex,
    Plan,
    find_shown_sides,
    label_vertices,
    mark_junctions,
)
from facetlog.perception.detection.picture_noise import noise_sd
from facetlog.perception.types import FloatArray, Image, Track, View

# A vertex borders the regions within this distance of it, px: the blurred rim between two faces
# is some 3 px wide, and junctions of three of them twice that.
BORDER_PX = 6
# Points of one plane are off it by less than this share of the face's size.
FLATNESS_SHARE = 0.03
# A track bounds a face if at least this share of the pictures that show both say so.
VOTE_SHARE = 0.5
# A face is seen in this many pictures at least, where there are more than that.
LEAST_VIEWS = 2


@dataclass(frozen=True, slots=True)
class _Sighting:
    """A region of a view, and the tracks that border it there."""

    view: int
    region: int
    tracks: frozenset[int]


def track_points(tracks: tuple[Track, ...], views: tuple[View, ...]) -> FloatArray:
    """Estimate the points (n, 3) of the tracks, NaN where the rays determine none.

    They only serve to separate planes; the final estimates are the filter's.
    """
    points = np.full((len(tracks), 3), np.nan)
    for n, track in enumerate(tracks):
        seen = track.observations
        uv, cov = np.array([o.uv for o in seen]), np.array([o.cov for o in seen])
        projections = np.array([views[o.view].projection for o in seen])
        rays = np.array(
            [
                views[o.view].pose.rotation
                @ np.linalg.solve(views[o.view].camera.matrix, [*o.uv, 1.0])
                for o in seen
            ]
        )
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        # Start from the two rays of the widest angle.
        i, j = divmod(int(np.argmin(np.abs(rays @ rays.T))), len(seen))
        if i == j:
            continue
        (start,) = triangulate_pairs(projections[i], projections[j], uv[None, i], uv[None, j])
        if np.isfinite(start).all():
            point = fit_point(projections, uv, cov, start)
            points[n] = np.nan if point is None else point
    return points


def _find_bordering_regions(regions: PlaneRegions, uv: FloatArray) -> frozenset[int]:
    """Return the regions within BORDER_PX of a pixel."""
    u, v = round(float(uv[0])), round(float(uv[1]))
    window = regions.labels[
        max(0, v - BORDER_PX) : v + BORDER_PX + 1, max(0, u - BORDER_PX) : u + BORDER_PX + 1
    ]
    return frozenset(int(label) for label in np.unique(window) if label > 0)


def _find_border_regions(regions: PlaneRegions, uv: FloatArray) -> frozenset[int]:
    """Return the regions that a pixel lies on the border of, none where it is inside one."""
    height, width = regions.labels.shape
    if not (0 <= uv[0] <= width - 1 and 0 <= uv[1] <= height - 1):
        return frozenset()
    u, v = round(float(uv[0])), round(float(uv[1]))
    near = BORDER_PX // 2
    window = regions.labels[max(0, v - near) : v + near + 1, max(0, u - near) : u + near + 1]
    labels = np.unique(window)
    return frozenset(int(label) for label in labels if label > 0 and len(labels) > 1)


def _sightings(
    tracks: tuple[Track, ...],
    points: FloatArray,
    regions: tuple[PlaneRegions, ...],
    views: tuple[View, ...],
) -> list[_Sighting]:
    """Return the regions of all views that show one plane, with the tracks that border them.

    A track that a view missed counts where its point falls on a region's border: in the region's
    plane it is one of its corners, in front of the plane it shows that the region is two faces
    whose common edge is unseen. Behind the plane it is occluded.
    """
    seen: dict[tuple[int, int], set[int]] = {}
    missed: dict[tuple[int, int], set[int]] = {}
    for index, (track, point) in enumerate(zip(tracks, points, strict=True)):
        pixels = {o.view: o.uv for o in track.observations}
        for number, view in enumerate(views):
            if number in pixels:
                for region in _find_bordering_regions(regions[number], pixels[number]):
                    seen.setdefault((number, region), set()).add(index)
                continue
            projected = view.projection @ np.append(point, 1.0)
            if projected[2] > 0:
                for region in _find_border_regions(regions[number], projected[:2] / projected[2]):
                    missed.setdefault((number, region), set()).add(index)
    sightings = []
    for (number, region), bordering in sorted(seen.items()):
        members = frozenset(bordering)
        if not _flat(points, members):
            continue
        others = sorted(missed.get((number, region), ()))
        ahead = _in_front(points, members, others, views[number].pose.centre)
        if (ahead <= FLATNESS_SHARE).all():
            corners = {k for k, off in zip(others, ahead, strict=True) if off >= -FLATNESS_SHARE}
            sightings.append(_Sighting(number, region, members | corners))
    return sightings


def _in_front(
    points: FloatArray, members: frozenset[int], others: list[int], eye: FloatArray
) -> FloatArray:
    """Return how far the others stand in front of the members' plane as seen from `eye`, over the
    members' size, (n,).
    """
    own = points[sorted(members)]
    middle = own.mean(axis=0)
    _, sizes, vt = np.linalg.svd(own - middle)
    towards = vt[2] if vt[2] @ (eye - middle) > 0 else -vt[2]
    ahead: FloatArray = (points[others] - middle) @ towards / sizes[0]
    return ahead


def _flat(points: FloatArray, members: frozenset[int]) -> bool:
    """Return whether the members' points lie in one plane."""
    own = points[sorted(members)]
    if not np.isfinite(own).all():
        return False
    centred = own - own.mean(axis=0)
    sizes = np.linalg.svd(centred, compute_uv=False)
    if len(own) < 3 or sizes[1] <= FLATNESS_SHARE * sizes[0]:
        return False  # on one line: no face
    _, _, vt = np.linalg.svd(centred)
    return bool(np.abs(centred @ vt[2]).max() <= FLATNESS_SHARE * sizes[0])


def _groups(sightings: list[_Sighting], points: FloatArray) -> list[list[_Sighting]]:
    """Return the sightings of each face: those that share three tracks and lie in one plane."""
    groups: list[tuple[frozenset[int], list[_Sighting]]] = []
    for sighting in sorted(sightings, key=lambda s: (-len(s.tracks), s.view, s.region)):
        for index, (tracks, group) in enumerate(groups):
            joined = tracks | sighting.tracks
            if len(tracks & sighting.tracks) >= 3 and _flat(points, joined):
                groups[index] = (joined, [*group, sighting])
                break
        else:
            groups.append((sighting.tracks, [sighting]))
    return [group for _, group in groups]


def _members(group: list[_Sighting], tracks: tuple[Track, ...]) -> frozenset[int]:
    """Return the tracks that most of the pictures that show them and the face put on the face."""
    views = {s.view for s in group}
    voted = []
    for index in sorted(frozenset().union(*(s.tracks for s in group))):
        shown = sum(o.view in views for o in tracks[index].observations)
        said = len({s.view for s in group if index in s.tracks})
        if said >= VOTE_SHARE * shown:
            voted.append(index)
    return frozenset(voted)


def _loop(
    group: list[_Sighting],
    members: frozenset[int],
    points: FloatArray,
    views: tuple[View, ...],
    regions: tuple[PlaneRegions, ...],
) -> tuple[int, ...]:
    """Return the members in the order of the region's outline where most of them border it,
    counter-clockwise as seen from there, which is from outside.
    """
    best = max(group, key=lambda s: (len(s.tracks & members), -s.view))
    mask: Image = (regions[best.view].labels == best.region).astype(np.uint8)
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    outline = max(outlines, key=len)[:, 0, :].astype(np.float64)
    order = sorted(members)
    homogeneous = np.column_stack([points[order], np.ones(len(order))])
    projected = homogeneous @ views[best.view].projection.T
    pixels = projected[:, :2] / projected[:, 2:]
    along = [int(np.argmin(((outline - pixel) ** 2).sum(axis=1))) for pixel in pixels]
    ring = [k for _, k in sorted((place, k) for k, place in enumerate(along))]
    u, v = pixels[ring, 0], pixels[ring, 1]
    # v runs down, so a positive shoelace sum is clockwise as seen.
    if (u * np.roll(v, -1) - np.roll(u, -1) * v).sum() > 0:
        ring.reverse()
    first = ring.index(min(ring, key=lambda k: order[k]))
    return tuple(order[k] for k in (*ring[first:], *ring[:first]))


def face_outlines(
    tracks: tuple[Track, ...], regions: tuple[PlaneRegions, ...], views: tuple[View, ...]
) -> tuple[tuple[int, ...], ...]:
    """Return the faces' outlines: loops of track indices, counter-clockwise as seen from outside.

    `regions` are those of each view. ValueError if their numbers differ. Faces with the most
    votes come first; of two faces with the same tracks one is kept.
    """
    if len(regions) != len(views):
        raise ValueError(f"regions of {len(regions)} views, but {len(views)} views")
    if not tracks:
        return ()
    points = track_points(tracks, views)
    groups = sorted(
        _groups(_sightings(tracks, points, regions, views), points), key=lambda g: -len(g)
    )
    outlines: list[tuple[int, ...]] = []
    for group in groups:
        if len({s.view for s in group}) < min(LEAST_VIEWS, len(views)):
            continue
        members = _members(group, tracks)
        if not _flat(points, members):
            continue
        if any(len(members & set(known)) >= 3 for known in outlines):
            continue
        outlines.append(_loop(group, members, points, views, regions))
    return tuple(outlines)


@dataclass(frozen=True, eq=False, slots=True)
class PictureFeatures:
    """One picture: the threshold used, where the object is, its edges, regions and 2-D vertices."""

    threshold: int
    object: Localisation
    lines: tuple[EdgeLine, ...]
    regions: PlaneRegions
    vertices: tuple[ImageVertex, ...]


def picture_features(
    image: Image,
    *,
    threshold: int | None = PAPER_THRESHOLD,
    grow: bool = True,
) -> PictureFeatures:
    """Apply steps 2 to 4 and 6 of the paper's algorithm to one grey picture (H, W).

    `threshold` None chooses it by the picture's histogram: the valley between its two peaks, or
    Otsu's where it has not two. `grow` adds faces in the shade to the localised region. Where
    nothing is found, `object` says why and there are no vertices.
    """
    if threshold is None:
        threshold = find_valley_threshold(image) or find_otsu_threshold(image)
    found = localise(threshold_picture(image, threshold))
    if found and grow:
        found = grow_region(image, found, threshold)
    noise = noise_sd(image)
    lines = find_edge_lines(image, found.mask, noise)
    return PictureFeatures(
        threshold,
        found,
        lines,
        plane_regions(image, found.mask, noise),
        find_vertices(lines, found.mask),
    )


@dataclass(frozen=True, eq=False, slots=True)
class BlockFeatures:
    """Results of the front end: per view its features and labelled vertices; the tracks; the
    faces' outlines as loops of track indices, counter-clockwise seen from outside; and the views
    in which nothing was found, with the reason.
    """

    pictures: tuple[PictureFeatures, ...]
    vertices: tuple[tuple[LabelledVertex, ...], ...]
    tracks: tuple[Track, ...]
    outlines: tuple[tuple[int, ...], ...]
    warnings: tuple[str, ...]


def label_pictures(
    views: tuple[View, ...],
    pictures: tuple[PictureFeatures, ...],
    up: FloatArray | None = None,
) -> tuple[tuple[LabelledVertex, ...], ...]:
    """Label the vertices of each view; those without a label are marked by their junctions.

    `up` (3,) is the world's if known. The labels on the block refer to the side that faces the
    first view in which it was found.
    """
    if not views:
        return ()
    plan = Plan.of(views, [picture.lines for picture in pictures], up)
    azimuths = [
        plan.measure_camera_azimuth(view, np.argwhere(picture.object.mask).mean(axis=0)[::-1])
        if picture.object
        else None
        for view, picture in zip(views, pictures, strict=True)
    ]
    labelled = []
    for view, picture, side in zip(views, pictures, find_shown_sides(plan, azimuths), strict=True):
        found = label_vertices(view, picture.vertices, picture.lines, picture.regions, plan, side)
        labelled.append(mark_junctions(found, picture.lines, side.quarters))
    return tuple(labelled)


def block_front_end(
    views: tuple[View, ...],
    *,
    up: FloatArray | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> BlockFeatures:
    """Find labelled vertices, tracks and face outlines of the one bright block in the views.

    `up` (3,) is the world's if known. `progress(done, total)` is called after each picture.
    """
    pictures = []
    for index, view in enumerate(views):
        pictures.append(picture_features(view.image))
        if progress is not None:
            progress(index + 1, len(views))
    found = tuple(pictures)
    vertices = label_pictures(views, found, up)
    tracks = track_vertices(vertices, views)
    outlines = face_outlines(tracks, tuple(picture.regions for picture in found), views)
    warnings = tuple(
        f"{view.name}: {picture.object.reason}"
        for view, picture in zip(views, found, strict=True)
        if not picture.object
    )
    return BlockFeatures(found, vertices, tracks, outlines, warnings)
