"""The paper's own front end as a whole: posed pictures of one block to tracks and outlines.

Algorithm of section 5.2, steps 2 to 6, with what section 5.3 says of each.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from facetlog.perception.detection.block_front_end.correspondence import track_vertices
from facetlog.perception.detection.block_front_end.edge_lines import EdgeLine
from facetlog.perception.detection.block_front_end.face_outlines import face_outlines
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
