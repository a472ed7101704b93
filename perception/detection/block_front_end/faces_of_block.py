"""The paper's own front end as a whole: posed pictures of one block to tracks and outlines.

Algorithm of section 5.2, steps 2 to 6, with what section 5.3 says of each.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from facetlog.perception.detection.block_front_end.correspondence import POSE_SD_PX, track_vertices
from facetlog.perception.detection.block_front_end.edge_lines import SLOPE_CHANGE, EdgeLine
from facetlog.perception.detection.block_front_end.face_outlines import face_outlines
from facetlog.perception.detection.block_front_end.image_vertices import (
    ImageVertex,
    find_edge_lines,
    find_vertices,
)
from facetlog.perception.detection.block_front_end.junction_marks import with_junctions
from facetlog.perception.detection.block_front_end.localise import (
    PAPER_THRESHOLD,
    Localisation,
    binary_picture,
    grow_region,
    localise,
    otsu_threshold,
    valley_threshold,
)
from facetlog.perception.detection.block_front_end.plane_regions import PlaneRegions, plane_regions
from facetlog.perception.detection.block_front_end.position_labels import (
    QUARTER,
    BlockSide,
    LabelledVertex,
    block_turn,
    edge_azimuth,
    ground_axes,
    label_vertices,
    upward_direction,
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
    slope_change: float = SLOPE_CHANGE,
) -> PictureFeatures:
    """Steps 2 to 4 and 6 of the paper's algorithm on one grey picture (H, W).

    `threshold` None chooses it by the picture's histogram: the valley between its two peaks, or
    Otsu's where it has not two. `grow` adds faces in the shade to the localised region. Where
    nothing is found, `object` says why and there are no vertices.
    """
    if threshold is None:
        threshold = valley_threshold(image) or otsu_threshold(image)
    found = localise(binary_picture(image, threshold))
    if found and grow:
        found = grow_region(image, found, threshold)
    noise = noise_sd(image)
    lines = find_edge_lines(image, found.mask, slope_change=slope_change, sd_grey=noise)
    return PictureFeatures(
        threshold,
        found,
        lines,
        plane_regions(image, found.mask, noise),
        find_vertices(lines, found.mask, slope_change=slope_change),
    )


# Without a known rotation of the block its sides are distinguished by where the views stand, except
# within this angle of the corner between two sides.
SIDE_MARGIN = np.deg2rad(15.0)


@dataclass(frozen=True, eq=False, slots=True)
class BlockFeatures:
    """What the front end found: per view its features and labelled vertices; the tracks; the
    faces' outlines as loops of track indices, counter-clockwise seen from outside; and the views
    in which nothing was found, with the reason.
    """

    pictures: tuple[PictureFeatures, ...]
    vertices: tuple[tuple[LabelledVertex, ...], ...]
    tracks: tuple[Track, ...]
    outlines: tuple[tuple[int, ...], ...]
    warnings: tuple[str, ...]


def _seen_from(
    view: View, picture: PictureFeatures, up: FloatArray, axes: tuple[FloatArray, FloatArray]
) -> float | None:
    """Azimuth (radians) of the camera as seen from the object; None straight above it."""
    rows, columns = np.nonzero(picture.object.mask)
    pixel = np.array([columns.mean(), rows.mean(), 1.0])
    ray = view.pose.rotation @ np.linalg.solve(view.camera.matrix, pixel)
    level = -(ray - up * (up @ ray))
    if np.linalg.norm(level) <= 1e-6 * np.linalg.norm(ray):
        return None
    return float(np.arctan2(level @ axes[1], level @ axes[0]))


def _turn(
    views: tuple[View, ...],
    pictures: tuple[PictureFeatures, ...],
    up: FloatArray,
    axes: tuple[FloatArray, FloatArray],
) -> float | None:
    """How the block is turned in the plan, by the level edges of all pictures."""
    azimuths, lengths = [], []
    for view, picture in zip(views, pictures, strict=True):
        for line in picture.lines:
            azimuth = edge_azimuth(view, line, up, axes)
            if azimuth is not None:
                azimuths.append(azimuth)
                lengths.append(line.length)
    return block_turn(np.array(azimuths), np.array(lengths))


def labelled_pictures(
    views: tuple[View, ...],
    pictures: tuple[PictureFeatures, ...],
    up: FloatArray | None = None,
) -> tuple[tuple[LabelledVertex, ...], ...]:
    """The labelled vertices of each view; `up` (3,) is the world's if known.

    Those without a label are marked by their junctions.

    The labels on the block refer to the side that faces the first view in which it was found.
    """
    if not views:
        return ()
    upward = upward_direction(views) if up is None else np.asarray(up, dtype=np.float64)
    axes = ground_axes(upward, views[0])
    turn = _turn(views, pictures, upward, axes)
    azimuths = [
        _seen_from(view, picture, upward, axes) if picture.object else None
        for view, picture in zip(views, pictures, strict=True)
    ]
    first = next((azimuth for azimuth in azimuths if azimuth is not None), None)
    labelled = []
    for view, picture, azimuth in zip(views, pictures, azimuths, strict=True):
        side, quarters = None, None
        if azimuth is not None and first is not None:
            if turn is not None:
                front = round((azimuth - turn) / QUARTER)
                side = BlockSide(turn, front % 4)
                quarters = (front - round((first - turn) / QUARTER)) % 4
            else:
                around = (azimuth - first) / QUARTER
                if abs(around - round(around)) * QUARTER <= QUARTER / 2 - SIDE_MARGIN:
                    quarters = round(around) % 4
        found = label_vertices(
            view,
            picture.vertices,
            picture.lines,
            picture.regions,
            up=upward,
            axes=axes,
            side=side,
            quarters=quarters,
        )
        labelled.append(with_junctions(found, picture.lines, quarters))
    return tuple(labelled)


def block_front_end(
    views: tuple[View, ...],
    *,
    threshold: int | None = PAPER_THRESHOLD,
    grow: bool = True,
    slope_change: float = SLOPE_CHANGE,
    up: FloatArray | None = None,
    pose_sd_px: float = POSE_SD_PX,
    progress: Callable[[int, int], None] | None = None,
) -> BlockFeatures:
    """Labelled vertices, tracks and face outlines of the one bright block in the views.

    `threshold` in grey levels (None: by each picture's histogram), `grow` adds faces in the shade,
    `slope_change` in radians makes a vertex, `up` (3,) is the world's if known, `pose_sd_px` is the
    effect of pose errors in the picture. `progress(done, total)` is called after each picture.
    """
    pictures = []
    for index, view in enumerate(views):
        pictures.append(
            picture_features(view.image, threshold=threshold, grow=grow, slope_change=slope_change)
        )
        if progress is not None:
            progress(index + 1, len(views))
    found = tuple(pictures)
    vertices = labelled_pictures(views, found, up)
    tracks = track_vertices(vertices, views, pose_sd_px=pose_sd_px)
    outlines = face_outlines(tracks, tuple(picture.regions for picture in found), views)
    warnings = tuple(
        f"{view.name}: {picture.object.reason}"
        for view, picture in zip(views, found, strict=True)
        if not picture.object
    )
    return BlockFeatures(found, vertices, tracks, outlines, warnings)
