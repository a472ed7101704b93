"""Everything the front end finds in one picture, before pictures are compared."""

from dataclasses import dataclass

from facetlog.perception.detection.block_front_end.edge_lines import SLOPE_CHANGE, EdgeLine
from facetlog.perception.detection.block_front_end.image_vertices import (
    ImageVertex,
    find_edge_lines,
    find_vertices,
)
from facetlog.perception.detection.block_front_end.localise import Localisation, localise
from facetlog.perception.detection.block_front_end.plane_regions import PlaneRegions, plane_regions
from facetlog.perception.detection.block_front_end.region_growing import grow_region
from facetlog.perception.detection.block_front_end.threshold import (
    PAPER_THRESHOLD,
    binary_picture,
    otsu_threshold,
    valley_threshold,
)
from facetlog.perception.detection.picture_noise import noise_sd
from facetlog.perception.types import Image

__all__ = ["PictureFeatures", "picture_features"]


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
